"""Cams whose lift is given by a table, a spline, with a follower that translates.

References
----------
.. [1] R. L. Norton, *Cam Design and Manufacturing Handbook*, 2nd ed., Industrial Press, 2009:
   pressure angle of a translating roller follower.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import ClassVar

from linkages.components.contributed.component import Section, component
from linkages.components.contributed.functions import Table, X
from linkages.components.contributed.interpolation import extremes
from linkages.components.contributed.listed import TURNING, ListedComponent
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import CamSize, Parameter, Path, Relation
from linkages.spec.quantities import Angle, Length, Name, NonNegativeLength, PositiveLength

_ONE = Parameter((), 1.0, structural=True)
_ROUND = 1e-9
"""Difference from a whole turn that rounding of units explains."""


@component
class Cam(ListedComponent):
    """A slider that a cam lifts: position = lift(θ_bar) + offset, in contact all the time.

    Parameters
    ----------
    index
        Place in the list of cams.
    slider
        The follower.
    bar
        The bar or plate that is the cam; it turns on the ground.
    angles
        Angles of the bar in radians, increasing, at least three. Over a whole turn the cam repeats;
        otherwise the lift goes on in a straight line beyond them.
    lifts
        The lift at each of them in metres; over a whole turn first and last are equal.
    offset
        Position of the slider at a lift of zero, in metres.
    base_radius
        Of the base circle in metres, for the pressure angle.
    roller_radius
        Of the follower's roller in metres; zero for a knife edge.
    eccentricity
        Distance in metres of the follower's axis from the pivot of the cam, positive to the side
        that makes the pressure angle of a rise smaller.
    """

    section: ClassVar[str] = "cams"
    opens: ClassVar[Section] = Section(
        "list", "{slider: piston, bar: crank, angles: [0, 1.5, 3], lifts: [0, 0.01, 0]}"
    )

    index: int
    slider: Name
    bar: Name
    angles: tuple[Angle, ...]
    lifts: tuple[Length, ...]
    offset: Length = 0.0
    base_radius: PositiveLength | None = None
    roller_radius: NonNegativeLength = 0.0
    eccentricity: Length = 0.0

    @property
    def _closed(self) -> bool:
        return abs(self.angles[-1] - self.angles[0] - 2 * math.pi) < _ROUND

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Enough increasing angles, a lift for each, and a base circle that the follower meets."""
        found = list(self._faults() or self._overflow())
        reach = (self.base_radius or math.inf) + self.roller_radius
        if abs(self.eccentricity) >= reach:
            message = f"expected less than base and roller radius together, {reach:g} m"
            found.append(((*self.path, "eccentricity"), message))
        return tuple(found)

    def _faults(self) -> tuple[tuple[Path, str], ...]:
        angles, lifts = (*self.path, "angles"), (*self.path, "lifts")
        if len(self.angles) < 3:
            return ((angles, f"expected at least three angles, found {len(self.angles)}"),)
        if len(self.lifts) != len(self.angles):
            counts = f"{len(self.angles)} angles and {len(self.lifts)} lifts"
            return ((lifts, f"expected as many lifts as angles, found {counts}"),)
        for before, after in pairwise(self.angles):
            if after <= before:
                return ((angles, f"expected increasing angles, found {after:g} after {before:g}"),)
        if self._closed and self.lifts[0] != self.lifts[-1]:
            ends = f"{self.lifts[0]:g} and {self.lifts[-1]:g}"
            return ((lifts, f"expected equal lifts a whole turn apart, found {ends}"),)
        return ()

    def _overflow(self) -> tuple[tuple[Path, str], ...]:
        """Polynomials without finite values."""
        if all(map(math.isfinite, extremes(self.table, self.angles[0], self.angles[-1]))):
            return ()
        message = "expected smaller lifts, or angles that are further apart"
        return (((*self.path, "lifts"), message),)

    @property
    def table(self) -> Table:
        """The lift, a function of the cam's angle."""
        closed = self._closed
        path = (*self.path, "lifts")
        return Table(path, self.angles, self.lifts, closed, over=X, turning=closed)

    def references(self) -> References:
        """The follower and its cam."""
        return References(
            bodies=(
                ((*self.path, "slider"), self.slider, ("slider",)),
                ((*self.path, "bar"), self.bar, TURNING),
            ),
            carried=(((*self.path, "slider"), self.slider, None),),
        )

    def terms(self) -> tuple[Relation | CamSize, ...]:
        """The position from the angle, and what the pressure angle depends on."""
        if self._faults():  # they have been reported
            return ()
        relation = Relation(
            self.slider, ((self.bar, _ONE),), self.number("offset"), self.path, profile=self.table
        )
        if self.base_radius is None:
            return (relation,)
        base = Parameter((*self.path, "base_radius"), self.base_radius)
        sizes = (self.number("roller_radius"), self.number("eccentricity"))
        return relation, CamSize(self.slider, base, *sizes)
