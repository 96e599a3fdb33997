"""Viscous dampers that turn: at a joint, between bodies, and in a clearance."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import component
from linkages.components.contributed.listed import ListedComponent, reference, turning, two_bodies
from linkages.components.contributed.measures import (
    ClearanceFriction,
    JointFriction,
    Load,
    Turn,
    damper_law,
)
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import Path
from linkages.components.laws.law import TorsionalDampingLaw, function_of
from linkages.spec.quantities import Name


@component
class JointDamper(ListedComponent):
    """Viscous friction in a revolute joint.

    Parameters
    ----------
    index
        Place in the list of dampers.
    joint
        A joint at which two bodies turn against each other, or one against the ground.
    damping
        N·m·s/rad, ≥ 0, or a law.
    bars
        Which two, where more meet; the first may be ``ground``.
    """

    section: ClassVar[str] = "dampers"
    told_by: ClassVar[str] = "joint"

    index: int
    joint: Name
    damping: TorsionalDampingLaw
    bars: tuple[Name, Name] | None = None

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different bodies."""
        return two_bodies((*self.path, "bars"), self.bars) if self.bars else ()

    def references(self) -> References:
        """The joint, and the bodies that have it."""
        path, bars = (*self.path, "bars"), self.bars or ()
        return References(
            joints=(((*self.path, "joint"), self.joint),),
            bodies=turning(path, bars),
            meeting=tuple(((*path, place), bar, self.joint) for place, bar in enumerate(bars)),
        )

    def terms(self) -> tuple[JointFriction, ...]:
        """Friction between bodies that only the whole mechanism knows."""
        damping = function_of(self.damping, (*self.path, "damping"))
        return (JointFriction(self.joint, self.bars, damper_law(damping), self.path),)


@component
class DamperBetweenBars(ListedComponent):
    """A torsional damper between two bodies, wherever they are.

    Parameters
    ----------
    index
        Place in the list of dampers.
    bars
        Two bars or plates; the first may be ``ground``.
    damping
        N·m·s/rad, ≥ 0, or a law.
    """

    section: ClassVar[str] = "dampers"
    told_by: ClassVar[str] = "bars"

    index: int
    bars: tuple[Name, Name]
    damping: TorsionalDampingLaw

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different bodies."""
        return two_bodies((*self.path, "bars"), self.bars)

    def references(self) -> References:
        """The bodies."""
        return References(bodies=turning((*self.path, "bars"), self.bars))

    def terms(self) -> tuple[Load, ...]:
        """A damper along their angle."""
        damping = function_of(self.damping, (*self.path, "damping"))
        angle = Turn(self.bars[1], reference(self.bars))
        return (Load(angle, damper_law(damping), self.path),)


@component
class ClearanceDamper(ListedComponent):
    """Viscous friction in a clearance: between its link and the bar that it displaces.

    Parameters
    ----------
    index
        Place in the list of dampers.
    clearance
        Clearance name.
    damping
        N·m·s/rad, ≥ 0, or a law.
    """

    section: ClassVar[str] = "dampers"
    told_by: ClassVar[str] = "clearance"

    index: int
    clearance: Name
    damping: TorsionalDampingLaw

    def references(self) -> References:
        """The clearance."""
        return References(bodies=(((*self.path, "clearance"), self.clearance, ("clearance",)),))

    def terms(self) -> tuple[ClearanceFriction, ...]:
        """Friction against a bar that the clearance knows."""
        damping = function_of(self.damping, (*self.path, "damping"))
        return (ClearanceFriction(self.clearance, damper_law(damping), self.path),)
