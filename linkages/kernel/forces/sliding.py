"""Work and distance of slip in clearances whose surfaces wear.

Archard's law takes the work ∫ F |v| dt of the normal force along the slip. A massless link presses
with its tension: where that is negative, a real journal would lie at the other side of its bearing,
and the magnitude counts.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from linkages.components.contributed.normal_forces import Contact, PinInHole
from linkages.components.contributed.terms import Displacement
from linkages.kernel.scalars import Scalar

if TYPE_CHECKING:
    from linkages.kernel.model import Model
    from linkages.kernel.velocities import Accelerations


class SlidingNodes:
    """What presses and slips in one clearance; of a link at given accelerations."""

    def __init__(
        self, model: Model, term: Contact | Displacement, accelerations: Accelerations | None = None
    ) -> None:
        assert term.rubbing is not None
        self.model, self.term, self.rubbing = model, term, term.rubbing
        self._accelerations = model.accelerations if accelerations is None else accelerations
        contacts = {nodes.contact.name: nodes for nodes in model.contacts}
        self._contact = contacts[term.name] if isinstance(term, Contact) else None

    @property
    def touching(self) -> Scalar:
        """Not negative where the sides touch."""
        return self.model.graph.one if self._contact is None else self._contact.touching

    @property
    def force(self) -> Scalar:
        """Normal force in newtons; of a massless link its tension."""
        if self._contact is not None:
            return self._contact.force
        partial = self.model.stretched(self.term.name)
        return -self.model.required_force(self._accelerations, partial)

    @property
    def slip(self) -> Scalar:
        """Velocity of slip of the journal in its bearing in m/s."""
        velocities = self.model.velocities
        if self._contact is not None:
            return self._contact.gap.slip(velocities)
        assert isinstance(self.term, Displacement)
        assert self.rubbing.radius is not None
        zero = self.model.graph.zero
        pin, hole = (zero if n is None else velocities.turning(n) for n in self._bodies)
        radius = self.model.inputs.parameter(self.rubbing.radius)
        size = self.model.inputs.parameter(self.term.links[0].points[self.term.renamed][0])
        return size * velocities.bodies[self.term.name] + radius * pin - (radius + size) * hole

    @property
    def _bodies(self) -> tuple[str | None, str | None]:
        """Bodies of journal and bearing; None for the ground."""
        term = self.term if isinstance(self.term, Displacement) else self.term.geometry
        assert isinstance(term, Displacement | PinInHole)
        other = self.model.mechanism.carrier(term.joint)
        return (other, term.body) if self.rubbing.hole else (term.body, other)

    @property
    def sides(self) -> tuple[Scalar, Scalar]:
        """Angles of journal and bearing."""
        positions, zero = self.model.positions, self.model.graph.zero
        first, second = (zero if n is None else positions.angle(n) for n in self._bodies)
        return first, second

    @property
    def way(self) -> Scalar:
        """Direction from the centre of the bearing to that of the journal, where both touch."""
        if self._contact is not None:
            along = self._contact.gap.turned(0)
        else:
            along = self.model.positions.angle(self.term.name)
        return along + math.pi if self.rubbing.hole else along

    @property
    def power(self) -> Scalar:
        """F |v| in watts."""
        force = self.force
        switches = self.model.switches
        if self._contact is None and self._at_kernel and switches.equivalent:
            force = force + switches.held(force)
        return magnitude(force) * magnitude(self.slip)

    @property
    def _at_kernel(self) -> bool:
        return self._accelerations is not self.model.accelerations

    @property
    def speed(self) -> Scalar:
        """|v| while the sides touch, in m/s."""
        return self.model.graph.select(self.touching, magnitude(self.slip), self.model.graph.zero)


def magnitude(node: Scalar) -> Scalar:
    """|x|; its corner is no mode: steps do not end there."""
    return node.graph.select(node, node, -node)


def sliding_rates(model: Model) -> list[Scalar]:
    """F |v| of all clearances that wear, then |v|, at accelerations that the state implies."""
    terms = model.mechanism.rubbing
    if not terms:
        return []
    moving = model.moving_with(model.free_accelerations)
    nodes = [SlidingNodes(model, term, moving) for term in terms]
    return [*(own.power for own in nodes), *(own.speed for own in nodes)]
