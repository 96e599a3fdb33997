"""Rigid contact: impacts change rates at once, and resting contact is a constraint.

While contact is closed the normal force is what keeps the indentation at zero. Errors of steps
move it to either side, so a pin that is all but at rest across the wall counts as touching a little
above it: round-off does not open a contact, the force does.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

from linkages.components.contributed.contacts import Contact, RigidContact
from linkages.kernel.forces.contacts import ContactNodes
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.symmetric import solve_symmetric

if TYPE_CHECKING:
    from linkages.kernel.model import Model

NEAR, RESTING = 1e-7, 0.1
"""Distance from the wall over size, and rate over the least one that bounces, of a pin at rest."""

LEAST = 1e-9
"""Acceleration (m/s²) that smaller ones count as, so that roots have derivatives."""

REST = 1e-9
"""Rate behind an impact that closes a contact, over that before."""


class RigidNodes(ContactNodes):
    """A contact of rigid bodies.

    With the derivatives N of the indentation by the free coordinates, and their inertia J, an
    impulse P changes rates by −J⁻¹Nᵀ P, and the rate of the indentation by −N J⁻¹Nᵀ P.
    """

    def __init__(self, model: Model, contact: Contact, law: RigidContact) -> None:
        super().__init__(model, contact)
        self.law = law

    @cached_property
    def _moved(self) -> tuple[list[Scalar], Scalar]:
        """J⁻¹Nᵀ, and the mass 1/(N J⁻¹Nᵀ) that resists along the indentation."""
        along = [self.gap.rate(partial) for partial in self.model.partials]
        moved = solve_symmetric(self.model.mass_matrix, along)
        inverse = self.graph.total(a * b for a, b in zip(along, moved, strict=True))
        # concentric, the offset has no direction: any mass will do where nothing touches
        return moved, 1.0 / self.graph.select(-inverse, self.graph.one, inverse)

    @property
    def rates_behind(self) -> list[Scalar]:
        """Rates of the free coordinates behind an impact; a slow one closes the contact."""
        inputs, (moved, mass) = self.model.inputs, self._moved
        # nothing pulls a pin that comes to rest near the wall while it leaves
        speed = self.graph.select(self.speed, self.speed, self.graph.zero)
        rebound = inputs.parameter(self.law.restitution) * speed
        slow = inputs.parameter(self.law.least_rate)
        # a rate of 0 might be one of −1e-20, which is thrown back
        rebound = self.graph.select(rebound - slow, rebound, speed * -REST)
        impulse = (speed + rebound) * mass
        return [inputs.rate(i) - part * impulse for i, part in enumerate(moved)]

    @property
    def touching(self) -> Scalar:
        """Mode: whether contact is closed."""
        rate = self.speed / (RESTING * self.model.inputs.parameter(self.law.least_rate))
        square = rate * rate  # twice squared: flat where the pin is at rest, so that its rate tells
        resting = NEAR * self.gap.size * self.graph.apply("exp", -(square * square))
        return self.model.switches.add(
            self.touch, self.gap.smooth + resting, jump=self.rates_behind
        )

    @cached_property
    def _pressed(self) -> Scalar:
        """Acceleration into the wall if nothing held there."""
        return self.gap.pushed(self.model.unheld)

    @property
    def _holding(self) -> Scalar:
        """The force that keeps contact closed: negative where it would have to pull.

        It lets the indentation settle as fast as a massless link would swing.
        """
        touching, pressed = self.touching, self._pressed
        least = self.graph.lift(LEAST)
        held = self.graph.select(pressed - least, pressed, least)
        swing = self.model.switches.memory(self.touch, self.graph.sqrt(held / self.gap.size))
        settling = swing * (2.0 * self.speed + swing * self.gap.indentation)
        return self._moved[1] * self.graph.select(touching, pressed + settling, pressed)

    @property
    def pressing(self) -> Scalar:
        """Mode: whether a closed contact presses."""
        touching, name = self.touching, f"{self.contact.name}: press"
        return self.model.switches.add(name, self._holding, active=touching)

    @cached_property
    def force(self) -> Scalar:
        """Normal force of a closed contact."""
        return self.graph.select(self.pressing, self._holding, self.graph.zero)

    @property
    def potential(self) -> Scalar:
        """Rigid bodies store nothing."""
        return self.graph.zero

    @property
    def normal_loss(self) -> Scalar:
        """Constraints lose nothing; impacts lose at once."""
        return self.graph.zero
