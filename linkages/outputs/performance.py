"""Pressure angle of cams, shaking force and moment, transmission angle, mechanical advantage."""

from __future__ import annotations

from collections.abc import Callable

from linkages.kernel.dyads import LinkAndSlider, LinkInGuide, TwoLinks
from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable, components, dyads, labels
from linkages.kernel.scalars import Scalar, Vector


def pressure_angles(model: Model) -> list[Scalar]:
    """Between the normal of a cam and the axis of its follower, which translates on a roller.

    tan φ = (ds/dθ − ε)/(s + √((R_base + R_roller)² − ε²)), R. L. Norton, *Cam Design and
    Manufacturing Handbook*, 2nd ed., 2009.
    """
    result = []
    for name in model.mechanism.cams:
        leaning = model.cam(name).leaning
        assert leaning is not None
        result.append(model.graph.apply("atan2", leaning.y, leaning.x))
    return result


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


def _transmission_angles(model: Model) -> list[Scalar]:
    """Between the directions of force and of motion's normal: 90° is best, 0 is singular."""
    graph, result = model.graph, []
    for block in dyads(model):
        dyad = model.positions.dyads[block.index]
        if isinstance(dyad, TwoLinks):
            crossed, along = dyad.first.cross(dyad.second), -dyad.first.dot(dyad.second)
        else:
            assert isinstance(dyad, LinkAndSlider | LinkInGuide)
            crossed, across = dyad.forward, dyad.across
            along = graph.select(across, across, -across)
        angle = graph.apply("atan2", graph.select(crossed, crossed, -crossed), along)
        result.append(graph.select(angle, angle, -angle))  # atan2(-0.0, -1.0) is -π
    return result


def _advantages(dim: str) -> Callable[[Model], list[Scalar]]:
    """Effort that a body delivers per effort of a drive: the reciprocal of their speeds' ratio.

    Power in is power out, M_in ω_in = M_out ω_out, with M_out on what resists the body.
    """

    def nodes(model: Model) -> list[Scalar]:
        partials = model.drive_partials
        return [1.0 / partial.moving(name) for partial in partials for name in labels(model, dim)]

    return nodes


OUTPUTS = {
    "pressure_angle": Variable(("cam",), "rad", "pressure angle", pressure_angles, smooth=False),
    "shaking_force": Variable(
        ("frame", "axis"), "N", "shaking force", _forces, magnitude=True
    ),
    "shaking_moment": Variable(
        ("frame",), "N m", "shaking moment about the origin", _moments
    ),
    "transmission_angle": Variable(
        ("dyad",), "rad", "transmission angle", _transmission_angles, unbounded=True
    ),
    "mechanical_advantage": Variable(
        ("drive", "bar"),
        "1",
        "mechanical advantage",
        _advantages("bar"),
        ("m", "mechanical advantage"),
        reciprocal=True,
    ),
    "slider_mechanical_advantage": Variable(
        ("drive", "slider"),
        "1/m",
        "mechanical advantage",
        _advantages("slider"),
        ("1", "mechanical advantage"),
        reciprocal=True,
    ),
}  # fmt: skip
