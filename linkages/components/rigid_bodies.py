"""Rigid bodies: bars, plates, sliders, masses, counterweights, ground joints and welds."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import combinations
from typing import Any, ClassVar

from pydantic import Field, model_validator

from linkages.components.contributed.attachments import two_joints
from linkages.components.contributed.component import (
    Component,
    Fault,
    References,
    Section,
    component,
    reference,
)
from linkages.components.contributed.terms import (
    ONE,
    ZERO,
    Body,
    GroundPin,
    Guide,
    Origin,
    Parameter,
    Place,
    PointMass,
    Relation,
)
from linkages.spec.quantities import (
    Angle,
    BarName,
    BarPair,
    BodyName,
    Inertia,
    JointName,
    Length,
    Mass,
    MovingJointName,
    Name,
    Point,
    PositiveLength,
)


class _Rigid(Component):
    """A body with a mass."""

    name: str
    mass: float

    def _body(self, kind: str, points: Mapping[str, Place], **more: Any) -> Body:
        """The body of that kind with these joints; `more` are further fields of it."""
        mass = self.number("mass")
        return Body(name=self.name, kind=kind, path=self.path, points=points, mass=mass, **more)


@component
class Bar(_Rigid):
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

    def faults(self) -> Iterator[Fault]:
        """A bar joins two different joints."""
        yield from two_joints(("joints",), self.joints)

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
        first, second = self.joints
        length = Parameter((*self.path, "length"), self.length)
        points = {first: (ZERO, ZERO), second: (length, ZERO)}
        inertia = Parameter((*self.path, "inertia"), self.central_inertia, structural=True)
        centre = self.pair(self.centre, "center")
        return (self._body("bar", points, inertia=inertia, centre=centre),)


@component
class Plate(_Rigid):
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

    def faults(self) -> Iterator[Fault]:
        """Pins apart from each other, and a centre and an inertia where there is a mass."""
        if not self.points:
            yield "points", "expected at least one point, found none"
        places = list(self.points.values())
        # a set finds equal numbers at once, but not equal columns of a sweep
        apart = all(isinstance(x, float) for place in places for x in place)
        apart = apart and len(set(places)) == len(places)
        for (first, p), (second, q) in () if apart else combinations(self.points.items(), 2):
            if p == q:
                yield ("points", second), f"{second!r} lies on {first!r}; expected two places"
        needed = "a plate with a mass needs it, nothing can be assumed"
        for key in ("center", "inertia") if self.mass > 0 else ():
            if getattr(self, key) is None:
                yield (), f"missing key {key!r}: {needed}"

    def terms(self) -> tuple[Body, ...]:
        """One body that turns.

        A plate with one joint gets its centre of mass as a second point: two points carry the mass.
        """
        points = {joint: self.pair(xy, "points", joint) for joint, xy in self.points.items()}
        centre = self.pair(self.center or (0.0, 0.0), "center")
        if len(points) == 1 and self.center is not None and self.center not in self.points.values():
            points[f"{self.name}.center"] = centre
        inertia = Parameter((*self.path, "inertia"), self.inertia or 0.0, structural=True)
        return (self._body("plate", points, inertia=inertia, centre=centre),)


@component
class Slider(_Rigid):
    """A block that moves along a straight axis, and turns only with the body that carries it.

    Parameters
    ----------
    name
        Slider name.
    joint
        The joint carried by the block; it lies on the axis.
    through
        A point that the axis goes through; positions count from there. On the ground: a ground
        joint or [x, y]. On a body: a joint of it, or [x, y] in its frame; its origin if not given.
    angle
        Direction of the axis in radians, in the frame of what carries it.
    on
        The bar, plate or slider that carries the axis; the ground if not given.
    mass
        Kilograms, at the joint.
    inertia
        About the joint in kg·m².
    points
        Further joints of the block, in metres along and across its axis, from its joint.
    """

    section: ClassVar[str] = "sliders"
    misplaced: ClassVar[Mapping[str, str]] = {
        "length": "a slider has no length; for a cylinder write its barrel as a bar and its rod as "
        "a slider 'on' it, whose 'position' under 'drives' is the distance of its two joints"
    }

    name: Name
    joint: Name
    through: Name | Point | None = None
    angle: Angle = 0.0
    on: BodyName | None = None
    mass: Mass = 0.0
    inertia: Inertia = 0.0
    points: dict[Name, Point] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _has_an_axis(self) -> Any:
        if self.on is None and self.through is None:
            message = "expected a ground joint or a point [x, y] that the axis goes through"
            raise ValueError(f"missing key 'through': {message}")
        return self

    def faults(self) -> Iterator[Fault]:
        """Points apart from each other."""
        places = {(0.0, 0.0): self.joint}
        for joint, place in self.points.items():
            if joint == self.joint:
                yield ("points", joint), f"{joint!r} is the slider's joint, at [0, 0]"
            elif place in places:
                message = f"{joint!r} lies on {places[place]!r}; expected two places"
                yield ("points", joint), message
            places.setdefault(place, joint)

    def references(self) -> References:
        """What carries the axis, and the joint that the axis goes through."""
        through = (*self.path, "through")
        joint = self.through if isinstance(self.through, str) else None
        return replace(
            super().references(),
            ground=((through, joint),) if joint and not self.on else (),
            points=((through, self.on, joint),) if joint and self.on else (),
        )

    def terms(self) -> tuple[Body, ...]:
        """One body that slides."""
        origin: Origin = (ZERO, ZERO)
        if isinstance(self.through, str):
            origin = self.through
        elif self.through is not None:
            origin = self.pair(self.through, "through")
        further = {name: self.pair(place, "points", name) for name, place in self.points.items()}
        points = {self.joint: (ZERO, ZERO), **further}
        guide = Guide(origin, Parameter((*self.path, "angle"), self.angle), self.on)
        return (self._body("slider", points, inertia=self.number("inertia"), guide=guide),)


@component
class JointMass(Component):
    """A mass concentrated at a joint: a payload, a pin, a bob.

    Parameters
    ----------
    name
        A joint that moves.
    mass
        Kilograms, ≥ 0.
    """

    section: ClassVar[str] = "masses"

    name: MovingJointName
    mass: Mass

    def terms(self) -> tuple[PointMass, ...]:
        """One point mass; exactly zero is structure."""
        return (PointMass(self.name, Parameter(self.path, self.mass, structural=True), self.path),)


@component
class Counterweight(_Rigid):
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
    bar: BarName
    joint: JointName
    mass: Mass
    distance: PositiveLength
    angle: Angle = math.pi
    inertia: Inertia = 0.0

    def faults(self) -> Iterator[Fault]:
        """One that is not the bar itself, and has a mass: without one it is none."""
        if self.name == self.bar:
            yield (), f"expected a name other than that of its bar, {self.bar!r}"
        if self.mass == 0:
            yield "mass", "expected a mass > 0, found 0"

    def references(self) -> References:
        """The bar and its joint."""
        meeting = (((*self.path, "joint"), self.bar, self.joint),)
        return replace(super().references(), meeting=meeting)

    def terms(self) -> tuple[Body | Relation, ...]:
        """A body with one joint, whose own axis leads to its centre, and a relation of angles."""
        centre = (Parameter((*self.path, "distance"), self.distance), ZERO)
        points = {self.joint: (ZERO, ZERO), f"{self.name}.center": centre}
        return (
            self._body("plate", points, inertia=self.number("inertia"), centre=centre),
            Relation(self.name, ((self.bar, ONE),), self.number("angle"), self.path),
        )


@component
class GroundJoint(Component):
    """A fixed pivot: a joint on the ground.

    Parameters
    ----------
    name
        Joint name.
    position
        Coordinates in metres.
    """

    section: ClassVar[str] = "joints"

    name: Name
    position: Point

    def terms(self) -> tuple[GroundPin, ...]:
        """One pin; a coordinate of exactly zero is structure."""
        return (GroundPin(self.name, self.pair(self.position)),)


@component
class Weld(Component):
    """At a joint, one body is rigidly fixed to another: θ_b = θ_a + angle.

    Parameters
    ----------
    name
        Joint name.
    bars
        Two bars or plates a and b that have the joint; a may be ``ground``.
    angle
        Angle of b against a in radians.
    """

    section: ClassVar[str] = "welds"

    name: JointName
    bars: BarPair
    angle: Angle

    def references(self) -> References:
        """The joint, and the bodies that have it."""
        named = enumerate(self.bars)
        meeting = tuple(((*self.path, "bars", place), bar, self.name) for place, bar in named)
        return replace(super().references(), meeting=meeting)

    def terms(self) -> tuple[Relation, ...]:
        """One relation of angles; the joint holds the rest."""
        other = reference(self.bars)
        angle = self.number("angle")
        parts = () if other is None else ((other, ONE),)
        return (Relation(self.bars[1], parts, angle, self.path),)
