"""Rigid contact: impacts change rates at once, and resting contact is a constraint.

While contact is closed the normal force is what keeps the indentation at zero. Errors of steps
move it to either side, so a pin that is all but at rest across the wall counts as touching a little
above it: round-off does not open a contact, the force does.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Protocol

from linkages.components.contributed.contacts import Contact, Geometry, RigidContact
from linkages.kernel.forces.contacts import ContactNodes
from linkages.kernel.forces.loads import Acting, Velocities
from linkages.kernel.forces.rubbing import Rubbing
from linkages.kernel.graph.scalars import Scalar, ScalarGraph

if TYPE_CHECKING:
    from linkages.kernel.closure.motion import Accelerations
    from linkages.kernel.forces.gaps import Gap
    from linkages.kernel.model import Model

NEAR, RESTING = 1e-7, 0.1
"""Distance from the wall over size, and rate over the least one that bounces, of a pin at rest."""

TOGETHER = 1e-9
"""Distance from the wall over size of a contact that is touched at the same time as another one."""

LEAST = 1e-9
"""Acceleration (m/s²) that smaller ones count as, so that roots have derivatives."""

REST = 1e-9
"""Rate behind an impact that closes a contact, over the least one that bounces."""


class Touchable(Protocol):
    """How far two bodies are apart where they may touch; see `linkages.kernel.forces.gaps.Gap`."""

    size: Scalar

    @property
    def indentation(self) -> Scalar:
        """Negative where the gap is open."""

    @property
    def smooth(self) -> Scalar:
        """What its sign is seen from."""

    def rate(self, velocities: Velocities) -> Scalar:
        """Rate of the indentation, at velocities that may be partial ones."""

    def pushed(self, accelerations: Accelerations) -> Scalar:
        """Second derivative of the indentation."""


class Unilateral(Acting):
    """A rigid contact along a gap, whatever that is; `Walls` knows those that it depends on.

    Attributes
    ----------
    model, graph, name
        Whose contact it is, and what modes are called by.
    gap
        What is zero where it is closed.
    law
        Its numbers.
    rubbing
        Friction along it, if there is any.
    geometry
        What touches what; None for ends of ways.
    """

    model: Model
    graph: ScalarGraph
    name: str
    gap: Touchable
    law: RigidContact
    rubbing: Rubbing | None = None
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
    def _slow(self) -> Scalar:
        return self.model.inputs.parameter(self.law.least_rate)

    @property
    def slowest(self) -> Scalar:
        """Rate that is none."""
        return REST * self._slow

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
        return speed + self.graph.select(rebound - self._slow, rebound, -rest)

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
        rate = self.speed / (RESTING * self._slow)
        square = rate * rate  # twice squared: flat where the pin is at rest, so that its rate tells
        resting = NEAR * self.gap.size * self.graph.apply("exp", -(square * square))
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
        least = self.graph.lift(LEAST)
        held = self.graph.select(pressed - least, pressed, least)
        pace = self.graph.sqrt(held / self.gap.size)
        # it has no effect on the motion: beside tangents that shrink, its own would grow
        swing = self.model.switches.memory(self.touch, pace, alike=True)
        settling = swing * (2.0 * self.speed + swing * self.gap.indentation)
        return self.graph.select(touching, pressed + settling, pressed)

    @property
    def pressing(self) -> Scalar:
        """Mode: whether a closed contact presses."""
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
            self.rubbing = Rubbing(self, self.gap, law.friction)

    @cached_property
    def friction(self) -> Scalar:
        """Force of friction along the direction of slip."""
        walls = self.model.walls
        if self.rubbing is None:
            return self.graph.zero
        return walls.force(walls.along(walls.place(self)))
