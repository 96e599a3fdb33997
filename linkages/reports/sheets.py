"""Report of a run, and reports as sheets of A3: texts beside figures and wide tables."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from textwrap import wrap
from typing import Any

from matplotlib.figure import Figure

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.figures import FIGURES, PICTURES, dense_data, figures_of
from linkages.plots.style import BLACK, GREY, scale_for, shown_in, style
from linkages.reading.output_files import replaced
from linkages.reading.paths import dotted
from linkages.reports.pages import computed_by, in_blocks, moved_by, page, spaced
from linkages.reports.report import Definition, Items, Notes, Part, Picture, Report, Section, Table
from linkages.reports.tables import (
    ENDS,
    LATE,
    LOAD_HEADS,
    MEASURES,
    OPEN,
    SI,
    Wanted,
    marked_ends,
    rows_of_loads,
    rows_of_measures,
    wanted,
)
from linkages.solution.files import DEFINITION, origin_of
from linkages.solution.solution import Solution
from linkages.stamps import stamp

WIDTH, HEIGHT = 16.54, 11.69
"""Inches: A3 across, which prints on A4 as well."""

MARGIN, GUTTER = 0.5, 0.3
SIDE = 4.7
"""Inches: width of the column at the left."""

SIZE, LINE = 7.0, 0.132
"""Points of text, and inches from one line to the next."""

CURVES = 4
WIDE = 5
"""Columns of a table from which it stands in the wide part."""

SHARES = {2: (1, 2), 3: (30, 12, 8), 5: (25, 16, 12, 10, 8), 7: (25, 10, 12, 10, 12, 10, 8)}
"""Number of columns → how they share the width."""

CHANGED = "#B3420A"
_METADATA: dict[Any, Any] = {"Creator": None, "Producer": None, "CreationDate": None}
_POINTS = 72.0


class _Column:
    """A column of a report, filled from top to bottom; what has no room goes to another sheet."""

    def __init__(self, sheets: list[_Sheet], left: float, width: float) -> None:
        self.sheets, self.left, self.width = sheets, left, width
        self.number, self.room = 0, HEIGHT - 2 * MARGIN

    def need(self, height: float) -> _Sheet:
        """The sheet with so much room, in inches; the next one if there is less on this one."""
        if self.room < height:
            self.number, self.room = self.number + 1, HEIGHT - 2 * MARGIN
        if self.number == len(self.sheets):
            self.sheets.append(_Sheet())
        return self.sheets[self.number]

    def text(self, x: float, words: str, **look: Any) -> None:
        """Write at a distance from the left edge of the column, below what it holds."""
        self.need(0.0).text(self.left + x, MARGIN + self.room, words, **look)

    def heading(self, words: str, size: float = 9.5) -> None:
        """Begin a part, with some of it on the same sheet."""
        self.need(size / 24 + 4 * LINE)
        self.room -= size / 96
        self.text(0.0, words, size=size, weight="bold")
        self.room -= size / 48

    def lines(self, texts: Sequence[str], **look: Any) -> None:
        """Write texts under each other, each broken where it is too long."""
        for text in texts:
            for part in wrap(text, _letters(self.width)) or [""]:
                self.need(LINE)
                self.text(0.0, part, **look)
                self.room -= LINE

    def table(self, shares: Sequence[float], head: list[str], rows: list[list[str]]) -> None:
        """Write rows of cells that share the width; the head is grey."""
        widths = [share * self.width / sum(shares) for share in shares]
        for index, row in enumerate([head, *rows]):
            cells = [
                wrap(cell, _letters(width - 0.06)) or [""]
                for cell, width in zip(row, widths, strict=True)
            ]
            height = LINE * max(map(len, cells))
            self.need(height)
            place = 0.0
            for cell, width in zip(cells, widths, strict=True):
                self.text(place, "\n".join(cell), color=BLACK if index else GREY)
                place += width
            self.room -= height

    def picture(self, figure: Figure, highest: float) -> None:
        """Place a figure, as wide as the column or so high, in inches."""
        scale = min(self.width / figure.get_figwidth(), highest / figure.get_figheight())
        height = scale * figure.get_figheight()
        sheet = self.need(height)
        self.room -= height
        sheet.pictures.append((figure, scale, self.left, MARGIN + self.room))


class _Sheet:
    """A sheet: its texts, and where its pictures are placed."""

    def __init__(self) -> None:
        self.figure = Figure(figsize=(WIDTH, HEIGHT))
        self.pictures: list[tuple[Figure, float, float, float]] = []

    def text(self, x: float, y: float, words: str, *, size: float = SIZE, **look: Any) -> None:
        """Write below and right of a place in inches."""
        spacing = LINE * _POINTS / (1.2 * SIZE)
        look = {"va": "top", "color": BLACK, "linespacing": spacing, **look}
        self.figure.text(x / WIDTH, y / HEIGHT, words, fontsize=size, **look)


def write_sheets(report: Report, mechanism: Mechanism, path: Path) -> None:
    """Set a report on a sheet; on several if its tables are long. Figures stay vectors."""
    from pypdf import PdfReader, PdfWriter, Transformation

    with style():
        sheets, writer = _filled(report, mechanism), PdfWriter()
        for number, sheet in enumerate(sheets, start=1):
            if len(sheets) > 1:
                foot = f"{report.name}, {number}/{len(sheets)}"
                sheet.text(WIDTH - MARGIN, MARGIN - 0.1, foot, ha="right", color=GREY)
            page = writer.add_page(PdfReader(_as_pdf(sheet.figure)).pages[0])
            for figure, scale, left, bottom in sheet.pictures:
                placed = Transformation().scale(scale).translate(_POINTS * left, _POINTS * bottom)
                page.merge_transformed_page(PdfReader(_as_pdf(figure)).pages[0], placed)
            page.compress_content_streams()
    writer.compress_identical_objects()
    writer.write(path)


def _filled(report: Report, mechanism: Mechanism) -> list[_Sheet]:
    sheets: list[_Sheet] = []
    side = _Column(sheets, MARGIN, SIDE)
    side.heading(report.name, 16.0)
    side.lines([mechanism.file_name], color=GREY)
    side.lines([spaced(text) for text in mechanism.changes], color=CHANGED, weight="bold")
    left = MARGIN + SIDE + 1.5 * GUTTER
    width = (WIDTH - MARGIN - left - GUTTER) / 2
    halves = [_Column(sheets, left + half * (width + GUTTER), width) for half in (0, 1)]
    for part in report.parts:
        _place(part, side, halves)
    return sheets


def _place(part: Part, side: _Column, halves: Sequence[_Column]) -> None:
    """Put a part at the side; sections of figures and of wide tables into the other columns."""
    match part:
        case Section(_, parts) if not parts:
            pass
        case Section(heading, parts):
            if any(isinstance(own, Picture) for own in parts):
                _place_figures([own.figure for own in parts if isinstance(own, Picture)], halves)
            elif isinstance(parts[0], Table) and len(parts[0].columns) >= WIDE:
                _place_rows(heading, parts[0], halves)
                halves[0].lines([own for own in parts[1:] if isinstance(own, str)], color=GREY)
            elif parts:
                side.heading(heading)
                for own in parts:
                    _place(own, side, halves)
        case Table():
            side.table(SHARES[len(part.columns)], part.headings, part.cells)
        case Items(texts):
            side.lines(texts)
        case Notes(texts):
            if texts:
                _place(Section("Notes", [Items(texts)]), side, halves)
        case Picture(figure):
            side.picture(figure, 3.4)
        case Definition():
            side.lines(["The definition is kept in this file."])
        case str():
            side.lines([part] if part else [])


def _place_figures(figures: Sequence[Figure], halves: Sequence[_Column]) -> None:
    curves = figures[:CURVES]
    highest = 2.9 if len(curves) > 2 else 5.0
    for start in range(0, len(curves), 2):
        for half, figure in zip(halves, curves[start : start + 2], strict=False):
            half.picture(figure, highest)
        _level(halves)


def _place_rows(heading: str, table: Table, halves: Sequence[_Column]) -> None:
    """Half of the rows in each column."""
    cells = table.cells
    middle = -(-len(cells) // 2)
    for half, rows in zip(halves, (cells[:middle], cells[middle:]), strict=True):
        if rows:
            half.heading(heading if half is halves[0] else "")
            half.table(SHARES[len(table.columns)], table.headings, rows)


def _level(columns: Sequence[_Column]) -> None:
    """Go on at one height in all columns."""
    number = max(column.number for column in columns)
    room = min(column.room for column in columns if column.number == number)
    for column in columns:
        column.number, column.room = number, room - 0.08


def _letters(inches: float) -> int:
    """How many letters of a text have room."""
    return max(4, int(inches * _POINTS / (0.53 * SIZE)))


def _as_pdf(figure: Figure) -> BytesIO:
    file = BytesIO()
    figure.savefig(file, format="pdf", metadata=_METADATA)
    return file


MARK = "●"
"""Stands before what differs from the file."""

_LONGEST = 160


def input_rows(mechanism: Mechanism) -> list[list[str]]:
    """A row for each entry of the definition: its path, marked where it differs, and its values."""
    changed = [text.partition("=")[0].strip() for text in mechanism.changes]
    rows = []
    for path, value in _entries(mechanism.definition.content):
        name = dotted(path)
        own = any(_same(name, text) or _same(text, name) for text in changed)
        rows.append([f"{MARK} {name}" if own else name, _shown(value)])
    return rows


def _entries(content: Mapping[str, Any]) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    for section, value in content.items():
        if section == "name":
            continue
        if isinstance(value, dict) and any(isinstance(v, dict | list) for v in value.values()):
            yield from (((section, name), entry) for name, entry in value.items())
        elif isinstance(value, list) and any(isinstance(entry, dict) for entry in value):
            yield from (((section, index), entry) for index, entry in enumerate(value))
        else:
            yield (section,), value


def _same(inner: str, outer: str) -> bool:
    """Whether one path is another one, or within it."""
    return inner == outer or inner.startswith((f"{outer}.", f"{outer}["))


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        text = ", ".join(f"{key} {_shown(entry)}" for key, entry in value.items())
    elif isinstance(value, list):
        text = f"[{', '.join(_shown(entry) for entry in value)}]"
    else:
        text = "" if value is None else str(value)
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"


MOST_CURVES = 6
FIRST = ("drive_effort", "drive_force", "clearance_force")
"""Curves that designers ask for first; then those in the order of `FIGURES`."""

MARKS = {
    LATE: "later than predictable: qualitatively correct only, another run gives another value",
    OPEN: "samples do not resolve the peak: the motion may exceed the value",
}


def save_report(
    solution: Solution,
    path: str | Path,
    *,
    units: Sequence[str] | str = (),
    measures: Sequence[str] = (),
    curves: Sequence[str] = (),
) -> Path:
    """Write a report of a run: drawing, inputs, curves, measures, loads, largest values, origin.

    Parameters
    ----------
    solution
        Of `linkages.simulate`.
    path
        Ends in ``.html``, a page that needs no other file, or in ``.pdf``, sheets of A4. The
        definition is in both, so that either can be computed again.
    units
        Units of tables and curves instead of SI, such as ``("mm", "kN", "deg")``.
    measures
        Numbers of the motion to list, such as ``"max(abs(crank.effort))"``.
    curves
        Series to draw, such as ``"crank.effort"``; a choice of figures if none is given.

    Raises
    ------
    ValueError
        For another ending, for units that no output has, and for unknown series.
    """
    file, mechanism = Path(path), solution.mechanism
    if file.suffix not in (".html", ".pdf"):
        raise ValueError(f"path must end in .html or .pdf, found {file.name!r}")
    origin = {"verb": "simulate", **origin_of(mechanism, solution.options)}
    report = run_report(solution, origin, wanted(units) if units else SI, measures, curves)
    with replaced(file) as temporary:
        if file.suffix == ".html":
            temporary.write_text(page(report, mechanism), encoding="utf-8")
        else:
            write_sheets(report, mechanism, temporary)
        stamp(temporary, origin)
    return file


def run_report(
    solution: Solution,
    origin: Mapping[str, str],
    units: Wanted = SI,
    measures: Sequence[str] = (),
    curves: Sequence[str] = (),
) -> Report:
    """The report of a run; `origin` is that of its files."""
    data, mechanism = solution.data, solution.mechanism
    units.check(row["units"] for row in solution.maxima)
    with shown_in(units.chosen):
        figures = _curves(solution, curves)
        drawing = FIGURES["mechanism"](data, mechanism)
    until = data.attrs.get("horizon")
    maxima = [
        [row["long_name"], row["element"], *marked_ends(row, until, factor), _shown_unit(name)]
        for row in solution.maxima
        if row["least"] or row["greatest"]  # not the velocities of fixed joints
        for name, factor in [units.of(row["units"])]
    ]
    measured = [
        [text, value, _shown_unit(name)]
        for text, value, name in rows_of_measures(solution, measures, units)
    ]
    loads = [[*row[:4], _shown_unit(row[4])] for row in rows_of_loads(solution, units)]
    values = "".join(cell for row in maxima for cell in (row[2], row[4]))
    options = json.loads(origin["arguments"])
    said = ", ".join(f"{name} = {value}" for name, value in options.items() if name != "outputs")
    inputs: list[Part] = [Table("", ["entry", "values"], input_rows(mechanism))]
    pictured = [] if drawing is None else [Picture(drawing, "The mechanism at t = 0.")]
    return Report(
        name=mechanism.name,
        parts=[
            *pictured,
            Items(_facts(solution)),
            Notes(list(dict.fromkeys([*solution.notes, *solution.motion.notes]))),
            Section(
                "Inputs", [*inputs, f"{MARK} differs from the file" if mechanism.changes else ""]
            ),
            Section("Measures", [Table("", MEASURES, measured)] if measured else []),
            Section("Curves", [Picture(figure) for figure in figures[:MOST_CURVES]]),
            Section("Loads of pins and guides", [Table("", LOAD_HEADS, loads)] if loads else []),
            Section(
                "Least and largest values",
                [
                    Table("", ENDS, maxima),
                    *(f"{mark} {text}" for mark, text in MARKS.items() if mark in values),
                ],
            ),
            Section(
                "Origin",
                [
                    Items([origin["version"], origin["libraries"], said]),
                    Definition(origin[DEFINITION]),
                ],
            ),
        ],
    )


def _curves(solution: Solution, names: Sequence[str]) -> list[Figure]:
    """Figures of the series that were asked for, or of a choice."""
    if names:
        from linkages.plots.charts import plot

        return [plot(solution, name).figure for name in names]  # type: ignore[misc]
    chosen = sorted({*figures_of(solution)} - {*PICTURES}, key=[*FIRST, *FIGURES].index)
    dense = dense_data(solution, chosen)
    return [f for n in chosen if (f := FIGURES[n](dense, solution.mechanism)) is not None]


def _shown_unit(units: str) -> str:
    return scale_for(1.0, units).units


def _facts(solution: Solution) -> list[str]:
    topology = solution.system.topology
    result = [moved_by(topology), in_blocks(topology), *computed_by(solution)]
    if "horizon" in solution.data.attrs:
        result.append(f"predictable to t = {solution.data.attrs['horizon']:.6g} s")
    return result
