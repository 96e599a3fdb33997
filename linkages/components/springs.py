"""Springs: between joints, in guides, torsional, tabulated and of constant force."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import ClassVar

from linkages.components.contributed.attachments import (
    Attached,
    BetweenBars,
    BetweenJoints,
    OnBar,
    OnSlider,
)
from linkages.components.contributed.attachments import ends as ends  # of earlier plug-ins
from linkages.components.contributed.attachments import two_joints as two_joints
from linkages.components.contributed.component import ListedComponent, component
from linkages.components.contributed.functions import (
    Interpolation,
    Number,
    Table,
    X,
    applied,
    extremes,
)
from linkages.components.contributed.load_measures import Load, damper_law, spring_law
from linkages.components.laws import (
    DampingLaw,
    StiffnessLaw,
    TorsionalDampingLaw,
    TorsionalStiffnessLaw,
    function_of,
)
from linkages.reading.paths import KeyPath
from linkages.spec.quantities import Angle, Force, Length, NonNegativeLength, Torque


class _Spring(Attached, ListedComponent):
    """A spring and a damper side by side."""

    relaxed: ClassVar[str]
    stiffness: StiffnessLaw | TorsionalStiffnessLaw
    damping: DampingLaw | TorsionalDampingLaw

    def terms(self) -> tuple[Load, ...]:
        """A spring and damper; numbers of exactly zero are structure."""
        law = spring_law(
            function_of(self.stiffness, (*self.path, "stiffness")),
            self.number(self.relaxed),
            function_of(self.damping, (*self.path, "damping")),
        )
        return (self.acting(law),)


@component
class JointSpring(_Spring, BetweenJoints):
    """A spring and a damper side by side that pull two joints together.

    Parameters
    ----------
    stiffness
        N/m, ≥ 0, or a law.
    length
        Length without force in metres, ≥ 0.
    damping
        N·s/m, ≥ 0, or a law.
    """

    section: ClassVar[str] = "springs"
    told_by: ClassVar[str] = ""
    relaxed: ClassVar[str] = "length"

    stiffness: StiffnessLaw
    length: NonNegativeLength
    damping: DampingLaw = 0.0


@component
class ConstantForceSpring(ListedComponent, BetweenJoints):
    """A spring that pulls two joints together with a constant force, and a damper beside it.

    Parameters
    ----------
    force
        Newtons; one below zero pushes.
    damping
        N·s/m, ≥ 0, or a law.
    """

    section: ClassVar[str] = "springs"
    told_by: ClassVar[str] = "force"

    force: Force
    damping: DampingLaw = 0.0

    def terms(self) -> tuple[Load, ...]:
        """One spring, whose energy is force times distance."""
        force = Number(self.number("force"))
        law = damper_law(function_of(self.damping, (*self.path, "damping"))) - force
        return (self.acting(law, called="constant-force spring", stores=force * X),)


@component
class _TorsionalSpring(_Spring):
    """A torsional spring and damper.

    Parameters
    ----------
    stiffness
        N·m/rad, ≥ 0, or a law.
    angle
        Angle without torque in radians: of the bar, or of the second body against the first; whole
        turns count.
    damping
        N·m·s/rad, ≥ 0, or a law.
    """

    relaxed: ClassVar[str] = "angle"

    stiffness: TorsionalStiffnessLaw
    angle: Angle = 0.0
    damping: TorsionalDampingLaw = 0.0


@component
class GuideSpring(_Spring, OnSlider):
    """A spring and a damper between a slider and what carries its axis, along that axis.

    Parameters
    ----------
    stiffness
        N/m, ≥ 0, or a law.
    position
        Position of the slider on its axis without force, in metres.
    damping
        N·s/m, ≥ 0, or a law.
    """

    section: ClassVar[str] = "springs"
    relaxed: ClassVar[str] = "position"

    stiffness: StiffnessLaw
    position: Length = 0.0
    damping: DampingLaw = 0.0


@component
class BarSpring(_TorsionalSpring, OnBar):
    """A torsional spring and damper that turn a bar or plate against the ground."""

    section: ClassVar[str] = "springs"


@component
class SpringBetweenBars(_TorsionalSpring, BetweenBars):
    """A torsional spring and damper between two bodies."""

    section: ClassVar[str] = "springs"


class _Tabulated(Attached, ListedComponent):
    """What pulls back along a measure, as a table says."""

    places: ClassVar[str]
    values: ClassVar[str]
    interpolation: Interpolation

    def _table(self) -> Table:
        path, places = (*self.path, self.values), getattr(self, self.places)
        return Table(path, places, getattr(self, self.values), False, self.interpolation, over=X)

    def problems(self) -> tuple[tuple[KeyPath, str], ...]:
        """Enough increasing places, and a value for each."""
        return (*super().problems(), *self._of_table())

    def _of_table(self) -> tuple[tuple[KeyPath, str], ...]:
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

    def terms(self) -> tuple[Load, ...]:
        """One load."""
        if self._of_table():  # reported
            return ()
        return (self.acting(applied("neg", self._table()), called="spring"),)


@component
class TabulatedSpring(_Tabulated, BetweenJoints):
    """A spring between two joints whose pull is a table over its length.

    Parameters
    ----------
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

    lengths: tuple[NonNegativeLength, ...]
    forces: tuple[Force, ...]
    interpolation: Interpolation = "pchip"


@component
class TabulatedGuideSpring(_Tabulated, OnSlider):
    """A spring in the guide of a slider whose force is a table over the slider's position.

    Parameters
    ----------
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

    positions: tuple[Length, ...]
    forces: tuple[Force, ...]
    interpolation: Interpolation = "pchip"


@component
class TabulatedTorsionalSpring(_Tabulated, BetweenBars):
    """A spring between two bodies whose torque is a table over their angle.

    Parameters
    ----------
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

    angles: tuple[Angle, ...]
    torques: tuple[Torque, ...]
    interpolation: Interpolation = "pchip"
