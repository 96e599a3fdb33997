"""Racks, cables and belts: a displacement tied to an angle, or to another displacement."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import Section, component
from linkages.components.contributed.listed import TURNING, ListedComponent
from linkages.components.contributed.references import References
from linkages.components.contributed.revolute import GROUND
from linkages.components.contributed.terms import Parameter, Path, Relation
from linkages.spec.quantities import Length, Name, Number


@component
class Rack(ListedComponent):
    """A slider that a wheel moves: position = radius·(θ_bar − θ_carrier) + offset.

    Parameters
    ----------
    index
        Place in the list of racks.
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

    section: ClassVar[str] = "racks"
    opens: ClassVar[Section] = Section("list", "{slider: piston, bar: crank, radius: 20 mm}")

    index: int
    slider: Name
    bar: Name
    radius: Length
    carrier: Name | None = None
    offset: Length = 0.0

    @property
    def _carried(self) -> bool:
        return self.carrier not in (None, GROUND)

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """A radius, and a pinion that turns on its carrier."""
        found = []
        if self.radius == 0:
            found.append(((*self.path, "radius"), "expected a radius other than 0"))
        if self.carrier == self.bar:
            message = f"expected another body than {self.bar!r}, which turns on it"
            found.append(((*self.path, "carrier"), message))
        return tuple(found)

    def references(self) -> References:
        """The slider, its pinion, and what carries both."""
        bodies = [
            ((*self.path, "slider"), self.slider, ("slider",)),
            ((*self.path, "bar"), self.bar, TURNING),
        ]
        if self._carried:
            bodies.append(((*self.path, "carrier"), str(self.carrier), TURNING))
        carrier = str(self.carrier) if self._carried else None
        return References(
            bodies=tuple(bodies),
            carried=(((*self.path, "carrier"), self.slider, carrier),),
        )

    def terms(self) -> tuple[Relation, ...]:
        """The position from the angles, or the angle from the position."""
        radius = self.radius or 1.0  # a radius of 0 has been reported
        parts = [(self.bar, Parameter((*self.path, "radius"), radius))]
        others = [(self.slider, Parameter((*self.path, "radius", "inverse"), 1.0 / radius))]
        if self._carried:
            parts.append((str(self.carrier), Parameter((*self.path, "carrier"), -radius)))
            others.append((str(self.carrier), Parameter((), 1.0, structural=True)))
        back = Parameter((*self.path, "offset", "inverse"), -self.offset / radius, structural=True)
        inverse = Relation(self.bar, tuple(others), back, self.path)
        return (Relation(self.slider, tuple(parts), self.number("offset"), self.path, inverse),)


@component
class Rope(ListedComponent):
    """Two sliders that a rope over pulleys ties: position of b = ratio·(position of a) + offset.

    Parameters
    ----------
    index
        Place in the list of racks.
    sliders
        Two sliders a and b.
    ratio
        Speed of b over that of a; negative where one goes back as the other goes forward. Not 0.
    offset
        Position of b in metres where a is at 0.
    """

    section: ClassVar[str] = "racks"
    told_by: ClassVar[str] = "sliders"

    index: int
    sliders: tuple[Name, Name]
    ratio: Number
    offset: Length = 0.0

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different sliders, and a ratio that is one."""
        found = []
        if self.ratio == 0:
            found.append(((*self.path, "ratio"), "expected a ratio other than 0"))
        if self.sliders[0] == self.sliders[1]:
            message = f"expected two different sliders, found {self.sliders[0]!r} twice"
            found.append(((*self.path, "sliders"), message))
        return tuple(found)

    def references(self) -> References:
        """The sliders."""
        named = enumerate(self.sliders)
        path = (*self.path, "sliders")
        return References(bodies=tuple(((*path, i), name, ("slider",)) for i, name in named))

    def terms(self) -> tuple[Relation, ...]:
        """Either position from the other one."""
        (first, second), ratio = self.sliders, self.ratio or 1.0  # one of 0 has been reported
        parts = ((first, Parameter((*self.path, "ratio"), ratio)),)
        others = ((second, Parameter((*self.path, "ratio", "inverse"), 1.0 / ratio)),)
        back = Parameter((*self.path, "offset", "inverse"), -self.offset / ratio, structural=True)
        inverse = Relation(first, others, back, self.path)
        return (Relation(second, parts, self.number("offset"), self.path, inverse),)
