"""Touches of pins in holes and of bodies at stops: when, in which direction, and how fast."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.sections.common_period import NoPeriodError, common_period
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.system import System
from linkages.solution.moving.evaluation import evaluate_nodes
from linkages.solution.moving.motion import Motion, Piece
from linkages.solution.values.series import system_series
from linkages.solution.values.surface import Surface

Floats = NDArray[np.float64]

TOUCH = "touch"
"""Dimension of what is known of touches: the clearance, or the end of a way."""

VARIABLES = {
    "touch_phase": ("", "part of the period of the drives"),
    "touch_direction": ("rad", "direction of the touch, from the bearing's or journal's centre"),
    "touch_rate": ("m/s", "rate of the indentation"),
}
"""Name → unit and what it is, over crossings and clearances."""


def touch_values(system: System, motion: Motion, surface: Surface) -> dict[str, Floats]:
    """What is known of touches, shape (crossings, 1) each; nothing of other sections.

    Without a common period of the drives there is no phase, without an offset no direction. Rates
    at stops are those before an impact.
    """
    if not surface.touch:
        return {}
    known = system_series(system)

    def along(quantity: str) -> Floats | None:
        series = known.get(f"{surface.touch}.{quantity}")
        if series is None:
            return None
        return _evaluated(motion, lambda piece: series.node(piece.system.model))

    rate, x, y = along("indentation rate"), along("x offset"), along("y offset")
    if surface.end:
        rate = _evaluated(motion, lambda piece: surface.nodes(piece.system.model)[1])
    found = {
        "touch_phase": _phase(system, motion),
        "touch_direction": None if x is None or y is None else np.arctan2(y, x),
        "touch_rate": rate,
    }
    return {name: values[:, None] for name, values in found.items() if values is not None}


def touch_variables(
    values: Mapping[str, Floats], section: str, dims: tuple[str, ...] = ("crossing",)
) -> dict[str, Any]:
    """Those of `values` that are about touches, as variables of a dataset.

    Parameters
    ----------
    values
        Arrays over `dims`, then one clearance.
    section
        What was asked for, such as ``gap.touch``.
    """
    import xarray as xr

    name = section.strip().rpartition(".")[0]
    return {
        variable: xr.DataArray(
            values[variable],
            dims=(*dims, TOUCH),
            coords={TOUCH: np.array([name], dtype=object)},
            attrs={"units": unit, "long_name": text},
        )
        for variable, (unit, text) in VARIABLES.items()
        if variable in values
    }


def _evaluated(motion: Motion, node: Callable[[Piece], Scalar]) -> Floats:
    return np.concatenate([evaluate_nodes(piece, [node(piece)])[0] for piece in motion.pieces])


def _phase(system: System, motion: Motion) -> Floats | None:
    try:
        period = common_period(system.mechanism)
    except NoPeriodError:
        return None
    return np.asarray(motion.time / period % 1.0)
