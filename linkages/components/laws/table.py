"""A law given by values at some times, or at some places of any other quantity."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Generic

from pydantic import field_validator, model_validator

from linkages.components.contributed.component import component
from linkages.components.contributed.functions import TIME, Table
from linkages.components.contributed.interpolation import Interpolation, extremes
from linkages.components.contributed.terms import Path
from linkages.components.laws.formula import translated
from linkages.components.laws.named import REFUSED, NamedLaw, Value
from linkages.spec.formulas import Constant, Formula
from linkages.spec.laws import ArgumentRule, PlaceRule
from linkages.spec.quantities import Instant, Text

WHOLE = 1e-9
"""Difference from a whole number of periods in a turn that rounding of units explains."""


@component
class TablePoints(Generic[Value]):
    """Values at given times, or over any other quantity, and what joins them.

    Parameters
    ----------
    times
        Seconds, increasing, at least three (two for straight lines).
    values
        One for each time or place.
    over
        What the table is a function of if it is not time: ``crank.angle``, or a formula.
    at
        Places on the axis of `over`, in the place of times.
    periodic
        Whether the law repeats; the first and the last value are then equal.
    interpolation
        ``linear``, ``pchip`` or ``spline``; pchip for loads and spline for drives if not given.
    file
        A CSV file in the folder of the definition file, in the place of times (or places) and
        values.
    columns
        Its columns with times (or places) and values: their names, or their numbers from 1; the
        first two if not given.
    units
        Units of both columns; SI if not given.
    """

    times: tuple[Instant, ...] = ()
    values: tuple[Value, ...] = ()
    over: Annotated[Formula, ArgumentRule()] | None = None
    at: tuple[Annotated[Constant, PlaceRule()], ...] = ()
    periodic: bool = False
    interpolation: Interpolation | None = None
    file: Text | None = None
    columns: tuple[Text, Text] | None = None
    units: tuple[Text, Text] | None = None

    @property
    def places(self) -> tuple[float, ...]:
        """Times, or places over any other quantity, in SI."""
        return self.times if self.over is None else tuple(place.value for place in self.at)

    @property
    def turning(self) -> bool:
        """Whether a turn of an angle, which it is a function of, is a whole number of periods."""
        periods = 2 * math.pi / (self.places[-1] - self.places[0])
        return self.over is not None and self.periodic and abs(periods - round(periods)) < WHOLE

    @model_validator(mode="after")
    def _fits(self) -> Any:
        keys = ("times", "values") if self.over is None else ("at", "values")
        expected = f"{keys[0]!r} and 'values'"
        if self.file is not None:
            raise ValueError(
                f"files are read with a definition file only, in its folder; expected {expected}"
            )
        other, of = ("at", "time") if self.over is None else ("times", "'over'")
        if getattr(self, other):
            hint = "; 'over' says what of" if self.over is None else ""
            raise ValueError(f"{other!r} is given for a table of {of}; expected {keys[0]!r}{hint}")
        missing = [key for key in keys if not getattr(self, key)]
        if missing or self.columns or self.units:
            key = "file" if self.columns or self.units else missing[0]
            raise ValueError(f"missing key {key!r}: expected {expected}, or 'file'")
        self._require_pairs("times" if self.over is None else "places")
        first, last = self.values[0], self.values[-1]
        if self.periodic and first != last:
            expected = "expected the same first and last value of a periodic table"
            raise ValueError(f"{expected}, found {first:g} and {last:g}")
        return self

    def _require_pairs(self, what: str) -> None:
        """Increasing places, enough of them, and a value for each."""
        count, values = len(self.places), len(self.values)
        least = "two" if self.interpolation == "linear" else "three"
        if count < {"two": 2, "three": 3}[least]:
            raise ValueError(f"expected at least {least} {what}, found {count}")
        if count != values:
            counts = f"{count} {what} and {values} values"
            raise ValueError(f"expected as many values as {what}, found {counts}")
        for before, after in pairwise(self.places):
            if after <= before:
                raise ValueError(f"expected increasing {what}, found {after:g} after {before:g}")


class _TableLaw(NamedLaw, Generic[Value]):
    """What loads and drives have in common; each says what joins its points unasked."""

    usual: ClassVar[Interpolation]
    held: ClassVar[bool]
    table: TablePoints[Value]

    def function(self, path: Path) -> Table:
        """Polynomials, whose coefficients are arguments of the kernel."""
        path, own = (*path, "table"), self.table
        values: Any = own.values
        over = TIME if own.over is None else translated(own.over, (*path, "over"))
        return Table(
            path, own.places, values, own.periodic, own.interpolation or self.usual, self.held,
            over, own.turning,
        )  # fmt: skip

    @field_validator("table")
    @classmethod
    def _bounded(cls, table: TablePoints[Any]) -> TablePoints[Any]:
        interpolation = table.interpolation or cls.usual
        places = table.places
        found = Table((), places, table.values, table.periodic, interpolation, cls.held)
        if not all(map(math.isfinite, extremes(found, *places[:: len(places) - 1]))):
            raise ValueError(
                f"the polynomials between these values ({interpolation}) overflow; expected "
                f"smaller values, or {'times' if table.over is None else 'places'} that are "
                "further apart"
            )
        return table


@component
class LoadTable(_TableLaw[Value], Generic[Value]):
    """A load given by values at some times or places; outside it keeps the first and the last."""

    usual: ClassVar[Interpolation] = "pchip"
    held: ClassVar[bool] = True

    table: TablePoints[Value]


@component
class DriveTable(_TableLaw[Value], Generic[Value]):
    """A motion given by values at some times; outside them its speed stays what it is there."""

    usual: ClassVar[Interpolation] = "spline"
    held: ClassVar[bool] = False

    table: TablePoints[Value]

    @field_validator("table")
    @classmethod
    def _smooth(cls, table: TablePoints[Any]) -> TablePoints[Any]:
        if table.over is not None:
            raise ValueError(f"'over' is refused: {REFUSED}")
        if table.interpolation == "linear":
            raise ValueError(
                "straight lines make the speed of a drive jump, which takes infinite forces; "
                "expected interpolation 'spline', or 'pchip', whose acceleration jumps"
            )
        return table
