"""Springs whose force is measured: tables over length, position or angle."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import ClassVar

from linkages.components.contributed.component import component
from linkages.components.contributed.functions import Table, X, applied
from linkages.components.contributed.interpolation import Interpolation, extremes
from linkages.components.contributed.listed import (
    ListedComponent,
    reference,
    turning,
    two_bodies,
)
from linkages.components.contributed.measures import Distance, Load, Measure, Slide, Turn
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import Path
from linkages.components.spring import ends, two_joints
from linkages.spec.quantities import Angle, Force, Length, Name, NonNegativeLength, Torque


class _Tabulated(ListedComponent):
    """What pulls back along a measure, as a table says."""

    places: ClassVar[str]
    values: ClassVar[str]
    interpolation: Interpolation

    def _table(self) -> Table:
        path, places = (*self.path, self.values), getattr(self, self.places)
        return Table(path, places, getattr(self, self.values), False, self.interpolation, over=X)

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Enough increasing places, and a value for each."""
        places, values = getattr(self, self.places), getattr(self, self.values)
        path = (*self.path, self.places)
        least = 2 if self.interpolation == "linear" else 3
        if len(places) < least:
            return ((path, f"expected at least {least} {self.places}, found {len(places)}"),)
        if len(values) != len(places):
            counts = f"{len(places)} {self.places} and {len(values)} {self.values}"
            message = f"expected as many {self.values} as {self.places}, found {counts}"
            return (((*self.path, self.values), message),)
        for before, after in pairwise(places):
            if after <= before:
                message = f"expected increasing {self.places}, found {after:g} after {before:g}"
                return ((path, message),)
        if not all(map(math.isfinite, extremes(self._table(), places[0], places[-1]))):
            return ((path, f"expected {self.places} that are further apart"),)
        return ()

    def _loads(self, measure: Measure) -> tuple[Load, ...]:
        if _Tabulated.problems(self):  # they have been reported
            return ()
        return (Load(measure, applied("neg", self._table()), self.path, called="spring"),)


@component
class TabulatedSpring(_Tabulated):
    """A spring between two joints whose pull is a table over its length.

    Parameters
    ----------
    index
        Place in the list of springs.
    between
        Two joints; one may be fixed to the ground.
    lengths
        Distances of the joints in metres, increasing, at least three (two for straight lines).
    forces
        The pull at each of them in newtons; below zero it pushes. Beyond the lengths it goes on in
        a straight line.
    interpolation
        ``pchip``, ``linear`` or ``spline``.
    """

    section: ClassVar[str] = "springs"
    told_by: ClassVar[str] = "lengths"
    places: ClassVar[str] = "lengths"
    values: ClassVar[str] = "forces"

    index: int
    between: tuple[Name, Name]
    lengths: tuple[NonNegativeLength, ...]
    forces: tuple[Force, ...]
    interpolation: Interpolation = "pchip"

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different joints, and a table."""
        return (*two_joints((*self.path, "between"), self.between), *super().problems())

    def references(self) -> References:
        """The joints."""
        return References(joints=ends((*self.path, "between"), self.between))

    def terms(self) -> tuple[Load, ...]:
        """One load along the distance."""
        return self._loads(Distance(*self.between))


@component
class TabulatedGuideSpring(_Tabulated):
    """A spring in the guide of a slider whose force is a table over the slider's position.

    Parameters
    ----------
    index
        Place in the list of springs.
    slider
        Slider name.
    positions
        Positions on the axis in metres, increasing, at least three (two for straight lines).
    forces
        The pull at each of them in newtons, against the direction of the axis. Beyond the positions
        it goes on in a straight line.
    interpolation
        ``pchip``, ``linear`` or ``spline``.
    """

    section: ClassVar[str] = "springs"
    told_by: ClassVar[str] = "positions"
    places: ClassVar[str] = "positions"
    values: ClassVar[str] = "forces"

    index: int
    slider: Name
    positions: tuple[Length, ...]
    forces: tuple[Force, ...]
    interpolation: Interpolation = "pchip"

    def references(self) -> References:
        """The slider."""
        return References(bodies=(((*self.path, "slider"), self.slider, ("slider",)),))

    def terms(self) -> tuple[Load, ...]:
        """One load along the axis."""
        return self._loads(Slide(self.slider))


@component
class TabulatedTorsionalSpring(_Tabulated):
    """A spring between two bodies whose torque is a table over their angle.

    Parameters
    ----------
    index
        Place in the list of springs.
    between_bars
        Two bars or plates; the first may be ``ground``.
    angles
        Angles of the second against the first in radians, increasing, at least three (two for
        straight lines); whole turns count.
    torques
        The torque at each of them in N·m that turns the second back. Beyond the angles it goes on
        in a straight line.
    interpolation
        ``pchip``, ``linear`` or ``spline``.
    """

    section: ClassVar[str] = "springs"
    told_by: ClassVar[str] = "angles"
    places: ClassVar[str] = "angles"
    values: ClassVar[str] = "torques"

    index: int
    between_bars: tuple[Name, Name]
    angles: tuple[Angle, ...]
    torques: tuple[Torque, ...]
    interpolation: Interpolation = "pchip"

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different bodies, and a table."""
        bodies = two_bodies((*self.path, "between_bars"), self.between_bars)
        return (*bodies, *super().problems())

    def references(self) -> References:
        """The bodies."""
        return References(bodies=turning((*self.path, "between_bars"), self.between_bars))

    def terms(self) -> tuple[Load, ...]:
        """One load along the angle."""
        return self._loads(Turn(self.between_bars[1], reference(self.between_bars)))
