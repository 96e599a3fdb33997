"""What bodies that touch do to each other: normal force and friction at one point of contact."""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING

from linkages.components.contributed.contacts import Contact, NormalForce
from linkages.components.contributed.functions import Function, Internal, Measured
from linkages.kernel.forces.across import GapNodes
from linkages.kernel.forces.loads import Forces, Torques, Velocities
from linkages.kernel.forces.slip import friction_force
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.numbers.laws import value_of

if TYPE_CHECKING:
    from linkages.kernel.model import Model

LEAST = 1e-30
"""Indentation in metres that a smaller one counts as, so that roots and logarithms exist."""


class ContactNodes(GapNodes):
    """A contact: a normal force, and friction under it."""

    @property
    @abstractmethod
    def pressing(self) -> Scalar:
        """Mode: whether a force presses."""

    @cached_property
    def friction(self) -> Scalar:
        """Force of friction along the direction of slip."""
        if self.contact.friction is None:
            return self.graph.zero
        slip, law = self.gap.slip(self.model.velocities), self.contact.friction
        return friction_force(
            self.model, self.contact.name, law, normal=self.force, slip=slip, active=self.pressing
        )

    def power(self, velocities: Velocities) -> Scalar:
        """Power at some velocities: its generalised force if they are partial ones."""
        found = -(self.force * self.gap.rate(velocities))
        if self.friction is self.graph.zero:
            return found
        return found + self.friction * self.gap.slip(velocities)

    @cached_property
    def friction_loss(self) -> Scalar:
        """Power lost along the wall."""
        return -(self.friction * self.gap.slip(self.model.velocities))

    def forces(self) -> Forces:
        """On both bodies."""
        return self.gap.forces(self.force, self.friction)

    def torques(self) -> Torques:
        """Of the same, about the points where they act."""
        return self.gap.torques(self.force, self.friction)


class PressingNodes(ContactNodes):
    """A contact whose force follows a law of indentation and rate."""

    def __init__(self, model: Model, contact: Contact, law: NormalForce) -> None:
        super().__init__(model, contact)
        self.law = law

    @property
    def touching(self) -> Scalar:
        """Mode: whether they touch."""
        return self.model.switches.add(self.touch, self.gap.smooth)

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
        return self.graph.select(
            self.gap.indentation - LEAST, self.gap.indentation, self.graph.lift(LEAST)
        )

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
