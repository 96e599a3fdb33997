"""Forces that act on a mechanism from outside."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.component import Component, component
from linkages.components.terms import AxialForce, Parameter, Path, References
from linkages.spec.quantities import Force, Name


@component
class SliderForce(Component):
    """A constant force on a slider along its axis.

    Parameters
    ----------
    index
        Place in the list of loads.
    slider
        Slider name.
    force
        Newtons, positive along the axis.
    """

    section: ClassVar[str] = "loads"

    index: int
    slider: Name
    force: Force

    @property
    def path(self) -> Path:
        """Loads have no names: they stand in a list."""
        return (self.section, self.index)

    def references(self) -> References:
        """The slider."""
        return References(bodies=(((*self.path, "slider"), self.slider, ("slider",)),))

    def terms(self) -> tuple[AxialForce, ...]:
        """One force."""
        force = Parameter((*self.path, "force"), self.force, structural=True)
        return (AxialForce(self.slider, force, self.path),)
