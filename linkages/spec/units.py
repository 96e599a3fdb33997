"""Units such as ``mm`` or ``N*m/rad``: their size in SI, and what they measure.

Pint knows the names; products and powers are read here. The radian counts as a base unit, so
that hertz, rad/s and a pure number, which SI gives the same dimension, cannot be confused.

Grammar::

    product = power {("*" | "/" | nothing) power}
    power   = atom ["**" NUMBER]
    atom    = NAME | "(" product ")"
"""

from __future__ import annotations

import enum
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from linkages.reading.output_files import private_folder
from linkages.reading.wording import shown, suggestion

_LONGEST = 80
_SMALLEST = 1e-100
_TOKEN = re.compile(r"\s*(?:(\*\*|[*/()])|([-+]?[0-9]+(?:\.[0-9]+)?)|([^\W\d]\w*|°))")
_SPELLINGS = {"·": "*", "⋅": "*", "×": "*", "^": "**", "²": "**2", "³": "**3"}
_STROKES = "spm = turn / minute"  # strokes per minute of pumps and presses: one per turn
_USUAL = (
    "m", "mm", "cm", "km", "um", "in", "ft", "meter", "metre", "millimeter", "millimetre",
    "centimeter", "centimetre", "kilometer", "inch", "foot", "rad", "deg", "radian", "degree",
    "turn", "rpm", "spm", "s", "ms", "us", "second", "minute", "min", "hour", "kg", "g", "gram",
    "kilogram", "N", "kN", "newton", "N*m", "lbf",
)  # fmt: skip


_SEVERAL = {
    "ton": "t: 1000 kg, short_ton: 907.185 kg, long_ton: 1016.05 kg",
    "force_ton ton_force": "tf: 9806.65 N, short_ton_force: 8896.44 N, long_ton_force: 9964.02 N",
    "cwt hundredweight": "short_hundredweight: 45.3592 kg, long_hundredweight: 50.8023 kg",
    "dr dram": "avdp_dram: 1.77185 g, apothecary_dram: 3.88793 g",
    "hp horsepower": "metric_horsepower: 735.499 W, UK_horsepower: 745.700 W",
    "cal calorie": "cal_th: 4.184 J, cal_it: 4.1868 J",
    "BTU Btu british_thermal_unit": "Btu_th: 1054.35 J, Btu_it: 1055.06 J",
    "thm therm": "US_therm: 105.480 MJ, EC_therm: 105.506 MJ",
    "grad grade Grad": "gon: turn/400, deg: turn/360",
    "mil": "thou: 25.4 µm, mrad: 0.001 rad",
    "gal gallon": "US_liquid_gallon: 3.78541 L, US_dry_gallon: 4.40488 L, UK_gallon: 4.54609 L",
    "qt quart": "US_liquid_quart: 0.946353 L, US_dry_quart: 1.10122 L, imperial_quart: 1.13652 L",
    "pt pint": "US_pint: 0.473176 L, US_dry_pint: 0.550610 L, imperial_pint: 0.568261 L",
    "cp cup": "US_liquid_cup: 0.236588 L, imperial_cup: 0.284131 L",
    "gi gill": "US_liquid_gill: 0.118294 L, imperial_gill: 0.142065 L",
    "floz fluid_ounce": "US_fluid_ounce: 29.5735 mL, imperial_fluid_ounce: 28.4131 mL",
    "fldr fluid_dram fluidram": "US_fluid_dram: 3.69669 mL, imperial_fluid_dram: 3.55163 mL",
    "barrel bbl": "oil_barrel: 158.987 L, US_dry_barrel: 115.627 L, imperial_barrel: 163.659 L",
    "bu bushel peck pk tablespoon tbsp teaspoon tsp": "L, mL",
}
"""Spellings that have several common meanings → spellings that have one, and what that is."""


COMMON: dict[tuple[tuple[str, float], ...], dict[str, float]] = {
    (("meter", 1),): {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "um": 1e-6, "in": 0.0254},
    (("radian", 1),): {"rad": 1.0, "deg": math.pi / 180.0, "turn": 2.0 * math.pi},
    (("radian", 1), ("second", -1)): {"rpm": math.pi / 30.0},
    (("second", 1),): {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0},
    (("second", -1),): {"Hz": 1.0},
    (("kilogram", 1),): {"kg": 1.0, "g": 1e-3, "t": 1e3},
    (("kilogram", 1), ("meter", 1), ("second", -2)): {"N": 1.0, "kN": 1e3, "MN": 1e6},
    (("kilogram", 1), ("meter", 2), ("second", -2)): {"J": 1.0, "kJ": 1e3},
    (("kilogram", 1), ("meter", 2), ("second", -3)): {"W": 1.0, "kW": 1e3},
    (("kilogram", 1), ("meter", -1), ("second", -2)): {
        "Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "bar": 1e5,
    },
}  # fmt: skip
"""Base units with powers → names and scales of common units, for which Pint, whose import takes
longer than many a simulation, is not needed."""

_COMMON = {name: (powers, scale) for powers, own in COMMON.items() for name, scale in own.items()}


class UnitError(ValueError):
    """Why a text is not a unit; a clause for the end of a message."""


@dataclass(frozen=True)
class Unit:
    """A unit in terms of SI base units."""

    scale: float  # one of this unit in SI base units
    # Sorted pairs of base unit and power: ``(("metre", 1), ("second", -1))``
    exponents: tuple[tuple[str, float], ...]

    def __str__(self) -> str:
        """Its base units, as they can be read again if its scale is one."""
        return "*".join(f"{base}**{power!r}" for base, power in self.exponents) or "rad"

    def times(self, other: Unit, power: float = 1) -> Unit:
        """Return the product of this unit and a power of another."""
        exponents = dict(self.exponents)
        for base, exponent in other.exponents:
            exponents[base] = exponents.get(base, 0) + power * exponent
        kept = tuple(sorted((base, p) for base, p in exponents.items() if p))
        return Unit(self.scale * other.scale**power, kept)

    def convert(self, value: float) -> float:
        """Return a value in this unit as SI."""
        # 35/1000 is the double nearest to 0.035; 35*0.001 is not.
        inverse = 1 / self.scale
        return value / inverse if inverse.is_integer() else value * self.scale


@cache
def unit(text: str) -> Unit:
    """Return the unit that a text names.

    Raises UnitError the text is no unit, a name in it is unknown, or its scale has an offset (degC,
    dB).
    """
    for spelling, plain in _SPELLINGS.items():
        text = text.replace(spelling, plain)
    if len(text) > _LONGEST:
        raise UnitError(f"a unit has at most {_LONGEST} characters")
    tokens = _tokens(text)
    try:
        result = _product(tokens)
    except (OverflowError, ZeroDivisionError):
        raise UnitError(f"{text} is out of the range of numbers") from None
    if tokens:
        raise UnitError(f"{shown(text)} is not a unit")
    if not _SMALLEST < result.scale < 1 / _SMALLEST:
        raise UnitError(f"{text} is out of the range of numbers")
    return result


def scale_to_si(text: str) -> float:
    """The factor from a unit to SI; 1 for no unit."""
    return unit(text).scale if text else 1.0


def near_unit(text: str) -> str:
    """Return ``"; did you mean 'mm'?"`` where a usual unit is near."""
    if text == "Nm":
        return "; did you mean 'N*m'?"
    return suggestion(text, _USUAL)


def _tokens(text: str) -> list[str]:
    tokens, at = [], 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise UnitError(f"{shown(text)} is not a unit")
        tokens.append(match.group().strip())
        at = match.end()
    return tokens


def _product(tokens: list[str]) -> Unit:
    result = _power(tokens)
    while tokens and tokens[0] != ")":
        operator = tokens.pop(0) if tokens[0] in "*/" else "*"
        result = result.times(_power(tokens), -1 if operator == "/" else 1)
    return result


def _power(tokens: list[str]) -> Unit:
    base = _atom(tokens)
    if not tokens or tokens[0] != "**":
        return base
    tokens.pop(0)
    exponent = tokens.pop(0) if tokens else ""
    if not re.fullmatch(r"[-+]?([1-9](\.[0-9]+)?|0\.[0-9]*[1-9])", exponent):
        raise UnitError("the power of a unit is a number such as 2, -1 or 1.5")
    power = float(exponent)
    return Unit(1.0, ()).times(base, int(power) if power.is_integer() else power)


def _atom(tokens: list[str]) -> Unit:
    token = tokens.pop(0) if tokens else ""
    if token == "(":
        inner = _product(tokens)
        if tokens.pop(0) if tokens else None:
            return inner
        raise UnitError("a parenthesis in the unit is not closed")
    if token == "1" and tokens and tokens[0] == "/":
        return Unit(1.0, ())
    if not token or not (token[0].isalpha() or token[0] in "_°"):
        raise UnitError(
            f"expected the name of a unit, found {shown(token) if token else 'nothing'}"
        )
    return _named(token)


def _refuse_ambiguous(name: str) -> None:
    """Raise UnitError for one of `_SEVERAL`, also in the plural or with a prefix."""
    parsed = _registry().parse_unit_name(name)
    for spellings, meanings in _SEVERAL.items():
        for spelling in spellings.split():
            prefixed = name.removesuffix("s").endswith(spelling) and parsed and parsed[0][0]
            if name in (spelling, f"{spelling}s") or (
                prefixed and parsed[0][1] == _registry().parse_unit_name(spelling)[0][1]
            ):
                raise UnitError(f"{name} has several meanings; expected one of {meanings}")


@cache
def _named(name: str) -> Unit:
    if name in _COMMON:
        powers, scale = _COMMON[name]
        return Unit(scale, powers)
    return named_by_pint(name)


def named_by_pint(name: str) -> Unit:
    """The unit of a name, as `unit` reads it."""
    import pint

    _refuse_ambiguous(name)
    try:
        one = _registry().Quantity(1.0, name).to_root_units()
        zero = _registry().Quantity(0.0, name).to_root_units()
    except (pint.errors.PintError, AttributeError, ValueError, TypeError, ArithmeticError):
        if powered := re.fullmatch(r"([^\W\d]+)([2-4])", name):  # kg mm2, as CAD prints
            return Unit(1.0, ()).times(_named(powered[1]), int(powered[2]))
        raise UnitError(f"unknown unit {name!r}{near_unit(name)}") from None
    if zero.magnitude != 0:
        raise UnitError(f"{name} has its zero elsewhere; expected a unit that scales")
    exponents = dict(one.unit_items())
    if any(power != int(power) for power in exponents.values()):
        raise UnitError(f"{name} is not a unit of mechanics")
    return _in_kilograms(float(one.magnitude), exponents)


def _in_kilograms(scale: float, exponents: Mapping[str, float]) -> Unit:
    """Return the unit with pint's root unit of mass, the gram, replaced by the SI one."""
    powers = {base: int(power) for base, power in exponents.items()}
    grams = powers.pop("gram", 0)
    if grams:
        powers["kilogram"] = grams
        scale = scale / 1000**grams if grams > 0 else scale * 1000**-grams
    return Unit(scale, tuple(sorted(powers.items())))


@cache
def _registry() -> Any:
    # Imported on first use: a file without units does not pay for the registry (0.3 s).
    import pint

    try:
        # parsed definitions of units are kept as pickles, which saves 0.15 s a run
        folder = private_folder("units")
        if any(path.stat().st_uid != folder.stat().st_uid for path in folder.iterdir()):
            raise PermissionError(None, f"others put files into {folder}")
        registry: Any = pint.UnitRegistry(cache_folder=folder)
    except Exception:
        # Another process may be writing there (pint does it in place), or have been stopped
        # meanwhile, and half a pickle raises anything. The definitions themselves need no cache.
        registry = pint.UnitRegistry()
    registry.define(_STROKES)
    return registry


@dataclass(frozen=True)
class Dimension:
    """What a number measures.

    `accepts`: further unit texts of the same scale that mean this dimension too: SI counts the
    radian in torsional stiffness and damping as one, and it is often left out.
    """

    name: str  # in words: ``"length"``
    unit: str = ""  # SI unit as text: ``"m"``; empty for a pure number
    spoken: str = ""  # SI unit in words: ``"metres"``
    accepts: tuple[str, ...] = ()
    largest: float = math.inf  # magnitude of the largest one that means something

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
