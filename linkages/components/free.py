"""Free coordinates other than clearances, with their initial state."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import Component, component
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import Initial
from linkages.spec.quantities import Angle, AngularSpeed, Length, Name, Speed


@component
class FreeAngle(Component):
    """The angle of a bar or plate that nothing drives.

    Parameters
    ----------
    name
        The bar or plate.
    angle, speed
        State at t = 0 in rad and rad/s.
    """

    section: ClassVar[str] = "free"

    name: Name
    angle: Angle
    speed: AngularSpeed = 0.0

    def references(self) -> References:
        """The bar."""
        return References(bodies=((self.path, self.name, ("bar", "plate")),))

    def terms(self) -> tuple[Initial, ...]:
        """One free coordinate."""
        return (Initial(self.name, self.angle, self.speed, self.path),)


@component
class FreePosition(Component):
    """The displacement of a slider that nothing drives.

    Parameters
    ----------
    name
        The slider.
    position, speed
        State at t = 0 in m and m/s.
    """

    section: ClassVar[str] = "free"
    told_by: ClassVar[str] = "position"

    name: Name
    position: Length
    speed: Speed = 0.0

    def references(self) -> References:
        """The slider."""
        return References(bodies=((self.path, self.name, ("slider",)),))

    def terms(self) -> tuple[Initial, ...]:
        """One free coordinate."""
        return (Initial(self.name, self.position, self.speed, self.path),)
