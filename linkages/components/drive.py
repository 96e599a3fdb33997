"""A motor that prescribes the angle of a bar."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.component import Component, component
from linkages.components.terms import Parameter, Prescribed, References
from linkages.spec.quantities import Angle, AngularSpeed, Name


@component
class Drive(Component):
    """Turns a bar or plate at constant speed: θ = angle + speed·t.

    Parameters
    ----------
    name
        The bar or plate that is driven against the ground.
    angle
        Angle at t = 0 in radians.
    speed
        Angular speed in rad/s.
    """

    section: ClassVar[str] = "drives"

    name: Name
    angle: Angle
    speed: AngularSpeed

    def references(self) -> References:
        """The driven bar."""
        return References(bodies=((self.path, self.name, ("bar", "plate")),))

    def terms(self) -> tuple[Prescribed, ...]:
        """One prescribed coordinate."""
        return (
            Prescribed(
                self.name,
                Parameter((*self.path, "angle"), self.angle),
                Parameter((*self.path, "speed"), self.speed),
                self.path,
            ),
        )
