"""What the paper reports (ω = ∓π rad/s, r = 0.15 mm), and how it is computed here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

import linkages


@dataclass(frozen=True)
class Reported:
    """A maximum that the paper reports."""

    words: str  # name of the quantity
    output: str  # its place in a solution
    element: str
    value: float  # as printed, in SI and seconds
    time: float
    factor: float  # for tables and figures
    units: str

    def shown(self, value: float) -> str:
        """A value with three digits, in `units`."""
        scaled = value * self.factor
        return f"{scaled:.0f}" if scaled >= 99.95 else f"{scaled:#.3g}"


REPORTED = (
    Reported("position error", "slider_position_error", "slider9", 7.806e-5, 1.232, 1e6, "µm"),
    Reported("velocity error", "slider_velocity_error", "slider9", 0.029, 1.187, 1e3, "mm/s"),
    Reported(
        "acceleration error", "slider_acceleration_error", "slider9", 8.684, 1.152, 1.0, "m/s²"
    ),
    Reported("torque of crank 1", "drive_effort", "crank1", 43.394, 0.528, 1.0, "N·m"),
    Reported("torque of crank 4", "drive_effort", "crank4", 11.576, 0.528, 1.0, "N·m"),
)
PRINTED = np.array([quantity.value for quantity in REPORTED])
OUTPUTS = tuple(dict.fromkeys(quantity.output for quantity in REPORTED))

SIZES = (5e-5, 1e-4, 1.5e-4, 2.5e-4)
"""Clearances of the paper's Fig. 12, in m."""

SIZE_RANGE = (1e-5, 5e-4)
"""Of its Fig. 13."""

SPEEDS = tuple(factor * np.pi for factor in (0.5, 1.0, 1.5, 2.5))
"""Speeds of its Fig. 14, in rad/s."""

SPEED_RANGE = (0.05 * np.pi, 5 * np.pi)
"""Of its Fig. 15."""

SIZE = "clearances.r1.size"
ANGLE = "clearances.r1.angle"
CRANKS = "drives.crank1.angle", "drives.crank4.angle"
DRIVES = {"drives.crank1.speed": -1.0, "drives.crank4.speed": 1.0}
"""Both cranks turn at the same speed, in opposite senses."""

STARTS = {"librating": "ninebar", "rotating": "ninebar-rotating"}
"""Motion of the clearance link from each of our two initial conditions → its definition file."""


def press(start: str = "librating", changes: Mapping[str, object] | None = None):
    """The mechanism from one of our initial conditions, with other values at some paths."""
    return linkages.load(STARTS[start], set=dict(changes or {}))


def speeds(speed) -> dict[str, object]:
    """Path → speed of both cranks."""
    return {path: sign * speed for path, sign in DRIVES.items()}
