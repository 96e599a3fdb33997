"""Wear: work and distance of slip, pressure by velocity, worn volumes."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable, labels
from linkages.kernel.scalars import Scalar

if TYPE_CHECKING:
    from linkages.kernel.forces.sliding import SlidingNodes


def _of_sliding(value: Callable[[SlidingNodes], Scalar]) -> Callable[[Model], list[Scalar]]:
    """One value of each clearance that wears, and zero of the others."""

    def nodes(model: Model) -> list[Scalar]:
        from linkages.kernel.forces.sliding import SlidingNodes

        own = {term.name: SlidingNodes(model, term) for term in model.mechanism.rubbing}
        names = labels(model, "clearance")
        return [value(own[name]) if name in own else model.graph.zero for name in names]

    return nodes


OUTPUTS = {
    "clearance_pressure_velocity": Variable(
        ("clearance",), "Pa m/s", "nominal pressure by velocity of slip",
        _of_sliding(lambda own: own.power / own.model.inputs.parameter(own.rubbing.area)),
        worn=True, smooth=False, unbounded=True,
    ),
    "clearance_sliding_power": Variable(
        ("clearance",), "W", "normal force by velocity of slip",
        _of_sliding(lambda own: own.power), worn=True, smooth=False, unbounded=True,
    ),
    "clearance_sliding_work": Variable(
        ("clearance",), "J", "work of the normal force along the slip", None,
        worn=True, smooth=False,
    ),
    "clearance_sliding_distance": Variable(
        ("clearance",), "m", "distance of slip", None, worn=True, smooth=False
    ),
    "wear_volume": Variable(
        ("clearance", "side"), "m^3", "worn volume", None, worn=True, smooth=False
    ),
}  # fmt: skip
