"""Journals in bearings that are round, and in those that are not."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from linkages.components.contributed.normal_forces import PinInHole
from linkages.kernel.differentiation import Iteration
from linkages.kernel.forces.gaps import RadialGap, Touchable
from linkages.kernel.forces.generalised_forces import Forces, Torques, Velocities
from linkages.kernel.scalars import Scalar, Vector

if TYPE_CHECKING:
    from linkages.kernel.model import Model


class PinGap(RadialGap):
    """A journal in a bearing.

    Both bodies touch at one point C, a radius of the journal away from its centre in the direction
    n_h from the centre of the bearing to that of the journal. Slip is the velocity of the journal's
    body against the bearing's at C, along n_h turned by +90°.
    """

    def __init__(self, model: Model, geometry: PinInHole) -> None:
        self.model, self.graph, self.geometry = model, model.graph, geometry
        self.other = model.mechanism.carrier(geometry.joint)
        self.size = self.reach = model.inputs.parameter(geometry.size)
        self.radius = model.inputs.parameter(geometry.pin_radius)

    @cached_property
    def offset(self) -> Vector:
        x, y = (self.model.positions.displacements[name] for name in self.geometry.axes)
        return Vector(x, y)

    def offset_rate(self, velocities: Velocities) -> Vector:
        x, y = (velocities.moving(name) for name in self.geometry.axes)
        return Vector(x, y)

    def slip(self, velocities: Velocities) -> Scalar:
        body, other = self.turning(velocities)
        pin, hole = (other, body) if self.geometry.hole else (body, other)
        along = self.normal.turned.dot(self.offset_rate(velocities))
        return along + self.radius * pin - (self.radius + self.distance) * hole

    def turning(self, velocities: Velocities) -> tuple[Scalar, Scalar]:
        """Angular speeds of the displaced body and of the other one."""
        other = self.graph.zero if self.other is None else velocities.turning(self.other)
        return velocities.turning(self.geometry.body), other

    def forces(self, force: Scalar, friction: Scalar) -> Forces:
        """On the displaced body through its offset, and the opposite at the joint."""
        return self.between(self.normal.turned * friction - self.normal * force)

    def between(self, acting: Vector) -> Forces:
        """A force on the displaced body through its offset, and the opposite at the joint."""
        geometry = self.geometry
        return [
            (geometry.axes[1], geometry.displaced, acting),
            (self.other, geometry.joint, -acting),
        ]

    def torques(self, force: Scalar, friction: Scalar) -> Torques:  # noqa: ARG002
        """Of the friction at C, about the centres of journal and bearing."""
        on_pin = self.radius * friction
        on_hole = -(self.radius + self.distance) * friction
        bodies = (self.other, self.geometry.body)
        pin, hole = bodies if self.geometry.hole else bodies[::-1]
        return [(pin, on_pin), (hole, on_hole)]


FLYING = 0.1
"""Gap over the size from which on it is told to a part of 1e-3 only: nothing depends on it."""

ANYWHERE = 1e300
"""Scale of what an iteration may be far from."""

SHARP = 0.25
"""Curvature of the gap over the size below which it is not told better there."""

PLACES = 8
"""Angles for each harmonic of a bearing at which the contact is looked for."""


class ProfiledGap(PinGap):
    """A journal in a bearing that is not round.

    In the frame of the bearing the centre of the journal is at e. The gap is the least
    F(θ) = p(θ) − e·u(θ) over the angle θ, with p of `bearing_profiles`. It is looked for at many
    angles, then F′ = 0 is solved by Newton's method within the neighbours of the best one. In
    contact F″ = p + p″ − F is positive. One more step in straight-line code takes the last
    round-off away, and has the derivatives of the solution.
    """

    def __init__(self, model: Model, geometry: PinInHole, number: int) -> None:
        super().__init__(model, geometry)
        self._number = number
        self._cos, self._sin = (
            [model.inputs.parameter(pair[k]) for pair in geometry.profile] for k in (0, 1)
        )
        self._sign = -1.0 if geometry.hole else 1.0

    @cached_property
    def _unit(self) -> Vector | None:
        """Direction of the frame of the bearing; None for the ground."""
        name = self.geometry.body if self.geometry.hole else self.other
        if name is None:
            return None
        angle = self.model.positions.angle(name)
        return Vector(self.graph.cos(angle), self.graph.sin(angle))

    @cached_property
    def _centre(self) -> Vector:
        """Of the journal in the frame of the bearing, e."""
        own = self.offset * self._sign
        return own if self._unit is None else Vector(self._unit.x, -self._unit.y).times(own)

    def _support(self, cos: Scalar, sin: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        """P and its first two derivatives by the angle, from its cosine and sine."""
        value, slope, bend = self.size, self.graph.zero, self.graph.zero
        unit = turned = Vector(cos, sin)
        for order, (a, b) in enumerate(zip(self._cos, self._sin, strict=True), 1):
            own = a * turned.x + b * turned.y
            value, bend = value + own, bend - float(order * order) * own
            slope = slope + float(order) * (b * turned.x - a * turned.y)
            turned = turned.times(unit)
        return value, slope, bend

    def _steps(self, angle: Scalar) -> tuple[Scalar, Scalar]:
        """F′ and F″ at an angle."""
        unit = Vector(self.graph.cos(angle), self.graph.sin(angle))
        _, slope, bend = self._support(unit.x, unit.y)
        return slope - unit.cross(self._centre), bend + unit.dot(self._centre)

    @cached_property
    def _best(self) -> tuple[Scalar, Scalar]:
        """Least F at many angles, and where."""
        count = PLACES * (len(self._cos) + 1)
        best: tuple[Scalar, Scalar] | None = None
        for angle in np.linspace(-np.pi, np.pi, count, endpoint=False).tolist():
            cos, sin = self.graph.lift(math.cos(angle)), self.graph.lift(math.sin(angle))
            here = self._support(cos, sin)[0] - self._centre.dot(Vector(cos, sin))
            if best is None:
                best = here, self.graph.lift(angle)
                continue
            nearer, select = best[0] - here, self.graph.select
            best = select(nearer, here, best[0]), select(nearer, self.graph.lift(angle), best[1])
        assert best is not None
        return best

    @cached_property
    def contact_angle(self) -> Scalar:
        """The angle of the contact in the frame of the bearing."""
        graph, select = self.graph, self.graph.select
        gap, start = self._best
        far = gap - FLYING * self.size
        apart = 2.0 * math.pi / (PLACES * (len(self._cos) + 1))
        first = len(self.model.positions.body_numbers) + 3 * self._number
        angle, low, high = iterates = [self.model.inputs.iterate(first + k) for k in range(3)]
        slope, curved = self._steps(angle)
        below, above = select(-slope, angle, low), select(-slope, high, angle)
        newton = angle - slope / select(curved, curved, graph.one)
        middle = 0.5 * (below + above)
        within = select(newton - below, select(above - newton, curved, -graph.one), -graph.one)
        step = select(far, graph.zero, select(within, newton, middle) - angle)
        iteration = Iteration(
            iterates=tuple(iterates),
            updates=(step, below - low, above - high),
            scales=(1.0, ANYWHERE, ANYWHERE),
            block=len(self.model.topology.blocks) + self._number,
        )
        found = graph.newton(iteration, [start, start - apart, start + apart])[0]
        slope, curved = self._steps(found)
        flat = select(curved - SHARP * self.size, curved, graph.lift(ANYWHERE))
        return found - slope / select(far, flat, curved)

    @cached_property
    def _facing(self) -> Vector:
        """Cosine and sine of that angle."""
        return Vector(self.graph.cos(self.contact_angle), self.graph.sin(self.contact_angle))

    @cached_property
    def facing(self) -> Vector:
        """The direction u from the bearing to the contact, along the axes of the ground."""
        return self._facing if self._unit is None else self._unit.times(self._facing)

    @cached_property
    def _along(self) -> Scalar:
        """e·u."""
        return self._facing.dot(self._centre)

    @cached_property
    def _across(self) -> Scalar:
        """e·u turned by +90°, which is p′: the normal misses the centre of the bearing by it."""
        return self._facing.cross(self._centre)

    @cached_property
    def indentation(self) -> Scalar:
        return self._along - self._support(self._facing.x, self._facing.y)[0]

    @property
    def smooth(self) -> Scalar:
        return self.indentation

    def _turning_of_sides(self, velocities: Velocities) -> tuple[Scalar, Scalar]:
        """Angular speeds of journal and bearing."""
        body, other = self.turning(velocities)
        return (other, body) if self.geometry.hole else (body, other)

    def rate(self, velocities: Velocities) -> Scalar:
        _, hole = self._turning_of_sides(velocities)
        return self._sign * self.facing.dot(self.offset_rate(velocities)) + self._across * hole

    def pushed(self, accelerations: Velocities) -> Scalar:
        return Touchable.pushed(self, accelerations)

    def slip(self, velocities: Velocities) -> Scalar:
        pin, hole = self._turning_of_sides(velocities)
        along = self._sign * self.facing.turned.dot(self.offset_rate(velocities))
        return along + self.radius * pin - (self.radius + self._along) * hole

    def forces(self, force: Scalar, friction: Scalar) -> Forces:
        normal = self.facing * self._sign
        return self.between(normal.turned * friction - normal * force)

    def torques(self, force: Scalar, friction: Scalar) -> Torques:
        """Of both at C, about the centres of journal and bearing."""
        on_pin = self.radius * friction
        on_hole = -(self.radius + self._along) * friction - self._across * force
        bodies = (self.other, self.geometry.body)
        pin, hole = bodies if self.geometry.hole else bodies[::-1]
        return [(pin, on_pin), (hole, on_hole)]
