"""Clearances: massless link, journal with contact, block in its guide."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Annotated, ClassVar, Literal, assert_never

import numpy as np

from linkages.components.contributed.bearing_profiles import FINE, BearingProfile, support_of
from linkages.components.contributed.component import Component, Fault, component
from linkages.components.contributed.contact_laws import Ratio, Touching
from linkages.components.contributed.normal_forces import (
    CORNERS,
    NARROWEST,
    WIDEST,
    Contact,
    CornerAtWall,
    PinInHole,
    offset_names,
    stiffness_of_cylinders,
    stiffness_of_spheres,
)
from linkages.components.contributed.terms import (
    ZERO,
    Body,
    Displacement,
    Initial,
    Parameter,
    Play,
    crossed,
)
from linkages.components.contributed.wear_laws import GuideWear, JournalWear, Rubbing
from linkages.spec.quantities import (
    Angle,
    AngularSpeed,
    BarName,
    JointName,
    Length,
    Name,
    Point,
    PositiveLength,
    Quantity,
    SliderName,
    Speed,
)
from linkages.spec.units import Bound, Dimension


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
    carries
        What the bar has, for wear: the ``hole``, or the ``pin``.
    pin_radius, width
        Of the journal, and of journal and bearing along their axis, for wear, in metres.
    wear
        How fast journal and bearing wear.
    """

    section: ClassVar[str] = "clearances"

    name: Name
    joint: JointName
    bar: BarName
    size: PositiveLength
    angle: Angle = 0.0
    speed: AngularSpeed = 0.0
    carries: Literal["hole", "pin"] = "hole"
    pin_radius: PositiveLength | None = None
    width: PositiveLength | None = None
    wear: JournalWear | None = None

    def faults(self) -> Iterable[Fault]:
        """What wear lacks."""
        return () if self.wear is None else self.wear.faults_of(self, "pin_radius", "width")

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
            Displacement(self.name, self.joint, self.bar, renamed, (link,), rubbing_of(self)),
            Initial(self.name, self.angle, self.speed, self.path, (("angle",), ("speed",))),
        )


def rubbing_of(clearance: Clearance | ContactClearance) -> Rubbing | None:
    """That journal and bearing rub, if they wear; over the area 2 R L, as usual in bearings."""
    if clearance.wear is None:
        return None
    radius, width = clearance.pin_radius or 1.0, clearance.width or 1.0
    return Rubbing(
        Parameter((*clearance.path, "wear", "area"), 2.0 * radius * width),
        Parameter((*clearance.path, "pin_radius"), radius),
        clearance.carries == "hole",
    )


Viscosity = Annotated[float, Quantity(Dimension("viscosity", "Pa*s", "Pa·s"), Bound.POSITIVE)]
Modulus = Annotated[float, Quantity(Dimension("modulus", "Pa", "pascals"), Bound.POSITIVE)]


@component
class ContactClearance(Touching):
    """The end of one bar moves freely within ``size`` of its journal, and presses where it touches.

    The offset from journal to end has two free coordinates, ``name.x`` and ``name.y``, along the
    axes of the ground.

    Parameters
    ----------
    joint
        The joint with clearance.
    bar
        The bar (or plate) whose point is displaced from the joint; that point is called
        ``joint.name`` in the results.
    size
        Radial clearance in metres, > 0.
    modulus, poisson
        Young's modulus in Pa and Poisson's ratio of journal and bearing, in the place of the
        stiffness.
    stiffness_model
        The stiffness that follows: ``sphere``, of one with the radius of the journal in one with
        the bearing's, or ``cylinder``, with an exponent of its own, from the width.
    carries
        What the bar has: the ``hole``, or the ``pin``.
    pin_radius
        Radius of the journal in metres.
    viscosity
        Dynamic viscosity of the oil in Pa·s, > 0.
    width
        Of journal and bearing along their axis, in metres: of an oil film, of wear, or of a contact
        with a modulus, for which it tells how far around the journal that reaches.
    profile
        Depth of the bearing beyond a circle over the angle, as harmonics.
    wear
        How fast journal and bearing wear.
    offset, rate
        From the journal to the bar's point at t = 0 in metres along the axes of the ground, and its
        rate in m/s.
    """

    section: ClassVar[str] = "clearances"
    told_by: ClassVar[str] = "contact"

    joint: JointName
    bar: BarName
    modulus: Modulus | None = None
    poisson: Ratio = 0.3
    stiffness_model: Literal["sphere", "cylinder"] = "sphere"
    carries: Literal["hole", "pin"] = "hole"
    pin_radius: PositiveLength | None = None
    viscosity: Viscosity | None = None
    width: PositiveLength | None = None
    profile: BearingProfile | None = None
    wear: JournalWear | None = None
    offset: Point = (0.0, 0.0)
    rate: tuple[Speed, Speed] = (0.0, 0.0)

    def faults(self) -> Iterator[Fault]:
        """Keys that the law has or lacks, numbers out of its range, a start outside the bearing."""
        yield from super().faults()
        if self.modulus is not None:
            yield from self._of_the_material()
        yield from self._of_the_start()
        yield from self.wear_problems(self.wear, "pin_radius", "width")
        if self.profile is None:
            return
        if "stiffness" not in self.law.needs:
            expected = "expected a law with a stiffness"
            yield "profile", f"{self.law.name} takes a round bearing; {expected}"
        for key, message in self.profile.problems(self.size):
            yield ("profile", *key), message

    @property
    def deepest(self) -> float:
        """Indentation at the start in metres; negative if journal and bearing do not touch.

        In a bearing that is not round it is at least that.
        """
        return math.hypot(*self.offset) - self.widest

    @property
    def widest(self) -> float:
        """Largest radial clearance in metres, of a bearing that need not be round."""
        if self.profile is None:
            return self.size
        cos, sin = self.profile.harmonics
        angles = np.linspace(0.0, 2.0 * math.pi, FINE * (len(cos) + 1), endpoint=False)
        return float(support_of(self.size, cos, sin, angles)[0].max())

    def _of_the_start(self) -> Iterator[Fault]:
        apart, film = math.hypot(*self.offset), "viscosity" in self.law.needs
        if film and self.pin_radius is None:
            yield (), f"missing key 'pin_radius', which {self.law.name} needs"
        if film and apart >= self.size:
            result = f"the bar's point lies {apart:g} m from the pin, where no oil is between them"
            yield "offset", f"{result}; expected less than the size, {self.size:g} m"
        elif not film and (message := self.start_problem(self.deepest, "the pin")):
            yield "offset", message

    @property
    def supplied(self) -> dict[str, float | None]:
        """The numbers that laws may need; moduli stand for a stiffness."""
        # that of a material, or of wear, is none of a law
        own = self.modulus is None and (self.wear is None or "width" in self.law.needs)
        width = self.width if own else None
        result = super().supplied | {"viscosity": self.viscosity, "width": width}
        if self.modulus is not None and "stiffness" in self.law.needs:
            result |= self._of_solids(self.modulus)
        return result

    def _of_solids(self, modulus: float) -> dict[str, float | None]:
        """Numbers that follow from a modulus; 1 where `problems` says that they do not."""
        if list(self._of_the_material()):
            return {"stiffness": 1.0}
        match self.stiffness_model:
            case "sphere":
                assert self.pin_radius is not None
                radii = (self.pin_radius + self.size, self.pin_radius)
                return {"stiffness": stiffness_of_spheres(modulus, self.poisson, *radii)}
            case "cylinder":
                assert self.width is not None
                about = modulus, self.poisson, self.size, self.width
                return dict(
                    zip(("stiffness", "exponent"), stiffness_of_cylinders(*about), strict=True)
                )
            case _:
                assert_never(self.stiffness_model)

    def half_angle(self, force: float) -> float | None:
        """How far a contact under a force (N) reaches to either side, in radians.

        It is 2 √(F/(π E* L c)) of a cylinder in a bearing (Johnson, *Contact Mechanics*, 1985);
        None where modulus or width are not given.
        """
        if self.modulus is None or self.width is None:
            return None
        plane = self.modulus / (2.0 * (1.0 - self.poisson**2))
        return 2.0 * math.sqrt(force / (math.pi * plane * self.width * self.size))

    def _of_the_material(self) -> Iterator[Fault]:
        law, sphere = self.law, self.stiffness_model == "sphere"
        if self.stiffness is not None:
            yield "modulus", "the stiffness is given as well; expected one of the two"
        elif "exponent" not in law.takes or self.exponent not in (None, 1.5 if sphere else None):
            solids = "spheres" if sphere else "cylinders"
            yield "modulus", f"{law.name} here is no law of {solids}; expected a stiffness"
        if sphere and self.pin_radius is None:
            yield (), "missing key 'pin_radius': the stiffness follows from both radii"
        if not sphere and self.width is None:
            yield (), "missing key 'width': the stiffness of cylinders follows from it"
        if not sphere and not NARROWEST <= self.size <= WIDEST:
            expected = f"expected a size from {NARROWEST:g} to {WIDEST:g} m"
            yield "stiffness_model", f"{expected}, for which it is known, found {self.size:g} m"
        if self.poisson > 0.5:
            yield "poisson", f"expected a ratio of at most 0.5, found {self.poisson:g}"

    def friction_problems(self) -> Iterator[Fault]:
        """What friction lacks."""
        yield from super().friction_problems()
        if self.friction and self.pin_radius is None and self.rubs:
            yield (), "missing key 'pin_radius': friction needs the radius of the pin"

    def at(self, state: Mapping[str, tuple[float, float]]) -> ContactClearance:
        """The same with another offset where a state names it."""
        start = zip(offset_names(self.name), self.offset, self.rate, strict=True)
        (x, vx), (y, vy) = (state.get(name, (place, rate)) for name, place, rate in start)
        return replace(self, offset=(x, y), rate=(vx, vy))

    def terms(self) -> tuple[Displacement | Initial | Contact, ...]:
        """The offset and its initial state, and the contact."""
        displaced = f"{self.joint}.{self.name}"
        names = offset_names(self.name)
        links = crossed(names, "offset", self.path, self.joint, displaced)
        start = enumerate(zip(names, self.offset, self.rate, strict=True))
        return (
            Displacement(self.name, self.joint, self.bar, displaced, links),
            *(
                Initial(name, place, rate, self.path, (("offset", axis), ("rate", axis)))
                for axis, (name, place, rate) in start
            ),
            self._contact(displaced),
        )

    def _contact(self, displaced: str) -> Contact:
        radius = self.pin_radius or 0.0
        geometry = PinInHole(
            clearance=self.name,
            joint=self.joint,
            displaced=displaced,
            body=self.bar,
            size=Parameter((*self.path, "size"), self.size),
            hole=self.carries == "hole",
            pin_radius=Parameter((*self.path, "pin_radius"), radius, structural=True),
            profile=()
            if self.profile is None
            else self.profile.parameters((*self.path, "profile")),
        )
        return Contact(
            name=self.name,
            geometry=geometry,
            normal=self.normal,
            friction=self.rubbing,
            path=self.path,
            rubbing=rubbing_of(self),
        )


@component
class GuideClearance(Touching):
    """A slider moves across its guide and turns in it as far as its corners let it.

    The block has two more free coordinates: ``name.offset``, how far its joint is from the middle
    of the guide, and ``name.tilt``, its angle in the guide. Results call its corners
    ``name.corner1`` to ``name.corner4``: those at the wall on the left of the axis, seen along it,
    the rear one first, then those at the other wall.

    Parameters
    ----------
    slider
        The slider; its joint is the middle of the block.
    size
        Distance from each wall in metres, > 0, of a block in the middle of its guide.
    length, height
        Of the block in metres, along its axis and across it.
    width
        Of block and guide, perpendicular to the plane, for wear, in metres.
    wear
        How fast block and guide wear.
    offset, rate
        How far the joint is from the middle of the guide at t = 0 in metres, to the left of the
        axis, and its rate in m/s.
    angle, speed
        Of the block in its guide at t = 0 (rad) and its rate (rad/s).
    """

    section: ClassVar[str] = "clearances"
    told_by: ClassVar[str] = "slider"

    slider: SliderName
    length: PositiveLength
    height: PositiveLength
    width: PositiveLength | None = None
    wear: GuideWear | None = None
    offset: Length = 0.0
    rate: Speed = 0.0
    angle: Angle = 0.0
    speed: AngularSpeed = 0.0

    def faults(self) -> Iterator[Fault]:
        """Keys that the law has or lacks, a block that could turn over or starts in a wall."""
        yield from super().faults()
        width, diagonal = self.height + 2.0 * self.size, math.hypot(self.length, self.height)
        if diagonal <= width:
            yield (
                "size",
                f"the block could turn over: its diagonal is {diagonal:g} m, the guide "
                f"{width:g} m wide; expected a guide narrower than the diagonal",
            )
        elif abs(self.angle) >= math.pi / 2:
            result = math.degrees(self.angle)
            yield "angle", f"expected a block less than 90 deg from its guide, found {result:g} deg"
        elif message := self.start_problem(self.deepest, "a corner"):
            yield "offset" if abs(self.offset) > self.size else "angle", message
        yield from self.wear_problems(self.wear, "width")

    @property
    def deepest(self) -> float:
        """Indentation of the deepest corner at the start in metres; negative if none touches."""
        sin, cos = math.sin(self.angle), math.cos(self.angle)
        reach = 0.5 * (self.length * abs(sin) + self.height * cos)
        return abs(self.offset) + reach - 0.5 * self.height - self.size

    @property
    def play(self) -> Play:
        """What is free to move."""
        return Play(self.name, self.slider, self.path)

    def at(self, state: Mapping[str, tuple[float, float]]) -> GuideClearance:
        """The same with another start where a state names it."""
        offset, rate = state.get(self.play.offset, (self.offset, self.rate))
        angle, speed = state.get(self.play.tilt, (self.angle, self.speed))
        return replace(self, offset=offset, rate=rate, angle=angle, speed=speed)

    def terms(self) -> tuple[Play | Initial | Contact, ...]:
        """What is free to move and its initial state, and the contacts of four corners."""
        play = self.play
        size, length, height = (
            Parameter((*self.path, key), getattr(self, key)) for key in ("size", "length", "height")
        )
        worn = None
        if self.wear is not None:
            area = self.length * (self.width or 1.0)
            worn = Rubbing(Parameter((*self.path, "wear", "area"), area))
        geometries = [
            CornerAtWall(play, along, across, size, length, height) for along, across in CORNERS
        ]
        return (
            play,
            Initial(play.offset, self.offset, self.rate, self.path, (("offset",), ("rate",))),
            Initial(play.tilt, self.angle, self.speed, self.path, (("angle",), ("speed",))),
            *(
                Contact(
                    f"{self.name}.corner{place}", own, self.normal, self.rubbing, self.path, worn
                )
                for place, own in enumerate(geometries, 1)
            ),
        )
