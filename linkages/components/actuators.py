"""Drives that prescribe motion, DC motors, and hydraulic or pneumatic cylinders."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, ClassVar

from pydantic import model_validator

from linkages.components.contributed.attachments import BetweenJoints
from linkages.components.contributed.component import (
    Component,
    Fault,
    References,
    Section,
    component,
)
from linkages.components.contributed.functions import Function, Number, V, X, applied, linear
from linkages.components.contributed.functions import constant as constant_of
from linkages.components.contributed.load_measures import GROUND, Load, Turn, damper_law
from linkages.components.contributed.state_laws import InternalState, value_of
from linkages.components.contributed.terms import ZERO, Body, Parameter, Prescribed, Relation
from linkages.components.laws import AngleLaw, Law, LengthLaw, PressureLaw, VoltageLaw, function_of
from linkages.spec import quantities
from linkages.spec.quantities import (
    Angle,
    AngularSpeed,
    BarName,
    BarOrGroundName,
    Current,
    Damping,
    Inertia,
    JointName,
    Length,
    Name,
    NonNegativeLength,
    PositiveInductance,
    PositiveLength,
    PositivePressure,
    PositiveResistance,
    PositiveTorqueConstant,
    PositiveVolume,
    Pressure,
    SliderName,
    Speed,
    Torque,
)


class _Drive(Component):
    """One prescribed coordinate: a number and a speed, or a law."""

    section: ClassVar[str] = "drives"
    start: ClassVar[str]

    name: str
    speed: float | None
    law: Law | None

    @model_validator(mode="after")
    def _one_law(self) -> Any:
        keys = (self.start, "speed")
        given = [key for key in keys if getattr(self, key) is not None]
        forms = f"either {self.start!r} and 'speed', or 'law'"
        if self.law is not None and given:
            raise ValueError(f"'law' and {given[0]!r} are both given; expected {forms}")
        if self.law is None and not given:
            raise ValueError(f"missing keys: expected {forms}")
        if self.law is None and len(given) == 1:
            (missing,) = {*keys} - {*given}
            raise ValueError(f"missing key {missing!r}: expected {forms}")
        return self

    def terms(self) -> tuple[Prescribed, ...]:
        """One prescribed coordinate."""
        if self.law is not None:
            return (Prescribed(self.name, function_of(self.law, (*self.path, "law")), self.path),)
        # A drive that happens to start at 0 or to stand still needs no kernel of its own.
        start, speed = (
            Parameter((*self.path, key), getattr(self, key)) for key in (self.start, "speed")
        )
        return (Prescribed(self.name, linear(start, speed), self.path),)


@component
class Drive(_Drive):
    """Turns a bar or plate: θ = angle + speed·t, or by another law of time.

    Parameters
    ----------
    name
        The bar or plate that is driven against the ground.
    angle
        Angle at t = 0 in radians.
    speed
        Angular speed in rad/s.
    law
        Angle as a function of time, in the place of angle and speed.
    """

    start: ClassVar[str] = "angle"

    name: BarName
    angle: Angle | None = None
    speed: AngularSpeed | None = None
    law: AngleLaw | None = None


@component
class SliderDrive(_Drive):
    """Moves a slider along its axis: s = position + speed·t, or by another law of time.

    Parameters
    ----------
    name
        The slider that is driven against the body that carries its axis.
    position
        Displacement at t = 0 in metres.
    speed
        In m/s.
    law
        Displacement as a function of time, in the place of position and speed.
    """

    told_by: ClassVar[str] = "position"
    names_slider: ClassVar[bool] = True
    start: ClassVar[str] = "position"

    name: SliderName
    position: Length | None = None
    speed: Speed | None = None
    law: LengthLaw | None = None


@component
class _Motor(Component):
    """What acts between a bar and what carries the motor; its rotor turns behind a gear.

    Parameters
    ----------
    name
        Name of the motor; its rotor, if it has inertia, is a body of that name in results.
    bar
        The bar or plate that it turns.
    against
        The bar or plate that carries the motor; the ground if not given.
    gear_ratio
        Speed of the rotor over that of the bar, both against what carries the motor; not 0.
    rotor_inertia
        About the rotor's own axis in kg·m².
    joint
        A joint of the bar at which the rotor sits; needed with an inertia.
    """

    section: ClassVar[str] = "motors"

    name: Name
    bar: BarName
    against: BarOrGroundName = GROUND
    gear_ratio: quantities.Number = 1.0
    rotor_inertia: Inertia = 0.0
    joint: JointName | None = None

    def faults(self) -> Iterator[Fault]:
        """A gear that turns, two bodies, and a place for the rotor."""
        if self.gear_ratio == 0:
            yield "gear_ratio", "expected a ratio other than 0"
        if self.against == self.bar:
            yield "against", f"expected another body than {self.bar!r}"
        if self.rotor_inertia and self.joint is None:
            yield (), f"missing key 'joint': the rotor needs a place, a joint of {self.bar!r}"

    def references(self) -> References:
        """The bar, what carries the motor, and the joint of the rotor."""
        points = (((*self.path, "joint"), self.bar, self.joint),) if self.joint else ()
        return replace(super().references(), points=points)

    def _falling(self, start: Function, fall: Function) -> Function:
        """A torque start − fall·speed of the rotor, both behind the gear."""
        gear = self.operand("gear_ratio")
        return gear * start - gear * gear * fall * V

    def _terms(self, law: Function, **electric: Any) -> tuple[Load | Body | Relation, ...]:
        """A torque on the bar, and the rotor itself."""
        against = None if self.against == GROUND else self.against
        gear, turn = self.operand("gear_ratio"), Turn(self.bar, against)
        load = Load(turn, law, self.path, called="motor", applied=True, **electric)
        if self.rotor_inertia == 0 or self.joint is None:
            return (load,)
        rotor = Body(
            name=self.name,
            kind="plate",
            path=self.path,
            points={self.joint: (ZERO, ZERO)},
            inertia=self.operand("rotor_inertia").parameter,
        )
        parts: tuple[tuple[str, Parameter], ...] = ((self.bar, gear.parameter),)
        if against is not None:
            parts = (*parts, (against, Parameter((*self.path, "against"), 1.0 - self.gear_ratio)))
        return load, rotor, Relation(self.name, parts, ZERO, self.path)


@component
class Motor(_Motor):
    """A motor whose torque falls in a straight line from standstill to its speed without load.

    Parameters
    ----------
    stall_torque
        Torque of the rotor at standstill in N·m.
    no_load_speed
        Speed of the rotor without torque in rad/s, of the same sign.
    """

    opens: ClassVar[Section] = Section(
        "mapping", "hoist: {bar: crank, stall_torque: 2 N m, no_load_speed: 3000 rpm}"
    )

    stall_torque: Torque
    no_load_speed: AngularSpeed

    def faults(self) -> Iterator[Fault]:
        """A torque that falls with the speed."""
        yield from super().faults()
        if self.stall_torque * self.no_load_speed <= 0:
            yield (), "expected a stall torque and a speed without load of the same sign, not 0"

    def terms(self) -> tuple[Load | Body | Relation, ...]:
        """The torque on the bar, and the rotor if it has inertia."""
        torque, speed = self.operand("stall_torque"), self.operand("no_load_speed")
        return self._terms(self._falling(torque, torque / speed))


@component
class ElectricMotor(_Motor):
    """A motor with permanent magnets at a voltage.

    Parameters
    ----------
    voltage
        Volts, or a law.
    torque_constant
        Torque of the rotor per current in N·m/A, which is also voltage per speed in V·s/rad; > 0.
    resistance
        Of the winding in ohms, > 0.
    inductance
        Of the winding in henrys, > 0; neglected if not given.
    current
        Through the winding at the start in amperes, with an inductance.
    """

    told_by: ClassVar[str] = "voltage"

    voltage: VoltageLaw
    torque_constant: PositiveTorqueConstant
    resistance: PositiveResistance
    inductance: PositiveInductance | None = None
    current: Current = 0.0

    def faults(self) -> Iterator[Fault]:
        """A current at the start is one through an inductance."""
        yield from super().faults()
        if self.current and self.inductance is None:
            yield "current", "without 'inductance' the current follows from voltage and speed"

    def terms(self) -> tuple[Load | Body | Relation, ...]:
        """The torque k·i on the bar, and the rotor if it has inertia.

        The current is (U − k·ω)/R or, with an inductance, L·di/dt = U − k·ω − R·i.
        """
        constant, resistance = self.operand("torque_constant"), self.operand("resistance")
        voltage = function_of(self.voltage, (*self.path, "voltage"))
        if self.inductance is None:
            fall = constant * constant / resistance
            return self._terms(self._falling(voltage * constant / resistance, fall))
        inductance, path = self.operand("inductance"), (*self.path, "current")
        gear = self.operand("gear_ratio")
        drop = voltage - constant * gear * V - resistance * value_of(path)
        current = InternalState(path, "A", drop / inductance, initial=self.current)
        stored = constant_of(0.5) * inductance * current.value**2
        return self._terms(gear * constant * current.value, stores=stored, states=(current,))


class _Cylinder(BetweenJoints):
    section: ClassVar[str] = "cylinders"
    no_body: ClassVar[str] = (
        "a cylinder is a force and has no coordinate; for a given stroke write its barrel as a bar "
        "and its rod as a slider 'on' it, and drive the slider"
    )

    bore: float

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

    told_by: ClassVar[str] = ""
    opens: ClassVar[Section] = Section(
        "mapping", "boom: {between: [O, B], bore: 50 mm, pressure: 160 bar}"
    )

    name: Name
    bore: PositiveLength
    pressure: PressureLaw
    rod: NonNegativeLength = 0.0
    rod_pressure: PressureLaw = 0.0
    damping: Damping = 0.0

    def faults(self) -> Iterator[Fault]:
        """A rod that fits into its cylinder."""
        if self.rod >= self.bore:
            yield "rod", f"expected less than the bore, {self.bore:g} m, found {self.rod:g} m"

    def terms(self) -> tuple[Load, ...]:
        """Pressures times areas, less what the damping takes."""
        pressure = function_of(self.pressure, (*self.path, "pressure"))
        against = function_of(self.rod_pressure, (*self.path, "rod_pressure"))
        rod = Number(self.number("rod")) ** 2 * (math.pi / 4)
        law = pressure * self._area - against * (self._area - rod)
        law = law + damper_law(self.number("damping"))
        return (self.acting(law, called="cylinder", applied=True),)


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

    told_by: ClassVar[str] = "gas_pressure"

    name: Name
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
        return (self.acting(law, called="gas spring", stores=energy),)
