"""Torques on bars and plates from outside, and between them."""

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
from linkages.components.contributed.measures import Load, Turn
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import Path
from linkages.components.laws.law import TorqueLaw, function_of
from linkages.spec.quantities import Name


@component
class BarTorque(ListedComponent):
    """A torque of the ground on a bar or plate.

    Parameters
    ----------
    index
        Place in the list of loads.
    bar
        The bar or plate.
    torque
        Newton metres, counter-clockwise positive, or a law.
    """

    section: ClassVar[str] = "loads"
    told_by: ClassVar[str] = "bar"

    index: int
    bar: Name
    torque: TorqueLaw

    def references(self) -> References:
        """The bar."""
        return References(bodies=(((*self.path, "bar"), self.bar, TURNING),))

    def terms(self) -> tuple[Load, ...]:
        """One torque."""
        torque = function_of(self.torque, (*self.path, "torque"))
        return (Load(Turn(self.bar, None), torque, self.path, applied=True),)


@component
class TorqueBetweenBars(ListedComponent):
    """A torque of one body on another.

    Parameters
    ----------
    index
        Place in the list of loads.
    bars
        Two bars or plates: the torque acts on the second, the opposite one on the first. The
        first may be ``ground``.
    torque
        Newton metres, counter-clockwise positive, or a law.
    """

    section: ClassVar[str] = "loads"
    told_by: ClassVar[str] = "bars"

    index: int
    bars: tuple[Name, Name]
    torque: TorqueLaw

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different bodies."""
        return two_bodies((*self.path, "bars"), self.bars)

    def references(self) -> References:
        """The bodies."""
        return References(bodies=turning((*self.path, "bars"), self.bars))

    def terms(self) -> tuple[Load, ...]:
        """One torque and its reaction."""
        torque = function_of(self.torque, (*self.path, "torque"))
        return (Load(Turn(self.bars[1], reference(self.bars)), torque, self.path, applied=True),)
