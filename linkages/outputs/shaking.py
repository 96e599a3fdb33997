"""What moving masses do to the ground: shaking force and shaking moment."""

from __future__ import annotations

from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable, components
from linkages.kernel.scalars import Scalar, Vector


class _Together:
    """All bodies moving as one: virtual velocities of a translation, or of a turn about the origin.

    With them the inertia terms of a motion are the rates of its momentum and angular momentum.
    """

    def __init__(self, joints: dict[str, Vector], turning: Scalar) -> None:
        self.joints = joints
        self._turning = turning

    def turning(self, _name: str) -> Scalar:
        return self._turning


def _rate(model: Model, joints: dict[str, Vector], turning: Scalar) -> Scalar:
    return model.inertia.product(model.accelerations, _Together(joints, turning))


def _forces(model: Model) -> list[Scalar]:
    """−Σ m a: forces of inertia, which reach the ground; weights and loads do not shake it."""
    graph, places = model.graph, model.positions.joints
    zero, one = graph.zero, graph.number(1.0)
    ways = Vector(one, zero), Vector(zero, one)
    rates = [_rate(model, dict.fromkeys(places, way), zero) for way in ways]
    return components([Vector(-rates[0], -rates[1])])


def _moments(model: Model) -> list[Scalar]:
    """−Σ (r × m a + J α) about the origin."""
    turned = {joint: Vector(-place.y, place.x) for joint, place in model.positions.joints.items()}
    return [-_rate(model, turned, model.graph.number(1.0))]


OUTPUTS = {
    "shaking_force": Variable(
        ("frame", "axis"), "N", "shaking force", _forces, magnitude=True
    ),
    "shaking_moment": Variable(
        ("frame",), "N m", "shaking moment about the origin", _moments
    ),
}  # fmt: skip
