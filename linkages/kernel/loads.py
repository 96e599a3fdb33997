"""Forces, torques and dampers along axes; and the nodes of every kind of load."""

from __future__ import annotations

from typing import TYPE_CHECKING, assert_never

from linkages.components.terms import (
    AxialDamper,
    AxialForce,
    Load,
    PointForce,
    Spring,
    Torque,
    TorsionSpring,
)
from linkages.kernel.acting import Conjugate, LoadNodes, Pull, Turning, Velocities
from linkages.kernel.laws import value_of
from linkages.kernel.scalars import Scalar
from linkages.kernel.springs import SpringNodes, TorsionSpringNodes
from linkages.kernel.vectors import Vector
from linkages.reading.paths import dotted

if TYPE_CHECKING:
    from linkages.kernel.model import Model


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


class _Torque(Turning):
    load: Torque
    dimension = "torque"

    @property
    def force(self) -> Scalar:
        return value_of(self.load.torque, self.model.inputs)

    @property
    def given(self) -> list[Scalar]:
        """The torque."""
        return self.acting


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
            return SpringNodes(model, load)
        case TorsionSpring():
            return TorsionSpringNodes(model, load)
        case _:
            assert_never(load)
