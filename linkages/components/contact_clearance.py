"""A revolute joint whose pin may leave its hole, hit its wall and follow it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Annotated, ClassVar, Literal

from linkages.components.contributed.component import Component, component
from linkages.components.contributed.contact_laws import ContactName, contact_laws
from linkages.components.contributed.contacts import (
    Contact,
    ContactLaw,
    offset_names,
    stiffness_of_spheres,
)
from linkages.components.contributed.friction_laws import (
    FRICTION_KEYS,
    FrictionName,
    friction_coefficient,
    friction_problems,
)
from linkages.components.contributed.functions import Function
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import (
    ZERO,
    Body,
    Displacement,
    Guide,
    Initial,
    Parameter,
    Path,
)
from linkages.spec import dimensions
from linkages.spec.dimensions import Bound, Dimension
from linkages.spec.powers import ContactStiffness, exponent_of, stiffness_unit
from linkages.spec.quantities import (
    Damping,
    Name,
    Point,
    PositiveLength,
    PositiveNumber,
    PositiveSpeed,
    Quantity,
    Speed,
)

Dissipation = Annotated[float, Quantity(Dimension("dissipation", "s/m", "s/m"), Bound.NON_NEGATIVE)]
Modulus = Annotated[float, Quantity(Dimension("modulus", "Pa", "pascals"), Bound.POSITIVE)]
Ratio = Annotated[float, Quantity(dimensions.NUMBER, Bound.NON_NEGATIVE)]

USUAL_RATE = 1e-3
"""Touches are no slower than this in laws that divide by their rate (m/s)."""


_KEYS = ("stiffness", "exponent", "dissipation", "restitution", "least_rate", "damping")


@component
class ContactClearance(Component):
    """The end of one bar moves freely within ``size`` around its pin, and presses where it touches.

    The offset from pin to end has two free coordinates, ``name.x`` and ``name.y``, along the axes
    of the ground.

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
    contact
        Law of the force between pin and hole.
    stiffness
        K of the force K·dⁿ at an indentation d, in N/mⁿ.
    modulus, poisson
        Young's modulus in Pa and Poisson's ratio of pin and hole, in the place of the stiffness:
        that of a sphere of the radius of the pin in one of the hole's.
    exponent
        n; 1.5 if not given.
    dissipation
        a of the factor 1 + a·d' in s/m.
    restitution
        Wanted ratio of the rates after and before an impact, in (0, 1].
    least_rate
        Rate of a touch that slower ones count as, in m/s; 1 mm/s if not given.
    damping
        D of the force D·d' in N·s/m.
    carries
        What the bar has: the ``hole``, or the ``pin``.
    pin_radius
        Radius of the pin in metres.
    friction
        Coulomb's coefficient of friction between pin and hole.
    friction_law
        How friction depends on the slip; ``tanh`` if not given.
    slip
        Velocity of slip over which friction rises, in m/s.
    least_slip
        Velocity of slip below which there is no friction, in m/s.
    static
        Coefficient at which friction is greatest, at least `friction`.
    stribeck_speed
        Velocity of slip over which it falls from there, in m/s.
    offset, rate
        From the pin to the bar's point at t = 0 in metres along the axes of the ground, and its
        rate in m/s.
    """

    section: ClassVar[str] = "clearances"
    told_by: ClassVar[str] = "contact"

    name: Name
    joint: Name
    bar: Name
    size: PositiveLength
    contact: ContactName
    stiffness: ContactStiffness | None = None
    modulus: Modulus | None = None
    poisson: Ratio = 0.3
    exponent: PositiveNumber | None = None
    dissipation: Dissipation | None = None
    restitution: PositiveNumber | None = None
    least_rate: PositiveSpeed | None = None
    damping: Damping | None = None
    carries: Literal["hole", "pin"] = "hole"
    pin_radius: PositiveLength | None = None
    friction: Ratio = 0.0
    friction_law: FrictionName = "tanh"
    slip: PositiveSpeed | None = None
    least_slip: PositiveSpeed | None = None
    static: Ratio | None = None
    stribeck_speed: PositiveSpeed | None = None
    offset: Point = (0.0, 0.0)
    rate: tuple[Speed, Speed] = (0.0, 0.0)

    @property
    def law(self) -> ContactLaw:
        """The law of the normal force."""
        return contact_laws()[self.contact]

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Keys that the law has or lacks, numbers out of its range, a start outside the hole."""
        found = [*self._of_the_law(), *self._of_friction()]
        if not self._reachable:
            message = f"expected a restitution > 0 and at most 1, found {self.restitution:g}"
            found.append(("restitution", message))
        apart = math.hypot(*self.offset)
        if apart > 2.0 * self.size:
            message = f"the bar's point lies {apart:g} m from the pin, far outside the hole"
            found.append(("offset", f"{message}; expected at most the size, {self.size:g} m"))
        return tuple(((*self.path, key), message) for key, message in found)

    @property
    def _reachable(self) -> bool:
        return self.restitution is None or self.restitution <= 1.0

    def _of_the_law(self) -> Iterator[tuple[str, str]]:
        law = self.law
        if self.modulus is not None:
            yield from self._of_the_material()
        for key in _KEYS:
            given = getattr(self, key) is not None
            if key == "stiffness" and self.modulus is not None:
                continue
            if key in law.needs and not given:
                yield "contact", f"missing key {key!r}, which {law.name} needs"
            elif given and key not in (*law.needs, *law.takes):
                known = ", ".join((*law.needs, *law.takes))
                yield key, f"{law.name} has no {key!r}; it takes {known}"
        written, expected = exponent_of(self.stiffness), self.stiffness_exponent
        if written is not None and written != expected:
            yield (
                "stiffness",
                f"expected a stiffness in {stiffness_unit(expected)}, for the exponent is "
                f"{expected:g}; found {stiffness_unit(written)}",
            )

    def _of_the_material(self) -> Iterator[tuple[str, str]]:
        if self.stiffness is not None:
            yield "modulus", "the stiffness is given as well; expected one of the two"
        elif self.stiffness_exponent != 1.5 or "stiffness" not in self.law.needs:
            yield "modulus", f"{self.law.name} here is no law of spheres; expected a stiffness"
        if self.pin_radius is None:
            yield "modulus", "missing key 'pin_radius': the stiffness follows from both radii"

        if self.poisson > 0.5:
            yield "poisson", f"expected a ratio of at most 0.5, found {self.poisson:g}"

    def _of_friction(self) -> Iterator[tuple[str, str]]:
        if self.friction and "stiffness" not in self.law.needs:
            yield "friction", f"{self.law.name} has no friction; expected the law of a force"
            return
        if self.friction and self.pin_radius is None:
            yield "friction", "missing key 'pin_radius': friction needs the radius of the pin"
        yield from friction_problems(self.friction_law, self._of_slip)

    @property
    def _of_slip(self) -> dict[str, float | None]:
        return {key: getattr(self, key) for key in FRICTION_KEYS}

    @property
    def stiffness_exponent(self) -> float:
        """The exponent n of the force K·dⁿ."""
        usual = 1.5 if "exponent" in self.law.takes else 1.0
        return usual if self.exponent is None else self.exponent

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
        return Contact(
            name=self.name,
            joint=self.joint,
            displaced=displaced,
            body=self.bar,
            size=Parameter((*self.path, "size"), self.size),
            normal=self.law.force(self._numbers),
            hole=self.carries == "hole",
            pin_radius=Parameter(
                (*self.path, "pin_radius"), self.pin_radius or 0.0, structural=True
            ),
            friction=self._friction,
            path=self.path,
        )

    @property
    def _numbers(self) -> dict[str, Parameter]:
        """The numbers of the law: the damping factor in the place of the restitution.

        What is missing or out of range, as `problems` says, is 1 here.
        """
        values = {key: getattr(self, key) for key in _KEYS}
        values["exponent"] = self.stiffness_exponent
        if self.modulus is not None and self.pin_radius is not None and self.poisson <= 0.5:
            radii = (self.pin_radius + self.size, self.pin_radius)
            values["stiffness"] = stiffness_of_spheres(self.modulus, self.poisson, *radii)
        values["least_rate"] = USUAL_RATE if self.least_rate is None else self.least_rate
        factor = self.law.restitution
        if factor is not None and self.restitution is not None and self._reachable:
            values["restitution"] = factor(self.restitution)
        return {
            key: Parameter((*self.path, key), 1.0 if value is None else float(value))
            for key, value in values.items()
        }

    @property
    def _friction(self) -> Function | None:
        if self.number("friction").absent:
            return None
        return friction_coefficient(self.friction_law, self._of_slip, self.path)
