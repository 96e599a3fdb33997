"""Gears: angles in a fixed ratio."""

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
from linkages.components.contributed.references import References
from linkages.components.contributed.revolute import GROUND
from linkages.components.contributed.terms import Parameter, Path, Relation
from linkages.spec.quantities import Angle, Name, Number


@component
class Gear(ListedComponent):
    """Two bodies that turn in a ratio: θ_b − θ_c = ratio·(θ_a − θ_c) + angle.

    Parameters
    ----------
    index
        Place in the list of gears.
    bars
        Two bars or plates a and b; a may be ``ground``, a wheel that stands still.
    ratio
        Speed of b over speed of a, seen from the carrier: minus the quotient of their radii for
        outer gears, plus for an inner gear or a belt. Not 0.
    carrier
        The bar or plate c that carries the axes; the ground if not given.
    angle
        In radians.
    """

    section: ClassVar[str] = "gears"

    index: int
    bars: tuple[Name, Name]
    ratio: Number
    carrier: Name | None = None
    angle: Angle = 0.0

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different wheels on a third body, and a ratio that is one."""
        found = list(two_bodies((*self.path, "bars"), self.bars))
        if self.ratio == 0:
            found.append(((*self.path, "ratio"), "expected a ratio other than 0"))
        if self.carrier in self.bars:
            expected = f"expected a third body, found {self.carrier!r} again"
            found.append(((*self.path, "carrier"), expected))
        if self.bars[0] == GROUND and self.carrier in (None, GROUND):
            needed = "a wheel that stands still needs a carrier that moves"
            found.append((self.path, f"missing key 'carrier': {needed}"))
        return tuple(found)

    def references(self) -> References:
        """The wheels and their carrier."""
        bodies = turning((*self.path, "bars"), self.bars)
        if self.carrier not in (None, GROUND):
            bodies = (*bodies, ((*self.path, "carrier"), str(self.carrier), TURNING))
        return References(bodies=bodies)

    def terms(self) -> tuple[Relation, ...]:
        """One relation: θ_b = ratio·θ_a + (1 − ratio)·θ_c + angle."""
        parts: tuple[tuple[str, Parameter], ...] = ()
        first = reference(self.bars)
        if first is not None:
            parts = ((first, Parameter((*self.path, "ratio"), self.ratio)),)
        if self.carrier is not None and self.carrier != GROUND:
            share = Parameter((*self.path, "carrier"), 1.0 - self.ratio)
            parts = (*parts, (self.carrier, share))
        offset = self.number("angle")
        return (Relation(self.bars[1], parts, offset, self.path),)
