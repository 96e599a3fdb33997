"""Free coordinates of a motion as one array, whatever it was integrated in on the way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.outputs import VARIABLES, labels
from linkages.kernel.system import System
from linkages.solution.evaluation import evaluate_variables
from linkages.solution.motion import Motion, Piece

Floats = NDArray[np.float64]

OUTPUTS = {
    "bar": ("bar_angle", "bar_speed"),
    "plate": ("bar_angle", "bar_speed"),
    "clearance": ("clearance_angle", "clearance_speed"),
    "slider": ("slider_position", "slider_velocity"),
}
"""Kind of body → outputs of its coordinate and its rate."""


def free_vectors(system: System, motion: Motion, *, turns: bool = True) -> Floats:
    """Free coordinates of a system, then rates, whatever others have taken their place on the way.

    Parameters
    ----------
    system, motion
        Whose coordinates, and how it moves.
    turns
        Whether angles have all the turns that they have made.

    Returns
    -------
    Shape (samples, 2n).
    """
    found = np.concatenate([_of_piece(system, piece, turns) for piece in motion.pieces], axis=1)
    return found.T


def _of_piece(system: System, piece: Piece, turns: bool) -> Floats:
    """Shape (2n, samples)."""
    free, count = system.topology.free, len(piece.turns)
    if piece.system.topology.free != free or piece.samples is not None:
        return _evaluated(system, piece)
    found = np.concatenate([piece.state[: len(free)], piece.state[count:][: len(free)]])
    if turns:
        found[: len(free)] += 2 * np.pi * piece.turns[: len(free)]
    return found


def _evaluated(system: System, piece: Piece) -> Floats:
    """The same from outputs."""
    kinds = [(name, system.mechanism.bodies[name].kind) for name in system.topology.free]
    wanted = list(dict.fromkeys(output for _, kind in kinds for output in OUTPUTS[kind]))
    values = evaluate_variables(Motion(pieces=(piece,)), wanted)
    rows = []
    for order in (0, 1):
        for name, kind in kinds:
            output = OUTPUTS[kind][order]
            index = labels(system.model, VARIABLES[output].dims[0]).index(name)
            rows.append(values[output][:, index])
    return np.array(rows)
