"""Loads along angles, axes and coordinates; and the nodes of any load."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, assert_never

from linkages.components.contributed.measures import (
    BodyAxis,
    Coordinate,
    Distance,
    Load,
    Slide,
    Turn,
)
from linkages.kernel.forces.distances import DistanceNodes
from linkages.kernel.forces.loads import Forces, LoadNodes, Torques, Velocities
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.vectors import Vector

if TYPE_CHECKING:
    from linkages.kernel.model import Model


class _Turn(LoadNodes):
    """Along the angle of a body, against the other one if there is one."""

    def __init__(self, model: Model, load: Load, index: int, measure: Turn) -> None:
        super().__init__(model, load, index)
        self.measure = measure

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

    def __init__(self, model: Model, load: Load, index: int, measure: Slide) -> None:
        super().__init__(model, load, index)
        self.body = measure.body

    @property
    def displacement(self) -> Scalar:
        return self.model.positions.displacement(self.body)

    def rate(self, velocities: Velocities) -> Scalar:
        return velocities.moving(self.body)

    def forces(self) -> Forces:
        slider = self.model.mechanism.bodies[self.body]
        assert slider.guide is not None
        pin = next(iter(slider.points))
        force = self.model.positions.unit(self.body) * self.pushed
        return [(self.body, pin, force), (slider.guide.body, pin, -force)]


class _Coordinate(LoadNodes):
    """Along a direction of the ground's frame."""

    def __init__(self, model: Model, load: Load, index: int, measure: Coordinate) -> None:
        super().__init__(model, load, index)
        self.joint, self.axis = measure.joint, measure.axis

    @property
    def label(self) -> str:
        return f"{super().label}.{'xy'[self.axis]}"

    def _part(self, vector: Vector) -> Scalar:
        return vector.y if self.axis else vector.x

    @property
    def displacement(self) -> Scalar:
        return self._part(self.model.positions.joints[self.joint])

    def rate(self, velocities: Velocities) -> Scalar:
        return self._part(velocities.joints[self.joint])

    def forces(self) -> Forces:
        force, zero = self.pushed, self.graph.zero
        vector = Vector(zero, force) if self.axis else Vector(force, zero)
        return [(self.model.mechanism.carrier(self.joint), self.joint, vector)]


class _BodyAxis(LoadNodes):
    """Along an axis of a body."""

    def __init__(self, model: Model, load: Load, index: int, measure: BodyAxis) -> None:
        super().__init__(model, load, index)
        self.measure = measure

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
        case Distance() as measure:
            return DistanceNodes(model, load, index, measure)
        case Turn() as measure:
            return _Turn(model, load, index, measure)
        case Slide() as measure:
            return _Slide(model, load, index, measure)
        case Coordinate() as measure:
            return _Coordinate(model, load, index, measure)
        case BodyAxis() as measure:
            return _BodyAxis(model, load, index, measure)
        case _ as measure:
            assert_never(measure)
