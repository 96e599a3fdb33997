"""Measurements: times, outputs and their uncertainties."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError, Problem
from linkages.kernel.system import System
from linkages.reading.document import csv_rows, decode
from linkages.solution.measure_names import measure_unit
from linkages.spec.measures import read_measure
from linkages.spec.units import UnitError, unit

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

Measurements: TypeAlias = str | Path | Mapping[str, Any]
"""A CSV file, or its columns: head → numbers."""

_HEAD = re.compile(
    r"\s*(?:(sigma|weight)\s+)?(.*?)\s*(?:\(([^()]*)\)|\[([^\[\]]*)\])?\s*", re.DOTALL
)
_TIME = ("t", "time")
HEADS = "'time (s)', 'crank.angle (deg)', 'sigma crank.angle (deg)'"


@dataclass(frozen=True)
class Column:
    """What was measured of a series."""

    series: str  # text of what changes with time, as in measures
    unit: str  # in which it was measured; empty for SI
    si: str  # its unit in SI
    values: Floats  # in SI, nan where nothing was measured
    sigma: Floats  # standard deviations in SI, of the same shape


@dataclass(frozen=True)
class Measured:
    """What was measured."""

    time: Floats  # in seconds, increasing, shape (times,)
    columns: tuple[Column, ...]  # of outputs
    absolute: bool  # whether standard deviations are known; else they are known up to a factor

    @property
    def count(self) -> int:
        """Number of values that were measured."""
        return int(sum(np.isfinite(column.values).sum() for column in self.columns))


MAX_BYTES = 100 * 1024**2
"""Of a file of measurements: each number takes a few times as much when it is fitted to."""


class _RefusedError(Exception):
    pass


def measured_of(
    mechanism: Mechanism, given: Measurements | Measured, sigma: Mapping[str, Any] | None
) -> Measured:
    """Measurements of outputs of a mechanism; `sigma` has a standard deviation per series."""
    if isinstance(given, Measured):
        return given
    source = "measured" if isinstance(given, Mapping) else str(given)
    columns = given if isinstance(given, Mapping) else _read(Path(given))
    try:
        return _measured(mechanism, columns, sigma or {})
    except (_RefusedError, UnitError, ValueError) as error:
        raise InputError(source, [Problem(message=str(error))]) from None


def _measured(mechanism: Mechanism, given: Mapping[str, Any], sigma: Mapping[str, Any]) -> Measured:
    result: dict[tuple[str, str], tuple[Floats, str]] = {}
    for head, numbers in given.items():
        kind, name, *units = (_HEAD.fullmatch(str(head)) or _no_head(head)).groups()
        place = (kind or "", "time" if name in _TIME else name)
        if place in result:
            raise _RefusedError(f"column {head!r} is there twice")
        result[place] = np.asarray(numbers, dtype=float).ravel(), units[0] or units[1] or ""
    if ("", "time") not in result:
        raise _RefusedError(f"found no column of times; expected heads such as {HEADS}")
    time, unit_ = result.pop(("", "time"))
    time = np.array([unit(unit_).convert(value) if unit_ else value for value in time])
    if len(time) < 2 or not (np.diff(time) > 0).all() or not time[0] >= 0:
        raise _RefusedError("expected times from 0 on, each later than the one before")
    names = [name for kind, name in result if not kind]
    if not names:
        raise _RefusedError(f"found no column of an output; expected heads such as {HEADS}")
    alone = [name for kind, name in result if kind and name not in names]
    alone += [name for name in sigma if name not in names]
    if alone:
        raise _RefusedError(f"{alone[0]} was not measured; expected one of: {', '.join(names)}")
    system = System(mechanism)
    columns = tuple(_column(system, name, result, sigma, len(time)) for name in names)
    known = [("sigma", name) in result or name in sigma for name in names]
    if any(known) and not all(known):
        raise _RefusedError(
            f"expected a standard deviation of {names[known.index(False)]} as of the others"
        )
    if not any(known) and len({column.si for column in columns}) > 1:
        raise _RefusedError(
            "outputs in different units cannot be weighed against each other; expected columns "
            f"such as 'sigma {names[0]}', or a standard deviation of each"
        )
    return Measured(time, columns, all(known))


def _no_head(head: object) -> Any:
    raise _RefusedError(f"expected heads such as {HEADS}, found {head!r}")


def _column(
    system: System,
    name: str,
    found: Mapping[tuple[str, str], tuple[Floats, str]],
    sigma: Mapping[str, Any],
    count: int,
) -> Column:
    measure = read_measure(f"final({name})")
    si = measure_unit(system, measure)
    values, own = found["", name]
    spread = np.ones(count)
    if ("sigma", name) in found:
        spread = _in_si(name, *found["sigma", name], si)
    elif name in sigma:
        number, unit_ = _number(sigma[name])
        spread = np.full(count, _in_si(name, np.array([number]), unit_, si)[0])
    if ("weight", name) in found:
        with np.errstate(divide="ignore", invalid="ignore"):
            spread = spread / np.sqrt(found["weight", name][0])
    values = _in_si(name, values, own, si)
    if not len(values) == len(spread) == count:
        raise _RefusedError(f"{name}: expected as many numbers as times, {count}")
    if not (spread[np.isfinite(values)] > 0).all():
        raise _RefusedError(f"{name}: expected standard deviations and weights above zero")
    return Column(name, own, si, np.where(np.isfinite(spread), values, np.nan), spread)


def _number(given: Any) -> tuple[float, str]:
    from linkages.spec.grammar import leading_number

    return leading_number(given) if isinstance(given, str) else (float(given), "")


def _in_si(name: str, values: Floats, text: str, si: str) -> Floats:
    if not text:
        return values
    result = unit(text)
    if result.exponents != (unit(si).exponents if si not in ("", "1") else ()):
        raise _RefusedError(f"{name} is in {si or 'no unit'}, found {text!r}")
    return np.array([result.convert(value) for value in values])


def _read(path: Path) -> dict[str, list[float]]:
    """Columns of a CSV file; an empty cell is nan."""
    source = str(path)
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        message = f"cannot be read: {error.strerror or error}"
        raise InputError(source, [Problem(message=message)]) from None
    if len(data) > MAX_BYTES:
        message = f"larger than {MAX_BYTES // 1024**2} MiB; expected measurements as CSV"
        raise InputError(source, [Problem(message=message)])
    rows = csv_rows(decode(data, source), source)
    if len(rows) < 2:
        raise InputError(source, [Problem(message=f"expected a line of heads such as {HEADS}")])
    heads = [cell.strip() for cell in rows[0][1]]
    columns: dict[str, list[float]] = {head: [] for head in heads}
    problems = []
    if len(columns) < len(heads):
        problems.append(
            Problem(message="two columns have the same head", line=rows[0][0], column=1)
        )
    for number, cells in rows[1:]:
        if len(cells) != len(heads):
            message = f"expected {len(heads)} cells, found {len(cells)}"
            problems.append(Problem(message=message, line=number, column=1))
            continue
        problems += _take(columns, heads, number, cells)
    if problems:
        raise InputError(source, problems)
    return columns


def _take(
    columns: dict[str, list[float]], heads: Sequence[str], line: int, cells: Sequence[str]
) -> list[Problem]:
    """Enter a line; returns what is wrong with it."""
    problems = []
    for place, (head, cell) in enumerate(zip(heads, cells, strict=True), 1):
        try:
            columns[head].append(float(cell) if cell.strip() else float("nan"))
        except ValueError:
            message = f"{head}: expected a number, found {cell.strip()!r}"
            problems.append(Problem(message=message, line=line, column=place))
    return problems


def measurements_in(results: xr.Dataset) -> Measured:
    """The measurements of a fit, as its results store them."""
    expected: dict[str, tuple[tuple[str, ...], str]] = {
        "series": (("series",), "OU"),
        "series_units": (("series",), "OU"),
        "time": (("time",), "f"),
        "measured": (("series", "time"), "f"),
        "sigma": (("series", "time"), "f"),
    }
    for name, (dims, kinds) in expected.items():
        result = results.variables.get(name)
        if (
            result is None
            or result.dims != dims
            or result.dtype.kind not in kinds
            or not result.size
        ):
            raise _damaged(results, f"{name!r} is missing or damaged")
    time, sigma = results["time"].to_numpy(), results["sigma"].to_numpy()
    if not (np.isfinite(time).all() and (np.diff(time) > 0).all()):
        raise _damaged(results, "times do not increase")
    if not (sigma > 0).all():
        raise _damaged(results, "standard deviations are not above zero")
    texts: Any = zip(results["series"].to_numpy(), results["series_units"].to_numpy(), strict=True)
    columns = tuple(
        Column(str(name), "", str(unit), results["measured"][k].values, results["sigma"][k].values)
        for k, (name, unit) in enumerate(texts)
    )
    known = bool(results.attrs.get("sigma_known", False))
    return Measured(time, columns, known)


def _damaged(results: xr.Dataset, what: str) -> InputError:
    message = f"expected the measurements of a fit; {what}"
    return InputError(str(results.encoding.get("source", "results")), [Problem(message=message)])
