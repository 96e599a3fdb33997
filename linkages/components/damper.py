"""Viscous dampers along a line: between joints, and in the guides of sliders."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import component
from linkages.components.contributed.listed import ListedComponent
from linkages.components.contributed.measures import Distance, Load, Slide, damper_law
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import Path
from linkages.components.laws.law import DampingLaw, function_of
from linkages.components.spring import ends, two_joints
from linkages.spec.quantities import Name


@component
class LineDamper(ListedComponent):
    """A damper between two joints: its force is damping times the rate of their distance.

    Parameters
    ----------
    index
        Place in the list of dampers.
    between
        Two joints; one may be fixed to the ground.
    damping
        N·s/m, ≥ 0, or a law.
    """

    section: ClassVar[str] = "dampers"

    index: int
    between: tuple[Name, Name]
    damping: DampingLaw

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different joints."""
        return two_joints((*self.path, "between"), self.between)

    def references(self) -> References:
        """The joints."""
        return References(joints=ends((*self.path, "between"), self.between))

    def terms(self) -> tuple[Load, ...]:
        """A damper between the joints."""
        damping = function_of(self.damping, (*self.path, "damping"))
        return (Load(Distance(*self.between), damper_law(damping), self.path),)


@component
class GuideDamper(ListedComponent):
    """Viscous friction of a slider in its guide.

    Parameters
    ----------
    index
        Place in the list of dampers.
    slider
        Slider name.
    damping
        N·s/m, ≥ 0, or a law.
    """

    section: ClassVar[str] = "dampers"
    told_by: ClassVar[str] = "slider"

    index: int
    slider: Name
    damping: DampingLaw

    def references(self) -> References:
        """The slider."""
        return References(bodies=(((*self.path, "slider"), self.slider, ("slider",)),))

    def terms(self) -> tuple[Load, ...]:
        """One damper along the axis."""
        damping = function_of(self.damping, (*self.path, "damping"))
        return (Load(Slide(self.slider), damper_law(damping), self.path),)
