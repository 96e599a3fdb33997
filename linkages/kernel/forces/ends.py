"""Ends of ways at which bodies bounce or rest: rigid contacts along a measure."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

from linkages.components.contributed.ends import End
from linkages.components.contributed.measures import Load
from linkages.components.contributed.state_laws import NOTHING
from linkages.kernel.forces.impacts import Unilateral
from linkages.kernel.forces.loads import Forces, LoadNodes, Torques, Velocities
from linkages.kernel.forces.measures import load_nodes
from linkages.kernel.graph.scalars import Scalar

if TYPE_CHECKING:
    from linkages.kernel.closure.motion import Accelerations
    from linkages.kernel.model import Model

SIZE = 0.1
"""Of a way (m, rad): one that has come to rest within a ten-millionth of it touches its end."""


class EndGap:
    """How far a measure is beyond its end: positive where it passes it."""

    def __init__(self, model: Model, end: End, along: LoadNodes) -> None:
        self.model, self.end, self.along = model, end, along
        self.size = model.graph.lift(SIZE)
        self.sense = 1.0 if end.upper else -1.0

    @property
    def indentation(self) -> Scalar:
        """Negative on the way to the end."""
        return self.sense * (self.along.displacement - self.model.inputs.parameter(self.end.limit))

    @property
    def smooth(self) -> Scalar:
        """The same."""
        return self.indentation

    def rate(self, velocities: Velocities) -> Scalar:
        """Its rate, at velocities that may be partial ones."""
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
        """Power of its force at some velocities."""
        return -(self.force * self.gap.rate(velocities))

    @property
    def working(self) -> Scalar:
        """Constraints lose nothing."""
        return self.graph.zero

    @cached_property
    def _pushing(self) -> LoadNodes:
        found = load_nodes(self.model, self.along.load, self.along.index)
        found.given_force = -self.sense * self.force
        return found

    def forces(self) -> Forces:
        """On both sides of the measure, as a load along it."""
        return self._pushing.forces()

    def torques(self) -> Torques:
        """The same for angles."""
        return self._pushing.torques()
