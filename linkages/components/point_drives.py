"""Drives that move a point, and actuators that make the motion of drives in their place."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import field_validator

from linkages.components.contributed.attachments import (
    Attached,
    BetweenJoints,
    OnBar,
    OnBars,
    OnSlider,
)
from linkages.components.contributed.component import Component, Fault, Section, component
from linkages.components.contributed.functions import Function, Table, polynomials
from linkages.components.contributed.load_measures import Actuation
from linkages.components.contributed.terms import (
    GUIDED,
    ZERO,
    Body,
    Prescribed,
    crossed,
)
from linkages.components.laws import LengthLaw, ShareLaw, function_of
from linkages.spec.quantities import Length, MovingJointName, Name

GAUSS = np.polynomial.legendre.leggauss(8)
"""Places and weights on [−1, 1] for the length of a cubic."""


def axis_names(point: str) -> tuple[str, str]:
    """Names of the coordinates of a point that a drive moves; no name of a file has a dot."""
    return f"{point}.x", f"{point}.y"


class _PointDrive(Component):
    """Coordinates of a point are those of two massless bodies, of which one carries the other."""

    section: ClassVar[str] = "drives"

    name: str

    def _terms(self, x: Function | None, y: Function | None) -> tuple[Body | Prescribed, ...]:
        """The bodies, and the laws of those that are given."""
        names = axis_names(self.name)
        laws = zip(names, (x, y), strict=True)
        return (
            *crossed(names, GUIDED, self.path, (ZERO, ZERO), self.name),
            *(Prescribed(name, law, self.path) for name, law in laws if law is not None),
        )


@component
class PointDrive(_PointDrive):
    """Moves a joint: its coordinates are laws of time.

    Parameters
    ----------
    name
        A joint that is not fixed to the ground.
    x, y
        Its coordinates in metres; one that is not given follows from the mechanism.
    """

    told_by: ClassVar[str] = "x"

    name: MovingJointName
    x: LengthLaw | None = None
    y: LengthLaw | None = None

    def terms(self) -> tuple[Body | Prescribed, ...]:
        """Both coordinates, and the laws of those that are prescribed."""
        x, y = (
            None if law is None else function_of(law, (*self.path, key))
            for key, law in (("x", self.x), ("y", self.y))
        )
        return self._terms(x, y)


@component
class HeightDrive(PointDrive):
    """Moves a joint: its ordinate is a law of time, and its abscissa follows from the mechanism.

    Parameters
    ----------
    name
        A joint that is not fixed to the ground.
    """

    told_by: ClassVar[str] = "y"


@component
class PathDrive(_PointDrive):
    """Moves a joint along a smooth curve through given points.

    Parameters
    ----------
    name
        A joint that is not fixed to the ground.
    waypoints
        Two points or more, [x, y] in metres.
    progress
        Law of time: the part of the curve's length that is done, 0 at its first point and 1 at its
        last, or back at the first of a closed one.
    closed
        Whether the curve returns to its first point and goes on from there.
    """

    told_by: ClassVar[str] = "waypoints"

    name: MovingJointName
    waypoints: tuple[tuple[Length, Length], ...]
    progress: ShareLaw
    closed: bool = False

    @field_validator("waypoints")
    @classmethod
    def _apart(cls, points: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
        if len(points) < 2:
            raise ValueError(f"expected at least two points, found {len(points)}")
        for number, (one, other) in enumerate(pairwise(points), 2):
            if one == other:
                raise ValueError(
                    f"expected points that differ, found number {number} at the one before"
                )
        return points

    def faults(self) -> Iterator[Fault]:
        """A closed curve has no seam of its own."""
        if self.closed and len(self.waypoints) < 3:
            yield "waypoints", "expected at least three points of a closed curve, found two"
        elif self.closed and self.waypoints[0] == self.waypoints[-1]:
            yield "waypoints", "a closed curve returns by itself; expected its first point once"

    def terms(self) -> tuple[Body | Prescribed, ...]:
        """Splines over the progress, whose knots are parts of the length of the curve."""
        points = (*self.waypoints, self.waypoints[0]) if self.closed else self.waypoints
        if not all(isinstance(number, float) for point in points for number in point):
            raise TypeError("the length of a curve")  # which decides where its knots are
        places = _shares(np.array(points, dtype=float), self.closed)
        progress = function_of(self.progress, (*self.path, "progress"))
        x, y = (
            Table((*self.path, axis), places, values, self.closed, held=True, over=progress)
            for axis, values in zip("xy", zip(*points, strict=True), strict=True)
        )
        return self._terms(x, y)


def _shares(points: NDArray[np.float64], closed: bool) -> tuple[float, ...]:
    """Parts of its length at which a curve passes its points, of which the first is 0.

    The curve is the spline over its chords. Over its own length it hardly differs from that, and
    goes on at a nearly constant speed.
    """
    chords = np.hypot(*np.diff(points, axis=0).T)
    knots = tuple(np.append(0.0, np.cumsum(chords)).tolist())
    splines = [polynomials(Table((), knots, tuple(v), closed)).derivative() for v in points.T]
    places, weights = GAUSS
    at = (np.array(knots)[:-1] + np.outer(places + 1.0, chords / 2.0)).T
    speeds = np.hypot(*(spline(at) for spline in splines))
    lengths = np.cumsum(speeds @ weights * chords / 2.0)
    return (0.0, *(lengths[:-1] / lengths[-1]).tolist(), 1.0)


@component
class _Actuator(Attached):
    """Makes the motion that drives prescribe, in their place.

    Parameters
    ----------
    name
        A new name, which its effort has in results.
    """

    section: ClassVar[str] = "actuators"

    name: Name

    def terms(self) -> tuple[Actuation, ...]:
        """What it acts along."""
        return (Actuation(self.name, self.measure, self.path),)


@component
class Actuator(_Actuator, OnBar):
    """A motor between the ground and a bar or plate, in the place of a drive."""

    told_by: ClassVar[str] = ""
    opens: ClassVar[Section] = Section("mapping", "shoulder: {bar: crank}")


@component
class JointActuator(_Actuator, OnBars):
    """A motor between two bars or plates, in the place of a drive."""


@component
class SliderActuator(_Actuator, OnSlider):
    """An actuator between a slider and what carries its axis, in the place of a drive."""


@component
class LinearActuator(_Actuator, BetweenJoints):
    """An actuator between two joints, such as a cylinder, in the place of a drive."""
