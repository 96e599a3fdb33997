"""Forces on sliders and joints from outside."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import component
from linkages.components.contributed.listed import ListedComponent
from linkages.components.contributed.measures import Coordinate, Load, Slide
from linkages.components.contributed.references import References
from linkages.components.laws.law import ForceLaw, function_of
from linkages.spec.quantities import Name


@component
class SliderForce(ListedComponent):
    """A force on a slider along its axis.

    Parameters
    ----------
    index
        Place in the list of loads.
    slider
        Slider name.
    force
        Newtons, positive along the axis, or a law of time. What carries the axis gets the
        opposite force.
    """

    section: ClassVar[str] = "loads"

    index: int
    slider: Name
    force: ForceLaw

    def references(self) -> References:
        """The slider."""
        return References(bodies=(((*self.path, "slider"), self.slider, ("slider",)),))

    def terms(self) -> tuple[Load, ...]:
        """One force."""
        force = function_of(self.force, (*self.path, "force"))
        return (Load(Slide(self.slider), force, self.path),)


@component
class JointForce(ListedComponent):
    """A force at a joint with given components along x and y.

    Parameters
    ----------
    index
        Place in the list of loads.
    joint
        A joint that moves.
    force
        Two numbers in newtons, or laws of time.
    """

    section: ClassVar[str] = "loads"
    told_by: ClassVar[str] = "joint"

    index: int
    joint: Name
    force: tuple[ForceLaw, ForceLaw]

    def references(self) -> References:
        """The joint."""
        return References(moving=(((*self.path, "joint"), self.joint),))

    def terms(self) -> tuple[Load, ...]:
        """One force along each axis."""
        return tuple(
            Load(
                Coordinate(self.joint, axis),
                function_of(law, (*self.path, "force", axis)),
                self.path,
            )
            for axis, law in enumerate(self.force)
        )
