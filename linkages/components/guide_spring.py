"""Springs in the guides of sliders, with a damper beside them."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import component
from linkages.components.contributed.listed import ListedComponent
from linkages.components.contributed.measures import Load, Slide, spring_law
from linkages.components.contributed.references import References
from linkages.components.laws.law import DampingLaw, StiffnessLaw, function_of
from linkages.spec.quantities import Length, Name


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
