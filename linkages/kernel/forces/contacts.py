"""What a pin and its hole do to each other: normal force and friction at one point of contact."""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING

from linkages.components.contributed.contacts import Contact, NormalForce
from linkages.components.contributed.functions import Function, Internal, Measured
from linkages.kernel.forces.loads import Acting, Forces, Torques, Velocities
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.vectors import Vector
from linkages.kernel.numbers.laws import value_of

if TYPE_CHECKING:
    from linkages.kernel.model import Model

NEAREST = 1e-9
"""Offset over size below which it has no direction."""

LEAST = 1e-30
"""Indentation in metres that a smaller one counts as, so that roots and logarithms exist."""


class ContactNodes(Acting):
    """A contact: its offset, the forces that it causes, and what they store and dissipate.

    Both bodies touch at one point C, a radius of the pin away from its centre in the direction n_h
    from the centre of the hole to that of the pin. Slip is the velocity of the pin's body against
    the hole's at C, along n_h turned by +90°.
    """

    def __init__(self, model: Model, contact: Contact) -> None:
        self.model, self.graph, self.contact = model, model.graph, contact
        self.other = model.mechanism.carrier(contact.joint)
        self.size = model.inputs.parameter(contact.size)
        self.radius = model.inputs.parameter(contact.pin_radius)

    @cached_property
    def offset(self) -> Vector:
        """From the pin of the joint to the displaced point."""
        x, y = (self.model.positions.displacements[name] for name in self.contact.axes)
        return Vector(x, y)

    def offset_rate(self, velocities: Velocities) -> Vector:
        """Its rate, at velocities that may be partial ones."""
        x, y = (velocities.moving(name) for name in self.contact.axes)
        return Vector(x, y)

    @cached_property
    def distance(self) -> Scalar:
        """Length of the offset; some small number where that has no direction."""
        least = self.size * NEAREST
        square = self.offset.square
        return self.graph.sqrt(self.graph.select(square - least * least, square, least * least))

    @cached_property
    def normal(self) -> Vector:
        """Direction of the offset; shorter than 1 where that has none."""
        return self.offset * (1.0 / self.distance)

    @cached_property
    def _squares(self) -> Scalar:
        """Difference of squares, which keeps the digits of a difference of lengths."""
        return self.offset.square - self.size * self.size

    @cached_property
    def indentation(self) -> Scalar:
        """Negative where the gap is open."""
        return self._squares / (self.distance + self.size)

    def rate(self, velocities: Velocities) -> Scalar:
        """Rate of the indentation."""
        return self.normal.dot(self.offset_rate(velocities))

    def slip(self, velocities: Velocities) -> Scalar:
        """Slip of the pin in the hole."""
        body, other = self._turning(velocities)
        pin, hole = (other, body) if self.contact.hole else (body, other)
        along = self.normal.turned.dot(self.offset_rate(velocities))
        return along + self.radius * pin - (self.radius + self.distance) * hole

    def _turning(self, velocities: Velocities) -> tuple[Scalar, Scalar]:
        """Angular speeds of the displaced body and of the other one."""
        other = self.graph.zero if self.other is None else velocities.turning(self.other)
        return velocities.turning(self.contact.body), other

    def turned(self, order: int) -> Scalar:
        """Direction of the offset (`order` 0) and its rates; 0 where it has no direction."""
        if order == 0:
            return self.graph.apply("atan2", self.offset.y, self.offset.x)
        across = self.normal.turned * (1.0 / self.distance)
        turning = across.dot(self.offset_rate(self.model.velocities))
        if order == 1:
            return turning
        pushed = across.dot(self.offset_rate(self.model.accelerations))
        return pushed - 2.0 * turning * self.speed / self.distance

    @property
    def touch(self) -> str:
        """Name of the mode of touching."""
        return f"{self.contact.name}: touch"

    @property
    def gap(self) -> Scalar:
        """What the sign of the indentation is seen from (m): it is smooth where that is not."""
        return self._squares * (0.5 / self.size)

    @property
    @abstractmethod
    def touching(self) -> Scalar:
        """Mode: whether pin and hole touch."""

    @property
    @abstractmethod
    def force(self) -> Scalar:
        """Normal force, positive where it presses."""

    @property
    @abstractmethod
    def normal_loss(self) -> Scalar:
        """Power lost across the wall."""

    @cached_property
    def speed(self) -> Scalar:
        """The actual rate of the indentation."""
        return self.rate(self.model.velocities)

    @cached_property
    def friction(self) -> Scalar:
        """Force of friction on the pin along the direction of slip."""
        if self.contact.friction is None:
            return self.graph.zero
        slip = self.slip(self.model.velocities)
        law = self.contact.friction.coefficient
        return self.force * value_of(law, self.model.inputs, lambda _: slip)

    def power(self, velocities: Velocities) -> Scalar:
        """Power at some velocities: its generalised force if they are partial ones."""
        found = -(self.force * self.rate(velocities))
        if self.contact.friction is None:
            return found
        return found + self.friction * self.slip(velocities)

    @cached_property
    def friction_loss(self) -> Scalar:
        """Power lost along the wall."""
        return -(self.friction * self.slip(self.model.velocities))

    @property
    def working(self) -> Scalar:
        """Power of all but the elastic part, at the actual velocities."""
        return -(self.normal_loss + self.friction_loss)

    def forces(self) -> Forces:
        """On the displaced body through its offset, and the opposite at the joint."""
        contact = self.contact
        force = self.normal.turned * self.friction - self.normal * self.force
        return [(contact.axes[1], contact.displaced, force), (self.other, contact.joint, -force)]

    def torques(self) -> Torques:
        """Of the friction at C, about the centres of pin and hole."""
        on_pin = self.radius * self.friction
        on_hole = -(self.radius + self.distance) * self.friction
        bodies = (self.other, self.contact.body)
        pin, hole = bodies if self.contact.hole else bodies[::-1]
        return [(pin, on_pin), (hole, on_hole)]


class PressingNodes(ContactNodes):
    """A contact whose force follows a law of indentation and rate."""

    def __init__(self, model: Model, contact: Contact, law: NormalForce) -> None:
        super().__init__(model, contact)
        self.law = law

    @property
    def touching(self) -> Scalar:
        """Mode: whether pin and hole touch."""
        return self.model.switches.add(self.touch, self.gap)

    @property
    def pressing(self) -> Scalar:
        """Mode: whether the law presses while they touch; otherwise the contact is slack."""
        law, touching = self.law.pressing, self.touching
        if law is None:
            return touching
        name = f"{self.contact.name}: press"
        return self.model.switches.add(name, self.value(law), active=touching)

    @cached_property
    def pressed(self) -> Scalar:
        """The indentation where they touch, as laws take it."""
        return self.graph.select(self.indentation - LEAST, self.indentation, self.graph.lift(LEAST))

    def value(self, law: Function) -> Scalar:
        """What a law gives, such as the force or the energy."""
        return value_of(law, self.model.inputs, self._measured)

    def _measured(self, found: Measured | Internal) -> Scalar:
        if isinstance(found, Internal):
            return self.model.sense(found)
        return getattr(self, ("pressed", "speed", "first_rate")[found.order])

    @property
    def first_rate(self) -> Scalar:
        """Rate of the indentation at the last touch, not below the least one that counts."""
        assert self.law.least_rate is not None
        least = self.model.inputs.parameter(self.law.least_rate)
        kept = self.graph.select(self.speed - least, self.speed, least)
        _ = self.touching
        return self.model.switches.memory(self.touch, kept)

    def _while_touching(self, value: Scalar) -> Scalar:
        return self.graph.select(self.touching, value, self.graph.zero)

    @cached_property
    def force(self) -> Scalar:
        """Normal force, positive where it presses."""
        force = self.value(self.law.force)
        return self.graph.select(self.pressing, force, self.graph.zero)

    @property
    def potential(self) -> Scalar:
        """Energy of the elastic part, in slack as well."""
        return self._while_touching(self.value(self.law.energy))

    @cached_property
    def normal_loss(self) -> Scalar:
        """Power lost across the wall."""
        elastic = self._while_touching(self.value(self.law.elastic))
        return (self.force - elastic) * self.speed
