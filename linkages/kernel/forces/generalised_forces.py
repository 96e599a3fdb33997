"""Generalised force, power and potential energy of loads."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, assert_never

from linkages.components.contributed.functions import PRESSED, Function, Internal, Measured, V, X
from linkages.components.contributed.load_measures import (
    BodyAxis,
    Coordinate,
    Distance,
    Load,
    Measure,
    Slide,
    Turn,
    written,
)
from linkages.components.contributed.state_laws import (
    addends,
    everywhere,
    internal,
    leaves,
    measured_in,
    monomial,
    rated,
)
from linkages.kernel.differentiation import derivative_along
from linkages.kernel.inputs import value_of
from linkages.kernel.scalars import Level, Scalar, Vector
from linkages.reading.paths import dotted

if TYPE_CHECKING:
    from linkages.kernel.model import Model

Forces = list[tuple[str | None, str, Vector]]
"""Bodies (None: the ground), their joints, and the forces on them there."""

Torques = list[tuple[str | None, Scalar]]
"""Bodies (None: the ground) and the torques on them."""


JAMMED = (
    "it jams: the force that presses grows with the friction by as much, so that none or two go "
    "with the motion (self-locking, Painlevé's paradox); expected a smaller coefficient or radius"
)


class Velocities(Protocol):
    """Velocities, actual or partial."""

    joints: dict[str, Vector]

    def turning(self, name: str) -> Scalar:
        """Angular speed of a body."""
        ...

    def moving(self, name: str) -> Scalar:
        """Rate of a body's own coordinate."""
        ...


class Acting(ABC):
    """What acts on a mechanism, whatever it is: its power, its forces, what it stores."""

    @abstractmethod
    def power(self, velocities: Velocities) -> Scalar:
        """Power at some velocities: its generalised force if they are partial ones."""

    @property
    @abstractmethod
    def potential(self) -> Scalar:
        """Energy that it stores."""

    @property
    @abstractmethod
    def working(self) -> Scalar:
        """Power of what it does not store, at the actual velocities."""

    @abstractmethod
    def forces(self) -> Forces:
        """It as forces on bodies, as far as it consists of them."""

    @abstractmethod
    def torques(self) -> Torques:
        """It as torques on bodies, as far as it consists of them."""


class LoadNodes(Acting):
    """A load for whatever law; `index` counts as `linkages.kernel.inputs.wound_angles` does."""

    undefined = "it has no finite value"
    """Why it may have no value, as the end of a sentence."""

    measure: Measure

    def __init__(self, model: Model, load: Load, index: int) -> None:
        self.model = model
        if load.bearing is not None:
            self.undefined = JAMMED
        self.graph = model.graph
        self.load, self.measure = load, load.measure
        self.index = index
        self.given_force: Scalar | None = None

    @property
    @abstractmethod
    def displacement(self) -> Scalar:
        """What it is measured by, x."""

    @abstractmethod
    def rate(self, velocities: Velocities) -> Scalar:
        """The rate of x, at velocities that may be partial ones."""

    @property
    def pushed(self) -> Scalar:
        """The force along the measure: that of the law, unless another one is given."""
        return self.value(self.load.force) if self.given_force is None else self.given_force

    def forces(self) -> Forces:
        return []

    def torques(self) -> Torques:
        return []

    def value(self, law: Function) -> Scalar:
        """What a law gives, such as the force or the energy."""
        return value_of(law, self.model.inputs, self.sensed, self.mode)

    def mode(self, part: Function, node: Scalar) -> Scalar:
        """On which side of zero the motion is of what makes a part of the law jump or turn."""
        name = f"{dotted(self.load.path)}: {written(part, self.load.measure)}"
        return self.model.switches.side(name, node)

    def sensed(self, found: Measured | Internal) -> Scalar:
        """The value or rate of a measure, its own or another one, or an internal state."""
        if isinstance(found, Measured) and found.measure is None:
            return self.measured(found.order)
        return self.model.sense(found)

    def measured(self, order: int) -> Scalar:
        """The displacement, its actual rate, or the force that presses surfaces together (3)."""
        if order == PRESSED.order:
            return self.model.pressing[self.index]
        return self.rate(self.model.velocities) if order else self.displacement

    def _power(self, law: Function, velocities: Velocities) -> Scalar:
        return self.value(law) * self.rate(velocities)

    def _components(self, law: Function) -> list[Scalar]:
        return [self.value(law)]

    @property
    def internal_rates(self) -> list[Scalar]:
        """Rates of its internal states; zero for those that are sampled."""
        zero = self.graph.zero
        return [self.value(s.law) if s.period is None else zero for s in self.load.states]

    @property
    def next_values(self) -> list[Scalar]:
        """What its internal states become at an update; the values of those that have none."""
        return [
            self.model.sense(s.value)
            if s.period is None
            else value_of(s.law, self.model.inputs, self.sensed)
            for s in self.load.states
        ]

    @property
    def changing(self) -> bool:
        """Whether its displacement depends on more than time."""
        return self.displacement.level is Level.STATE

    @property
    def dimension(self) -> str:
        """Dimension of the output that it belongs to: of given loads, or of springs and dampers."""
        if self.load.passive:
            return "torsional_spring" if self.load.twists else "spring"
        return "torque" if self.load.twists else "force"

    @property
    def sign(self) -> float:
        """With which the force is an output."""
        return 1.0

    @property
    def label(self) -> str:
        """What it is called in outputs: its place in the file."""
        return dotted(self.load.path)

    @property
    def acting(self) -> Scalar:
        """Force or torque as outputs show it."""
        return self.sign * self.value(self.load.force)

    @property
    def given(self) -> list[Scalar]:
        """What of it follows from time and positions: not finite where the load has no value."""
        return self._components(self.load.still)

    @property
    def doubtful(self) -> list[Scalar]:
        """Its force, then what it depends on, if it may have no value where all of that has one."""
        force = self.load.force
        if (everywhere(force) and self.load.bearing is None) or not rated(force):
            return []
        known = dict.fromkeys(leaf for leaf in measured_in(force) if leaf != PRESSED)
        return [self.value(force), *map(self.sensed, known)]

    def power(self, velocities: Velocities) -> Scalar:
        return self._power(self.load.force, velocities)

    @property
    def potential(self) -> Scalar:
        return self.value(self.load.energy)

    @property
    def working(self) -> Scalar:
        power = self._power(self.load.working, self.model.velocities)
        if not internal(self.load.energy):
            return power
        rates = self.model.changes[len(self.model.topology.free) :]
        pairs = zip(self.model.internal, rates, strict=True)
        direction = {value.index: rate for value, rate in pairs}
        ((storing,),) = derivative_along([self.potential], [direction])
        return power + storing


class DistanceNodes(LoadNodes):
    """Along the line between two joints.

    Where its ends meet, the line has no direction of its own. A term of the law that is a multiple
    of x needs none. One with a rate in it then acts along the velocity at which the ends meet or
    part, for along every motion that is the limit of r/|r|. Any other term has no limit there: its
    force is nan.
    """

    measure: Distance

    def __init__(self, model: Model, load: Load, index: int) -> None:
        super().__init__(model, load, index)
        self.first, self.second = self.measure.first, self.measure.second
        self.undefined = (
            f"its ends {self.first} and {self.second} meet, so its force has no direction; "
            "expected ends that are apart, or a spring relaxed there: 'length: 0'"
        )

    @property
    def sign(self) -> float:
        """Springs and dampers are positive where they pull, forces as they are given."""
        return -1.0 if self.load.passive else 1.0

    @property
    def _between(self) -> Vector:
        joints = self.model.positions.joints
        return joints[self.second] - joints[self.first]

    def _opening(self, velocities: Velocities) -> Vector:
        return velocities.joints[self.second] - velocities.joints[self.first]

    @property
    def _apart(self) -> Scalar:
        """Negative where round-off alone keeps its ends apart."""
        nearest = self.model.inputs.nearest
        return self._between.square - nearest * nearest

    @property
    def displacement(self) -> Scalar:
        return self.graph.sqrt(self._between.square)

    def rate(self, velocities: Velocities) -> Scalar:
        """Of the distance; zero where the ends meet."""
        distance = self.graph.select(self._apart, self.displacement, self.graph.one)
        return self._between.dot(self._opening(velocities)) / distance

    def _power(self, law: Function, velocities: Velocities) -> Scalar:
        return self._force(law).dot(self._opening(velocities))

    def _components(self, law: Function) -> list[Scalar]:
        force = self._force(law)
        return [force.x, force.y]

    def forces(self) -> Forces:
        carrier = self.model.mechanism.carrier
        if self.given_force is None:
            force = self._force(self.load.force)
        else:
            force = self._between * (self.given_force / self.displacement)
        ends = (self.second, force), (self.first, -force)
        return [(carrier(joint), joint, pull) for joint, pull in ends]

    def _force(self, law: Function) -> Vector:
        """The force on its second end; the first gets the opposite."""
        total = Vector(self.graph.zero, self.graph.zero)
        for term in addends(law):
            total = total + self._of_term(term)
        return total

    def _of_term(self, term: Function) -> Vector:
        product = monomial(term)
        if product is not None and product.base == X:
            return self._between * self.value(product.over(X))
        if product is not None and product.rate == 1:
            return self._along * self.value(product.over(V))
        if V in leaves(term):
            return self._following(term)
        distance = self.graph.select(self._apart, self.displacement, self.graph.zero)
        return self._between * (self.value(term) / distance)

    @property
    def _along(self) -> Vector:
        """The opening velocity along the line."""
        opening, apart = self._opening(self.model.velocities), self._apart
        square = self.graph.select(apart, self._between.square, self.graph.one)
        along = self._between * (self._between.dot(opening) / square)
        return self._selected(apart, along, opening)

    def _following(self, term: Function) -> Vector:
        """A force that is no multiple of the rate; none where the ends rest on each other."""
        select, one = self.graph.select, self.graph.one
        opening, apart = self._opening(self.model.velocities), self._apart
        speed = self.graph.sqrt(opening.square)
        rate = select(apart, self.rate(self.model.velocities), speed)
        met = opening * (1.0 / select(-speed, one, speed))
        distance = select(apart, self.displacement, one)
        direction = self._selected(apart, self._between * (1.0 / distance), met)
        own: dict[Function, Scalar] = {X: self.displacement, V: rate}

        def measured(found: Measured | Internal) -> Scalar:
            return own[found] if found in own else self.sensed(found)

        return direction * value_of(term, self.model.inputs, measured, self.mode)

    def _selected(self, condition: Scalar, first: Vector, second: Vector) -> Vector:
        select = self.graph.select
        return Vector(select(condition, first.x, second.x), select(condition, first.y, second.y))


class _Turn(LoadNodes):
    """Along the angle of a body, against the other one if there is one."""

    measure: Turn

    @property
    def displacement(self) -> Scalar:
        """The angle without the whole turns that are taken away at t = 0, if they count."""
        angle = self._difference(self.model.positions.angle)
        counts = ("turns", self.index) in self.model.inputs.parameters
        return angle - self.model.inputs.turns(self.index) if counts else angle

    def rate(self, velocities: Velocities) -> Scalar:
        return self._difference(velocities.turning)

    def _difference(self, of_body: Callable[[str], Scalar]) -> Scalar:
        body, reference = self.measure.body, self.measure.reference
        return of_body(body) if reference is None else of_body(body) - of_body(reference)

    def torques(self) -> Torques:
        torque = self.pushed
        return [(self.measure.body, torque), (self.measure.reference, -torque)]


class _Slide(LoadNodes):
    """Along the axis of a slider."""

    measure: Slide

    @property
    def displacement(self) -> Scalar:
        return self.model.positions.displacement(self.measure.body)

    def rate(self, velocities: Velocities) -> Scalar:
        return velocities.moving(self.measure.body)

    def forces(self) -> Forces:
        slider = self.model.mechanism.bodies[self.measure.body]
        assert slider.guide is not None
        pin = next(iter(slider.points))
        force = self.model.positions.unit(slider.name) * self.pushed
        return [(slider.name, pin, force), (slider.guide.body, pin, -force)]


class _Coordinate(LoadNodes):
    """Along a direction of the ground's frame."""

    measure: Coordinate

    @property
    def label(self) -> str:
        return f"{super().label}.{'xy'[self.measure.axis]}"

    def _part(self, vector: Vector) -> Scalar:
        return vector.y if self.measure.axis else vector.x

    @property
    def displacement(self) -> Scalar:
        return self._part(self.model.positions.joints[self.measure.joint])

    def rate(self, velocities: Velocities) -> Scalar:
        return self._part(velocities.joints[self.measure.joint])

    def forces(self) -> Forces:
        force, zero, joint = self.pushed, self.graph.zero, self.measure.joint
        vector = Vector(zero, force) if self.measure.axis else Vector(force, zero)
        return [(self.model.mechanism.carrier(joint), joint, vector)]


class _BodyAxis(LoadNodes):
    """Along an axis of a body."""

    measure: BodyAxis

    @property
    def label(self) -> str:
        return f"{super().label}.{'xy'[self.measure.axis]}"

    @property
    def _direction(self) -> Vector:
        unit = self.model.positions.unit(self.measure.body)
        return unit.turned if self.measure.axis else unit

    @property
    def displacement(self) -> Scalar:
        raise ValueError(f"{self.label}: a force that turns with a body is measured along no way")

    def rate(self, velocities: Velocities) -> Scalar:
        return velocities.joints[self.measure.joint].dot(self._direction)

    def forces(self) -> Forces:
        """On the body itself, if it has the joint."""
        joint, body = self.measure.joint, self.measure.body
        mechanism, force = self.model.mechanism, self._direction * self.pushed
        own = joint in mechanism.bodies[body].points
        return [(body if own else mechanism.carrier(joint), joint, force)]


def load_nodes(model: Model, load: Load, index: int) -> LoadNodes:
    """The nodes of a load, or of a measure that others sense; see `LoadNodes`."""
    match load.measure:
        case Distance():
            return DistanceNodes(model, load, index)
        case Turn():
            return _Turn(model, load, index)
        case Slide():
            return _Slide(model, load, index)
        case Coordinate():
            return _Coordinate(model, load, index)
        case BodyAxis():
            return _BodyAxis(model, load, index)
        case _ as measure:
            assert_never(measure)
