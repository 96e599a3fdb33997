"""A revolute joint whose journal may leave its bearing, hit its wall and follow it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Annotated, ClassVar, Literal, assert_never

from linkages.components.contributed.component import component
from linkages.components.contributed.contacts import (
    Contact,
    PinInHole,
    offset_names,
)
from linkages.components.contributed.references import References
from linkages.components.contributed.stiffnesses import (
    NARROWEST,
    WIDEST,
    stiffness_of_cylinders,
    stiffness_of_spheres,
)
from linkages.components.contributed.terms import (
    ZERO,
    Body,
    Displacement,
    Guide,
    Initial,
    Parameter,
    Path,
)
from linkages.components.contributed.touching import Ratio, Touching
from linkages.spec.dimensions import Bound, Dimension
from linkages.spec.quantities import (
    Name,
    Point,
    PositiveLength,
    Quantity,
    Speed,
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
        Of journal and bearing along their axis, in metres: of an oil film, or of a contact with a
        modulus, for which it tells how far around the journal that reaches.
    offset, rate
        From the journal to the bar's point at t = 0 in metres along the axes of the ground, and its
        rate in m/s.
    """

    section: ClassVar[str] = "clearances"
    told_by: ClassVar[str] = "contact"

    joint: Name
    bar: Name
    modulus: Modulus | None = None
    poisson: Ratio = 0.3
    stiffness_model: Literal["sphere", "cylinder"] = "sphere"
    carries: Literal["hole", "pin"] = "hole"
    pin_radius: PositiveLength | None = None
    viscosity: Viscosity | None = None
    width: PositiveLength | None = None
    offset: Point = (0.0, 0.0)
    rate: tuple[Speed, Speed] = (0.0, 0.0)

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Keys that the law has or lacks, numbers out of its range, a start outside the bearing."""
        found = [*self.contact_problems()]
        if self.modulus is not None:
            found += self._of_the_material()
        found += self._of_the_start()
        return tuple(((*self.path, key), message) for key, message in found)

    @property
    def deepest(self) -> float:
        """Indentation at the start in metres; negative if journal and bearing do not touch."""
        return math.hypot(*self.offset) - self.size

    def _of_the_start(self) -> Iterator[tuple[str, str]]:
        apart, film = math.hypot(*self.offset), "viscosity" in self.law.needs
        if film and self.pin_radius is None:
            yield "contact", f"missing key 'pin_radius', which {self.law.name} needs"
        if film and apart >= self.size:
            found = f"the bar's point lies {apart:g} m from the pin, where no oil is between them"
            yield "offset", f"{found}; expected less than the size, {self.size:g} m"
        elif not film and (message := self.start_problem(self.deepest, "the pin")):
            yield "offset", message

    @property
    def supplied(self) -> dict[str, float | None]:
        """The numbers that laws may need; moduli stand for a stiffness."""
        width = self.width if self.modulus is None else None  # that of a material is none of a law
        found = super().supplied | {"viscosity": self.viscosity, "width": width}
        if self.modulus is not None and "stiffness" in self.law.needs:
            found |= self._of_solids(self.modulus)
        return found

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

    def _of_the_material(self) -> Iterator[tuple[str, str]]:
        law, sphere = self.law, self.stiffness_model == "sphere"
        if self.stiffness is not None:
            yield "modulus", "the stiffness is given as well; expected one of the two"
        elif "exponent" not in law.takes or self.exponent not in (None, 1.5 if sphere else None):
            solids = "spheres" if sphere else "cylinders"
            yield "modulus", f"{law.name} here is no law of {solids}; expected a stiffness"
        if sphere and self.pin_radius is None:
            yield "modulus", "missing key 'pin_radius': the stiffness follows from both radii"
        if not sphere and self.width is None:
            yield "modulus", "missing key 'width': the stiffness of cylinders follows from it"
        if not sphere and not NARROWEST <= self.size <= WIDEST:
            expected = f"expected a size from {NARROWEST:g} to {WIDEST:g} m"
            yield "stiffness_model", f"{expected}, for which it is known, found {self.size:g} m"
        if self.poisson > 0.5:
            yield "poisson", f"expected a ratio of at most 0.5, found {self.poisson:g}"

    def friction_problems(self) -> Iterator[tuple[str, str]]:
        """What friction lacks."""
        yield from super().friction_problems()
        if self.friction and self.pin_radius is None and self.rubs:
            yield "friction", "missing key 'pin_radius': friction needs the radius of the pin"

    def at(self, state: Mapping[str, tuple[float, float]]) -> ContactClearance:
        """The same with another offset where a state names it."""
        start = zip(offset_names(self.name), self.offset, self.rate, strict=True)
        (x, vx), (y, vy) = (state.get(name, (place, rate)) for name, place, rate in start)
        return replace(self, offset=(x, y), rate=(vx, vy))

    def references(self) -> References:
        """The joint and the bar that has it."""
        return References(
            joints=(((*self.path, "joint"), self.joint),),
            bodies=(((*self.path, "bar"), self.bar, ("bar", "plate")),),
        )

    def terms(self) -> tuple[Displacement | Initial | Contact, ...]:
        """The offset and its initial state, and the contact."""
        displaced = f"{self.joint}.{self.name}"
        along, across = offset_names(self.name)
        links = (
            Body(
                name=along,
                kind="offset",
                path=self.path,
                points={},
                guide=Guide(self.joint, ZERO),
            ),
            Body(
                name=across,
                kind="offset",
                path=self.path,
                points={displaced: (ZERO, ZERO)},
                guide=Guide((ZERO, ZERO), Parameter((), math.pi / 2), along),
            ),
        )
        start = zip((along, across), self.offset, self.rate, strict=True)
        return (
            Displacement(self.name, self.joint, self.bar, displaced, links),
            *(Initial(name, place, rate, self.path) for name, place, rate in start),
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
        )
        return Contact(
            name=self.name,
            geometry=geometry,
            normal=self.normal,
            friction=self.rubbing,
            path=self.path,
        )
