"""Contacts of points and rounds of one body with straight or circular walls of another."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import ClassVar

from linkages.components.contributed.component import Fault, References, Section, component
from linkages.components.contributed.contact_laws import WithoutRoom
from linkages.components.contributed.load_measures import GROUND
from linkages.components.contributed.normal_forces import Contact, RoundAtWall
from linkages.components.contributed.terms import Parameter
from linkages.spec.quantities import (
    Angle,
    BodyName,
    BodyOrGroundName,
    JointName,
    Name,
    NonNegativeLength,
    PositiveLength,
)


@component
class WallContact(WithoutRoom):
    """Points of one body, or rounds about them, may touch a wall of another body and leave it.

    Results call a contact by the name of the entry; of several points each is ``name.point``.

    Parameters
    ----------
    name
        What results call it.
    body, points
        What touches the wall, and which of its joints: each a point, or the middle of a round.
    radius
        Of the rounds, in metres; 0 for points.
    wall
        What has the wall: a body, or the ``ground``.
    through
        One of its joints: a point of a straight wall, or the middle of a circular one.
    angle
        Direction of a straight wall in the frame of its body, in radians: what lies on its left is
        free.
    circle
        Radius of a circular wall in metres, in the place of an angle.
    inside
        Whether the round is within the circle; otherwise it is around it.
    """

    section: ClassVar[str] = "contacts"
    opens: ClassVar[Section] = Section(
        "mapping",
        "tip: {body: rod, points: [B], through: O, angle: 0, contact: restitution, "
        "restitution: 0.5, friction: 0.3}",
    )

    name: Name
    body: BodyName
    points: tuple[JointName, ...]
    radius: NonNegativeLength = 0.0
    wall: BodyOrGroundName = GROUND
    through: Name
    angle: Angle | None = None
    circle: PositiveLength | None = None
    inside: bool = False

    def faults(self) -> Iterator[Fault]:
        """Keys that the law has or lacks, and a wall that is neither straight nor a circle."""
        yield from super().faults()
        if not self.points or len({*self.points}) < len(self.points):
            yield "points", "expected the names of one joint or more, each once"
        if self.body == self.wall:
            yield "wall", f"expected another body than {self.body!r}, which touches it"
        if self.angle is None and self.circle is None:
            yield (), "missing key 'angle' or 'circle': a wall is straight or a circle"
        elif self.angle is not None and self.circle is not None:
            yield "circle", "'angle' is given as well; expected one of the two"
        if self.inside and self.circle is None:
            yield "inside", "a straight wall has no inside; it is for a 'circle'"
        elif self.inside and self.circle is not None and self.radius >= self.circle:
            found = f"found {self.radius:g} m"
            yield "radius", f"expected less than that of the circle, {self.circle:g} m, {found}"

    def references(self) -> References:
        """Both bodies and their points."""
        named, path = super().references(), (*self.path, "through")
        points = [(own, self.body, point) for own, point in named.joints]
        through = ((path, self.through),)
        if self.wall == GROUND:
            return replace(named, ground=through, points=tuple(points))
        points.append((path, self.wall, self.through))
        return replace(named, joints=(*named.joints, *through), points=tuple(points))

    def terms(self) -> tuple[Contact, ...]:
        """A contact for each point."""
        several = len(self.points) > 1
        return tuple(
            Contact(
                f"{self.name}.{point}" if several else self.name,
                self._geometry(point, self.name if several else ""),
                self.normal,
                self.rubbing,
                self.path,
            )
            for point in self.points
        )

    def _geometry(self, point: str, together: str) -> RoundAtWall:
        return RoundAtWall(
            body=self.body,
            joint=point,
            radius=self.number("radius"),
            wall=None if self.wall == GROUND else self.wall,
            through=self.through,
            angle=None if self.angle is None else Parameter((*self.path, "angle"), self.angle),
            circle=Parameter((*self.path, "circle"), self.circle or 0.0),
            inside=self.inside,
            size=Parameter((*self.path, "size"), self.size),
            together=together,
        )
