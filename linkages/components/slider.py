"""A block that slides on a fixed axis."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.component import Component, component
from linkages.components.terms import ZERO, Body, Guide, Origin, Parameter, References
from linkages.spec.quantities import Angle, Mass, Name, Point


@component
class Slider(Component):
    """A block pinned at a joint that moves along a straight axis without turning.

    Parameters
    ----------
    name
        Slider name.
    joint
        The joint carried by the block; it lies on the axis.
    through
        A ground joint or a point [x, y] that the axis goes through; positions count from there.
    angle
        Direction of the axis in radians.
    mass
        Kilograms.
    """

    section: ClassVar[str] = "sliders"

    name: Name
    joint: Name
    through: Name | Point
    angle: Angle = 0.0
    mass: Mass = 0.0

    def references(self) -> References:
        """The ground joint that the axis goes through."""
        if isinstance(self.through, str):
            return References(ground=(((*self.path, "through"), self.through),))
        return References()

    def terms(self) -> tuple[Body, ...]:
        """One body that slides."""
        if isinstance(self.through, str):
            origin: Origin = self.through
        else:
            origin = (
                Parameter((*self.path, "through", 0), self.through[0], structural=True),
                Parameter((*self.path, "through", 1), self.through[1], structural=True),
            )
        return (
            Body(
                name=self.name,
                kind="slider",
                path=self.path,
                points={self.joint: (ZERO, ZERO)},
                mass=Parameter((*self.path, "mass"), self.mass, structural=True),
                guide=Guide(origin, Parameter((*self.path, "angle"), self.angle)),
            ),
        )
