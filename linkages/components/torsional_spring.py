"""Torsional springs between bodies and against the ground, with a damper beside them."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import component
from linkages.components.contributed.listed import (
    TURNING,
    ListedComponent,
    reference,
    turning,
    two_bodies,
)
from linkages.components.contributed.measures import Load, Turn, spring_law
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import Path
from linkages.components.laws.law import (
    TorsionalDampingLaw,
    TorsionalStiffnessLaw,
    function_of,
)
from linkages.spec.quantities import Angle, Name


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

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different bodies."""
        return two_bodies((*self.path, "between_bars"), self.between_bars)

    def references(self) -> References:
        """The bodies."""
        return References(bodies=turning((*self.path, "between_bars"), self.between_bars))

    def terms(self) -> tuple[Load, ...]:
        """One torsional spring; numbers of exactly zero are structure."""
        return self._spring(self.between_bars[1], reference(self.between_bars))
