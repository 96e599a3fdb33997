"""What loads act along: value, rate, and the forces on bodies, as nodes of a model."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, assert_never

from linkages.components.functions import Function, V, X
from linkages.components.measures import Coordinate, Distance, Slide, Turn
from linkages.components.state_laws import addends, leaves, monomial
from linkages.kernel.laws import value_of
from linkages.kernel.loads import Forces, LoadNodes, Torques, Velocities
from linkages.kernel.scalars import Scalar
from linkages.kernel.vectors import Vector

if TYPE_CHECKING:
    from linkages.kernel.model import Model


class _Distance(LoadNodes):
    """Along the line between two joints.

    Where its ends meet, the line has no direction of its own. A term of the law that is a multiple
    of x needs none. One with a rate in it then acts along the velocity at which the ends meet or
    part, for along every motion that is the limit of r/|r|. Any other term has no limit there: its
    force is nan.
    """

    sign = -1.0  # positive where it pulls

    def __init__(self, model: Model, index: int, measure: Distance) -> None:
        super().__init__(model, index)
        self.first, self.second = measure.first, measure.second
        self.undefined = (
            f"its ends {self.first} and {self.second} meet, so its force has no direction; "
            "expected ends that are apart, or a spring relaxed there: 'length: 0'"
        )

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
        force, carrier = self._force(self.load.force), self.model.mechanism.carrier
        return [
            (carrier(self.second), self.second, force),
            (carrier(self.first), self.first, -force),
        ]

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
        rate = select(apart, self.measured(1), speed)
        met = opening * (1.0 / select(-speed, one, speed))
        distance = select(apart, self.displacement, one)
        direction = self._selected(apart, self._between * (1.0 / distance), met)
        measured = (self.displacement, rate)
        return direction * value_of(term, self.model.inputs, lambda order: measured[order])

    def _selected(self, condition: Scalar, first: Vector, second: Vector) -> Vector:
        select = self.graph.select
        return Vector(select(condition, first.x, second.x), select(condition, first.y, second.y))


class _Turn(LoadNodes):
    """Along the angle of a body, against the other one if there is one."""

    def __init__(self, model: Model, index: int, measure: Turn) -> None:
        super().__init__(model, index)
        self.measure = measure

    @property
    def displacement(self) -> Scalar:
        """The angle without the whole turns that are taken away at t = 0."""
        angle = self._difference(self.model.positions.angle)
        return angle - self.model.inputs.turns(self.index)

    def rate(self, velocities: Velocities) -> Scalar:
        return self._difference(velocities.turning)

    def _difference(self, of_body: Callable[[str], Scalar]) -> Scalar:
        body, reference = self.measure.body, self.measure.reference
        return of_body(body) if reference is None else of_body(body) - of_body(reference)

    def torques(self) -> Torques:
        torque = self.value(self.load.force)
        return [(self.measure.body, torque), (self.measure.reference, -torque)]


class _Slide(LoadNodes):
    """Along the axis of a slider."""

    def __init__(self, model: Model, index: int, measure: Slide) -> None:
        super().__init__(model, index)
        self.body = measure.body

    @property
    def displacement(self) -> Scalar:
        return self.model.positions.displacements[self.body]

    def rate(self, velocities: Velocities) -> Scalar:
        return velocities.bodies[self.body]

    def forces(self) -> Forces:
        slider = self.model.mechanism.bodies[self.body]
        assert slider.guide is not None
        pin = next(iter(slider.points))
        force = self.model.positions.unit(self.body) * self.value(self.load.force)
        return [(self.body, pin, force), (slider.guide.body, pin, -force)]


class _Coordinate(LoadNodes):
    """Along a direction of the ground's frame."""

    def __init__(self, model: Model, index: int, measure: Coordinate) -> None:
        super().__init__(model, index)
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
        force, zero = self.value(self.load.force), self.graph.zero
        vector = Vector(zero, force) if self.axis else Vector(force, zero)
        return [(self.model.mechanism.carrier(self.joint), self.joint, vector)]


def load_nodes(model: Model, index: int) -> LoadNodes:
    """The nodes of the load at a place among those of the mechanism."""
    match model.mechanism.loads[index].measure:
        case Distance() as measure:
            return _Distance(model, index, measure)
        case Turn() as measure:
            return _Turn(model, index, measure)
        case Slide() as measure:
            return _Slide(model, index, measure)
        case Coordinate() as measure:
            return _Coordinate(model, index, measure)
        case _ as measure:
            assert_never(measure)
