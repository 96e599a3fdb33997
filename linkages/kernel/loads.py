"""Forces, torques, springs and dampers: their generalised force, power and potential energy."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar, Protocol, assert_never

from linkages.components.terms import (
    AxialDamper,
    AxialForce,
    Load,
    Parameter,
    PointForce,
    Spring,
    Torque,
    TorsionSpring,
)
from linkages.kernel.laws import value_of
from linkages.kernel.scalars import Scalar
from linkages.kernel.vectors import Vector
from linkages.reading.paths import dotted

if TYPE_CHECKING:
    from linkages.components.mechanism import Mechanism
    from linkages.kernel.model import Model


ROUND_OFF = 4e-15
"""Distance of two joints, beside the size of the mechanism, that round-off may cause."""


class Velocities(Protocol):
    """Velocities, actual or partial."""

    bodies: dict[str, Scalar]
    joints: dict[str, Vector]

    def turning(self, name: str) -> Scalar:
        """Angular speed of a body."""
        ...


class LoadNodes(ABC):
    """What a load contributes to the equations of a model."""

    load: Load
    dimension: ClassVar[str]
    """Dimension of the output that it belongs to."""

    @property
    def labels(self) -> tuple[str, ...]:
        """What its forces are called in outputs: the place of the load in the file."""
        return (dotted(self.load.path),)

    @property
    @abstractmethod
    def acting(self) -> list[Scalar]:
        """Force or torque as it acts, one for each label."""

    @property
    @abstractmethod
    def given(self) -> list[Scalar]:
        """What of it follows from time and positions: not finite where the load has no value."""

    @property
    def undefined(self) -> str:
        """Why it may have no value, as the end of a sentence."""
        return "it has no finite value"

    @abstractmethod
    def power(self, velocities: Velocities) -> Scalar:
        """Power of the load at some velocities: its generalised force if they are partial ones."""

    def potential(self) -> Scalar | None:
        """Energy that it stores; None for a load that stores none."""
        return None

    def dissipated(self) -> Scalar | None:
        """Power of what it does not store, at the actual velocities; None if it stores all."""
        return None


class Conjugate(LoadNodes):
    """A scalar force that works on one rate."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.graph = model.graph

    @property
    @abstractmethod
    def force(self) -> Scalar:
        """The force, positive in the direction of the rate."""

    @property
    def acting(self) -> list[Scalar]:
        """The force."""
        return [self.force]

    @abstractmethod
    def rate(self, velocities: Velocities) -> Scalar:
        """What it works on."""

    def power(self, velocities: Velocities) -> Scalar:
        """Force times rate."""
        return self.force * self.rate(velocities)

    def dissipated(self) -> Scalar | None:
        """All of its power."""
        return self.power(self.model.velocities)


class Pull(LoadNodes):
    """A force in the plane."""

    @property
    @abstractmethod
    def vector(self) -> Vector:
        """The force, on the joint or on the second of two."""


class _Axial(Conjugate):
    load: AxialForce | AxialDamper

    def __init__(self, model: Model, load: AxialForce | AxialDamper) -> None:
        super().__init__(model)
        self.load = load

    def rate(self, velocities: Velocities) -> Scalar:
        return velocities.bodies[self.load.body]


class _AxialForce(_Axial):
    load: AxialForce
    dimension = "force"

    @property
    def force(self) -> Scalar:
        return value_of(self.load.force, self.model.inputs)

    @property
    def given(self) -> list[Scalar]:
        """The force."""
        return self.acting


class _AxialDamper(_Axial):
    load: AxialDamper
    dimension = "spring"

    @property
    def force(self) -> Scalar:
        return -(self.model.inputs.parameter(self.load.damping) * self.rate(self.model.velocities))

    @property
    def given(self) -> list[Scalar]:
        """Nothing: it depends on the velocity alone."""
        return []


class _PointForce(Pull):
    load: PointForce
    dimension = "force"

    def __init__(self, model: Model, load: PointForce) -> None:
        self.model = model
        self.load = load

    @property
    def labels(self) -> tuple[str, ...]:
        """One for each component."""
        return tuple(f"{dotted(self.load.path)}.{axis}" for axis in "xy")

    @property
    def acting(self) -> list[Scalar]:
        """Both components."""
        return [self.vector.x, self.vector.y]

    @property
    def given(self) -> list[Scalar]:
        """Both components."""
        return self.acting

    @property
    def vector(self) -> Vector:
        """The force."""
        x, y = (value_of(part, self.model.inputs) for part in self.load.force)
        return Vector(x, y)

    def power(self, velocities: Velocities) -> Scalar:
        return velocities.joints[self.load.joint].dot(self.vector)

    def dissipated(self) -> Scalar | None:
        return self.power(self.model.velocities)


class _Turning(Conjugate):
    load: Torque | TorsionSpring

    def __init__(self, model: Model, load: Torque | TorsionSpring) -> None:
        super().__init__(model)
        self.load = load

    def rate(self, velocities: Velocities) -> Scalar:
        rate = velocities.turning(self.load.body)
        if self.load.reference is None:
            return rate
        return rate - velocities.turning(self.load.reference)


class _Torque(_Turning):
    load: Torque
    dimension = "torque"

    @property
    def force(self) -> Scalar:
        return value_of(self.load.torque, self.model.inputs)

    @property
    def given(self) -> list[Scalar]:
        """The torque."""
        return self.acting


class _Elastic(Conjugate):
    """A spring with a damper: stiffness·elongation against it, damping·rate."""

    stiffness: Parameter
    damping: Parameter

    @property
    @abstractmethod
    def elongation(self) -> Scalar:
        """How far it is from being relaxed."""

    @property
    def force(self) -> Scalar:
        return self._damping_force - self._stiffness * self._elongation

    @property
    def _stiffness(self) -> Scalar:
        return self.model.inputs.parameter(self.stiffness)

    @property
    def _elongation(self) -> Scalar:
        return self.graph.zero if self.stiffness.absent else self.elongation

    @property
    def _damping_force(self) -> Scalar:
        if self.damping.absent:
            return self.graph.zero
        return -(self.model.inputs.parameter(self.damping) * self.rate(self.model.velocities))

    def potential(self) -> Scalar | None:
        if self.stiffness.absent:
            return None
        elongation = self.elongation
        return 0.5 * self._stiffness * elongation * elongation

    def dissipated(self) -> Scalar | None:
        if self.damping.absent:
            return None
        return self._damping_force * self.rate(self.model.velocities)


class _Spring(_Elastic, Pull):
    """A spring and damper along the line between two joints.

    Where its ends meet, the line has no direction of its own. A spring that is relaxed there pulls
    with −k·r, which needs none; a damper then acts along the velocity at which the ends meet or
    part, for along every motion that is the limit of r/|r|. Any other spring has no limit there:
    its force is nan.
    """

    load: Spring
    dimension = "spring"

    def __init__(self, model: Model, load: Spring) -> None:
        self.model, self.graph = model, model.graph
        self.load, self.stiffness, self.damping = load, load.stiffness, load.damping

    @property
    def acting(self) -> list[Scalar]:
        """How it pulls its ends together."""
        return [-self.force]

    @property
    def given(self) -> list[Scalar]:
        """The elastic force, which has no direction where the ends meet."""
        return [self._elastic_vector.x, self._elastic_vector.y]

    @property
    def undefined(self) -> str:
        """Where its ends meet."""
        return (
            f"its ends {self.load.first} and {self.load.second} meet, so its force has no "
            "direction; expected ends that are apart, or a spring relaxed there: 'length: 0'"
        )

    @property
    def _between(self) -> Vector:
        joints = self.model.positions.joints
        return joints[self.load.second] - joints[self.load.first]

    def _opening(self, velocities: Velocities) -> Vector:
        return velocities.joints[self.load.second] - velocities.joints[self.load.first]

    @property
    def _apart(self) -> Scalar:
        """Negative where round-off alone keeps its ends apart."""
        mechanism = self.model.mechanism
        index = mechanism.loads.index(self.load)
        nearest = self.model.inputs.nearest(index, ROUND_OFF * extent(mechanism))
        return self._between.square - nearest * nearest

    @property
    def _distance(self) -> Scalar:
        return self.graph.sqrt(self._between.square)

    @property
    def elongation(self) -> Scalar:
        return self._distance - self.model.inputs.parameter(self.load.length)

    @property
    def _slack(self) -> bool:
        """Whether it does not pull where its ends meet."""
        return self.load.length.absent or self.stiffness.absent

    def power(self, velocities: Velocities) -> Scalar:
        return self.vector.dot(self._opening(velocities))

    @property
    def vector(self) -> Vector:
        """The force on its second end; the first gets the opposite."""
        return self._elastic_vector + self._damping_vector

    @property
    def _elastic_vector(self) -> Vector:
        if self.stiffness.absent:
            return Vector(self.graph.zero, self.graph.zero)
        if self._slack:
            return -(self._between * self._stiffness)
        distance = self.graph.select(self._apart, self._distance, self.graph.zero)
        return self._between * (-(self._stiffness * self.elongation) / distance)

    @property
    def _damping_vector(self) -> Vector:
        if self.damping.absent:
            return Vector(self.graph.zero, self.graph.zero)
        damping, opening = (
            self.model.inputs.parameter(self.damping),
            self._opening(self.model.velocities),
        )
        select, apart, between = self.graph.select, self._apart, self._between
        square = select(apart, between.square, self.graph.one)
        along = between * (between.dot(opening) / square)
        return Vector(
            -(damping * select(apart, along.x, opening.x)),
            -(damping * select(apart, along.y, opening.y)),
        )

    def potential(self) -> Scalar | None:
        if self._slack and not self.stiffness.absent:
            return 0.5 * self._stiffness * self._between.square
        return super().potential()

    def dissipated(self) -> Scalar | None:
        if self.damping.absent:
            return None
        return self._damping_vector.dot(self._opening(self.model.velocities))

    def rate(self, velocities: Velocities) -> Scalar:
        distance = self.graph.select(self._apart, self._distance, self.graph.one)
        return self._between.dot(self._opening(velocities)) / distance


class TorsionSpringNodes(_Turning, _Elastic):
    """A torsional spring and damper."""

    load: TorsionSpring
    dimension = "torsional_spring"

    def __init__(self, model: Model, load: TorsionSpring) -> None:
        super().__init__(model, load)
        self.stiffness, self.damping = load.stiffness, load.damping

    @property
    def given(self) -> list[Scalar]:
        """The torque of the spring, which is finite for all angles."""
        return []

    @property
    def difference(self) -> Scalar:
        """Angle of the body, against the other one if there is one."""
        angle = self.model.positions.angle(self.load.body)
        if self.load.reference is None:
            return angle
        return angle - self.model.positions.angle(self.load.reference)

    @property
    def elongation(self) -> Scalar:
        """Without the whole turns that are taken away at t = 0."""
        turns = self.model.inputs.turns(self.model.mechanism.loads.index(self.load))
        return self.difference - self.model.inputs.parameter(self.load.angle) - turns


def extent(mechanism: Mechanism) -> float:
    """A length that all places have in common: the farthest point of every body, summed up."""
    places = [*mechanism.attachments.values(), mechanism.anchors]
    farthest = (
        max((abs(n.value) for p in some.values() for n in p), default=0.0) for some in places
    )
    return sum(farthest)


def load_nodes(model: Model, load: Load) -> LoadNodes:
    """The nodes of a load."""
    match load:
        case AxialForce():
            return _AxialForce(model, load)
        case AxialDamper():
            return _AxialDamper(model, load)
        case PointForce():
            return _PointForce(model, load)
        case Torque():
            return _Torque(model, load)
        case Spring():
            return _Spring(model, load)
        case TorsionSpring():
            return TorsionSpringNodes(model, load)
        case _:
            assert_never(load)
