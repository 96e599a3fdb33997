"""A revolute joint with clearance, modelled as a massless virtual link (paper, "Idea")."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import Component, component
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import ZERO, Body, Displacement, Initial, Parameter
from linkages.spec.quantities import Angle, AngularSpeed, Name, PositiveLength


@component
class Clearance(Component):
    """The end of one bar sits ``size`` away from the journal that it would turn on.

    Journal and bearing stay in contact, so the distance is a massless link whose angle is one more
    free coordinate.

    Parameters
    ----------
    name
        Clearance name.
    joint
        The joint with clearance.
    bar
        The bar (or plate) whose point is displaced from the joint; that point is called
        ``joint.name`` in the results.
    size
        Radial clearance in metres, > 0.
    angle, speed
        Direction from the journal to the bar's point at t = 0 (rad) and its rate (rad/s).
    """

    section: ClassVar[str] = "clearances"

    name: Name
    joint: Name
    bar: Name
    size: PositiveLength
    angle: Angle = 0.0
    speed: AngularSpeed = 0.0

    def references(self) -> References:
        """The joint and the bar that has it."""
        return References(
            joints=(((*self.path, "joint"), self.joint),),
            bodies=(((*self.path, "bar"), self.bar, ("bar", "plate")),),
        )

    def terms(self) -> tuple[Displacement | Initial, ...]:
        """The virtual link and its initial state."""
        renamed = f"{self.joint}.{self.name}"
        size = Parameter((*self.path, "size"), self.size)
        link = Body(
            name=self.name,
            kind="clearance",
            path=self.path,
            points={self.joint: (ZERO, ZERO), renamed: (size, ZERO)},
        )
        return (
            Displacement(self.name, self.joint, self.bar, renamed, (link,)),
            Initial(self.name, self.angle, self.speed, self.path),
        )
