"""How well a position transmits force: angles and ratios of efforts."""

from __future__ import annotations

from collections.abc import Callable

from linkages.kernel.dyads import LinkAndSlider, LinkInGuide, TwoLinks
from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable, dyads, labels
from linkages.kernel.scalars import Scalar


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
        partials = [model.partial(name) for name in model.topology.driven]
        return [1.0 / partial.moving(name) for partial in partials for name in labels(model, dim)]

    return nodes


OUTPUTS = {
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
