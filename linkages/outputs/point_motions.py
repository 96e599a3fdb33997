"""Actuators and the points that drives move: motions, powers, distance from where none can hold."""

from __future__ import annotations

from collections.abc import Callable

from linkages.kernel.differentiation import derivative_along
from linkages.kernel.forces.generalised_forces import LoadNodes
from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable, labels
from linkages.kernel.scalars import Scalar
from linkages.outputs import along_motion, of_each

ROTARY, LINEAR = "rotary_actuator", "linear_actuator"
"""Dimensions: actuators that turn, and those that do not."""


def _of(dim: str, value: Callable[[Model, LoadNodes], Scalar]) -> Callable[[Model], list[Scalar]]:
    """Something of each actuator that turns, or that does not."""

    def nodes(model: Model) -> list[Scalar]:
        names = labels(model, dim)
        own = zip(model.mechanism.actuations, model.actuators, strict=True)
        return [value(model, actuator) for name, actuator in own if name in names]

    return nodes


def _speed(model: Model, own: LoadNodes) -> Scalar:
    return own.rate(model.velocities)


def _acceleration(model: Model, own: LoadNodes) -> Scalar:
    """The rate of a speed, which moves with time, the free coordinates and their rates."""
    ((result,),) = derivative_along([own.rate(model.velocities)], [along_motion(model)])
    return result


def _powers(model: Model) -> list[Scalar]:
    efforts = (model.required_force(model.accelerations, p) for p in model.drive_partials)
    rates = (own.rate(model.velocities) for own in model.actuators)
    return [effort * rate for effort, rate in zip(efforts, rates, strict=True)]


OUTPUTS = {
    "rotary_actuator_angle": Variable(
        (ROTARY,), "rad", "angle of an actuator", _of(ROTARY, lambda _, own: own.displacement),
        default=True, angle=True, rate="rotary_actuator_speed",
    ),
    "rotary_actuator_speed": Variable(
        (ROTARY,), "rad/s", "angular speed of an actuator", _of(ROTARY, _speed),
        default=True, rate="rotary_actuator_acceleration",
    ),
    "rotary_actuator_acceleration": Variable(
        (ROTARY,), "rad/s^2", "angular acceleration of an actuator", _of(ROTARY, _acceleration),
        default=True,
    ),
    "linear_actuator_position": Variable(
        (LINEAR,), "m", "position of an actuator", _of(LINEAR, lambda _, own: own.displacement),
        default=True, rate="linear_actuator_velocity",
    ),
    "linear_actuator_velocity": Variable(
        (LINEAR,), "m/s", "velocity of an actuator", _of(LINEAR, _speed),
        default=True, rate="linear_actuator_acceleration",
    ),
    "linear_actuator_acceleration": Variable(
        (LINEAR,), "m/s^2", "acceleration of an actuator", _of(LINEAR, _acceleration),
        default=True,
    ),
    "actuator_power": Variable(("actuator",), "W", "power of an actuator", _powers, default=True),
    "dexterity": Variable(
        ("actuation",), "1", "dexterity", lambda model: [model.actuated.dexterity],
        default=True,
    ),
    "guided_position": Variable(
        ("guided",), "m", "coordinate of a driven point",
        of_each("guided", lambda m, name: m.positions.displacement(name)),
        coordinate=True, rate="guided_velocity",
    ),
    "guided_velocity": Variable(
        ("guided",), "m/s", "velocity of a driven point",
        of_each("guided", lambda m, name: m.velocities.bodies[name]),
    ),
}  # fmt: skip
