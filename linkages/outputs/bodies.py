"""Coordinates of bars and sliders, their rates, and what clearances change in them."""

from __future__ import annotations

from linkages.kernel.outputs import Variable
from linkages.outputs import of_each

OUTPUTS = {
    "bar_angle": Variable(
        ("bar",), "rad", "angle",
        of_each("bar", lambda m, name: m.positions.angle(name)),
        default=True, coordinate=True, angle=True, rate="bar_speed",
    ),
    "bar_speed": Variable(
        ("bar",), "rad/s", "angular speed",
        of_each("bar", lambda m, name: m.velocities.turning(name)),
        default=True, rate="bar_acceleration",
    ),
    "bar_acceleration": Variable(
        ("bar",), "rad/s^2", "angular acceleration",
        of_each("bar", lambda m, name: m.accelerations.turning(name)),
        default=True,
    ),
    "slider_position": Variable(
        ("slider",), "m", "position",
        of_each("slider", lambda m, name: m.positions.displacement(name)),
        default=True, coordinate=True, rate="slider_velocity",
    ),
    "slider_velocity": Variable(
        ("slider",), "m/s", "velocity",
        of_each("slider", lambda m, name: m.velocities.moving(name)),
        default=True, rate="slider_acceleration",
    ),
    "slider_acceleration": Variable(
        ("slider",), "m/s^2", "acceleration",
        of_each("slider", lambda m, name: m.accelerations.moving(name)), default=True,
    ),
    "slider_position_error": Variable(
        ("slider",), "m", "position error", None,
        default=True, compared="slider_position",
    ),
    "slider_velocity_error": Variable(
        ("slider",), "m/s", "velocity error", None,
        default=True, compared="slider_velocity",
    ),
    "slider_acceleration_error": Variable(
        ("slider",), "m/s^2", "acceleration error", None,
        default=True, compared="slider_acceleration",
    ),
}  # fmt: skip
