"""Numbers of the methods of exported programs, and what else their routines look up."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.closure.dyads import LEAST_MARGIN
from linkages.solution.moving.march import CLOSER, EARLY, PASSAGE_RTOL
from linkages.solution.moving.passage import COMPARED, STAGES, gauss
from linkages.solvers.loops.transitions import GRAZING
from linkages.solvers.methods.dop853 import tableau
from linkages.solvers.methods.rk4 import tableau as classical_tableau
from linkages.solvers.printed.advance import CONCAVITY
from linkages.solvers.printed.control import MOST_CHANGE, ROUNDING, WILD

if TYPE_CHECKING:
    from linkages.exports.kernels.exported import Exported

Floats = NDArray[np.float64]
Constant = int | float | tuple[int, ...] | Floats


@cache
def _methods() -> dict[str, Constant]:
    """Coefficients as their tableaus have them, and limits as motions of this package do."""
    dop853, classical = tableau(), classical_tableau()
    assert dop853.dense_A is not None
    assert dop853.dense_c is not None
    assert dop853.dense is not None
    rows = np.zeros((3, 2, STAGES * STAGES))
    for k, stages in enumerate((COMPARED, STAGES)):
        for own, values in zip(rows, gauss(stages), strict=True):
            own[k, : values.size] = values.ravel()
    return {
        "STAGES": len(dop853.b),
        "FURTHER": len(dop853.dense_A),
        "POWERS": dop853.dense.shape[1],
        "RK4_STAGES": len(classical.b),
        "NODES": STAGES,
        "PLACES": STAGES + 2,
        "LEAST_MARGIN": LEAST_MARGIN,
        "EARLY": EARLY,
        "CLOSER": CLOSER,
        "PASSAGE_RTOL": PASSAGE_RTOL,
        "CONCAVITY": CONCAVITY,
        "GRAZING": GRAZING,
        "MOST_CHANGE": MOST_CHANGE,
        "ROUNDING": ROUNDING,
        "WILD": WILD,
        "DOP853_A": dop853.A,
        "DOP853_B": dop853.b,
        "DOP853_C": dop853.c,
        "DOP853_ERROR": np.asarray(dop853.error),
        "DOP853_FURTHER_A": dop853.dense_A,
        "DOP853_FURTHER_C": dop853.dense_c,
        "DOP853_DENSE": dop853.dense,
        "RK4_A": classical.A,
        "RK4_B": classical.b,
        "RK4_C": classical.c,
        "GAUSS_COUNTS": (COMPARED, STAGES),
        "GAUSS_NODES": rows[0, :, :STAGES],
        "GAUSS_WEIGHTS": rows[1, :, :STAGES],
        "GAUSS_ONCE": rows[2],
    }


def constants(found: Exported) -> dict[str, Constant]:
    """Name → what routines look up: numbers, lists of whole numbers, and tables.

    Parameters
    ----------
    found
        The program.
    """
    from linkages.exports.kernels import exported as status

    layout, own, switching = found.system.layout, found.program, found.switching
    n, modes = len(layout.coordinates), len(found.modes)
    function = n + 2 * len(layout.carried)
    given = {
        name: tuple(int(value) for value in getattr(switching, name)) if switching else ()
        for name in ("active", "owners", "jumps", "sticks", "shakes")
    }
    return {
        "N": n,
        "STATE": 2 * n,
        "FREE": len(layout.free),
        "FIRST_CARRIED": layout.moved,
        "CARRIED": len(layout.carried),
        "NUMBER_COUNT": len(found.feed.numbers),
        "PARAMETERS": len(found.p),
        "QUANTITIES": len(found.quantities),
        "TIMED": own.timed,
        "WRITTEN": found.written,
        "VALUES": own.routines[-1].arguments["out"],
        "MODES": modes,
        "MEMORIES": len(given["owners"]),
        "HELD": len(found.p) - own.held,
        "FUNCTION": function,
        "MARGIN": function + 2 * modes,
        "BLOCKS": len(found.blocks),
        "TURNED": len(found.turned),
        "PASSING": int(found.passing),
        "STEP_TOO_SMALL": status.STEP_TOO_SMALL,
        "NOT_BACK": status.NOT_BACK,
        "SINGULAR": status.SINGULAR,
        "SLIDING": status.SLIDING,
        "CHATTER": status.CHATTER,
        **{name.upper(): values for name, values in given.items()},
        "SCALES": found.margin_scale,
        "BLOCK_NUMBERS": found.blocks,
        "SIDES": found.sides,
        "TURNED_PLACES": found.turned,
        "OWN_NUMBERS": np.array([number.value for number in found.feed.numbers]),
        "OWN_PARAMETERS": found.p,
        "OWN_STATE": found.state,
        **_methods(),
    }
