"""Rigid contact: impacts, Coulomb friction and end stops.

A normal force λ and friction f along the slip change the rate d' of the indentation and the slip
w by d″ = … − W_nn λ + W_nt f and w' = … − W_nt λ + W_tt f, with the derivatives N and T of
indentation and slip by the free coordinates: W_nn = N J⁻¹ Nᵀ, W_nt = N J⁻¹ Tᵀ, W_tt = T J⁻¹ Tᵀ.
Impulses do the same to rates. In an impact the impulse grows along straight pieces [1]_, [2]_:
friction opposes the slip until that ends; then it holds, or as much of it as there is.

References
----------
.. [1] E. J. Routh, Dynamics of a System of Rigid Bodies, Macmillan 1860.
.. [2] Y. Wang, M. T. Mason, Two-dimensional rigid-body collisions with friction, J. Appl. Mech. 59
       (1992) 635.

While contact is closed the normal force is what keeps the indentation at zero. Errors of steps
move it to either side, so a pin that is all but at rest across the wall counts as touching a little
above it: round-off does not open a contact, the force does.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, assert_never

from linkages.components.contributed.load_measures import End, Load
from linkages.components.contributed.normal_forces import (
    Contact,
    Geometry,
    NormalForce,
    OilFilm,
    RigidContact,
)
from linkages.components.contributed.state_laws import NOTHING
from linkages.kernel.forces.contact_forces import ContactNodes, FilmNodes, PressingNodes
from linkages.kernel.forces.gaps import GapNodes, Touchable
from linkages.kernel.forces.generalised_forces import (
    Acting,
    Forces,
    LoadNodes,
    Torques,
    Velocities,
    load_nodes,
)
from linkages.kernel.scalars import Scalar, ScalarGraph

if TYPE_CHECKING:
    from linkages.components.contributed.terms import Parameter
    from linkages.kernel.forces.gaps import Gap
    from linkages.kernel.model import Model
    from linkages.kernel.velocities import Accelerations


class RigidFriction:
    """Friction of a rigid contact, and its impacts while no other one touches."""

    def __init__(self, contact: Unilateral, gap: Gap, friction: Parameter) -> None:
        self.model, self.graph, self.gap = contact.model, contact.graph, gap
        self.contact, self.law, self.path = contact, contact.law, friction.path
        self.friction = self.model.inputs.parameter(friction)

    @cached_property
    def slip(self) -> Scalar:
        """The actual slip."""
        return self.gap.slip(self.model.velocities)

    @cached_property
    def along_slip(self) -> list[Scalar]:
        """T, the derivatives of the slip by the rates of the free coordinates."""
        return [self.gap.slip(partial) for partial in self.model.partials]

    @cached_property
    def moved(self) -> list[Scalar]:
        """J⁻¹Tᵀ."""
        return self.model.accelerated(self.along_slip)

    @cached_property
    def normal(self) -> Scalar:
        """W_nn."""
        place = self.model.walls.place(self.contact)
        return self.model.walls.mobility(place, place)

    @cached_property
    def mixed(self) -> Scalar:
        """W_nt."""
        across = [self.gap.rate(partial) for partial in self.model.partials]
        return self.graph.total(a * b for a, b in zip(across, self.moved, strict=True))

    @cached_property
    def tangential(self) -> Scalar:
        """W_tt."""
        result = self.graph.total(a * b for a, b in zip(self.along_slip, self.moved, strict=True))
        # concentric, as for W_nn: what touches slips
        return self.graph.select(-result, self.graph.one, result)

    @property
    def jamming(self) -> Scalar:
        """Positive where W_nn < μ |W_nt|: no finite force keeps a sliding contact closed."""
        pushed = self.friction * self.mixed
        return pushed * pushed - self.normal * self.normal

    @cached_property
    def _sense(self) -> Scalar:
        return self.graph.select(self.slip, self.graph.one, -self.graph.one)

    @cached_property
    def _first(self) -> Scalar:
        """By how much impulses lower the rate, over them, while it slips."""
        return self.normal + self.friction * self._sense * self.mixed

    @cached_property
    def _slows(self) -> Scalar:
        """By how much impulses lower the slip, over them; it ends where that is positive."""
        return self._sense * self.mixed + self.friction * self.tangential

    @cached_property
    def _until(self) -> Scalar:
        """The impulse at which slip ends."""
        slows = self.graph.select(-self._slows, self.graph.one, self._slows)
        return self._sense * self.slip / slows

    @cached_property
    def _holds(self) -> Scalar:
        """Impulse along the wall over the normal one behind the end of slip."""
        ratio, most = self.mixed / self.tangential, self.friction
        ratio = self.graph.select(ratio - most, most, ratio)
        return self.graph.select(-most - ratio, -most, ratio)

    @cached_property
    def _second(self) -> Scalar:
        """As `_first`, behind the end of slip."""
        return self.normal - self._holds * self.mixed

    def _by_piece(self, beyond: Scalar, first: Scalar, second: Scalar) -> Scalar:
        """The one that holds while it slips, or behind the end of slip."""
        graph = self.graph
        return graph.select(-self._slows, first, graph.select(-beyond, first, second))

    def impulse(self, fall: Scalar) -> Scalar:
        """Normal impulse that lowers the rate of the indentation by so much."""
        slope = self.graph.select(-self._first, self.graph.one, self._first)
        beyond = fall - self._first * self._until
        return self._by_piece(beyond, fall / slope, self._until + beyond / self._second)

    def along(self, impulse: Scalar) -> Scalar:
        """Impulse of friction along the slip that goes with a normal impulse."""
        slipping, beyond = -self.friction * self._sense, impulse - self._until
        held = slipping * self._until + self._holds * beyond
        return self._by_piece(beyond, slipping * impulse, held)

    def lost(self, impulse: Scalar) -> Scalar:
        """Energy that friction takes: on each piece of the path its impulse times the mean slip."""
        sliding = self._by_piece(impulse - self._until, impulse, self._until)
        first, whole = self.along(sliding), self.along(impulse)
        between, behind = (
            self.slip - self.mixed * normal + self.tangential * along
            for normal, along in ((sliding, first), (impulse, whole))
        )
        return -0.5 * (first * (self.slip + between) + (whole - first) * (between + behind))

    def rebound(self, restitution: Scalar, speed: Scalar) -> Scalar:
        """Rate at which it leaves, of an impact at a speed."""
        if self.law.impact == "poisson":
            whole = (1.0 + restitution) * self.impulse(speed)
            beyond = whole - self._until
            later = self._first * self._until + self._second * beyond
            return self._by_piece(beyond, self._first * whole, later) - speed
        wanted = restitution * speed
        beyond = speed + wanted - self._first * self._until
        most = self._most(self._by_piece(beyond, self.graph.zero, self._until), speed)
        return self._by_piece(beyond, wanted, self.graph.select(most - wanted, wanted, most))

    def _most(self, until: Scalar, speed: Scalar) -> Scalar:
        """The fastest rebound behind the end of slip by which energy does not grow.

        Until then so much is lost; later −d' dP − w dF is gained, with both rates linear in P.
        """
        rate = speed - self._first * until
        lost = 0.5 * until * (speed + rate + self.friction * self._sense * self.slip)
        held = self._holds
        bent = self._second - held * (self.mixed - held * self.tangential)
        further = (rate + self.graph.sqrt(rate * rate + 2.0 * bent * lost)) / bent
        return self._second * further - rate


RESTING = 0.1
"""Rate over the least one that bounces, of a pin at rest."""

TOGETHER = 1e-9
"""Distance from the wall over size of a contact that is touched at the same time as another one."""

LEAST = 1e-9
"""Acceleration (m/s²) that smaller ones count as, so that roots have derivatives."""

REST = 1e-9
"""Rate behind an impact that closes a contact, over the least one that bounces."""


class Unilateral(Acting):
    """A rigid contact along a gap, or at the end of a way, which has no `geometry`."""

    model: Model
    graph: ScalarGraph
    name: str
    gap: Touchable
    law: RigidContact
    rubbing: RigidFriction | None = None
    geometry: Geometry | None = None

    @property
    def touch(self) -> str:
        """Name of the mode of touching."""
        return f"{self.name}: touch"

    @cached_property
    def speed(self) -> Scalar:
        """The actual rate of the indentation."""
        return self.gap.rate(self.model.velocities)

    @property
    def least_rate(self) -> Scalar:
        """An impact that would part them more slowly leaves contact closed."""
        return self.model.inputs.parameter(self.law.least_rate)

    @property
    def slowest(self) -> Scalar:
        """Rate that is none."""
        return REST * self.least_rate

    @property
    def _approach(self) -> Scalar:
        """The speed; nothing pulls a pin that comes to rest near the wall while it leaves."""
        return self.graph.select(self.speed, self.speed, self.graph.zero)

    @property
    def _restitution(self) -> Scalar:
        return self.model.inputs.parameter(self.law.restitution)

    @property
    def fall(self) -> Scalar:
        """By how much an impact lowers the rate; a slow one closes the contact."""
        speed, rough = self._approach, self.rubbing
        if rough is None:
            return self._falls(speed, self._restitution * speed)
        return self._falls(speed, rough.rebound(self._restitution, speed))

    @property
    def shared_fall(self) -> Scalar:
        """The same by Newton's law in impacts that contacts share."""
        return self._shared(self._restitution * self._approach)

    @property
    def stopping_fall(self) -> Scalar:
        """The same without restitution."""
        return self._shared(self.graph.zero)

    def _shared(self, rebound: Scalar) -> Scalar:
        # one that leaves may be kept from it by others, and closes then
        kept = self.speed - self.slowest
        return self.graph.select(self.speed, self._falls(self._approach, rebound), kept)

    def _falls(self, speed: Scalar, rebound: Scalar) -> Scalar:
        """A speed and its rebound; none where that is slow."""
        # a rate of 0 might be one of −1e-20, which is thrown back; it is the same for neighbours
        rest = self.graph.select(self.slowest - speed, speed, self.slowest)
        return speed + self.graph.select(rebound - self.least_rate, rebound, -rest)

    @property
    def together(self) -> Scalar:
        """Not negative where it takes part in the impact of another one at the same time."""
        return self.gap.smooth + TOGETHER * self.gap.size

    @property
    def met(self) -> Scalar:
        """Not negative where it takes part in an impact, also in its own."""
        return self.nearness + TOGETHER * self.gap.size

    @property
    def impulses(self) -> list[Scalar]:
        """Impulses of all contacts in an impact of this one: normal ones, then frictions."""
        return self.model.walls.impulses(self)

    @property
    def rubbed(self) -> list[Scalar]:
        """Energy that each friction takes in an impact of this contact."""
        return self.model.walls.rubbed(self)

    @property
    def rates_behind(self) -> list[Scalar]:
        """Rates of the free coordinates behind an impact."""
        walls = self.model.walls
        impulses, count = self.impulses, len(walls.contacts)
        pairs = list(zip(walls.moved, impulses[:count], strict=True))
        rough = zip(walls.rough.values(), impulses[count:], strict=True)
        pairs += [(rubbing.moved, -impulse) for rubbing, impulse in rough]
        return [
            self.model.inputs.rate(i) - self.graph.total(part[i] * p for part, p in pairs)
            for i in range(len(self.model.topology.free))
        ]

    @property
    def nearness(self) -> Scalar:
        """What is positive where it touches."""
        return self._nearness(self.gap.near)

    @property
    def nearness_kept(self) -> Scalar | None:
        """The same where it touches already, if that is another function."""
        return None if self.gap.kept == self.gap.near else self._nearness(self.gap.kept)

    def _nearness(self, near: float) -> Scalar:
        rate = self.speed / (RESTING * self.least_rate)
        square = rate * rate  # twice squared: flat where the pin is at rest, so that its rate tells
        resting = near * self.gap.size * self.graph.apply("exp", -(square * square))
        return self.gap.smooth + resting

    @property
    def touching(self) -> Scalar:
        """Mode: whether contact is closed."""
        walls = self.model.walls
        return walls.touching[walls.place(self)]

    @cached_property
    def needed(self) -> Scalar:
        """Acceleration out of the wall that keeps contact closed: negative where it must pull.

        It lets the indentation settle as fast as a massless link would librate.
        """
        touching, pressed = self.touching, self.gap.pushed(self.model.unheld)
        least, size = self.graph.lift(LEAST), pressed
        if self.law.adhesion is not None:  # it may be closed while it is pulled
            size = self.graph.select(pressed, pressed, -pressed)
        held = self.graph.select(size - least, size, least)
        pace = self.graph.sqrt(held / self.gap.size)
        # it has no effect on the motion: beside tangents that shrink, its own would grow
        swing = self.model.switches.memory(self.touch, pace, insensitive=True)
        settling = swing * (2.0 * self.speed + swing * self.gap.indentation)
        return self.graph.select(touching, pressed + settling, pressed)

    @property
    def adhesion(self) -> Scalar:
        """Largest tensile force of a closed contact."""
        law, zero = self.law.adhesion, self.graph.zero
        return zero if law is None else self.model.inputs.parameter(law)

    @property
    def pressing(self) -> Scalar:
        """Mode: whether a closed contact has a force, which presses or is held by adhesion."""
        walls = self.model.walls
        return walls.pressing[walls.place(self)]

    @property
    def force(self) -> Scalar:
        """Normal force of a closed contact."""
        walls = self.model.walls
        return walls.force(walls.place(self))

    @property
    def potential(self) -> Scalar:
        """Rigid bodies store nothing."""
        return self.graph.zero

    @property
    def normal_loss(self) -> Scalar:
        """Constraints lose nothing; impacts lose at once."""
        return self.graph.zero


class RigidNodes(Unilateral, ContactNodes):
    """A contact of rigid bodies in a clearance."""

    gap: Gap

    def __init__(self, model: Model, contact: Contact, law: RigidContact) -> None:
        super().__init__(model, contact)
        self.law, self.name, self.geometry = law, contact.name, contact.geometry
        if law.friction is not None:
            self.rubbing = RigidFriction(self, self.gap, law.friction)

    @cached_property
    def friction(self) -> Scalar:
        walls = self.model.walls
        if self.rubbing is None:
            return self.graph.zero
        return walls.force(walls.along(walls.place(self)))


SIZE = 0.1
"""Of a way (m, rad): one that has come to rest within a ten-millionth of it touches its end."""


class EndGap(Touchable):
    """How far a measure is beyond its end: positive where it passes it."""

    def __init__(self, model: Model, end: End, along: LoadNodes) -> None:
        self.model, self.end, self.along = model, end, along
        self.size = model.graph.lift(SIZE)
        self.sense = 1.0 if end.upper else -1.0

    @property
    def indentation(self) -> Scalar:
        return self.sense * (self.along.displacement - self.model.inputs.parameter(self.end.limit))

    def rate(self, velocities: Velocities) -> Scalar:
        return self.sense * self.along.rate(velocities)

    def pushed(self, accelerations: Accelerations) -> Scalar:
        """Its second derivative: the rate's own derivative along the motion."""
        model = self.model
        known = [accelerations.bodies[name] for name in model.topology.free]
        known += [model.graph.zero] * len(model.internal)  # no rate depends on internal states
        speed = self.rate(model.velocities)
        return model.switches.rates([speed], model.integrated_accelerations(known))[0]


class EndNodes(Unilateral):
    """An end of a way."""

    def __init__(self, model: Model, end: End, place: int) -> None:
        if not model.topology.coordinates:
            message = "nothing moves freely, so nothing bounces; expected 'stiffness'"
            raise model.mechanism.error([((*end.path, "restitution"), message)])
        self.model, self.graph, self.end = model, model.graph, end
        self.name, self.law = end.name, end.law
        self.along = load_nodes(model, Load(end.measure, NOTHING, end.path), place)
        gap = EndGap(model, end, self.along)
        self.gap, self.sense = gap, gap.sense

    def power(self, velocities: Velocities) -> Scalar:
        return -(self.force * self.gap.rate(velocities))

    @property
    def working(self) -> Scalar:
        """Constraints lose nothing."""
        return self.graph.zero

    @cached_property
    def _pushing(self) -> LoadNodes:
        result = load_nodes(self.model, self.along.load, self.along.index)
        result.given_force = -self.sense * self.force
        return result

    def forces(self) -> Forces:
        """On both sides of the measure, as a load along it."""
        return self._pushing.forces()

    def torques(self) -> Torques:
        return self._pushing.torques()


def gap_nodes(model: Model, contact: Contact) -> GapNodes:
    """The nodes of a contact, or of a film."""
    match contact.normal:
        case NormalForce() as law:
            return PressingNodes(model, contact, law)
        case RigidContact() as law:
            return RigidNodes(model, contact, law)
        case OilFilm() as law:
            return FilmNodes(model, contact, law)
        case _ as law:
            assert_never(law)
