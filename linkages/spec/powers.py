"""Stiffnesses of laws that are powers: numbers in N/mⁿ, which say themselves what n is."""

from __future__ import annotations

from typing import Annotated, Any

from linkages.spec.arithmetic import leading_number
from linkages.spec.conversion import QuantityError, parse_quantity
from linkages.spec.dimensions import Bound, Dimension
from linkages.spec.quantities import ARITHMETIC, FieldType
from linkages.spec.tolerance_zones import nominal_of, nominal_text
from linkages.spec.units import UnitError, unit


class PowerStiffness(float):
    """A stiffness in N/mⁿ whose unit was written."""

    exponent: float


class _Rule(FieldType):
    """K of a force K·dⁿ."""

    def read(self, value: Any) -> float:
        """Return the number in SI; a `PowerStiffness` where a unit stands behind it."""
        exponent = _written(value)
        dimension = _dimension(exponent or 1.5)
        try:
            nominal = nominal_of(value, dimension, Bound.POSITIVE)
            number = parse_quantity(nominal, dimension, Bound.POSITIVE)
        except QuantityError as fault:
            raise QuantityError(self.expected(), fault.found) from None
        if exponent is None:
            return number
        found = PowerStiffness(number)
        found.exponent = exponent
        return found

    def expected(self) -> str:
        """Return what messages expect."""
        return "a stiffness > 0 (N/m^n, or with a unit such as N/m^1.5)"

    def json_schema(self) -> dict[str, Any]:
        """Return a positive number, or text that begins with arithmetic."""
        return {"type": ["number", "string"], "exclusiveMinimum": 0, "pattern": ARITHMETIC}


ContactStiffness = Annotated[float, _Rule()]


def exponent_of(stiffness: float | None) -> float | None:
    """The exponent n that the unit of a stiffness says; None if no unit was written."""
    return stiffness.exponent if isinstance(stiffness, PowerStiffness) else None


def stiffness_unit(exponent: float) -> str:
    """The SI unit of a stiffness."""
    return "N/m" if exponent == 1.0 else f"N/m^{exponent:g}"


def _dimension(exponent: float) -> Dimension:
    return Dimension("stiffness", stiffness_unit(exponent))


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
