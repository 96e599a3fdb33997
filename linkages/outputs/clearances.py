"""Clearances: massless links and their force; offset, indentation, friction and slip of contacts.

A clearance whose journal and bearing stay in contact has the offset of its massless link.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable
from linkages.kernel.scalars import Scalar, Vector
from linkages.outputs import of_each

if TYPE_CHECKING:
    from linkages.kernel.forces.contact_forces import GapNodes


def _contact(model: Model, name: str) -> GapNodes | None:
    return next((nodes for nodes in model.contacts if nodes.contact.name == name), None)


def _force(model: Model, name: str) -> Scalar:
    """Tension: the force that would be needed to lengthen the link, reversed.

    Where journal and bearing may part, what presses them together.
    """
    if (own := _contact(model, name)) is not None:
        return own.force
    return -model.required_force(model.accelerations, model.stretched(name))


def _directions(
    order: int, link: Callable[[Model, str], Scalar]
) -> Callable[[Model], list[Scalar]]:
    """Directions of clearances (`order` 0), or a derivative of them; `link`: of massless ones."""

    def direction(model: Model, name: str) -> Scalar:
        own = _contact(model, name)
        return link(model, name) if own is None else own.gap.turned(order)

    return of_each("clearance", direction)


def _vector(model: Model, name: str, field: str) -> Vector:
    """From the joint to the displaced point, or the rate of that."""
    if (own := _contact(model, name)) is not None:
        gap = own.gap
        return gap.offset if field == "positions" else gap.offset_rate(model.velocities)
    term = next(term for term in model.mechanism.displacements if term.name == name)
    points: dict[str, Vector] = getattr(model, field).joints
    return points[term.renamed] - points[term.joint]


def _scalars(value: Callable[[GapNodes], Scalar]) -> Callable[[Model], list[Scalar]]:
    """One value of each clearance that opens, and zero of the others."""

    def scalar(model: Model, name: str) -> Scalar:
        own = _contact(model, name)
        return model.graph.zero if own is None else value(own)

    return of_each("clearance", scalar)


OUTPUTS = {
    "clearance_angle": Variable(
        ("clearance",), "rad", "clearance angle",
        _directions(0, lambda m, name: m.positions.angle(name)),
        default=True, coordinate=True, angle=True, rate="clearance_speed",
    ),
    "clearance_speed": Variable(
        ("clearance",), "rad/s", "clearance speed",
        _directions(1, lambda m, name: m.velocities.bodies[name]),
        default=True, rate="clearance_acceleration",
    ),
    "clearance_acceleration": Variable(
        ("clearance",), "rad/s^2", "clearance acceleration",
        _directions(2, lambda m, name: m.accelerations.bodies[name]), default=True,
    ),
    "clearance_force": Variable(
        ("clearance",), "N", "clearance force", of_each("clearance", _force),
        default=True, unbounded=True,
    ),
    "clearance_offset": Variable(
        ("clearance", "axis"), "m", "offset of the displaced point from the pin",
        of_each("clearance", lambda m, name: _vector(m, name, "positions")),
        default=True, opening=True, rate="clearance_offset_rate",
    ),
    "clearance_offset_rate": Variable(
        ("clearance", "axis"), "m/s", "rate of the offset",
        of_each("clearance", lambda m, name: _vector(m, name, "velocities")),
        default=True, opening=True,
    ),
    "clearance_indentation": Variable(
        ("clearance",), "m", "indentation, negative where the gap is open",
        _scalars(lambda contact: contact.gap.indentation),
        default=True, opening=True, rate="clearance_indentation_rate",
    ),
    "clearance_indentation_rate": Variable(
        ("clearance",), "m/s", "rate of the indentation", _scalars(lambda contact: contact.speed),
        opening=True, smooth=False,
    ),
    "clearance_friction": Variable(
        ("clearance",), "N", "force of friction on the journal along the wall of its bearing",
        _scalars(lambda contact: contact.friction), default=True, opening=True, smooth=False,
    ),
    "clearance_slip": Variable(
        ("clearance",), "m/s", "velocity of slip of the journal in its bearing",
        _scalars(lambda contact: contact.gap.slip(contact.model.velocities)),
        default=True, opening=True, smooth=False,
    ),
    "clearance_normal_loss": Variable(
        ("clearance",), "W", "power lost across the wall",
        _scalars(lambda contact: contact.normal_loss), opening=True, smooth=False,
    ),
    "clearance_friction_loss": Variable(
        ("clearance",), "W", "power lost by friction along the wall",
        _scalars(lambda contact: contact.friction_loss), opening=True, smooth=False,
    ),
    "clearance_normal_dissipation": Variable(
        ("clearance",), "J", "energy dissipated across the wall", None, opening=True, smooth=False
    ),
    "clearance_friction_dissipation": Variable(
        ("clearance",), "J", "energy dissipated along the wall", None, opening=True, smooth=False
    ),
    "clearance_state": Variable(
        ("clearance",), "1", "state of the contact", None, default=True, opening=True,
        smooth=False, flags=("free", "impact", "following"),
    ),
    "offset_position": Variable(
        ("offset",), "m", "offset",
        of_each("offset", lambda m, name: m.positions.displacements[name]),
        coordinate=True, rate="offset_rate",
    ),
    "offset_rate": Variable(
        ("offset",), "m/s", "offset rate",
        of_each("offset", lambda m, name: m.velocities.bodies[name]),
    ),
    "tilt_angle": Variable(
        ("tilt",), "rad", "tilt angle", of_each("tilt", lambda m, name: m.positions.angle(name)),
        coordinate=True, rate="tilt_speed",
    ),
    "tilt_speed": Variable(
        ("tilt",), "rad/s", "tilt speed",
        of_each("tilt", lambda m, name: m.velocities.bodies[name]),
    ),
}  # fmt: skip
