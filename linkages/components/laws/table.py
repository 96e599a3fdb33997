"""A law of time given by values at some times."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, ClassVar, Generic

from pydantic import field_validator, model_validator

from linkages.components.contributed.component import component
from linkages.components.contributed.functions import Table
from linkages.components.contributed.interpolation import Interpolation, extremes
from linkages.components.contributed.terms import Path
from linkages.components.laws.named import NamedLaw, Value
from linkages.spec.quantities import Instant, Text


@component
class Points(Generic[Value]):
    """Values at given times, and what joins them.

    Parameters
    ----------
    times
        Seconds, increasing, at least three (two for straight lines).
    values
        One for each time.
    periodic
        Whether the law repeats; the first and the last value are then equal.
    interpolation
        ``linear``, ``pchip`` or ``spline``; pchip for loads and spline for drives if not given.
    file
        A CSV file in the folder of the definition file, in the place of times and values.
    columns
        Its columns with times and values: their names, or their numbers from 1; the first two if
        not given.
    units
        Units of both columns; SI if not given.
    """

    times: tuple[Instant, ...] = ()
    values: tuple[Value, ...] = ()
    periodic: bool = False
    interpolation: Interpolation | None = None
    file: Text | None = None
    columns: tuple[Text, Text] | None = None
    units: tuple[Text, Text] | None = None

    @model_validator(mode="after")
    def _fits(self) -> Any:
        if self.file is not None:
            raise ValueError(
                "files are read with a definition file only, in its folder; expected 'times' and "
                "'values'"
            )
        given = {"times": self.times, "values": self.values}
        missing = [key for key, numbers in given.items() if not numbers]
        if missing or self.columns or self.units:
            key = "file" if self.columns or self.units else missing[0]
            raise ValueError(f"missing key {key!r}: expected 'times' and 'values', or 'file'")
        least = "two" if self.interpolation == "linear" else "three"
        if len(self.times) < {"two": 2, "three": 3}[least]:
            raise ValueError(f"expected at least {least} times, found {len(self.times)}")
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


class _TableLaw(NamedLaw, Generic[Value]):
    """What loads and drives have in common; each says what joins its points unasked."""

    usual: ClassVar[Interpolation]
    held: ClassVar[bool]
    table: Points[Value]

    def function(self, path: Path) -> Table:
        """Polynomials, whose coefficients are arguments of the kernel."""
        values: Any = self.table.values
        interpolation = self.table.interpolation or self.usual
        periodic, held = self.table.periodic, self.held
        return Table((*path, "table"), self.table.times, values, periodic, interpolation, held)

    @field_validator("table")
    @classmethod
    def _bounded(cls, table: Points[Any]) -> Points[Any]:
        interpolation = table.interpolation or cls.usual
        found = Table((), table.times, table.values, table.periodic, interpolation, cls.held)
        if not all(map(math.isfinite, extremes(found, *table.times[:: len(table.times) - 1]))):
            raise ValueError(
                f"the polynomials between these values ({interpolation}) overflow; expected "
                "smaller values, or times that are further apart"
            )
        return table


@component
class LoadTable(_TableLaw[Value], Generic[Value]):
    """A load given by values at some times; outside them it keeps the first and the last."""

    usual: ClassVar[Interpolation] = "pchip"
    held: ClassVar[bool] = True

    table: Points[Value]


@component
class DriveTable(_TableLaw[Value], Generic[Value]):
    """A motion given by values at some times; outside them its speed stays what it is there."""

    usual: ClassVar[Interpolation] = "spline"
    held: ClassVar[bool] = False

    table: Points[Value]

    @field_validator("table")
    @classmethod
    def _smooth(cls, table: Points[Any]) -> Points[Any]:
        if table.interpolation == "linear":
            raise ValueError(
                "straight lines make the speed of a drive jump, which takes infinite forces; "
                "expected interpolation 'spline', or 'pchip', whose acceleration jumps"
            )
        return table
