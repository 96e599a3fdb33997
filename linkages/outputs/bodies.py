"""Coordinates of bars and sliders, their rates, and what clearances change in them."""

from __future__ import annotations

from collections.abc import Callable

from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable, labels
from linkages.kernel.scalars import Scalar


def _of_bodies(dim: str, field: str) -> Callable[[Model], list[Scalar]]:
    return lambda model: [getattr(model, field).moving(name) for name in labels(model, dim)]


def _of_turning(dim: str, field: str) -> Callable[[Model], list[Scalar]]:
    return lambda model: [getattr(model, field).turning(name) for name in labels(model, dim)]


def _angles(dim: str) -> Callable[[Model], list[Scalar]]:
    return lambda model: [model.positions.angle(name) for name in labels(model, dim)]


OUTPUTS = {
    "bar_angle": Variable(
        ("bar",), "rad", "angle", _angles("bar"),
        default=True, coordinate=True, angle=True, rate="bar_speed",
    ),
    "bar_speed": Variable(
        ("bar",), "rad/s", "angular speed", _of_turning("bar", "velocities"),
        default=True, rate="bar_acceleration",
    ),
    "bar_acceleration": Variable(
        ("bar",), "rad/s^2", "angular acceleration", _of_turning("bar", "accelerations"),
        default=True,
    ),
    "slider_position": Variable(
        ("slider",),
        "m",
        "position",
        lambda m: [m.positions.displacement(name) for name in labels(m, "slider")],
        default=True, coordinate=True, rate="slider_velocity",
    ),
    "slider_velocity": Variable(
        ("slider",), "m/s", "velocity", _of_bodies("slider", "velocities"),
        default=True, rate="slider_acceleration",
    ),
    "slider_acceleration": Variable(
        ("slider",), "m/s^2", "acceleration", _of_bodies("slider", "accelerations"), default=True
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
