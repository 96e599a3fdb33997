"""Report of a run: drawing, inputs, curves, largest values, notes; HTML or PDF."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from textwrap import wrap
from typing import Any

from matplotlib.figure import Figure

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.figures import FIGURES, PICTURES, dense_data, figures_of
from linkages.plots.style import BLACK, GREY, scale_for, style
from linkages.reading.output_files import replaced
from linkages.reading.paths import dotted
from linkages.reports import pages
from linkages.reports.pages import spaced
from linkages.solution.files import DEFINITION, origin_of
from linkages.solution.solution import Solution
from linkages.stamps import stamp

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

RESOLVED = 1e-3
"""Part of a largest value that samples may miss before it is marked."""

LATE, OPEN = "*", "~"

MARKS = {
    LATE: "later than the motion is predictable: right in kind only, another run has another value",
    OPEN: "samples do not resolve the peak: the motion may exceed the value",
}


@dataclass(frozen=True, kw_only=True)
class Report:
    """What a report says, however it is set.

    Parameters
    ----------
    solution
        The run.
    facts
        What is to be known of it, line by line.
    inputs, maxima
        Rows of tables.
    marks
        What marks in `maxima` mean, those that are there.
    notes
        What was assumed, or could not be computed.
    drawing, curves
        Figures.
    origin
        Of `origin_of`.
    """

    solution: Solution
    facts: list[str]
    inputs: list[list[str]]
    maxima: list[list[str]]
    marks: list[str]
    notes: list[str]
    drawing: Figure | None
    curves: list[Figure]
    origin: dict[str, str]


HEADS = ["quantity", "of", "least", "at t (s)", "largest", "at t (s)", "unit"]


def save_report(solution: Solution, path: str | Path) -> Path:
    """Write a report of a run: drawing, inputs, curves, largest values, notes, and its origin.

    Parameters
    ----------
    solution
        Of `linkages.simulate`.
    path
        Ends in ``.html``, a page that needs no other file, or in ``.pdf``, sheets of A4. The
        definition is in both, so that either can be computed again.

    Raises
    ------
    ValueError
        For another ending.
    """
    file = Path(path)
    kinds: dict[str, Callable[[Report, Path], None]] = {".html": _write_html, ".pdf": write_pdf}
    if file.suffix not in kinds:
        raise ValueError(f"path must end in .html or .pdf, found {file.name!r}")
    found = report_of(solution)
    with replaced(file) as temporary:
        kinds[file.suffix](found, temporary)
        stamp(temporary, found.origin)
    return file


def report_of(solution: Solution) -> Report:
    """Gather what a report says."""
    data, mechanism = solution.data, solution.mechanism
    rows = [_row(solution, row) for row in solution.maxima]
    chosen = sorted({*figures_of(solution)} - {*PICTURES}, key=_importance)
    dense = dense_data(solution, chosen)
    curves = (FIGURES[name](dense, mechanism) for name in chosen)
    values = "".join(cell for row in rows for cell in (row[2], row[4]))
    return Report(
        solution=solution,
        facts=_facts(solution),
        inputs=input_rows(mechanism),
        maxima=rows,
        marks=[f"{mark} {text}" for mark, text in MARKS.items() if mark in values],
        notes=list(dict.fromkeys([*solution.notes, *solution.motion.notes])),
        drawing=FIGURES["mechanism"](data, mechanism),
        curves=[figure for figure in curves if figure is not None][:MOST_CURVES],
        origin={"verb": "simulate", **origin_of(mechanism, solution.options)},
    )


def _importance(name: str) -> tuple[int, int]:
    place = FIRST.index(name) if name in FIRST else len(FIRST)
    return place, list(FIGURES).index(name)


def _row(solution: Solution, row: dict[str, Any]) -> list[str]:
    """Cells of `HEADS`."""
    until = solution.data.attrs.get("horizon")
    cells = [row["long_name"], row["element"]]
    for which in ("least", "greatest"):
        time = row[f"{which}_time"]
        late = LATE if until is not None and abs(time) > abs(until) else ""
        unresolved = OPEN if row["missed"] > RESOLVED else ""
        cells += [f"{row[which]:.6g}{late}{unresolved}", f"{time:.4g}"]
    return [*cells, scale_for(1.0, row["units"]).units]


def _facts(solution: Solution) -> list[str]:
    topology, motion = solution.system.topology, solution.motion
    coordinates = "; ".join(
        f"{word} {', '.join(names)}"
        for word, names in (("driving", topology.driven), ("independent", topology.free))
        if names
    )
    how = (
        f"{motion.method}, rtol {solution.settings.run.rtol:g}"
        if motion.method
        else "drives determine the motion, nothing integrated"
    )
    found = [
        f"mobility {topology.mobility}" + (f": {coordinates}" if coordinates else ""),
        f"{len(topology.dependent)} dependent coordinates in {len(topology.solved_blocks)} blocks",
        f"{solution.summary}; {how}",
    ]
    if motion.failure is not None:
        found.append(f"stopped {motion.failure}")
    if "horizon" in solution.data.attrs:
        found.append(f"predictable to t = {solution.data.attrs['horizon']:.6g} s")
    return found


def provenance(report: Report) -> list[str]:
    """How the run is computed again."""
    options = json.loads(report.origin["arguments"])
    said = ", ".join(f"{k} = {v}" for k, v in options.items() if k != "outputs")
    return [report.origin["version"], report.origin["libraries"], said]


def _write_html(report: Report, path: Path) -> None:
    mechanism = report.solution.mechanism
    changed = [f"{MARK} differs from the file"] if mechanism.changes else []
    body = [
        pages.figure_with(report.drawing, "The mechanism at t = 0.") if report.drawing else "",
        pages.items(report.facts),
        pages.section("Notes", pages.items(report.notes)),
        pages.section(
            "Inputs",
            pages.table(["entry", "values"], report.inputs, texts=True),
            *map(pages.paragraph, changed),
        ),
        pages.section("Curves", *(pages.figure_with(f, "") for f in report.curves)),
        pages.section(
            "Least and largest values",
            pages.table(HEADS, report.maxima, texts=True),
            *map(pages.paragraph, report.marks),
        ),
        pages.section(
            "Origin",
            pages.items(provenance(report)),
            pages.definition(report.origin[DEFINITION]),
        ),
    ]
    text = pages.page(mechanism.name, mechanism.file_name, mechanism.changes, body)
    path.write_text(text, encoding="utf-8")


WIDTH, HEIGHT = 16.54, 11.69
"""Inches: A3 across, which prints on A4 as well."""

MARGIN, GUTTER = 0.5, 0.3
SIDE = 4.7
"""Inches: width of the column at the left."""

SIZE, LINE = 7.0, 0.132
"""Points of text, and inches from one line to the next."""

CURVES = 4
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


def write_pdf(report: Report, path: Path) -> None:
    """Set a report on a sheet; on several if its tables are long. Figures stay vectors."""
    from pypdf import PdfReader, PdfWriter, Transformation

    with style():
        sheets, writer = _filled(report), PdfWriter()
        for number, sheet in enumerate(sheets, start=1):
            if len(sheets) > 1:
                foot = f"{report.solution.mechanism.name}, {number}/{len(sheets)}"
                sheet.text(WIDTH - MARGIN, MARGIN - 0.1, foot, ha="right", color=GREY)
            page = writer.add_page(PdfReader(_as_pdf(sheet.figure)).pages[0])
            for figure, scale, left, bottom in sheet.pictures:
                placed = Transformation().scale(scale).translate(_POINTS * left, _POINTS * bottom)
                page.merge_transformed_page(PdfReader(_as_pdf(figure)).pages[0], placed)
            page.compress_content_streams()
    writer.compress_identical_objects()
    writer.write(path)


def _filled(report: Report) -> list[_Sheet]:

    sheets: list[_Sheet] = []
    mechanism, side = report.solution.mechanism, _Column(sheets, MARGIN, SIDE)
    side.heading(mechanism.name, 16.0)
    side.lines([mechanism.file_name], color=GREY)
    side.lines([spaced(text) for text in mechanism.changes], color=CHANGED, weight="bold")
    if report.drawing is not None:
        side.picture(report.drawing, 3.4)
    side.lines(report.facts)
    if report.notes:
        side.heading("Notes")
        side.lines(report.notes)
    side.heading("Inputs")
    side.table((1, 2), ["entry", "values"], report.inputs)
    side.heading("Origin")
    side.lines([*provenance(report), "The definition is kept in this file."])

    left = MARGIN + SIDE + 1.5 * GUTTER
    width = (WIDTH - MARGIN - left - GUTTER) / 2
    halves = [_Column(sheets, left + half * (width + GUTTER), width) for half in (0, 1)]
    curves = report.curves[:CURVES]
    highest = 2.9 if len(curves) > 2 else 5.0
    for pair in _rows(curves, 2):
        for half, figure in zip(halves, pair, strict=False):
            half.picture(figure, highest)
        _level(halves)
    middle = -(-len(report.maxima) // 2)
    for half, rows in zip(halves, (report.maxima[:middle], report.maxima[middle:]), strict=True):
        if rows:
            half.heading("Least and largest values" if half is halves[0] else "")
            half.table((25, 10, 12, 10, 12, 10, 8), HEADS, rows)
    halves[0].lines(report.marks, color=GREY)
    return sheets


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


def _rows(figures: Sequence[Figure], columns: int) -> Iterator[Sequence[Figure]]:
    return (figures[start : start + columns] for start in range(0, len(figures), columns))
