"""A report on sheets of A4."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from io import BytesIO
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.image import imread

from linkages.plots.pages import picture, spaced
from linkages.plots.style import BLACK, GREY, style

if TYPE_CHECKING:
    from linkages.reports.report import Report

WIDTH, HEIGHT = 8.27, 11.69
MARGIN, GUTTER = 0.7, 0.2
LINE = 0.165
"""Height of a line of text, in inches."""

CHANGED = "#B3420A"
_METADATA = {"Creator": None, "Producer": None, "CreationDate": None}


class _Sheets:
    """Sheets that are filled from top to bottom."""

    def __init__(self) -> None:
        self.figures: list[Figure] = []
        self.room = 0.0

    def need(self, height: float) -> None:
        """Begin another sheet if there is less room than that."""
        if self.room < height:
            self.figures.append(Figure(figsize=(WIDTH, HEIGHT)))
            self.room = HEIGHT - 2 * MARGIN

    def text(self, x: float, words: str, size: float = 8.0, **look: Any) -> None:
        """Write at a distance from the left margin, on the present line."""
        y = (MARGIN + self.room) / HEIGHT
        self.figures[-1].text(
            (MARGIN + x) / WIDTH, y, words, fontsize=size, va="top", **{"color": BLACK, **look}
        )

    def heading(self, words: str, after: float = 0.5) -> None:
        """Begin a part, with so much of it on the same sheet."""
        self.need(0.35 + after)
        self.room -= 0.12
        self.text(0.0, words, 10.0, weight="bold")
        self.room -= 0.23

    def lines(self, texts: Sequence[str], **look: Any) -> None:
        """Write texts under each other, each broken where it is too long."""
        for text in texts:
            for part in wrap(text, 112) or [""]:
                self.need(LINE)
                self.text(0.0, part, **look)
                self.room -= LINE

    def table(self, places: Sequence[float], widths: Sequence[int], rows: list[list[str]]) -> None:
        """Write rows of cells at distances from the margin; the first is a head."""
        for index, row in enumerate(rows):
            cells = [wrap(cell, width) or [""] for cell, width in zip(row, widths, strict=True)]
            height = LINE * max(map(len, cells))
            self.need(height)
            for place, cell in zip(places, cells, strict=True):
                colour = BLACK if index else GREY
                self.text(place, "\n".join(cell), linespacing=1.25, color=colour)
            self.room -= height

    def pictures(self, figures: Sequence[Figure], columns: int) -> None:
        """Place figures beside and under each other."""
        for row in _rows(figures, columns):
            width = (WIDTH - 2 * MARGIN - GUTTER * (columns - 1)) / columns
            heights = [width * f.get_figheight() / f.get_figwidth() for f in row]
            self.need(max(heights))
            for column, (figure, height) in enumerate(zip(row, heights, strict=True)):
                left = MARGIN + column * (width + GUTTER)
                bottom = MARGIN + self.room - height
                box = (left / WIDTH, bottom / HEIGHT, width / WIDTH, height / HEIGHT)
                figure.set_dpi(300)
                ax = self.figures[-1].add_axes(box)
                ax.set_axis_off()
                ax.imshow(imread(BytesIO(picture(figure))), aspect="auto", interpolation="none")
            self.room -= max(heights) + 0.1


def write_pdf(report: Report, path: Path) -> None:
    """Set a report on sheets."""
    with style():
        sheets = _filled(report)
        with PdfPages(path, metadata=_METADATA) as file:
            for number, figure in enumerate(sheets.figures, start=1):
                foot = f"{report.solution.mechanism.name}, {number}/{len(sheets.figures)}"
                figure.text(1 - MARGIN / WIDTH, 0.035, foot, ha="right", fontsize=7, color=GREY)
                file.savefig(figure)


def _filled(report: Report) -> _Sheets:
    from linkages.reports.report import HEADS, provenance
    from linkages.solution.origin import DEFINITION

    mechanism, sheets = report.solution.mechanism, _Sheets()
    sheets.need(HEIGHT - 2 * MARGIN)
    sheets.text(0.0, mechanism.name, 16.0, weight="bold")
    sheets.room -= 0.34
    sheets.lines([mechanism.file_name], color=GREY)
    sheets.lines([spaced(text) for text in mechanism.changes], color=CHANGED, weight="bold")
    sheets.room -= 0.1
    if report.drawing is not None:
        sheets.pictures([report.drawing], 1 if report.drawing.get_figheight() < 4.5 else 2)
    sheets.lines(report.facts)
    if report.curves:
        sheets.heading("Curves", 2.5)
        sheets.pictures(report.curves, 2)
    if report.notes:
        sheets.heading("Notes")
        sheets.lines(report.notes)
    sheets.heading("Inputs")
    sheets.table((0.0, 2.0), (28, 80), [["entry", "values"], *report.inputs])
    if report.maxima:
        sheets.heading("Least and largest values")
        places = (0.0, 2.3, 3.2, 4.2, 4.95, 5.95, 6.7)
        sheets.table(places, (34, 12, 14, 11, 14, 11, 9), [HEADS, *report.maxima])
        sheets.lines(report.marks, color=GREY)
    sheets.heading("Origin")
    sheets.lines(provenance(report))
    sheets.room -= 0.1
    sheets.lines(report.origin[DEFINITION].splitlines(), family="monospace", size=6.5)
    return sheets


def _rows(figures: Sequence[Figure], columns: int) -> Iterator[Sequence[Figure]]:
    return (figures[start : start + columns] for start in range(0, len(figures), columns))
