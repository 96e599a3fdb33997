"""Field types of definitions: quantities in SI, names, and stiffnesses in N/mⁿ."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from linkages.reading.wording import listed, shown, suggestion
from linkages.spec.conversion import (
    QuantityError,
    has_tolerance,
    nominal_of,
    nominal_text,
    parse_quantity,
)
from linkages.spec.grammar import leading_number
from linkages.spec.units import (
    ACCELERATION,
    ANGLE,
    ANGULAR_SPEED,
    CURRENT,
    DAMPING,
    DURATION,
    FORCE,
    FREQUENCY,
    INDUCTANCE,
    INERTIA,
    LENGTH,
    MASS,
    NUMBER,
    PRESSURE,
    RESISTANCE,
    SPEED,
    STIFFNESS,
    TORQUE,
    TORQUE_CONSTANT,
    TORSIONAL_DAMPING,
    TORSIONAL_STIFFNESS,
    VOLTAGE,
    VOLUME,
    Bound,
    Dimension,
    UnitError,
    unit,
)

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic_core import CoreSchema

# pydantic itself is imported when it is needed: options have these types too, and `--help` is fast

_LONGEST_NAME = 64
_NAME = r"\w([\w -]*\w)?"
# The same in terms that all dialects of regular expressions share: in most of them \w is ASCII.
_LETTER = r"[^\x00-/:-@\[-^`{-\x7f]"
_INNER = r"[^\x00-\x1f!-,./:-@\[-^`{-\x7f]"
_NAME_ANYWHERE = f"^{_LETTER}({_INNER}*{_LETTER})?$"
# How arithmetic begins: signs and parentheses, then a number or pi.
ARITHMETIC = r"^[-+−(\s]*(\.?[0-9]|pi\b|π)"
LIMITS: dict[Bound, dict[str, Any]] = {
    Bound.NONE: {},
    Bound.POSITIVE: {"exclusiveMinimum": 0},
    Bound.NON_NEGATIVE: {"minimum": 0},
}
"""Limits of numbers as a JSON schema has them."""
MOST_HARMONICS = 64
"""Of the profile of a bearing."""
ONLY_NUMBERS = "only quantities have tolerances"


class FieldType(ABC):
    """A rule of one field: reads a raw value, says what it expects, and describes itself."""

    words: ClassVar[str]
    schema: ClassVar[Mapping[str, Any]]
    """What messages expect, and the JSON schema of the raw value, of rules without properties."""

    @abstractmethod
    def read(self, value: Any) -> Any:
        """Return the value of the field, or raise QuantityError."""

    def expected(self) -> str:
        """Return what messages expect."""
        return self.words

    def json_schema(self) -> dict[str, Any]:
        """Return the JSON schema of the raw value."""
        return {**self.schema}

    @property
    def models(self) -> tuple[Any, ...]:
        """Models of the mappings that may stand in this place."""
        return ()

    def __get_pydantic_core_schema__(self, _: Any, __: GetCoreSchemaHandler) -> CoreSchema:
        from pydantic_core import core_schema

        return core_schema.no_info_plain_validator_function(self._validate)

    def __get_pydantic_json_schema__(self, _: Any, __: GetJsonSchemaHandler) -> dict[str, Any]:
        return {"description": self.expected(), **self.json_schema()}

    def _validate(self, value: Any) -> Any:
        try:
            return self.read(value)
        except QuantityError as error:
            from pydantic_core import PydanticCustomError

            # Through the context: braces in a message must not be taken for placeholders.
            context = {"expected": error.expected, "found": error.found}
            template = "expected {expected}, found {found}"
            raise PydanticCustomError("linkages", template, context) from None


@dataclass(frozen=True)
class Quantity(FieldType):
    """A real number of a dimension, within a bound."""

    dimension: Dimension
    bound: Bound = Bound.NONE

    def read(self, value: Any) -> float:
        """Return the number in SI; the nominal one where the text states a tolerance."""
        nominal = nominal_of(value, self.dimension, self.bound)
        return parse_quantity(nominal, self.dimension, self.bound)

    def expected(self) -> str:
        """Return for example ``"a length > 0 (metres, or with a unit)"``."""
        return self.dimension.expected(self.bound)

    def json_schema(self) -> dict[str, Any]:
        """Return a number within the bound, or text that begins with arithmetic."""
        return {"type": ["number", "string"], **LIMITS[self.bound], "pattern": ARITHMETIC}


LARGEST_COUNT = 2**53
"""Beyond it, doubles do not hold every whole number; ten times as many fit into 64 bits."""


@dataclass(frozen=True)
class Count(FieldType):
    """A whole number from `least` to `most`."""

    least: int = 1
    most: int = LARGEST_COUNT

    def read(self, value: Any) -> int:
        """Return the number; ``2001.5`` is refused rather than rounded."""
        try:
            number = parse_quantity(value, NUMBER)
        except QuantityError as error:
            counted = f"{shown(value)}: {ONLY_NUMBERS}" if has_tolerance(value) else error.found
            raise QuantityError(self.expected(), counted) from None
        if number < self.least or number != int(number):
            raise QuantityError(self.expected(), shown(value))
        if number > self.most:
            raise QuantityError(f"{self.expected()}, at most {self.most}", shown(value))
        return int(number)

    def expected(self) -> str:
        """Return for example ``"a whole number > 0"``."""
        return f"a whole number > {self.least - 1}" if self.least else "a whole number >= 0"

    def json_schema(self) -> dict[str, Any]:
        """Return an integer, or text that begins with arithmetic."""
        return {"type": ["integer", "string"], "minimum": self.least, "pattern": ARITHMETIC}


@dataclass(frozen=True)
class NameRule(FieldType):
    """A name that needs no quoting in messages, dotted paths, tables and file names."""

    words: ClassVar[str] = (
        f"a name (letters, digits, _, inner spaces and hyphens; at most {_LONGEST_NAME})"
    )
    # YAML takes digits alone for a number
    schema: ClassVar[Mapping[str, Any]] = {
        "type": ["string", "integer"],
        "pattern": _NAME_ANYWHERE,
        "maxLength": _LONGEST_NAME,
    }

    # What must have it elsewhere in the definition: kinds of bodies, or one of `JOINTS`
    of: tuple[str, ...] = ()
    ground: bool = False  # whether the ground may stand in the place of a body

    def read(self, value: Any) -> str:
        """Return the name."""
        if not isinstance(value, str) or len(value) > _LONGEST_NAME:
            raise QuantityError(self.expected(), shown(value))
        if has_tolerance(value):
            raise QuantityError(self.expected(), f"{shown(value)}: {ONLY_NUMBERS}")
        if not re.fullmatch(_NAME, value):
            raise QuantityError(self.expected(), shown(value))
        return value


@dataclass(frozen=True)
class TextRule(FieldType):
    """One line of text, which YAML may take for a number."""

    words: ClassVar[str] = "text"
    schema: ClassVar[Mapping[str, Any]] = {"type": ["string", "number"]}

    def read(self, value: Any) -> str:
        """Return the text; numbers are the text that was written."""
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise QuantityError(self.expected(), shown(value))
        return str(value)


JOINTS = ("joint", "moving joint")
"""What names of joints are of: any, or those that are not of the ground."""

Name = Annotated[str, NameRule()]
JointName = Annotated[str, NameRule(("joint",))]
MovingJointName = Annotated[str, NameRule(("moving joint",))]
SliderName = Annotated[str, NameRule(("slider",))]
ClearanceName = Annotated[str, NameRule(("clearance",))]
BarName = Annotated[str, NameRule(("bar", "plate"))]
BarOrGroundName = Annotated[str, NameRule(("bar", "plate"), ground=True)]
BodyName = Annotated[str, NameRule(("bar", "plate", "slider"))]
BodyOrGroundName = Annotated[str, NameRule(("bar", "plate", "slider"), ground=True)]
BarPair = tuple[BarOrGroundName, BarName]
Text = Annotated[str, TextRule()]
PositiveInteger = Annotated[int, Count()]
NonNegativeInteger = Annotated[int, Count(0)]
Periods = Annotated[int, Count(most=10_000_000)]
SkippedPeriods = Annotated[int, Count(0, most=10_000_000)]
Harmonics = Annotated[int, Count(2, most=MOST_HARMONICS)]
Number = Annotated[float, Quantity(NUMBER)]
Tolerance = Annotated[float, Quantity(NUMBER, Bound.POSITIVE)]
Length = Annotated[float, Quantity(LENGTH)]
PositiveLength = Annotated[float, Quantity(LENGTH, Bound.POSITIVE)]
NonNegativeLength = Annotated[float, Quantity(LENGTH, Bound.NON_NEGATIVE)]
NonNegativeNumber = Annotated[float, Quantity(NUMBER, Bound.NON_NEGATIVE)]
PositiveNumber = Annotated[float, Quantity(NUMBER, Bound.POSITIVE)]
Angle = Annotated[float, Quantity(ANGLE)]
AngularSpeed = Annotated[float, Quantity(ANGULAR_SPEED)]
Speed = Annotated[float, Quantity(SPEED)]
PositiveSpeed = Annotated[float, Quantity(SPEED, Bound.POSITIVE)]
Mass = Annotated[float, Quantity(MASS, Bound.NON_NEGATIVE)]
Inertia = Annotated[float, Quantity(INERTIA, Bound.NON_NEGATIVE)]
Acceleration = Annotated[float, Quantity(ACCELERATION)]
Force = Annotated[float, Quantity(FORCE)]
Torque = Annotated[float, Quantity(TORQUE)]
Stiffness = Annotated[float, Quantity(STIFFNESS, Bound.NON_NEGATIVE)]
TorsionalStiffness = Annotated[float, Quantity(TORSIONAL_STIFFNESS, Bound.NON_NEGATIVE)]
Damping = Annotated[float, Quantity(DAMPING, Bound.NON_NEGATIVE)]
TorsionalDamping = Annotated[float, Quantity(TORSIONAL_DAMPING, Bound.NON_NEGATIVE)]
Duration = Annotated[float, Quantity(DURATION, Bound.POSITIVE)]
Instant = Annotated[float, Quantity(DURATION)]
Frequency = Annotated[float, Quantity(FREQUENCY)]
Pressure = Annotated[float, Quantity(PRESSURE)]
NonNegativeForce = Annotated[float, Quantity(FORCE, Bound.NON_NEGATIVE)]
NonNegativeTorque = Annotated[float, Quantity(TORQUE, Bound.NON_NEGATIVE)]
PositiveAngularSpeed = Annotated[float, Quantity(ANGULAR_SPEED, Bound.POSITIVE)]
PositiveStiffness = Annotated[float, Quantity(STIFFNESS, Bound.POSITIVE)]
PositiveTorsionalStiffness = Annotated[float, Quantity(TORSIONAL_STIFFNESS, Bound.POSITIVE)]
PositiveDamping = Annotated[float, Quantity(DAMPING, Bound.POSITIVE)]
PositiveTorsionalDamping = Annotated[float, Quantity(TORSIONAL_DAMPING, Bound.POSITIVE)]
PositivePressure = Annotated[float, Quantity(PRESSURE, Bound.POSITIVE)]
PositiveVolume = Annotated[float, Quantity(VOLUME, Bound.POSITIVE)]
Voltage = Annotated[float, Quantity(VOLTAGE)]
PositiveResistance = Annotated[float, Quantity(RESISTANCE, Bound.POSITIVE)]
PositiveInductance = Annotated[float, Quantity(INDUCTANCE, Bound.POSITIVE)]
Current = Annotated[float, Quantity(CURRENT)]
PositiveTorqueConstant = Annotated[float, Quantity(TORQUE_CONSTANT, Bound.POSITIVE)]
Point = tuple[Length, Length]
AccelerationVector = tuple[Acceleration, Acceleration]


@dataclass(frozen=True)
class LawName(FieldType):
    """The name of a law."""

    laws: Callable[[], Mapping[str, Any]]  # all laws by their names; called when a name is read
    what: str  # what messages call such a law

    def read(self, value: Any) -> str:
        """Return the name."""
        if not isinstance(value, str) or value not in self.laws():
            near = suggestion(str(value), self.laws())
            raise QuantityError(self.expected(), f"{shown(value)}{near}")
        return value

    def expected(self) -> str:
        """Return the names."""
        return f"{self.what} ({listed(self.laws())})"

    def json_schema(self) -> dict[str, Any]:
        """Return the names."""
        return {"enum": list(self.laws())}


class PowerStiffness(float):
    """A stiffness in N/mⁿ whose unit was written."""

    exponent: float


class _Rule(FieldType):
    """K of a force K·dⁿ."""

    words: ClassVar[str] = "a stiffness > 0 (N/m^n, or with a unit such as N/m^1.5)"
    schema: ClassVar[Mapping[str, Any]] = {
        "type": ["number", "string"], "exclusiveMinimum": 0, "pattern": ARITHMETIC,
    }  # fmt: skip

    def read(self, value: Any) -> float:
        """Return the number in SI; a `PowerStiffness` where a unit stands behind it."""
        exponent = _written(value)
        dimension = Dimension("stiffness", stiffness_unit(exponent or 1.5))
        try:
            number = Quantity(dimension, Bound.POSITIVE).read(value)
        except QuantityError as fault:
            raise QuantityError(self.expected(), fault.found) from None
        if exponent is None:
            return number
        result = PowerStiffness(number)
        result.exponent = exponent
        return result


ContactStiffness = Annotated[float, _Rule()]


def exponent_of(stiffness: float | None) -> float | None:
    """The exponent n that the unit of a stiffness says; None if no unit was written."""
    return stiffness.exponent if isinstance(stiffness, PowerStiffness) else None


def stiffness_unit(exponent: float) -> str:
    """The SI unit of a stiffness."""
    return "N/m" if exponent == 1.0 else f"N/m^{exponent:g}"


def _written(value: Any) -> float | None:
    """The exponent in a text with a unit, if that is one of force over a power of length."""
    if not isinstance(value, str):
        return None
    try:
        _, text = leading_number(nominal_text(value).replace("−", "-").strip())
        powers = dict(unit(text).exponents) if text else {}
    except (UnitError, ValueError):
        return None
    exponent = 1.0 - powers.pop("meter", 0)
    return exponent if powers == {"kilogram": 1, "second": -2} and exponent > 0 else None
