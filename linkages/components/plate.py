"""A ternary or higher link: a rigid body with any number of joints."""

from __future__ import annotations

from itertools import combinations
from typing import ClassVar

from linkages.components.contributed.component import Component, component
from linkages.components.contributed.terms import Body, Parameter, Path
from linkages.spec.quantities import Inertia, Mass, Name, Point


@component
class Plate(Component):
    """A rigid body with joints given in its frame; its angle is that of the frame.

    Parameters
    ----------
    name
        Plate name; plates stand among the bars of the definition file.
    points
        Joint name → coordinates in the plate's frame, in metres.
    mass
        Kilograms.
    center
        Centre of mass in the plate's frame; must be given with a mass.
    inertia
        About the centre of mass in kg·m²; must be given with a mass.
    """

    section: ClassVar[str] = "bars"
    told_by: ClassVar[str] = "points"

    name: Name
    points: dict[Name, Point]
    mass: Mass = 0.0
    center: Point | None = None
    inertia: Inertia | None = None

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Pins apart from each other, and a centre and an inertia where there is a mass."""
        found: list[tuple[Path, str]] = []
        if not self.points:
            found.append(((*self.path, "points"), "expected at least one point, found none"))
        for (first, p), (second, q) in combinations(self.points.items(), 2):
            if p == q:
                found.append(
                    (
                        (*self.path, "points", second),
                        f"{second!r} lies on {first!r}; expected two places",
                    )
                )
        if self.mass > 0:
            found.extend(
                (
                    self.path,
                    f"missing key {key!r}: a plate with a mass needs it, nothing can be assumed",
                )
                for key in ("center", "inertia")
                if getattr(self, key) is None
            )
        return tuple(found)

    def terms(self) -> tuple[Body, ...]:
        """One body that turns.

        A plate with one joint gets its centre of mass as a second point: two points carry the mass.
        """
        points = {joint: self.pair(xy, "points", joint) for joint, xy in self.points.items()}
        centre = self.pair(self.center or (0.0, 0.0), "center")
        if len(points) == 1 and self.center is not None and self.center not in self.points.values():
            points[f"{self.name}.center"] = centre
        return (
            Body(
                name=self.name,
                kind="plate",
                path=self.path,
                points=points,
                mass=self.number("mass"),
                inertia=Parameter((*self.path, "inertia"), self.inertia or 0.0, structural=True),
                centre=centre,
            ),
        )
