"""The types of fields that are a quantity or a law, and of what tables are functions of."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import isfinite
from typing import Any, get_origin

from pydantic import TypeAdapter

from linkages.reading.wording import listed, nearest, shown
from linkages.spec.conversion import QuantityError, parse_quantity
from linkages.spec.dimensions import Bound, Dimension
from linkages.spec.formulas import Constant, Formula, formula
from linkages.spec.grammar import NumberError
from linkages.spec.quantities import ARITHMETIC, LIMITS, FieldType
from linkages.spec.tolerance_zones import has_tolerance, nominal_of, nominal_text, zone_of
from linkages.spec.units import UnitError

# A text with the time, a call or a quantity in it is a formula, whatever else is wrong with it.
_FORMULA = re.compile(r"\bt\b|[^\W\d]\w*[ \t]*\(|[^\W\d]\w*[ \t]*\.[ \t]*[^\W\d]|['\"]")
# A formula begins as arithmetic does, or with t, the name of a function or of the mechanism.
_BEGINNING = r"^[-+−(\s]*(\.?[0-9]|['\"A-Za-z]|[^\x00-\x7f])"


@dataclass(frozen=True)
class LawRule(FieldType):
    """A quantity of a dimension, a formula, or a named law.

    Parameters
    ----------
    dimension
        What the law gives.
    named
        Pairs of the key that tells a named law and its model.
    refused
        Why the law may not depend on quantities of the mechanism; empty where it may.
    bound
        Limit of a number that is no law.
    """

    dimension: Dimension
    named: tuple[tuple[str, Any], ...] = ()
    refused: str = ""
    bound: Bound = Bound.NONE

    @property
    def models(self) -> tuple[Any, ...]:
        """The models of the named laws."""
        return tuple(model for _, model in self.named)

    def read(self, value: Any) -> Any:
        """Return a number in SI, a `Formula`, or a named law.

        A law that has been read is returned as it is.
        """
        known = tuple(get_origin(model) or model for model in self.models)
        if isinstance(value, (Formula, *known)):
            return value
        if isinstance(value, dict):
            return self._named(value)
        try:
            nominal = nominal_of(value, self.dimension, self.bound)
            return parse_quantity(nominal, self.dimension, self.bound)
        except QuantityError as fault:
            found = fault.found
        if not isinstance(value, str):
            raise QuantityError(self.expected(), found)
        if has_tolerance(value):
            raise QuantityError(self.expected(), found)
        try:
            read = formula(value, self.refused)
        except NumberError as why:
            if _FORMULA.search(value):
                found = f"{shown(value)}: {why}"
            raise QuantityError(self.expected(), found) from None
        if isinstance(read.tree, Constant) and not _FORMULA.search(value):
            raise QuantityError(self.expected(), found)
        return read

    def _named(self, value: dict[str, Any]) -> Any:
        models = dict(self.named)
        keys = [key for key in value if key in models]
        if len(keys) == 1:
            # A ValidationError from here keeps its places: pydantic adds where this field is.
            return TypeAdapter(models[keys[0]]).validate_python(value)
        if keys:
            found = f"a mapping with {listed(map(repr, keys), 'and')}"
            raise QuantityError(self.expected(), f"{found}; expected one of them")
        near = [(key, word) for key in value if (word := nearest(str(key), models))]
        hint = f" with {near[0][0]!r}; did you mean {near[0][1]!r}?" if near else " of other keys"
        raise QuantityError(self.expected(), f"a mapping{hint}")

    def expected(self) -> str:
        """Return for example ``"a force (…), a formula of t, or a law (harmonic, rise)"``."""
        quantity = self.dimension.expected(self.bound)
        laws = f", or a law ({listed(dict(self.named))})" if self.named else ""
        state = "" if self.refused else ", crank.angle and the like"
        return f"{quantity}, a formula of t{state}{laws}"

    def json_schema(self) -> dict[str, Any]:
        """Return a number, text that begins with arithmetic or a formula, or a mapping."""
        kinds = ["number", "string", *(["object"] if self.named else [])]
        return {"type": kinds, **LIMITS[self.bound], "pattern": _BEGINNING}


@dataclass(frozen=True)
class ArgumentRule(FieldType):
    """What a table is a function of: a quantity of the mechanism, or a formula of some.

    Parameters
    ----------
    constant
        Whether it may be a number as well.
    """

    constant: bool = False

    def read(self, value: Any) -> Any:
        """Return a `Formula`; one that has been read is returned as it is."""
        if isinstance(value, Formula):
            return value
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if number and self.constant and isfinite(value):
            return Formula(repr(value), Constant(float(value)))
        if not isinstance(value, str):
            raise QuantityError(self.expected(), shown(value))
        try:
            read = formula(value)
        except NumberError as why:
            raise QuantityError(self.expected(), f"{shown(value)}: {why}") from None
        if isinstance(read.tree, Constant) and not self.constant:
            raise QuantityError(self.expected(), shown(value))
        return read

    def expected(self) -> str:
        """Return what messages expect."""
        number = "a number, " if self.constant else ""
        return f"{number}a quantity such as crank.angle or piston.position, or a formula of some"

    def json_schema(self) -> dict[str, Any]:
        """Return text, and a number where there may be one."""
        kinds = ["number", "string"] if self.constant else "string"
        return {"type": kinds, "pattern": _BEGINNING}


@dataclass(frozen=True)
class PlaceRule(FieldType):
    """A place on the axis of such a quantity, with a unit of it or in SI."""

    def read(self, value: Any) -> Any:
        """Return a `Constant`; one that has been read is returned as it is."""
        if isinstance(value, Constant):
            return value
        if isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value):
            return Constant(float(value))
        try:
            read = formula(nominal_text(value)).tree if isinstance(value, str) else None
            zone_of(str(value))
        except (NumberError, UnitError) as why:
            raise QuantityError(self.expected(), f"{shown(value)}: {why}") from None
        if not isinstance(read, Constant):
            raise QuantityError(self.expected(), shown(value))
        return read

    def expected(self) -> str:
        """Return what messages expect."""
        return "a number (in SI, or with a unit)"

    def json_schema(self) -> dict[str, Any]:
        """Return a number, or text that begins with arithmetic."""
        return {"type": ["number", "string"], "pattern": ARITHMETIC}
