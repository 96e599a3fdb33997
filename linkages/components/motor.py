"""Direct-current motors: their torque falls with their speed."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import Component, Section, component
from linkages.components.contributed.functions import Function, Number, V
from linkages.components.contributed.listed import TURNING
from linkages.components.contributed.measures import Load, Turn
from linkages.components.contributed.references import References
from linkages.components.contributed.revolute import GROUND
from linkages.components.contributed.terms import ZERO, Body, Parameter, Path, Relation
from linkages.components.laws.law import VoltageLaw, function_of
from linkages.spec import quantities
from linkages.spec.quantities import (
    AngularSpeed,
    Inertia,
    Name,
    PositiveResistance,
    PositiveTorqueConstant,
    Torque,
)


class _Motor(Component):
    """What acts between a bar and what carries the motor; its rotor turns behind a gear."""

    name: str
    bar: str
    against: str
    joint: str | None
    gear_ratio: float
    rotor_inertia: float

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

    @property
    def _gear(self) -> Number:
        return Number(Parameter((*self.path, "gear_ratio"), self.gear_ratio))

    def _terms(self, start: Function, fall: Function) -> tuple[Load | Body | Relation, ...]:
        """A torque start − fall·speed of the rotor, both behind the gear, and the rotor."""
        against = None if self.against == GROUND else self.against
        gear = self._gear
        law = gear * start - gear * gear * fall * V
        torque = Load(Turn(self.bar, against), law, self.path, called="motor", applied=True)
        if self.rotor_inertia == 0 or self.joint is None:
            return (torque,)
        rotor = Body(
            name=self.name,
            kind="plate",
            path=self.path,
            points={self.joint: (ZERO, ZERO)},
            inertia=Parameter((*self.path, "rotor_inertia"), self.rotor_inertia),
        )
        parts: tuple[tuple[str, Parameter], ...] = ((self.bar, gear.parameter),)
        if against is not None:
            parts = (*parts, (against, Parameter((*self.path, "against"), 1.0 - self.gear_ratio)))
        return torque, rotor, Relation(self.name, parts, ZERO, self.path)


@component
class Motor(_Motor):
    """A motor whose torque falls in a straight line from standstill to its speed without load.

    Parameters
    ----------
    name
        Name of the motor; its rotor, if it has inertia, is a body of that name in results.
    bar
        The bar or plate that it turns.
    stall_torque
        Torque of the rotor at standstill in N·m.
    no_load_speed
        Speed of the rotor without torque in rad/s, of the same sign.
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
    opens: ClassVar[Section] = Section(
        "mapping", "hoist: {bar: crank, stall_torque: 2 N m, no_load_speed: 3000 rpm}"
    )

    name: Name
    bar: Name
    stall_torque: Torque
    no_load_speed: AngularSpeed
    against: Name = GROUND
    gear_ratio: quantities.Number = 1.0
    rotor_inertia: Inertia = 0.0
    joint: Name | None = None

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """A torque that falls with the speed."""
        found = super().problems()
        if self.stall_torque * self.no_load_speed <= 0:
            message = "expected a stall torque and a speed without load of the same sign, not 0"
            found = (*found, (self.path, message))
        return found

    def terms(self) -> tuple[Load | Body | Relation, ...]:
        """The torque on the bar, and the rotor if it has inertia."""
        torque = Number(Parameter((*self.path, "stall_torque"), self.stall_torque))
        speed = Number(Parameter((*self.path, "no_load_speed"), self.no_load_speed))
        return self._terms(torque, torque / speed)


@component
class ElectricMotor(_Motor):
    """A motor with permanent magnets at a voltage; its inductance is neglected.

    Parameters
    ----------
    name
        Name of the motor; its rotor, if it has inertia, is a body of that name in results.
    bar
        The bar or plate that it turns.
    voltage
        Volts, or a law.
    torque_constant
        Torque of the rotor per current in N·m/A, which is also voltage per speed in V·s/rad; > 0.
    resistance
        Of the winding in ohms, > 0.
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
    told_by: ClassVar[str] = "voltage"

    name: Name
    bar: Name
    voltage: VoltageLaw
    torque_constant: PositiveTorqueConstant
    resistance: PositiveResistance
    against: Name = GROUND
    gear_ratio: quantities.Number = 1.0
    rotor_inertia: Inertia = 0.0
    joint: Name | None = None

    def terms(self) -> tuple[Load | Body | Relation, ...]:
        """The torque k·(U − k·ω)/R on the bar, and the rotor if it has inertia."""
        constant = Number(Parameter((*self.path, "torque_constant"), self.torque_constant))
        resistance = Number(Parameter((*self.path, "resistance"), self.resistance))
        voltage = function_of(self.voltage, (*self.path, "voltage"))
        return self._terms(voltage * constant / resistance, constant * constant / resistance)
