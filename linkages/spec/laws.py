"""The type of fields that are a quantity or a law of time."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, get_origin

from pydantic import TypeAdapter

from linkages.reading.wording import listed, nearest
from linkages.spec.conversion import QuantityError, parse_quantity
from linkages.spec.dimensions import Bound, Dimension
from linkages.spec.formulas import Formula, formula
from linkages.spec.grammar import NumberError
from linkages.spec.quantities import FieldType

# A text with the time or a call in it is a formula, whatever else is wrong with it.
_FORMULA = re.compile(r"\bt\b|[^\W\d]\w*[ \t]*\(")
# A formula begins as arithmetic does, or with t or the name of a function.
_BEGINNING = r"^[-+−(\s]*(\.?[0-9]|π|[A-Za-z])"


@dataclass(frozen=True)
class LawRule(FieldType):
    """A quantity of a dimension, a formula of time in SI units, or a named law.

    Parameters
    ----------
    dimension
        What the law gives.
    named
        Pairs of the key that tells a named law and its model.
    """

    dimension: Dimension
    named: tuple[tuple[str, Any], ...] = ()

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
            return parse_quantity(value, self.dimension)
        except QuantityError as fault:
            if not isinstance(value, str) or not _FORMULA.search(value):
                raise QuantityError(self.expected(), fault.found) from None
            found = fault.found.split(": ")[0]
        try:
            return formula(value)
        except NumberError as fault:
            raise QuantityError(self.expected(), f"{found}: {fault}") from None

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
        quantity = self.dimension.expected(Bound.NONE)
        laws = f", or a law ({listed(dict(self.named))})" if self.named else ""
        return f"{quantity}, a formula of t{laws}"

    def json_schema(self) -> dict[str, Any]:
        """Return a number, text that begins with arithmetic or a formula, or a mapping."""
        kinds = ["number", "string", *(["object"] if self.named else [])]
        return {"type": kinds, "pattern": _BEGINNING}
