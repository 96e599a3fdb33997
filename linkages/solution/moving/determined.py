"""Whether redundant constraints tell which way a motion goes on from a singular position.

Blocks are solved one after the other, from as many equations as they have unknowns. Where one of
them is singular, an equation that is redundant elsewhere may be what keeps the mechanism as a whole
from going on in two ways: then this is no change point.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from linkages.solution.moving.evaluation import evaluate_nodes
from linkages.solution.moving.motion import Piece
from linkages.topology.jacobian import closure_jacobian, distance_from_singular

LEAST_DISTANCE = 1e-6
"""Smallest over largest singular value of the closure from which on it is regular.

Positions in a singular position are interpolated; of a true one they leave 1e-9 or less.
"""


def is_determined(piece: Piece) -> bool:
    """Whether the whole closure is regular in the middle of a piece that leads across.

    Parameters
    ----------
    piece
        With times on both sides of its `crossing`.
    """
    system = piece.system
    if not system.topology.redundant:
        return False
    model = system.model
    sliders = [name for name, body in system.mechanism.bodies.items() if not body.rotates]
    vectors = [*model.positions.joints.values(), *(model.positions.travel(n) for n in sliders)]
    rows = evaluate_nodes(piece, [node for vector in vectors for node in (vector.x, vector.y)])
    middle = replace(piece, samples=np.array([piece.crossing])).interpolated(rows)
    found = middle.reshape(-1, 2)
    joints = len(model.positions.joints)
    places = dict(zip(model.positions.joints, found[:joints], strict=True))
    axes = dict(zip(sliders, found[joints:], strict=True))
    jacobian = closure_jacobian(system.topology, places, axes)
    distance = distance_from_singular(system.topology, jacobian, system.topology.free)
    return distance >= LEAST_DISTANCE
