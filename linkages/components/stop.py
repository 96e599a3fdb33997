"""Stops: springs that a slider or a bar meets at the ends of its way, and ropes that go slack."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import Section, component
from linkages.components.contributed.functions import Function, Number, V, X, applied
from linkages.components.contributed.listed import (
    ListedComponent,
    reference,
    turning,
    two_bodies,
)
from linkages.components.contributed.measures import Distance, Load, Measure, Slide, Turn
from linkages.components.contributed.references import References
from linkages.components.contributed.state_laws import sum_of
from linkages.components.contributed.terms import Parameter, Path
from linkages.components.spring import ends, two_joints
from linkages.spec.quantities import (
    Angle,
    Damping,
    Length,
    Name,
    NonNegativeLength,
    PositiveStiffness,
    PositiveTorsionalStiffness,
    TorsionalDamping,
)


class _Stop(ListedComponent):
    lower: float | None
    upper: float | None
    damping: float

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """At least one end, and the upper one above the lower one."""
        if self.lower is None and self.upper is None:
            return ((self.path, "missing key 'lower' or 'upper': a stop is somewhere"),)
        if self.lower is not None and self.upper is not None and self.lower >= self.upper:
            message = f"expected more than 'lower', {self.lower:g}, found {self.upper:g}"
            return (((*self.path, "upper"), message),)
        return ()

    def _number(self, key: str) -> Number:
        return Number(Parameter((*self.path, key), getattr(self, key)))

    def _load(self, measure: Measure) -> Load:
        """A spring and a damper at each end, which push back and never pull."""
        depths = []
        if self.upper is not None:
            depths.append((X - self._number("upper"), -1.0))
        if self.lower is not None:
            depths.append((self._number("lower") - X, 1.0))
        stiffness = self._number("stiffness")
        pushes, energies = [], []
        for depth, sense in depths:
            push = stiffness * depth
            if self.damping:
                push = push - sense * self._number("damping") * V
                push = applied("where", depth, applied("max", push, 0), 0)
                pushes.append(sense * push)
            else:
                inside: Function = applied("max", depth, 0)
                pushes.append(sense * stiffness * inside)
                energies.append(0.5 * stiffness * inside * inside)
        stores = sum_of(energies) if energies else None
        return Load(measure, sum_of(pushes), self.path, called="stop", stores=stores)


@component
class GuideStop(_Stop):
    """Stops of a slider on its axis.

    Parameters
    ----------
    index
        Place in the list of stops.
    slider
        Slider name.
    stiffness
        N/m, > 0.
    lower, upper
        Positions from which a stop pushes back, in metres; one of them may be left out.
    damping
        N·s/m, ≥ 0, while it pushes.
    """

    section: ClassVar[str] = "stops"
    opens: ClassVar[Section] = Section("list", "{slider: piston, upper: 0.3, stiffness: 1e6}")

    index: int
    slider: Name
    stiffness: PositiveStiffness
    lower: Length | None = None
    upper: Length | None = None
    damping: Damping = 0.0

    def references(self) -> References:
        """The slider."""
        return References(bodies=(((*self.path, "slider"), self.slider, ("slider",)),))

    def terms(self) -> tuple[Load, ...]:
        """One load along the axis."""
        return (self._load(Slide(self.slider)),)


@component
class AngleStop(_Stop):
    """Stops of a bar or plate that turns, against the ground or another one.

    Parameters
    ----------
    index
        Place in the list of stops.
    bars
        Two bars or plates: the angle is that of the second against the first, which may be
        ``ground``; whole turns count.
    stiffness
        N·m/rad, > 0.
    lower, upper
        Angles from which a stop pushes back, in radians; one of them may be left out.
    damping
        N·m·s/rad, ≥ 0, while it pushes.
    """

    section: ClassVar[str] = "stops"
    told_by: ClassVar[str] = "bars"

    index: int
    bars: tuple[Name, Name]
    stiffness: PositiveTorsionalStiffness
    lower: Angle | None = None
    upper: Angle | None = None
    damping: TorsionalDamping = 0.0

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different bodies, and ends of the way."""
        return (*two_bodies((*self.path, "bars"), self.bars), *super().problems())

    def references(self) -> References:
        """The bodies."""
        return References(bodies=turning((*self.path, "bars"), self.bars))

    def terms(self) -> tuple[Load, ...]:
        """One load along the angle."""
        return (self._load(Turn(self.bars[1], reference(self.bars))),)


@component
class DistanceStop(_Stop):
    """Ends of the distance of two joints: a rope that gets taut, a telescope that is pushed in.

    Parameters
    ----------
    index
        Place in the list of stops.
    between
        Two joints; one may be fixed to the ground.
    stiffness
        N/m, > 0.
    lower, upper
        Distances from which it pushes apart or pulls together, in metres; one may be left out.
    damping
        N·s/m, ≥ 0, while it does so.
    """

    section: ClassVar[str] = "stops"
    told_by: ClassVar[str] = "between"

    index: int
    between: tuple[Name, Name]
    stiffness: PositiveStiffness
    lower: NonNegativeLength | None = None
    upper: NonNegativeLength | None = None
    damping: Damping = 0.0

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different joints, and ends of the distance."""
        return (*two_joints((*self.path, "between"), self.between), *super().problems())

    def references(self) -> References:
        """The joints."""
        return References(joints=ends((*self.path, "between"), self.between))

    def terms(self) -> tuple[Load, ...]:
        """One load along the distance."""
        return (self._load(Distance(*self.between)),)
