"""A report on one sheet: drawing, facts and inputs at the left, curves and values at the right."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from io import BytesIO
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

from linkages.plots.pages import spaced
from linkages.plots.style import BLACK, GREY, style

if TYPE_CHECKING:
    from linkages.reports.report import Report

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
    from linkages.reports.report import HEADS, provenance

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
