"""Reports as sheets of A3: one column of texts beside two of figures and wide tables."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from textwrap import wrap
from typing import Any

from matplotlib.figure import Figure

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.style import BLACK, GREY, style
from linkages.reports.pages import spaced
from linkages.reports.report import Definition, Items, Notes, Part, Picture, Report, Section, Table

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

SHARES = {2: (1, 2), 7: (25, 10, 12, 10, 12, 10, 8)}
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
