"""Clearances: massless links and their force; offset, indentation, friction and slip of contacts.

A clearance whose journal and bearing stay in contact has the offset of its massless link.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable, labels
from linkages.kernel.scalars import Scalar, Vector

if TYPE_CHECKING:
    from linkages.kernel.forces.contact_forces import GapNodes


def _clearance_forces(model: Model) -> list[Scalar]:
    """Tension: the force that would be needed to lengthen the link, reversed.

    Where journal and bearing may part, what presses them together.
    """
    contacts = {nodes.contact.name: nodes for nodes in model.contacts}

    def force(name: str) -> Scalar:
        if name in contacts:
            return contacts[name].force
        return -model.required_force(model.accelerations, model.stretched(name))

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


def _contacts(model: Model) -> dict[str, GapNodes]:
    return {nodes.contact.name: nodes for nodes in model.contacts}


def _vectors(field: str) -> Callable[[Model], list[Scalar]]:
    """From the joint to the displaced point, or the rate of that."""

    def nodes(model: Model) -> list[Scalar]:
        contacts = _contacts(model)
        links = {term.name: term for term in model.mechanism.displacements}
        result: list[Vector] = []
        for name in labels(model, "clearance"):
            if name in contacts:
                own = contacts[name].gap
                result.append(
                    own.offset if field == "positions" else own.offset_rate(model.velocities)
                )
            else:
                points: dict[str, Vector] = getattr(model, field).joints
                result.append(points[links[name].renamed] - points[links[name].joint])
        return [value for vector in result for value in (vector.x, vector.y)]

    return nodes


def _scalars(value: Callable[[GapNodes], Scalar]) -> Callable[[Model], list[Scalar]]:
    """One value of each clearance that opens, and zero of the others."""

    def nodes(model: Model) -> list[Scalar]:
        contacts = _contacts(model)
        names = labels(model, "clearance")
        return [value(contacts[n]) if n in contacts else model.graph.zero for n in names]

    return nodes


def _tilts(field: str) -> Callable[[Model], list[Scalar]]:
    def nodes(model: Model) -> list[Scalar]:
        if field == "positions":
            return [model.positions.angle(name) for name in labels(model, "tilt")]
        return [getattr(model, field).bodies[name] for name in labels(model, "tilt")]

    return nodes


def _offsets(field: str) -> Callable[[Model], list[Scalar]]:
    def nodes(model: Model) -> list[Scalar]:
        if field == "positions":
            return [model.positions.displacements[name] for name in labels(model, "offset")]
        return [getattr(model, field).bodies[name] for name in labels(model, "offset")]

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
    "clearance_offset": Variable(
        ("clearance", "axis"), "m", "offset of the displaced point from the pin",
        _vectors("positions"), default=True, opening=True, rate="clearance_offset_rate",
    ),
    "clearance_offset_rate": Variable(
        ("clearance", "axis"), "m/s", "rate of the offset", _vectors("velocities"),
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
        ("offset",), "m", "offset", _offsets("positions"),
        coordinate=True, rate="offset_rate",
    ),
    "offset_rate": Variable(("offset",), "m/s", "offset rate", _offsets("velocities")),
    "tilt_angle": Variable(
        ("tilt",), "rad", "tilt angle", _tilts("positions"),
        coordinate=True, rate="tilt_speed",
    ),
    "tilt_speed": Variable(
        ("tilt",), "rad/s", "tilt speed", _tilts("velocities"),
    ),
}  # fmt: skip
