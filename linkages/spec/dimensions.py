"""What numbers of a definition measure, with their SI units, and the bounds that they keep."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Dimension:
    """What a number measures.

    Parameters
    ----------
    name
        In words: ``"length"``.
    unit
        SI unit as text: ``"m"``; empty for a pure number.
    spoken
        SI unit in words: ``"metres"``.
    accepts
        Further unit texts of the same scale that mean this dimension too: SI counts the radian
        in torsional stiffness and damping as one, and it is often left out.
    largest
        Magnitude of the largest one that means something.
    """

    name: str
    unit: str = ""
    spoken: str = ""
    accepts: tuple[str, ...] = ()
    largest: float = math.inf

    @property
    def article(self) -> str:
        """The name with its article: ``"a length"``."""
        return f"{'an' if self.name[0] in 'aeiou' else 'a'} {self.name}"

    def expected(self, bound: Bound) -> str:
        """Return what messages expect: ``"a length > 0 (metres, or with a unit)"``."""
        limit = f" {bound.value}" if bound.value else ""
        return self.article + limit + (f" ({self.spoken}, or with a unit)" if self.unit else "")


class Bound(enum.Enum):
    """The limit of a number, as messages print it."""

    NONE = ""
    POSITIVE = "> 0"
    NON_NEGATIVE = ">= 0"

    def holds(self, value: float) -> bool:
        """Tell whether a value is within the limit."""
        if self is Bound.POSITIVE:
            return value > 0
        return self is Bound.NONE or value >= 0


NUMBER = Dimension("number")
LENGTH = Dimension("length", "m", "metres")
ANGLE = Dimension("angle", "rad", "radians", largest=1e8)
ANGULAR_SPEED = Dimension("angular speed", "rad/s", "radians per second")
SPEED = Dimension("speed", "m/s", "metres per second")
MASS = Dimension("mass", "kg", "kilograms")
INERTIA = Dimension("inertia", "kg*m**2", "kg·m²")
ACCELERATION = Dimension("acceleration", "m/s**2", "m/s²")
FORCE = Dimension("force", "N", "newtons")
TORQUE = Dimension("torque", "N*m", "newton metres")
STIFFNESS = Dimension("stiffness", "N/m", "newtons per metre")
TORSIONAL_STIFFNESS = Dimension("torsional stiffness", "N*m/rad", "N·m/rad", ("N*m",))
DAMPING = Dimension("damping", "N*s/m", "N·s/m")
TORSIONAL_DAMPING = Dimension("torsional damping", "N*m*s/rad", "N·m·s/rad", ("N*m*s",))
DURATION = Dimension("time", "s", "seconds")
FREQUENCY = Dimension("frequency", "1/s", "hertz")
PRESSURE = Dimension("pressure", "Pa", "pascals")
VOLUME = Dimension("volume", "m**3", "cubic metres")
VOLTAGE = Dimension("voltage", "V", "volts")
RESISTANCE = Dimension("resistance", "ohm", "ohms")
INDUCTANCE = Dimension("inductance", "H", "henrys")
CURRENT = Dimension("current", "A", "amperes")
TORQUE_CONSTANT = Dimension("torque constant", "N*m/A", "N·m/A", ("V*s/rad",))
KNOWN = (
    LENGTH, ANGLE, ANGULAR_SPEED, SPEED, MASS, INERTIA, ACCELERATION, FORCE, TORQUE, STIFFNESS,
    TORSIONAL_STIFFNESS, DAMPING, TORSIONAL_DAMPING, DURATION, FREQUENCY, PRESSURE, VOLUME,
    VOLTAGE, RESISTANCE, TORQUE_CONSTANT, INDUCTANCE, CURRENT,
    Dimension("temperature", "K"), Dimension("area", "m**2"), Dimension("power", "W"),
    Dimension("momentum", "kg*m/s"),
    Dimension("angular acceleration", "rad/s**2"),
)  # fmt: skip
