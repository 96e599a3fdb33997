"""Two bodies fixed to each other at a joint."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import Component, component
from linkages.components.contributed.listed import reference, turning, two_bodies
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import Parameter, Path, Relation
from linkages.spec.quantities import Angle, Name

_ONE = Parameter((), 1.0, structural=True)


@component
class Weld(Component):
    """At a joint, one body is rigidly fixed to another: θ_b = θ_a + angle.

    Parameters
    ----------
    name
        Joint name.
    bars
        Two bars or plates a and b that have the joint; a may be ``ground``.
    angle
        Angle of b against a in radians.
    """

    section: ClassVar[str] = "welds"

    name: Name
    bars: tuple[Name, Name]
    angle: Angle

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different bodies."""
        return two_bodies((*self.path, "bars"), self.bars)

    def references(self) -> References:
        """The joint, and the bodies that have it."""
        path = (*self.path, "bars")
        return References(
            joints=((self.path, self.name),),
            bodies=turning(path, self.bars),
            meeting=tuple(((*path, place), bar, self.name) for place, bar in enumerate(self.bars)),
        )

    def terms(self) -> tuple[Relation, ...]:
        """One relation of angles; the joint holds the rest."""
        other = reference(self.bars)
        angle = self.number("angle")
        parts = () if other is None else ((other, _ONE),)
        return (Relation(self.bars[1], parts, angle, self.path),)
