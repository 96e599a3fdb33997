"""Counterweights: masses behind the pivot of a bar that balance it."""

from __future__ import annotations

import math
from typing import ClassVar

from linkages.components.contributed.component import Component, Section, component
from linkages.components.contributed.listed import TURNING
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import ZERO, Body, Parameter, Path, Relation
from linkages.spec.quantities import Angle, Inertia, Mass, Name, PositiveLength

_ONE = Parameter((), 1.0, structural=True)


@component
class Counterweight(Component):
    """A mass that is fixed to a bar or plate at a distance from one of its joints.

    Parameters
    ----------
    name
        Name of the counterweight, a body of its own in results.
    bar
        The bar or plate that carries it.
    joint
        A joint of that bar, from which it stands off.
    mass
        Kilograms.
    distance
        From the joint to its centre of mass, in metres.
    angle
        Direction of the centre of mass from the joint, against the bar's own; half a turn, which is
        opposite to the bar, if not given.
    inertia
        About the centre of mass in kg·m²; zero, that of a point, if not given.
    """

    section: ClassVar[str] = "counterweights"
    opens: ClassVar[Section] = Section(
        "mapping", "balance: {bar: crank, joint: O, mass: 1.5, distance: 40 mm}"
    )

    name: Name
    bar: Name
    joint: Name
    mass: Mass
    distance: PositiveLength
    angle: Angle = math.pi
    inertia: Inertia = 0.0

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """One that is not the bar itself, and has a mass: without one it is none."""
        found = []
        if self.name == self.bar:
            found.append((self.path, f"expected a name other than that of its bar, {self.bar!r}"))
        if self.mass == 0:
            found.append(((*self.path, "mass"), "expected a mass > 0, found 0"))
        return tuple(found)

    def references(self) -> References:
        """The bar and its joint."""
        return References(
            joints=(((*self.path, "joint"), self.joint),),
            bodies=(((*self.path, "bar"), self.bar, TURNING),),
            meeting=(((*self.path, "joint"), self.bar, self.joint),),
        )

    def terms(self) -> tuple[Body | Relation, ...]:
        """A body with one joint, whose own axis leads to its centre, and a relation of angles."""
        centre = (Parameter((*self.path, "distance"), self.distance), ZERO)
        return (
            Body(
                name=self.name,
                kind="plate",
                path=self.path,
                points={self.joint: (ZERO, ZERO), f"{self.name}.center": centre},
                mass=Parameter((*self.path, "mass"), self.mass, structural=True),
                inertia=Parameter((*self.path, "inertia"), self.inertia, structural=True),
                centre=centre,
            ),
            Relation(
                self.name,
                ((self.bar, _ONE),),
                Parameter((*self.path, "angle"), self.angle, structural=True),
                self.path,
            ),
        )
