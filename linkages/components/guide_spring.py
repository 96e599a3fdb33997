"""Springs in the guides of sliders, with a damper beside them."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import component
from linkages.components.contributed.listed import ListedComponent
from linkages.components.contributed.measures import Load, Slide, spring_law
from linkages.components.contributed.references import References
from linkages.spec.quantities import Damping, Length, Name, Stiffness


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
        N/m, ≥ 0.
    position
        Position of the slider on its axis without force, in metres.
    damping
        N·s/m, ≥ 0.
    """

    section: ClassVar[str] = "springs"
    told_by: ClassVar[str] = "slider"

    index: int
    slider: Name
    stiffness: Stiffness
    position: Length = 0.0
    damping: Damping = 0.0

    def references(self) -> References:
        """The slider."""
        return References(bodies=(((*self.path, "slider"), self.slider, ("slider",)),))

    def terms(self) -> tuple[Load, ...]:
        """A spring and damper; numbers of exactly zero are structure."""
        law = spring_law(*map(self.number, ("stiffness", "position", "damping")))
        return (Load(Slide(self.slider), law, self.path),)
