"""Hydraulic and pneumatic cylinders between two joints."""

from __future__ import annotations

import math
from typing import Any, ClassVar

from linkages.components.contributed.component import Component, Section, component
from linkages.components.contributed.functions import Function, Number, X, applied
from linkages.components.contributed.measures import Distance, Load, damper_law
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import Path
from linkages.components.laws.law import PressureLaw, function_of
from linkages.components.spring import ends, two_joints
from linkages.spec import quantities
from linkages.spec.quantities import (
    Damping,
    Name,
    NonNegativeLength,
    PositiveLength,
    PositivePressure,
    PositiveVolume,
    Pressure,
)


class _Cylinder(Component):
    no_body: ClassVar[str] = (
        "a cylinder is a force and has no coordinate; for a given stroke write its barrel as a bar "
        "and its rod as a slider 'on' it, and drive the slider"
    )

    between: tuple[str, str]
    bore: float

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different joints."""
        return two_joints((*self.path, "between"), self.between)

    def references(self) -> References:
        """The joints."""
        return References(joints=ends((*self.path, "between"), self.between))

    @property
    def _area(self) -> Function:
        """Of the piston."""
        return self.operand("bore") ** 2 * (math.pi / 4)


@component
class Cylinder(_Cylinder):
    """A cylinder that pressures on both sides of its piston extend or retract.

    Parameters
    ----------
    name
        Name of the cylinder.
    between
        The joints of its barrel and its rod; one may be fixed to the ground.
    bore
        Diameter of the piston in metres, > 0.
    pressure
        On the piston's full side in pascals, or a law; it pushes the joints apart.
    rod
        Diameter of the rod in metres, less than the bore.
    rod_pressure
        On the rod's side of the piston, where its area is smaller.
    damping
        N·s/m, ≥ 0.
    """

    section: ClassVar[str] = "cylinders"
    opens: ClassVar[Section] = Section(
        "mapping", "boom: {between: [O, B], bore: 50 mm, pressure: 160 bar}"
    )

    name: Name
    between: tuple[Name, Name]
    bore: PositiveLength
    pressure: PressureLaw
    rod: NonNegativeLength = 0.0
    rod_pressure: PressureLaw = 0.0
    damping: Damping = 0.0

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """A rod that fits into its cylinder."""
        found = super().problems()
        if self.rod >= self.bore:
            message = f"expected less than the bore, {self.bore:g} m, found {self.rod:g} m"
            found = (*found, ((*self.path, "rod"), message))
        return found

    def terms(self) -> tuple[Load, ...]:
        """Pressures times areas, less what the damping takes."""
        pressure = function_of(self.pressure, (*self.path, "pressure"))
        against = function_of(self.rod_pressure, (*self.path, "rod_pressure"))
        rod = Number(self.number("rod")) ** 2 * (math.pi / 4)
        law = pressure * self._area - against * (self._area - rod)
        law = law + damper_law(self.number("damping"))
        return (Load(Distance(*self.between), law, self.path, called="cylinder", applied=True),)


@component
class GasCylinder(_Cylinder):
    """A cylinder with enclosed gas: a gas spring, whose pressure is p·Vⁿ = constant.

    Parameters
    ----------
    name
        Name of the gas spring.
    between
        The joints of its barrel and its rod; one may be fixed to the ground.
    bore
        Diameter of what displaces the gas in metres, > 0: the piston, or a rod alone that dips in.
    gas_pressure
        Absolute pressure of the gas in pascals at `length`, > 0.
    length
        Distance of the joints at which pressure and volume are known, in metres, > 0.
    volume
        Of the gas at `length` in m³, > 0.
    exponent
        n > 0: 1 for slow changes at one temperature, 1.4 for fast ones of air or nitrogen.
    ambient
        Pressure outside in pascals.
    damping
        N·s/m, ≥ 0.
    """

    section: ClassVar[str] = "cylinders"
    told_by: ClassVar[str] = "gas_pressure"

    name: Name
    between: tuple[Name, Name]
    bore: PositiveLength
    gas_pressure: PositivePressure
    length: PositiveLength
    volume: PositiveVolume
    exponent: quantities.Tolerance = 1.4
    ambient: Pressure = 101325.0
    damping: Damping = 0.0

    def terms(self) -> tuple[Load, ...]:
        """Over-pressure times area, and the energy of gas and surroundings, zero at `length`."""
        pressure, volume = self.operand("gas_pressure"), self.operand("volume")
        ambient = Number(self.number("ambient"))
        way = X - self.operand("length")
        logarithm = applied("log", 1 + self._area * way / volume)
        outside = ambient * self._area * way
        power: Any = logarithm
        if self.exponent == 1.0:
            energy = outside - pressure * volume * logarithm
        else:
            exponent = self.operand("exponent")
            power = exponent * logarithm
            growth = applied("exp", logarithm - power) - 1
            energy = outside + pressure * volume * growth / (exponent - 1)
        push = pressure * self._area * applied("exp", applied("neg", power)) - ambient * self._area
        law = push + damper_law(self.number("damping"))
        measure = Distance(*self.between)
        return (Load(measure, law, self.path, called="gas spring", stores=energy),)
