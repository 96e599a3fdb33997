"""Loads as forces and torques on bodies, for the equations of single bodies."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanism import Mechanism
from linkages.components.terms import (
    AxialDamper,
    AxialForce,
    PointForce,
    Spring,
    Torque,
    TorsionSpring,
)
from linkages.kernel.acting import Conjugate, Pull
from linkages.kernel.loads import load_nodes
from linkages.kernel.scalars import Scalar
from linkages.kernel.vectors import Vector
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
    mechanism = piece.system.mechanism
    rows = np.zeros((len(piece.wanted), 3 * len(mechanism.bodies)))
    order = list(mechanism.bodies)
    for load in mechanism.loads:
        match load:
            case Torque() | TorsionSpring():
                nodes = load_nodes(piece.system.model, load)
                assert isinstance(nodes, Conjugate)
                (torque,) = piece.interpolated(evaluate_nodes(piece, [nodes.force]))
                rows[:, 3 * order.index(load.body) + 2] += torque
                if load.reference is not None:
                    rows[:, 3 * order.index(load.reference) + 2] -= torque
            case PointForce() | Spring():
                for body, joint, force in _at_joints(piece, load):
                    add(rows, body, joint, force)
            case AxialForce() | AxialDamper():
                for body, joint, force in _along_axis(piece, load):
                    add(rows, body, joint, force)
            case _:
                assert_never(load)
    return rows


def carrier_of(mechanism: Mechanism, joint: str) -> str | None:
    """The body that loads and masses at a joint belong to: the first there; None is the ground."""
    if joint in mechanism.ground:
        return None
    return next((name for name, body in mechanism.bodies.items() if joint in body.points), None)


Forces = list[tuple[str, str, Floats]]
"""Bodies, joints and forces of a load, shape (samples, 2) each."""


def _at_joints(piece: Piece, load: PointForce | Spring) -> Forces:
    nodes = load_nodes(piece.system.model, load)
    assert isinstance(nodes, Pull)
    force = _vectors(piece, nodes.vector)
    ends = [load.joint] if isinstance(load, PointForce) else [load.second, load.first]
    return _on_bodies(
        (carrier_of(piece.system.mechanism, joint), joint, sign * force)
        for joint, sign in zip(ends, (1.0, -1.0), strict=False)
    )


def _along_axis(piece: Piece, load: AxialForce | AxialDamper) -> Forces:
    model = piece.system.model
    nodes = load_nodes(model, load)
    assert isinstance(nodes, Conjugate)
    slider = piece.system.mechanism.bodies[load.body]
    assert slider.guide is not None
    force = _vectors(piece, model.positions.unit(load.body) * nodes.force)
    pin = next(iter(slider.points))
    return _on_bodies([(load.body, pin, force), (slider.guide.body, pin, -force)])


def _on_bodies(found: Iterable[tuple[str | None, str, Floats]]) -> Forces:
    """Without what acts on the ground."""
    return [(body, joint, force) for body, joint, force in found if body is not None]


def _vectors(piece: Piece, vector: Vector) -> Floats:
    nodes: list[Scalar] = [vector.x, vector.y]
    return piece.interpolated(evaluate_nodes(piece, nodes)).T
