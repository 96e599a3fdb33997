"""Loads as forces and torques on bodies, for the equations of single bodies."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.motion import Piece

Floats = NDArray[np.float64]
Add = Callable[[Floats, str, str, Floats], None]


def applied_forces(piece: Piece, add: Add) -> Floats:
    """Forces and moments of all loads on each body, shape (samples, 3·bodies).

    Parameters
    ----------
    piece
        Where the mechanism is.
    add
        Adds a force on a body at a joint, shape (samples, 2), to such an array.
    """
    order = list(piece.system.mechanism.bodies)
    rows = np.zeros((len(piece.wanted), 3 * len(order)))
    for load in piece.system.model.loads:
        for body, joint, force in load.measure.forces(load.load.force):
            if body is not None:
                nodes = [force.x, force.y]
                add(rows, body, joint, piece.interpolated(evaluate_nodes(piece, nodes)).T)
        for body, torque in load.measure.torques(load.load.force):
            if body is not None:
                (values,) = piece.interpolated(evaluate_nodes(piece, [torque]))
                rows[:, 3 * order.index(body) + 2] += values
    return rows
