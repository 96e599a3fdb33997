"""Work and distance of slip in clearances whose surfaces wear.

Archard's law takes the work ∫ F |v| dt of the normal force along the slip. A massless link presses
with its tension: where that is negative, a real journal would lie at the other side of its bearing,
and the magnitude counts.

A rigid impact adds ∫ |v| dP over its normal impulse P. Along a path of impulses slip is piecewise
linear. Of impacts without one, those that contacts share and Moreau's, the slips v⁻ before and v⁺
behind are known, and the impulse f of friction. Coulomb's friction takes that while the normal
impulse grows by |f|/μ, which is all of it but where slip ends. Slip is taken as linear from v⁻ to
v⁺ meanwhile.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from linkages.components.contributed.normal_forces import Contact, PinInHole
from linkages.components.contributed.terms import Displacement
from linkages.kernel.forces.bearing_gaps import ProfiledGap
from linkages.kernel.forces.rigid_impacts import RigidNodes, Unilateral, mean_magnitude
from linkages.kernel.scalars import Scalar

if TYPE_CHECKING:
    from linkages.kernel.forces.generalised_forces import Velocities
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
        return self._slip(self.model.velocities)

    def _slip(self, velocities: Velocities) -> Scalar:
        if self._contact is not None:
            return self._contact.gap.slip(velocities)
        assert isinstance(self.term, Displacement)
        assert self.rubbing.radius is not None
        zero = self.model.graph.zero
        pin, hole = (zero if n is None else velocities.turning(n) for n in self._bodies)
        radius = self.model.inputs.parameter(self.rubbing.radius)
        size = self.model.inputs.parameter(self.term.links[0].points[self.term.renamed][0])
        return size * velocities.turning(self.term.name) + radius * pin - (radius + size) * hole

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
            gap = self._contact.gap
            if isinstance(gap, ProfiledGap):
                return self.model.graph.apply("atan2", gap.facing.y, gap.facing.x)
            along = gap.turned(0)
        else:
            along = self.model.positions.angle(self.term.name)
        return along + math.pi if self.rubbing.hole else along

    @property
    def power(self) -> Scalar:
        """F |v| in watts."""
        force = self.force
        switches = self.model.switches
        presses_at_once = self._contact is None or isinstance(self._contact, RigidNodes)
        if presses_at_once and self._at_kernel and switches.equivalent:
            force = force + switches.held(force)
        return magnitude(force) * magnitude(self.slip)

    def impulse(self, hit: Unilateral) -> Scalar:
        """What presses in an impact of a contact, as `force` does, in N s."""
        model, impulses = self.model, hit.impulses
        if self._contact is not None:
            if not isinstance(self._contact, RigidNodes):
                return model.graph.zero
            return impulses[model.walls.place(self._contact)]
        partial = model.stretched(self.term.name)
        rates = [model.inputs.rate(i) for i in range(len(model.partials))]
        before, behind = (
            model.inertia.product(model.moving_with(one), partial)
            for one in (rates, hit.rates_behind)
        )
        # rates in the place of accelerations, whose other parts cancel
        pushed = behind - before
        for place, contact in enumerate(model.rigid):
            pushed = pushed + impulses[place] * contact.gap.rate(partial)
        for place, rubbing in model.walls.rough.items():
            pushed = pushed - impulses[model.walls.along(place)] * rubbing.gap.slip(partial)
        return -pushed

    def in_impact(self, hit: Unilateral) -> Scalar:
        """Work of the normal impulse along the slip in an impact of a contact, in joules."""
        model, walls, impulse = self.model, self.model.walls, self.impulse(hit)
        if impulse is model.graph.zero:
            return impulse
        pairs = enumerate(zip(model.partials, hit.rates_behind, strict=True))
        behind = self.slip + model.graph.total(
            self._slip(partial) * (rate - model.inputs.rate(i)) for i, (partial, rate) in pairs
        )
        mean = mean_magnitude(self.slip, behind)
        rubbing = self._contact.rubbing if isinstance(self._contact, RigidNodes) else None
        if rubbing is None:
            return magnitude(impulse) * mean
        select, one, most = model.graph.select, model.graph.one, rubbing.friction
        friction = magnitude(hit.impulses[walls.along(walls.place(rubbing.contact))])
        slipping = select(-most, impulse, friction / select(-most, one, most))
        shared = slipping * mean
        if rubbing is not hit.rubbing:
            return shared
        return walls.unless_alone(hit, rubbing.slid(impulse), shared)

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
    moving = model.moving_with(model.free_accelerations)
    nodes = [SlidingNodes(model, term, moving) for term in model.mechanism.rubbing]
    return [*(own.power for own in nodes), *(own.speed for own in nodes)]
