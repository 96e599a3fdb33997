"""Springs and dampers: between two joints, and torsional."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING

from linkages.components.terms import Parameter, Spring, TorsionSpring
from linkages.kernel.acting import Conjugate, Pull, Turning, Velocities
from linkages.kernel.scalars import Scalar
from linkages.kernel.vectors import Vector

if TYPE_CHECKING:
    from linkages.kernel.model import Model


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


class SpringNodes(_Elastic, Pull):
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
        nearest = self.model.inputs.nearest
        return self._between.square - nearest * nearest

    @property
    def _distance(self) -> Scalar:
        return self.graph.sqrt(self._between.square)

    @property
    def elongation(self) -> Scalar:
        """Distance beyond the relaxed length."""
        return self._distance - self.model.inputs.parameter(self.load.length)

    @property
    def _slack(self) -> bool:
        """Whether it does not pull where its ends meet."""
        return self.load.length.absent or self.stiffness.absent

    def power(self, velocities: Velocities) -> Scalar:
        """Of the force at the velocities of its ends."""
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
        """½ k (D − L)²; smooth where the ends meet if L = 0."""
        if self._slack and not self.stiffness.absent:
            return 0.5 * self._stiffness * self._between.square
        return super().potential()

    def dissipated(self) -> Scalar | None:
        """Of the damper, along its force."""
        if self.damping.absent:
            return None
        return self._damping_vector.dot(self._opening(self.model.velocities))

    def rate(self, velocities: Velocities) -> Scalar:
        """Of the distance; zero where the ends meet."""
        distance = self.graph.select(self._apart, self._distance, self.graph.one)
        return self._between.dot(self._opening(velocities)) / distance


class TorsionSpringNodes(Turning, _Elastic):
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
        paths = [load.path for load in self.model.mechanism.loads]
        turns = self.model.inputs.turns(paths.index(self.load.path))
        return self.difference - self.model.inputs.parameter(self.load.angle) - turns
