"""Direction in which each clearance displaces, and the force along it."""

from __future__ import annotations

from collections.abc import Callable

from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable, labels
from linkages.kernel.scalars import Scalar


def _clearance_forces(model: Model) -> list[Scalar]:
    """Tension: the force that would be needed to lengthen the link, reversed.

    Where journal and bearing may part, what presses them together.
    """
    contacts = {nodes.contact.name: nodes for nodes in model.contacts}

    def force(name: str) -> Scalar:
        if name in contacts:
            return contacts[name].force
        return -model.required_force(model.accelerations, model.partial(name, stretch=name))

    return [force(name) for name in labels(model, "clearance")]


def _of_clearances(order: int) -> Callable[[Model], list[Scalar]]:
    """Directions of clearances (`order` 0), or a derivative of them."""
    of_link: Callable[[Model, str], Scalar] = (
        lambda model, name: model.positions.angle(name),
        lambda model, name: model.velocities.bodies[name],
        lambda model, name: model.accelerations.bodies[name],
    )[order]

    def nodes(model: Model) -> list[Scalar]:
        turned = {nodes.contact.name: nodes.gap.turned(order) for nodes in model.contacts}
        names = labels(model, "clearance")
        return [turned[name] if name in turned else of_link(model, name) for name in names]

    return nodes


OUTPUTS = {
    "clearance_angle": Variable(
        ("clearance",), "rad", "clearance angle", _of_clearances(0),
        default=True, coordinate=True, angle=True, rate="clearance_speed",
    ),
    "clearance_speed": Variable(
        ("clearance",), "rad/s", "clearance speed", _of_clearances(1),
        default=True, rate="clearance_acceleration",
    ),
    "clearance_acceleration": Variable(
        ("clearance",),
        "rad/s^2",
        "clearance acceleration",
        _of_clearances(2),
        default=True,
    ),
    "clearance_force": Variable(
        ("clearance",), "N", "clearance force", _clearance_forces,
        default=True, unbounded=True,
    ),
}  # fmt: skip
