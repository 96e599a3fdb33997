"""A law of time given by values at some times."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, Generic

from pydantic import model_validator

from linkages.components.component import component
from linkages.components.functions import Function, Table
from linkages.components.laws.named import NamedLaw, Value
from linkages.components.terms import Path
from linkages.spec.quantities import Instant


@component
class Points(Generic[Value]):
    """Values at given times, joined by a cubic spline with a continuous second derivative.

    Parameters
    ----------
    times
        Seconds, increasing, at least three.
    values
        One for each time.
    periodic
        Whether the law repeats; the first and the last value are then equal. Otherwise it goes on
        in straight lines.
    """

    times: tuple[Instant, ...]
    values: tuple[Value, ...]
    periodic: bool = False

    @model_validator(mode="after")
    def _fits(self) -> Any:
        if len(self.times) < 3:
            raise ValueError(f"expected at least three times, found {len(self.times)}")
        if len(self.times) != len(self.values):
            counts = f"{len(self.times)} times and {len(self.values)} values"
            raise ValueError(f"expected as many values as times, found {counts}")
        for before, after in pairwise(self.times):
            if after <= before:
                raise ValueError(f"expected increasing times, found {after:g} after {before:g}")
        first, last = self.values[0], self.values[-1]
        if self.periodic and first != last:
            expected = "expected the same first and last value of a periodic table"
            raise ValueError(f"{expected}, found {first:g} and {last:g}")
        return self


@component
class TableLaw(NamedLaw, Generic[Value]):
    """A law given by values at some times; see `Points`."""

    table: Points[Value]

    def function(self, path: Path) -> Function:
        """One spline."""
        values: Any = self.table.values
        return Table((*path, "table"), self.table.times, values, self.table.periodic)
