"""Gears, racks, belts and cams: coordinates that follow from each other.

References
----------
.. [1] R. L. Norton, *Cam Design and Manufacturing Handbook*, 2nd ed., Industrial Press, 2009:
   pressure angle of a translating roller follower.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import ClassVar

from linkages.components.contributed.component import (
    Fault,
    ListedComponent,
    References,
    Section,
    component,
    reference,
)
from linkages.components.contributed.contact_laws import WithoutRoom
from linkages.components.contributed.functions import Table, X, extremes, polynomials, unpaired
from linkages.components.contributed.load_measures import GROUND
from linkages.components.contributed.normal_forces import Contact, FollowerOnCam
from linkages.components.contributed.terms import ONE, CamSize, Parameter, Relation
from linkages.reading.paths import dotted
from linkages.spec.quantities import (
    Angle,
    BarName,
    BarOrGroundName,
    BarPair,
    Length,
    NonNegativeLength,
    Number,
    PositiveLength,
    SliderName,
)


@component
class Gear(ListedComponent):
    """Two bodies that turn in a ratio: θ_b − θ_c = ratio·(θ_a − θ_c) + angle.

    Parameters
    ----------
    bars
        Two bars or plates a and b; a may be ``ground``, a wheel that stands still.
    ratio
        Speed of b over speed of a, seen from the carrier: minus the quotient of their radii for
        outer gears, plus for an inner gear or a belt. Not 0.
    carrier
        The bar or plate c that carries the axes; the ground if not given.
    angle
        In radians.
    """

    section: ClassVar[str] = "gears"

    bars: BarPair
    ratio: Number
    carrier: BarOrGroundName | None = None
    angle: Angle = 0.0

    def faults(self) -> Iterator[Fault]:
        """Two different wheels on a third body, and a ratio that is one."""
        if self.ratio == 0:
            yield "ratio", "expected a ratio other than 0"
        if self.carrier in self.bars:
            yield "carrier", f"expected a third body, found {self.carrier!r} again"
        if self.bars[0] == GROUND and self.carrier in (None, GROUND):
            yield (), "missing key 'carrier': a wheel that stands still needs a carrier that moves"

    def terms(self) -> tuple[Relation, ...]:
        """One relation: θ_b = ratio·θ_a + (1 − ratio)·θ_c + angle."""
        parts: tuple[tuple[str, Parameter], ...] = ()
        first = reference(self.bars)
        if first is not None:
            parts = ((first, Parameter((*self.path, "ratio"), self.ratio)),)
        if self.carrier is not None and self.carrier != GROUND:
            share = Parameter((*self.path, "carrier"), 1.0 - self.ratio)
            parts = (*parts, (self.carrier, share))
        offset = self.number("angle")
        return (Relation(self.bars[1], parts, offset, self.path),)


class _Reversible(ListedComponent):
    """Ties a slider to a bar or to another slider; either may follow from the other."""

    section: ClassVar[str] = "racks"
    factor: ClassVar[str]

    def _tie(
        self, slider: str, other: str, offset: float, carrier: str | None = None
    ) -> tuple[Relation]:
        """Position = factor·(other − carrier) + offset, or what that makes of the other."""
        factor = getattr(self, self.factor) or 1.0  # one of 0 has been reported
        path = (*self.path, self.factor)
        parts = [(other, Parameter(path, factor))]
        inverse = [(slider, Parameter((*path, "inverse"), 1.0 / factor))]
        if carrier is not None:
            parts.append((carrier, Parameter((*self.path, "carrier"), -factor)))
            inverse.append((carrier, ONE))
        back = Parameter((*self.path, "offset", "inverse"), -offset / factor, structural=True)
        reverse = Relation(other, tuple(inverse), back, self.path)
        return (Relation(slider, tuple(parts), self.number("offset"), self.path, reverse),)


@component
class Rack(_Reversible):
    """A slider that a wheel moves: position = radius·(θ_bar − θ_carrier) + offset.

    Parameters
    ----------
    slider
        The rack, or what a cable or belt pulls.
    bar
        The bar or plate that is its pinion or drum.
    radius
        Of the pitch circle in metres; negative where the slider goes back as the bar turns
        counter-clockwise. Not 0.
    carrier
        The bar or plate that carries both; the ground if not given.
    offset
        Position of the slider in metres where the bar is at 0 against the carrier.
    """

    opens: ClassVar[Section] = Section("list", "{slider: piston, bar: crank, radius: 20 mm}")
    factor: ClassVar[str] = "radius"

    slider: SliderName
    bar: BarName
    radius: Length
    carrier: BarOrGroundName | None = None
    offset: Length = 0.0

    @property
    def _moving(self) -> str | None:
        """What carries both, unless it is the ground."""
        return None if self.carrier == GROUND else self.carrier

    def faults(self) -> Iterator[Fault]:
        """A radius, and a pinion that turns on its carrier."""
        if self.radius == 0:
            yield "radius", "expected a radius other than 0"
        if self.carrier == self.bar:
            yield "carrier", f"expected another body than {self.bar!r}, which turns on it"

    def references(self) -> References:
        """The slider, its pinion, and what carries both."""
        carried = (((*self.path, "carrier"), self.slider, self._moving),)
        return replace(super().references(), carried=carried)

    def terms(self) -> tuple[Relation, ...]:
        """The position from the angles, or the angle from the position."""
        return self._tie(self.slider, self.bar, self.offset, self._moving)


@component
class Rope(_Reversible):
    """Two sliders that a rope over pulleys ties: position of b = ratio·(position of a) + offset.

    Parameters
    ----------
    sliders
        Two sliders a and b.
    ratio
        Speed of b over that of a; negative where one goes back as the other goes forward. Not 0.
    offset
        Position of b in metres where a is at 0.
    """

    told_by: ClassVar[str] = "sliders"
    factor: ClassVar[str] = "ratio"

    sliders: tuple[SliderName, SliderName]
    ratio: Number
    offset: Length = 0.0

    def faults(self) -> Iterator[Fault]:
        """A ratio that is one."""
        if self.ratio == 0:
            yield "ratio", "expected a ratio other than 0"

    def terms(self) -> tuple[Relation, ...]:
        """Either position from the other one."""
        first, second = self.sliders
        return self._tie(second, first, self.offset)


_ROUND = 1e-9
"""Difference from a whole turn that rounding of units explains."""


@component
class Cam(ListedComponent):
    """A slider that a cam lifts: position = lift(θ_bar) + offset, in contact all the time.

    Parameters
    ----------
    slider
        The follower.
    bar
        The bar or plate that is the cam; it turns on the ground.
    angles
        Angles of the bar in radians, increasing, at least three. Over a whole turn the cam repeats;
        otherwise the lift goes on in a straight line beyond them.
    lifts
        The lift at each of them in metres; over a whole turn first and last are equal.
    offset
        Position of the slider at a lift of zero, in metres.
    base_radius
        Of the base circle in metres, for the pressure angle and for forces across the guide.
    flat
        Whether the follower has a flat face across its axis, and neither roller nor knife edge.
    roller_radius
        Of the follower's roller in metres; zero for a knife edge.
    eccentricity
        Distance in metres of the follower's axis from the pivot of the cam, positive to the side
        that makes the pressure angle of a rise smaller.
    """

    section: ClassVar[str] = "cams"
    opens: ClassVar[Section] = Section(
        "list", "{slider: piston, bar: crank, angles: [0, 1.5, 3], lifts: [0, 0.01, 0]}"
    )
    misplaced: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("stiffness", "damping", "restitution", "friction"),
        "a follower that may leave its cam has a law of contact: expected 'contact' as well, such "
        "as 'restitution' or 'kelvin-voigt'",
    )

    slider: SliderName
    bar: BarName
    angles: tuple[Angle, ...]
    lifts: tuple[Length, ...]
    offset: Length = 0.0
    base_radius: PositiveLength | None = None
    flat: bool = False
    roller_radius: NonNegativeLength = 0.0
    eccentricity: Length = 0.0

    @property
    def _closed(self) -> bool:
        return abs(self.angles[-1] - self.angles[0] - 2 * math.pi) < _ROUND

    def faults(self) -> Iterator[Fault]:
        """Enough increasing angles, a lift for each, and a base circle that the follower meets."""
        yield from self._of_table() or self._overflow() or self._hollow()
        if self.flat:
            for key in ("roller_radius", "eccentricity"):
                if getattr(self, key):
                    yield key, "a flat face has none; it is for a roller or a knife edge"
            return
        reach = (self.base_radius or math.inf) + self.roller_radius
        if abs(self.eccentricity) >= reach:
            message = f"expected less than base and roller radius together, {reach:g} m"
            yield "eccentricity", message

    def _of_table(self) -> tuple[Fault, ...]:
        if fault := unpaired({"angles": self.angles, "lifts": self.lifts}, "three"):
            return (fault,)
        if self._closed and self.lifts[0] != self.lifts[-1]:
            ends = f"{self.lifts[0]:g} and {self.lifts[-1]:g}"
            return (("lifts", f"expected equal lifts a whole turn apart, found {ends}"),)
        return ()

    def _overflow(self) -> tuple[Fault, ...]:
        """Polynomials without finite values."""
        if all(map(math.isfinite, extremes(self.table, self.angles[0], self.angles[-1]))):
            return ()
        return (("lifts", "expected smaller lifts, or angles that are further apart"),)

    def _hollow(self) -> tuple[Fault, ...]:
        """A profile that a flat face does not touch all around: its radius of curvature."""
        if not self.flat or self.base_radius is None:
            return ()
        knots = polynomials(self.table)
        places = knots.x[:-1]
        bent = knots(places) + knots.derivative(2)(places)
        lowest = bent.argmin()
        if bent[lowest] + self.base_radius > 0.0:
            return ()
        least, place = -bent[lowest], math.degrees(places[lowest])
        message = f"expected more than {least:.4g} m: at {place:.4g}° a flat face meets a hollow"
        return (("base_radius", message),)

    @property
    def table(self) -> Table:
        """The lift, a function of the cam's angle."""
        closed = self._closed
        path = (*self.path, "lifts")
        return Table(path, self.angles, self.lifts, closed, over=X, turning=closed)

    def references(self) -> References:
        """The follower and its cam."""
        carried = (((*self.path, "slider"), self.slider, None),)
        return replace(super().references(), carried=carried)

    def terms(self) -> tuple[Relation | CamSize, ...]:
        """The position from the angle, and what the pressure angle depends on."""
        if self._of_table():  # they have been reported
            return ()
        relation = Relation(
            self.slider, ((self.bar, ONE),), self.number("offset"), self.path, profile=self.table
        )
        return relation, self._profile

    @property
    def _profile(self) -> CamSize:
        base = None
        if self.base_radius is not None:
            base = Parameter((*self.path, "base_radius"), self.base_radius)
        sizes = (self.number("roller_radius"), self.number("eccentricity"))
        return CamSize(self.slider, base, *sizes, self.flat)


@component
class CamContact(WithoutRoom, Cam):
    """A slider that may leave the cam under it: its position is lift(θ_bar) + offset or more.

    Results call it by its place, such as ``cams[0]``.

    Parameters
    ----------
    slider
        The follower, whose position is free.
    friction
        Coulomb's coefficient of friction of a flat face on its cam; rollers roll.
    """

    told_by: ClassVar[str] = "contact"
    touched: ClassVar[str] = "cam"

    def faults(self) -> Iterator[Fault]:
        """Those of a cam and of a law of contact, and friction where nothing slides."""
        yield from Cam.faults(self)
        if self.friction and not self.flat:
            yield "friction", "a roller or knife edge has none here; it is for a face: 'flat: true'"
        elif self.friction and self.base_radius is None:
            yield "friction", "missing key 'base_radius': the speed of slip depends on it"
        yield from super().faults()

    def terms(self) -> tuple[Contact | CamSize, ...]:  # type: ignore[override]
        """A contact in the place of the relation."""
        if self._of_table():  # they have been reported
            return ()
        geometry = FollowerOnCam(
            slider=self.slider,
            cam=self.bar,
            lift=self.table,
            bends=self.table.bends,
            offset=self.number("offset"),
            profile=self._profile,
            size=Parameter((*self.path, "size"), self.size),
        )
        contact = Contact(dotted(self.path), geometry, self.normal, self.rubbing, self.path)
        return contact, self._profile
