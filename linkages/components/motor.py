"""Direct-current motors: their torque falls with their speed."""

from __future__ import annotations

from typing import Any, ClassVar

from linkages.components.contributed.component import Component, Section, component
from linkages.components.contributed.functions import Function, V
from linkages.components.contributed.functions import constant as constant_of
from linkages.components.contributed.internal import InternalState, value_of
from linkages.components.contributed.listed import TURNING
from linkages.components.contributed.measures import Load, Turn
from linkages.components.contributed.references import References
from linkages.components.contributed.revolute import GROUND
from linkages.components.contributed.terms import ZERO, Body, Parameter, Path, Relation
from linkages.components.laws.law import VoltageLaw, function_of
from linkages.spec import quantities
from linkages.spec.quantities import (
    AngularSpeed,
    Current,
    Inertia,
    Name,
    PositiveInductance,
    PositiveResistance,
    PositiveTorqueConstant,
    Torque,
)


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

    name: Name
    bar: Name
    against: Name = GROUND
    gear_ratio: quantities.Number = 1.0
    rotor_inertia: Inertia = 0.0
    joint: Name | None = None

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """A gear that turns, two bodies, and a place for the rotor."""
        found = []
        if self.gear_ratio == 0:
            found.append(((*self.path, "gear_ratio"), "expected a ratio other than 0"))
        if self.against == self.bar:
            found.append(((*self.path, "against"), f"expected another body than {self.bar!r}"))
        if self.rotor_inertia and self.joint is None:
            message = f"missing key 'joint': the rotor needs a place, a joint of {self.bar!r}"
            found.append((self.path, message))
        return tuple(found)

    def references(self) -> References:
        """The bar, what carries the motor, and the joint of the rotor."""
        bodies = [((*self.path, "bar"), self.bar, TURNING)]
        if self.against != GROUND:
            bodies.append(((*self.path, "against"), self.against, TURNING))
        joint = (*self.path, "joint")
        return References(
            joints=((joint, self.joint),) if self.joint else (),
            bodies=tuple(bodies),
            points=((joint, self.bar, self.joint),) if self.joint else (),
        )

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

    section: ClassVar[str] = "motors"
    opens: ClassVar[Section] = Section(
        "mapping", "hoist: {bar: crank, stall_torque: 2 N m, no_load_speed: 3000 rpm}"
    )

    stall_torque: Torque
    no_load_speed: AngularSpeed

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """A torque that falls with the speed."""
        found = super().problems()
        if self.stall_torque * self.no_load_speed <= 0:
            message = "expected a stall torque and a speed without load of the same sign, not 0"
            found = (*found, (self.path, message))
        return found

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

    section: ClassVar[str] = "motors"
    told_by: ClassVar[str] = "voltage"

    voltage: VoltageLaw
    torque_constant: PositiveTorqueConstant
    resistance: PositiveResistance
    inductance: PositiveInductance | None = None
    current: Current = 0.0

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """A current at the start is one through an inductance."""
        found = super().problems()
        if self.current and self.inductance is None:
            message = "without 'inductance' the current follows from voltage and speed"
            found = (*found, ((*self.path, "current"), message))
        return found

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
