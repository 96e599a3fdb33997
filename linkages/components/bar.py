"""A rigid bar between two joints."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import Component, component
from linkages.components.contributed.terms import ZERO, Body, Parameter, Path
from linkages.spec.quantities import Inertia, Length, Mass, Name, Point, PositiveLength


@component
class Bar(Component):
    """A rigid bar; its angle is that of the direction from its first to its second joint.

    Parameters
    ----------
    name
        Bar name.
    joints
        The joints at its two ends.
    length
        Distance of the two joints in metres, > 0.
    mass
        Kilograms; a bar without mass is left out of the energies.
    inertia
        About the centre of mass in kg·m²; m·L²/12 if not given.
    center
        Distance of the centre of mass from the first joint, or its coordinates along and
        across the bar, in metres; mid-length if not given.
    """

    section: ClassVar[str] = "bars"

    name: Name
    joints: tuple[Name, Name]
    length: PositiveLength
    mass: Mass = 0.0
    inertia: Inertia | None = None
    center: Length | Point | None = None

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """A bar joins two different joints."""
        if self.joints[0] == self.joints[1]:
            found = self.joints[0]
            return (
                ((*self.path, "joints"), f"expected two different joints, found {found!r} twice"),
            )
        return ()

    @property
    def centre(self) -> tuple[float, float]:
        """Centre of mass along and across the bar, from the first joint, in metres."""
        if self.center is None:
            return (0.5 * self.length, 0.0)
        return self.center if isinstance(self.center, tuple) else (self.center, 0.0)

    @property
    def central_inertia(self) -> float:
        """Moment of inertia about the centre of mass in kg·m²."""
        uniform = self.mass * self.length * self.length / 12.0
        return uniform if self.inertia is None else self.inertia

    def terms(self) -> tuple[Body, ...]:
        """One body that turns."""
        length = Parameter((*self.path, "length"), self.length)
        return (
            Body(
                name=self.name,
                kind="bar",
                path=self.path,
                points={self.joints[0]: (ZERO, ZERO), self.joints[1]: (length, ZERO)},
                mass=self.number("mass"),
                inertia=Parameter((*self.path, "inertia"), self.central_inertia, structural=True),
                centre=self.pair(self.centre, "center"),
            ),
        )
