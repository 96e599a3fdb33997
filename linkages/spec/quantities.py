"""Types of the fields of a definition: quantities in SI and names, with their messages."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from linkages.reading.wording import listed, shown, suggestion
from linkages.spec import dimensions
from linkages.spec.conversion import QuantityError, parse_quantity
from linkages.spec.dimensions import Bound, Dimension
from linkages.spec.tolerance_zones import has_tolerance, nominal_of

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
ONLY_NUMBERS = "only quantities have tolerances"
_NAME_RULE = f"a name (letters, digits, _, inner spaces and hyphens; at most {_LONGEST_NAME})"


class FieldType(ABC):
    """A rule of one field: reads a raw value, says what it expects, and describes itself."""

    @abstractmethod
    def read(self, value: Any) -> Any:
        """Return the value of the field, or raise QuantityError."""

    @abstractmethod
    def expected(self) -> str:
        """Return what messages expect."""

    @abstractmethod
    def json_schema(self) -> dict[str, Any]:
        """Return the JSON schema of the raw value."""

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
            number = parse_quantity(value, dimensions.NUMBER)
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

    def read(self, value: Any) -> str:
        """Return the name."""
        if not isinstance(value, str) or len(value) > _LONGEST_NAME:
            raise QuantityError(self.expected(), shown(value))
        if has_tolerance(value):
            raise QuantityError(self.expected(), f"{shown(value)}: {ONLY_NUMBERS}")
        if not re.fullmatch(_NAME, value):
            raise QuantityError(self.expected(), shown(value))
        return value

    def expected(self) -> str:
        """Return what a name may consist of."""
        return _NAME_RULE

    def json_schema(self) -> dict[str, Any]:
        """Return a string with the pattern of names; YAML takes digits alone for a number."""
        return {
            "type": ["string", "integer"],
            "pattern": _NAME_ANYWHERE,
            "maxLength": _LONGEST_NAME,
        }


@dataclass(frozen=True)
class TextRule(FieldType):
    """One line of text."""

    def read(self, value: Any) -> str:
        """Return the text; numbers are the text that was written."""
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise QuantityError(self.expected(), shown(value))
        return str(value)

    def expected(self) -> str:
        """Return ``"text"``."""
        return "text"

    def json_schema(self) -> dict[str, Any]:
        """Return text, which YAML may take for a number."""
        return {"type": ["string", "number"]}


Name = Annotated[str, NameRule()]
Text = Annotated[str, TextRule()]
PositiveInteger = Annotated[int, Count()]
NonNegativeInteger = Annotated[int, Count(0)]
Periods = Annotated[int, Count(most=10_000_000)]
SkippedPeriods = Annotated[int, Count(0, most=10_000_000)]
Number = Annotated[float, Quantity(dimensions.NUMBER)]
Tolerance = Annotated[float, Quantity(dimensions.NUMBER, Bound.POSITIVE)]
Length = Annotated[float, Quantity(dimensions.LENGTH)]
PositiveLength = Annotated[float, Quantity(dimensions.LENGTH, Bound.POSITIVE)]
NonNegativeLength = Annotated[float, Quantity(dimensions.LENGTH, Bound.NON_NEGATIVE)]
NonNegativeNumber = Annotated[float, Quantity(dimensions.NUMBER, Bound.NON_NEGATIVE)]
PositiveNumber = Annotated[float, Quantity(dimensions.NUMBER, Bound.POSITIVE)]
Angle = Annotated[float, Quantity(dimensions.ANGLE)]
AngularSpeed = Annotated[float, Quantity(dimensions.ANGULAR_SPEED)]
Speed = Annotated[float, Quantity(dimensions.SPEED)]
PositiveSpeed = Annotated[float, Quantity(dimensions.SPEED, Bound.POSITIVE)]
Mass = Annotated[float, Quantity(dimensions.MASS, Bound.NON_NEGATIVE)]
Inertia = Annotated[float, Quantity(dimensions.INERTIA, Bound.NON_NEGATIVE)]
Acceleration = Annotated[float, Quantity(dimensions.ACCELERATION)]
Force = Annotated[float, Quantity(dimensions.FORCE)]
Torque = Annotated[float, Quantity(dimensions.TORQUE)]
Stiffness = Annotated[float, Quantity(dimensions.STIFFNESS, Bound.NON_NEGATIVE)]
TorsionalStiffness = Annotated[float, Quantity(dimensions.TORSIONAL_STIFFNESS, Bound.NON_NEGATIVE)]
Damping = Annotated[float, Quantity(dimensions.DAMPING, Bound.NON_NEGATIVE)]
TorsionalDamping = Annotated[float, Quantity(dimensions.TORSIONAL_DAMPING, Bound.NON_NEGATIVE)]
Duration = Annotated[float, Quantity(dimensions.DURATION, Bound.POSITIVE)]
Instant = Annotated[float, Quantity(dimensions.DURATION)]
Frequency = Annotated[float, Quantity(dimensions.FREQUENCY)]
Pressure = Annotated[float, Quantity(dimensions.PRESSURE)]
NonNegativeForce = Annotated[float, Quantity(dimensions.FORCE, Bound.NON_NEGATIVE)]
NonNegativeTorque = Annotated[float, Quantity(dimensions.TORQUE, Bound.NON_NEGATIVE)]
PositiveAngularSpeed = Annotated[float, Quantity(dimensions.ANGULAR_SPEED, Bound.POSITIVE)]
PositiveStiffness = Annotated[float, Quantity(dimensions.STIFFNESS, Bound.POSITIVE)]
PositiveTorsionalStiffness = Annotated[
    float, Quantity(dimensions.TORSIONAL_STIFFNESS, Bound.POSITIVE)
]
PositiveDamping = Annotated[float, Quantity(dimensions.DAMPING, Bound.POSITIVE)]
PositiveTorsionalDamping = Annotated[float, Quantity(dimensions.TORSIONAL_DAMPING, Bound.POSITIVE)]
PositivePressure = Annotated[float, Quantity(dimensions.PRESSURE, Bound.POSITIVE)]
PositiveVolume = Annotated[float, Quantity(dimensions.VOLUME, Bound.POSITIVE)]
Voltage = Annotated[float, Quantity(dimensions.VOLTAGE)]
PositiveResistance = Annotated[float, Quantity(dimensions.RESISTANCE, Bound.POSITIVE)]
PositiveInductance = Annotated[float, Quantity(dimensions.INDUCTANCE, Bound.POSITIVE)]
Current = Annotated[float, Quantity(dimensions.CURRENT)]
PositiveTorqueConstant = Annotated[float, Quantity(dimensions.TORQUE_CONSTANT, Bound.POSITIVE)]
Point = tuple[Length, Length]
AccelerationVector = tuple[Acceleration, Acceleration]


class LawName(FieldType):
    """The name of a law.

    Parameters
    ----------
    laws
        Returns all laws by their names; called when a name is read.
    what
        What messages call such a law.
    """

    def __init__(self, laws: Callable[[], Mapping[str, Any]], what: str) -> None:
        self._laws, self._what = laws, what

    def read(self, value: Any) -> str:
        """Return the name."""
        if not isinstance(value, str) or value not in self._laws():
            near = suggestion(str(value), self._laws())
            raise QuantityError(self.expected(), f"{shown(value)}{near}")
        return value

    def expected(self) -> str:
        """Return the names."""
        return f"{self._what} ({listed(self._laws())})"

    def json_schema(self) -> dict[str, Any]:
        """Return the names."""
        return {"enum": list(self._laws())}
