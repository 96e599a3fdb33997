"""Loads along the distance of two joints, which has no direction where they meet."""

from __future__ import annotations

from typing import TYPE_CHECKING

from linkages.components.contributed.functions import Function, Internal, Measured, V, X
from linkages.components.contributed.measures import Distance, Load
from linkages.components.contributed.state_laws import addends, leaves, monomial
from linkages.kernel.forces.loads import Forces, LoadNodes, Velocities
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.vectors import Vector
from linkages.kernel.numbers.laws import value_of

if TYPE_CHECKING:
    from linkages.kernel.model import Model


class DistanceNodes(LoadNodes):
    """Along the line between two joints.

    Where its ends meet, the line has no direction of its own. A term of the law that is a multiple
    of x needs none. One with a rate in it then acts along the velocity at which the ends meet or
    part, for along every motion that is the limit of r/|r|. Any other term has no limit there: its
    force is nan.
    """

    def __init__(self, model: Model, load: Load, index: int, measure: Distance) -> None:
        super().__init__(model, load, index)
        self.first, self.second = measure.first, measure.second
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
        """The distance."""
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
        """On both ends."""
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
