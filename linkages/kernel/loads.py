"""Forces, torques, springs and dampers: their generalised force, power and potential energy."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Protocol

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

if TYPE_CHECKING:
    from linkages.kernel.model import Model


class Velocities(Protocol):
    """Velocities, actual or partial."""

    bodies: dict[str, Scalar]
    joints: dict[str, Vector]

    def turning(self, name: str) -> Scalar:
        """Angular speed of a body."""
        ...


class LoadNodes(ABC):
    """What a load contributes to the equations of a model."""

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
    def __init__(self, model: Model, load: AxialForce | AxialDamper) -> None:
        super().__init__(model)
        self.load = load

    def rate(self, velocities: Velocities) -> Scalar:
        return velocities.bodies[self.load.body]


class _AxialForce(_Axial):
    load: AxialForce

    @property
    def force(self) -> Scalar:
        return value_of(self.load.force, self.model.inputs)


class _AxialDamper(_Axial):
    load: AxialDamper

    @property
    def force(self) -> Scalar:
        return -(self.model.inputs.parameter(self.load.damping) * self.rate(self.model.velocities))


class _PointForce(Pull):
    def __init__(self, model: Model, load: PointForce) -> None:
        self.model = model
        self.load = load

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

    @property
    def force(self) -> Scalar:
        return value_of(self.load.torque, self.model.inputs)


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
    def __init__(self, model: Model, load: Spring) -> None:
        super().__init__(model)
        self.load, self.stiffness, self.damping = load, load.stiffness, load.damping

    @property
    def _between(self) -> Vector:
        joints = self.model.positions.joints
        return joints[self.load.second] - joints[self.load.first]

    @property
    def _distance(self) -> Scalar:
        return self.graph.sqrt(self._between.square)

    @property
    def elongation(self) -> Scalar:
        return self._distance - self.model.inputs.parameter(self.load.length)

    @property
    def _slack(self) -> bool:
        """Whether its relaxed length is zero: its force is then smooth where its ends meet."""
        return self.load.length.absent and self.damping.absent

    def power(self, velocities: Velocities) -> Scalar:
        joints = velocities.joints
        return self.vector.dot(joints[self.load.second] - joints[self.load.first])

    @property
    def vector(self) -> Vector:
        """The force on its second end; the first gets the opposite."""
        if self._slack:
            return -(self._between * self._stiffness)
        return self._between * (self.force / self._distance)

    def potential(self) -> Scalar | None:
        if self._slack and not self.stiffness.absent:
            return 0.5 * self._stiffness * self._between.square
        return super().potential()

    def rate(self, velocities: Velocities) -> Scalar:
        joints = velocities.joints
        opened = joints[self.load.second] - joints[self.load.first]
        return self._between.dot(opened) / self._distance


class TorsionSpringNodes(_Turning, _Elastic):
    """A torsional spring and damper."""

    load: TorsionSpring

    def __init__(self, model: Model, load: TorsionSpring) -> None:
        super().__init__(model, load)
        self.stiffness, self.damping = load.stiffness, load.damping

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


_KINDS = {
    AxialForce: _AxialForce,
    AxialDamper: _AxialDamper,
    PointForce: _PointForce,
    Torque: _Torque,
    Spring: _Spring,
    TorsionSpring: TorsionSpringNodes,
}


def load_nodes(model: Model, load: Load) -> LoadNodes:
    """The nodes of a load."""
    return _KINDS[type(load)](model, load)
