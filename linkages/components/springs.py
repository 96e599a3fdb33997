"""Springs: between joints, in guides, torsional, tabulated and of constant force."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import ClassVar

from linkages.components.contributed.component import (
    TURNING,
    ListedComponent,
    References,
    component,
    reference,
    turning,
    two_bodies,
)
from linkages.components.contributed.functions import (
    Interpolation,
    Number,
    Table,
    X,
    applied,
    extremes,
)
from linkages.components.contributed.load_measures import (
    Distance,
    Load,
    Measure,
    Slide,
    Turn,
    damper_law,
    spring_law,
)
from linkages.components.laws import (
    DampingLaw,
    StiffnessLaw,
    TorsionalDampingLaw,
    TorsionalStiffnessLaw,
    function_of,
)
from linkages.reading.paths import KeyPath
from linkages.spec.quantities import Angle, Force, Length, Name, NonNegativeLength, Torque


@component
class JointSpring(ListedComponent):
    """A spring and a damper side by side that pull two joints together.

    Parameters
    ----------
    index
        Place in the list of springs.
    between
        Two joints; one may be fixed to the ground.
    stiffness
        N/m, ≥ 0, or a law.
    length
        Length without force in metres, ≥ 0.
    damping
        N·s/m, ≥ 0, or a law.
    """

    section: ClassVar[str] = "springs"

    index: int
    between: tuple[Name, Name]
    stiffness: StiffnessLaw
    length: NonNegativeLength
    damping: DampingLaw = 0.0

    def problems(self) -> tuple[tuple[KeyPath, str], ...]:
        """Two different joints."""
        return two_joints((*self.path, "between"), self.between)

    def references(self) -> References:
        """The joints."""
        return References(joints=ends((*self.path, "between"), self.between))

    def terms(self) -> tuple[Load, ...]:
        """A spring and damper; numbers of exactly zero are structure."""
        law = spring_law(
            function_of(self.stiffness, (*self.path, "stiffness")),
            self.number("length"),
            function_of(self.damping, (*self.path, "damping")),
        )
        return (Load(Distance(*self.between), law, self.path),)


def ends(path: KeyPath, joints: tuple[str, str]) -> tuple[tuple[KeyPath, str], ...]:
    """References to the joints of a list at a path."""
    return tuple(((*path, place), joint) for place, joint in enumerate(joints))


def two_joints(path: KeyPath, joints: tuple[str, str]) -> tuple[tuple[KeyPath, str], ...]:
    """What is wrong with a pair of joints."""
    if joints[0] == joints[1]:
        return ((path, f"expected two different joints, found {joints[0]!r} twice"),)
    return ()


@component
class ConstantForceSpring(ListedComponent):
    """A spring that pulls two joints together with a constant force, and a damper beside it.

    Parameters
    ----------
    index
        Place in the list of springs.
    between
        Two joints; one may be fixed to the ground.
    force
        Newtons; one below zero pushes.
    damping
        N·s/m, ≥ 0, or a law.
    """

    section: ClassVar[str] = "springs"
    told_by: ClassVar[str] = "force"

    index: int
    between: tuple[Name, Name]
    force: Force
    damping: DampingLaw = 0.0

    def problems(self) -> tuple[tuple[KeyPath, str], ...]:
        """Two different joints."""
        return two_joints((*self.path, "between"), self.between)

    def references(self) -> References:
        """The joints."""
        return References(joints=ends((*self.path, "between"), self.between))

    def terms(self) -> tuple[Load, ...]:
        """One spring, whose energy is force times distance."""
        force = Number(self.number("force"))
        law = damper_law(function_of(self.damping, (*self.path, "damping"))) - force
        measure = Distance(*self.between)
        return (Load(measure, law, self.path, called="constant-force spring", stores=force * X),)


@component
class GuideSpring(ListedComponent):
    """A spring and a damper between a slider and what carries its axis, along that axis.

    Parameters
    ----------
    index
        Place in the list of springs.
    slider
        Slider name.
    stiffness
        N/m, ≥ 0, or a law.
    position
        Position of the slider on its axis without force, in metres.
    damping
        N·s/m, ≥ 0, or a law.
    """

    section: ClassVar[str] = "springs"
    told_by: ClassVar[str] = "slider"

    index: int
    slider: Name
    stiffness: StiffnessLaw
    position: Length = 0.0
    damping: DampingLaw = 0.0

    def references(self) -> References:
        """The slider."""
        return References(bodies=(((*self.path, "slider"), self.slider, ("slider",)),))

    def terms(self) -> tuple[Load, ...]:
        """A spring and damper; numbers of exactly zero are structure."""
        law = spring_law(
            function_of(self.stiffness, (*self.path, "stiffness")),
            self.number("position"),
            function_of(self.damping, (*self.path, "damping")),
        )
        return (Load(Slide(self.slider), law, self.path),)


class _Tabulated(ListedComponent):
    """What pulls back along a measure, as a table says."""

    places: ClassVar[str]
    values: ClassVar[str]
    interpolation: Interpolation

    def _table(self) -> Table:
        path, places = (*self.path, self.values), getattr(self, self.places)
        return Table(path, places, getattr(self, self.values), False, self.interpolation, over=X)

    def problems(self) -> tuple[tuple[KeyPath, str], ...]:
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

    def problems(self) -> tuple[tuple[KeyPath, str], ...]:
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

    def problems(self) -> tuple[tuple[KeyPath, str], ...]:
        """Two different bodies, and a table."""
        bodies = two_bodies((*self.path, "between_bars"), self.between_bars)
        return (*bodies, *super().problems())

    def references(self) -> References:
        """The bodies."""
        return References(bodies=turning((*self.path, "between_bars"), self.between_bars))

    def terms(self) -> tuple[Load, ...]:
        """One load along the angle."""
        return self._loads(Turn(self.between_bars[1], reference(self.between_bars)))


class _Torsional(ListedComponent):
    stiffness: TorsionalStiffnessLaw
    damping: TorsionalDampingLaw

    def _spring(self, body: str, against: str | None) -> tuple[Load, ...]:
        law = spring_law(
            function_of(self.stiffness, (*self.path, "stiffness")),
            self.number("angle"),
            function_of(self.damping, (*self.path, "damping")),
        )
        return (Load(Turn(body, against), law, self.path),)


@component
class BarSpring(_Torsional):
    """A torsional spring and damper that turn a bar or plate against the ground.

    Parameters
    ----------
    index
        Place in the list of springs.
    bar
        The bar or plate.
    stiffness
        N·m/rad, ≥ 0, or a law.
    angle
        Angle of the bar without torque, in radians; whole turns count.
    damping
        N·m·s/rad, ≥ 0, or a law.
    """

    section: ClassVar[str] = "springs"
    told_by: ClassVar[str] = "bar"

    index: int
    bar: Name
    stiffness: TorsionalStiffnessLaw
    angle: Angle = 0.0
    damping: TorsionalDampingLaw = 0.0

    def references(self) -> References:
        """The bar."""
        return References(bodies=(((*self.path, "bar"), self.bar, TURNING),))

    def terms(self) -> tuple[Load, ...]:
        """One torsional spring; numbers of exactly zero are structure."""
        return self._spring(self.bar, None)


@component
class SpringBetweenBars(_Torsional):
    """A torsional spring and damper between two bodies.

    Parameters
    ----------
    index
        Place in the list of springs.
    between_bars
        Two bars or plates; the first may be ``ground``.
    stiffness
        N·m/rad, ≥ 0, or a law.
    angle
        Angle of the second against the first without torque, in radians; whole turns count.
    damping
        N·m·s/rad, ≥ 0, or a law.
    """

    section: ClassVar[str] = "springs"
    told_by: ClassVar[str] = "between_bars"

    index: int
    between_bars: tuple[Name, Name]
    stiffness: TorsionalStiffnessLaw
    angle: Angle = 0.0
    damping: TorsionalDampingLaw = 0.0

    def problems(self) -> tuple[tuple[KeyPath, str], ...]:
        """Two different bodies."""
        return two_bodies((*self.path, "between_bars"), self.between_bars)

    def references(self) -> References:
        """The bodies."""
        return References(bodies=turning((*self.path, "between_bars"), self.between_bars))

    def terms(self) -> tuple[Load, ...]:
        """One torsional spring; numbers of exactly zero are structure."""
        return self._spring(self.between_bars[1], reference(self.between_bars))
