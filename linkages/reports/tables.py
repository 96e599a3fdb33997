"""Tables of a run in user units: CSV and XLSX."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.reading.output_files import replaced
from linkages.reading.wording import listed
from linkages.reports.report import Table, headed, rounded
from linkages.solution.files import DEFINITION, origin_of, save_columns, series_of
from linkages.solution.series import LabelledArrays
from linkages.solution.solution import Solution
from linkages.spec.units import Unit, UnitError, unit

if TYPE_CHECKING:
    import xarray as xr

_NAME = re.compile(r"[^\W\d]+")


@dataclass(frozen=True)
class Wanted:
    """Units in which a table is written, one per dimension.

    ``mm`` replaces the metre in all units (``mm/s``, ``N mm``), ``rpm`` rad/s alone. Raises
    ValueError for what is no unit, and for two units of one dimension.
    """

    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        seen: dict[tuple[tuple[str, float], ...], str] = {}
        for name in self.names:
            try:
                result = unit(name)
            except UnitError as error:
                raise ValueError(f"units: {error}") from None
            if before := seen.get(result.exponents):
                raise ValueError(f"units: {before!r} and {name!r} measure the same")
            seen[result.exponents] = name

    def of(self, si: str) -> tuple[str, float]:
        """The unit that is written for one of SI, and the factor from SI to it."""
        if si in ("", "1"):
            return si, 1.0
        own = unit(si)
        whole = self._like(own)
        name = whole or _NAME.sub(lambda found: self._like(unit(found[0])) or found[0], si)
        return name, 1.0 if name == si else own.scale / unit(name).scale

    def chosen(self, si: str) -> tuple[str, float] | None:
        """As `of`; None if no part of the unit is among those that are wanted."""
        spelt = si.translate({ord("·"): " ", ord("²"): "^2", ord("³"): "^3"})
        parts = () if spelt in ("", "1") else (spelt, *_NAME.findall(spelt))
        return self.of(spelt) if any(self._like(unit(part)) for part in parts) else None

    def check(self, known: Iterable[str]) -> None:
        """Refuse units that none of the columns has; the ValueError names those that are there."""
        there = [text for text in dict.fromkeys(known) if text not in ("", "1")]
        parts = {part for text in there for part in (text, *_NAME.findall(text))}
        measured = {unit(part).exponents for part in parts}
        for name in self.names:
            if unit(name).exponents not in measured:
                raise ValueError(f"units: no output is measured in {name!r}; found {listed(there)}")

    def _like(self, si: Unit) -> str | None:
        return next((name for name in self.names if unit(name).exponents == si.exponents), None)


SI = Wanted()


def wanted(names: Sequence[str] | str) -> Wanted:
    """Units from a list, or from a text with commas."""
    parts = names.split(",") if isinstance(names, str) else names
    return Wanted(tuple(part.strip() for part in parts))


def require_table(ending: str, units: Sequence[str] | str) -> None:
    """Refuse units that are none, and a workbook without its library: before a run, not after."""
    wanted(units or ())
    if ending == "xlsx":
        _workbooks()


def _workbooks() -> Any:
    """The library that writes workbooks."""
    try:
        import xlsxwriter
    except ImportError:
        message = "XLSX needs XlsxWriter, which is not installed: pip install 'linkages[xlsx]'"
        raise ImportError(message) from None
    return xlsxwriter


MOST_ROWS = 1_048_576
"""Of a sheet, its head among them."""

Columns = dict[str, NDArray[np.float64]]


def save_table(
    solution: Solution,
    path: str | Path,
    units: Sequence[str] | str = (),
    measures: Sequence[str] = (),
    curves: Sequence[str] = (),
) -> Path:
    """Write all series of a run as a table, a row for each sample.

    Parameters
    ----------
    solution
        Of `linkages.simulate`.
    path
        Ends in ``.csv`` or ``.xlsx``. The latter has sheets with measures, largest values, loads
        of pins and guides, options and the definition besides, and needs XlsxWriter:
        ``pip install 'linkages[xlsx]'``.
    units
        Units to use instead of SI, such as ``("mm", "deg", "rpm")``: they stand in the heads.
    measures
        Numbers of the motion for the workbook, such as ``"max(abs(crank.effort))"``.
    curves
        Series for a sheet of the workbook, such as ``"K.reaction"``, as reports draw them.

    Raises
    ------
    ValueError
        For another ending, for units that no series has, for unknown series, and for more rows
        than a sheet holds.
    ImportError
        If XlsxWriter is not installed.

    Examples
    --------
    >>> import linkages, tempfile
    >>> solution = linkages.simulate(linkages.load("slider-crank"), outputs=["slider_position"])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = linkages.save_table(solution, f"{folder}/run.csv", units=["mm", "ms"])
    ...     print(path.read_text().splitlines()[0])
    time (ms),slider_position[piston] (mm)
    """
    file, chosen = Path(path), wanted(units) if units else SI
    columns = columns_of(solution.data, chosen)
    if file.suffix == ".csv":
        save_columns(columns, file)
    elif file.suffix == ".xlsx":
        drawn = _curves(solution, curves, chosen) if curves else {}
        _write_workbook(file, solution, columns, chosen, measures, drawn)
    else:
        raise ValueError(f"path must end in .csv or .xlsx, found {file.name!r}")
    return file


def columns_of(data: xr.Dataset, units: Wanted) -> Columns:
    """Head → values of each series, in the units that are wanted; time first."""
    result = [*series_of(LabelledArrays.of(data))]
    units.check(own for _, own, _ in result)
    columns: Columns = {}
    for head, own, values in result:
        name, factor = units.of(own)
        columns[f"{head} ({name})"] = values if factor == 1.0 else values * factor
    return columns


def _curves(solution: Solution, names: Sequence[str], units: Wanted) -> Columns:
    """Head → values of the series that reports draw, at the times at which they draw them."""
    from linkages.plots.motion.compared import compared

    drawn = compared({"": solution}, names).curves
    columns = {}
    for name, own, values in [
        ("time", "s", drawn[0].time),
        *((name, curve.units, curve.y) for name, curve in zip(names, drawn, strict=True)),
    ]:
        unit_name, factor = units.of(own)
        columns[headed(name, unit_name)] = values * factor
    return columns


def rows_of_maxima(solution: Solution, units: Wanted) -> list[list[Any]]:
    """Rows of least and largest values: quantity, element, both with their times, the units."""
    clock, factor_of_time = units.of("s")
    rows: list[list[Any]] = []
    for row in solution.maxima:
        name, factor = units.of(row["units"])
        ends = [
            number
            for end in ("least", "greatest")
            for number in (row[end] * factor, row[f"{end}_time"] * factor_of_time)
        ]
        rows.append([row["long_name"], row["element"], *ends, name, clock])
    return rows


MEASURES = ["measure", "value", "unit"]


def rows_of_measures(
    solution: Solution, texts: Sequence[str], units: Wanted
) -> list[tuple[str, float | str, str]]:
    """Rows of measures: text, value or why there is none, and the unit."""
    from linkages.solution.measuring import measured_rows

    rows: list[tuple[str, float | str, str]] = []
    for row in measured_rows(solution, texts):
        name, factor = units.of(row["units"])
        value = row["reason"] if row["value"] is None else row["value"] * factor
        rows.append((row["measure"], value, name))
    return rows


LOADS = ("pin_reaction", "joint_reaction", "guide_reaction", "guide_moment", "clearance_force")
"""Outputs with the forces that size pins, bearings and guides."""

LOAD_HEADS = ["load", "of", "largest", "at t (s)", "unit"]


def rows_of_loads(solution: Solution, units: Wanted) -> list[list[Any]]:
    """Rows of the largest loads of pins, guides and clearances, with their times and units.

    A pin of several bodies has the force on each of them, which `joint_reaction` has not.
    """
    rows = [row for name in LOADS for row in solution.maxima if row["variable"] == name]
    pins = {row["element"] for row in rows if row["variable"] == "pin_reaction"}
    result: list[list[Any]] = []
    for row in rows:
        if row["value"] and (row["variable"] != "joint_reaction" or row["element"] not in pins):
            name, factor = units.of(row["units"])
            value = abs(row["value"]) * factor
            result.append([row["long_name"], row["element"], value, row["time"], name])
    return result


ENDS = ["quantity", "of", "least", "at t (s)", "largest", "at t (s)", "unit"]
"""Heads of a table of least and largest values."""

LATE, OPEN = "*", "~"
"""Marks of values beyond the horizon, and of those that samples may miss."""

RESOLVED = 1e-3
"""Part of a value that may be missing before it is marked."""


def is_late(time: float, until: float | None) -> bool:
    """Whether a time is beyond that until which a motion is predictable, if there is such."""
    return until is not None and abs(time) > abs(until)


def marked_ends(row: Mapping[str, Any], until: float | None, factor: float = 1.0) -> list[str]:
    """Least and greatest value of a row of maxima with their marks, each followed by its time."""
    cells = []
    for end in ("least", "greatest"):
        time = row[f"{end}_time"]
        late = LATE if is_late(time, until) else ""
        missed = OPEN if row["missed"] > RESOLVED else ""
        cells += [f"{rounded(row[end] * factor)}{late}{missed}", rounded(time)]
    return cells


def _write_workbook(
    path: Path,
    solution: Solution,
    columns: Columns,
    units: Wanted,
    measures: Sequence[str],
    curves: Columns,
) -> None:
    xlsxwriter = _workbooks()
    sheets = {"series": columns} | ({"curves": curves} if curves else {})
    count = max(len(values) for sheet in sheets.values() for values in sheet.values())
    if count + 1 > MOST_ROWS:
        raise ValueError(f"a sheet has {MOST_ROWS} rows at most, found {count} samples; write CSV")
    origin = origin_of(solution.mechanism, solution.options)
    about: list[list[str]] = [
        ["mechanism", solution.mechanism.name],
        *(["differs from its file", text] for text in solution.mechanism.changes),
        *([name, str(value)] for name, value in json.loads(origin["options"]).items()),
        ["computed by", origin["version"]],
        ["libraries", origin["libraries"]],
        *(["note", note] for note in solution.notes),
    ]
    heads = ["quantity", "of", "least", "at", "largest", "at", "unit", "unit of time"]
    measured = rows_of_measures(solution, measures, units)
    loads = rows_of_loads(solution, units)
    with replaced(path) as temporary:
        plain = {"strings_to_formulas": False, "strings_to_urls": False, "nan_inf_to_errors": True}
        with xlsxwriter.Workbook(temporary, plain) as book:
            bold = book.add_format({"bold": True, "text_wrap": True, "valign": "top"})
            for name, own in sheets.items():
                sheet = book.add_worksheet(name)
                sheet.write_row(0, 0, list(own), bold)
                sheet.set_column(0, len(own) - 1, 16)
                sheet.freeze_panes(1, 1)
                for index, values in enumerate(own.values()):
                    sheet.write_column(1, index, values.tolist())
            for table in (
                *([Table("measures", MEASURES, measured)] if measured else []),
                Table("maxima", heads, rows_of_maxima(solution, units)),
                *([Table("loads", LOAD_HEADS, loads)] if loads else []),
                Table("run", ["what", "value"], about),
                Table(DEFINITION, ["YAML"], [[line] for line in origin[DEFINITION].splitlines()]),
            ):
                _fill(book.add_worksheet(table.heading), table, bold)


def _fill(sheet: Any, table: Table, bold: Any) -> None:
    """Write a table with its numbers as such."""
    sheet.write_row(0, 0, table.headings, bold)
    for index, row in enumerate(table.rows, start=1):
        for column, cell in enumerate(row):
            write = sheet.write_string if isinstance(cell, str) else sheet.write_number
            write(index, column, cell)
    sheet.set_column(0, 0, 32)
    sheet.set_column(1, len(table.columns) - 1, 18)
    sheet.freeze_panes(1, 0)
