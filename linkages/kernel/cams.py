"""Cams and the followers that translate on them: lifts, and forces between both.

With the unit vector a along the guide, b = a turned by −90°, and the lift s(θ), both touch at
h = s + √((base + roller)² − ε²) along a and ε along b from the pivot of the cam: at the centre of a
roller, or a knife edge. A flat face touches at h = base + s along a and ds/dθ along b. A force N
along the guide presses with N (a − tan φ b), with the pressure angle φ of tan φ = (ds/dθ − ε)/h
[1]_ for a roller or knife edge and 0 for a face, and turns the cam with −N ds/dθ.

References
----------
.. [1] R. L. Norton, *Cam Design and Manufacturing Handbook*, 2nd ed., Industrial Press, 2009.
"""

from __future__ import annotations

from functools import cached_property

from linkages.components.contributed.functions import Table
from linkages.kernel.positions import Positions
from linkages.kernel.scalars import Scalar, Vector


class CamNodes:
    """A follower on its cam; `slider` and `cam` are their names, `table` is the lift."""

    def __init__(self, positions: Positions, slider: str, cam: str, table: Table) -> None:
        self._positions, self._graph = positions, positions.graph
        mechanism = positions.topology.mechanism
        self.slider, self.cam, self.table = slider, cam, table
        self.profile = mechanism.cam_profiles[slider]
        follower = mechanism.bodies[slider]
        self._pin, self._axis = next(iter(follower.points)), follower.axis
        points = mechanism.bodies[cam].points
        pivots = (joint for joint in points if joint in mechanism.ground)
        loose = any(play.slider == slider for play in mechanism.plays)
        self.pivot = None if loose else next(pivots, None)
        """What the cam turns about; None where that or the follower has room."""

    @cached_property
    def angle(self) -> Scalar:
        """The angle θ of the cam."""
        return self._positions.angle(self.cam)

    @cached_property
    def lift(self) -> Scalar:
        """The lift s."""
        return self._positions.lift(self.table, self.angle)

    @cached_property
    def slope(self) -> Scalar:
        """ds/dθ."""
        return self._positions.lift_slope(self.table, self.angle)

    @cached_property
    def along(self) -> Vector:
        """The direction a."""
        return self._positions.unit(self.slider)

    @cached_property
    def across(self) -> Vector:
        """The direction b."""
        return -self.along.turned

    @cached_property
    def height(self) -> Scalar | None:
        """The height h; None where the size of the cam is not known."""
        profile, parameter = self.profile, self._positions.inputs.parameter
        if profile.base is None:
            return None
        radius = parameter(profile.base) + parameter(profile.roller)
        if profile.eccentricity.absent:
            return self.lift + radius
        aside = parameter(profile.eccentricity)
        return self.lift + self._graph.sqrt(radius * radius - aside * aside)

    @cached_property
    def leaning(self) -> Vector | None:
        """Lengths h and h tan φ; None of a flat face, or where the size of the cam is not known."""
        if self.height is None or self.profile.flat:
            return None
        aside = self._positions.inputs.parameter(self.profile.eccentricity)
        return Vector(self.height, self.slope - aside)

    @cached_property
    def pressing(self) -> Vector:
        """What a unit force along the guide presses the follower with, as far as it is known."""
        if self.leaning is None:
            return self.along
        return self.along - self.across * (self.leaning.y / self.leaning.x)

    def parted(self, apart: tuple[str, str, Vector] | None) -> Vector:
        """Velocity of the follower less that of the cam where one leaves its guide or pivot."""
        match apart:
            case (self.slider, self._axis, velocity):
                return velocity
            case (self.cam, self.pivot, velocity):
                return -velocity
        return Vector(self._graph.zero, self._graph.zero)

    def forces(self, force: Scalar, friction: Scalar) -> list[tuple[str, str, Vector]]:
        """A force along the guide, and friction along b, as forces on both bodies."""
        assert self.pivot is not None
        acting = self.pressing * force + self.across * friction
        return [(self.slider, self._pin, acting), (self.cam, self.pivot, -acting)]

    def torques(self, force: Scalar, friction: Scalar) -> list[tuple[str, Scalar]]:
        """Their torques about the points at which `forces` act, as far as they are known."""
        assert self.pivot is not None
        places, zero = self._positions.joints, self._graph.zero
        joint = places[self.pivot] - places[self._pin]
        height, aside, on_cam = zero, zero, -(force * self.slope)
        if self.height is not None:
            height = self.height + self.along.dot(joint)
            on_cam = on_cam + friction * self.height
        if self.profile.flat:
            aside = self.slope + self.across.dot(joint)
        arm = self.along * height + self.across * aside
        on_follower = arm.cross(self.pressing * force + self.across * friction)
        return [(self.cam, on_cam), (self.slider, on_follower)]


def following_cam(positions: Positions, slider: str) -> CamNodes:
    """The cam of a follower that never leaves it."""
    relation = positions.topology.followers[slider]
    assert relation.profile is not None
    return CamNodes(positions, slider, relation.parts[0][0], relation.profile)
