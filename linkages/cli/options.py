"""Options that several commands have."""

from __future__ import annotations

import os
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

SUFFIXES = (".yaml", ".yml")


def complete_file(incomplete: str) -> list[str]:
    """Definition files and folders that begin as given, then shipped mechanisms."""
    from linkages.reading.document import shipped

    return [*_paths(incomplete), *(name for name in shipped() if name.startswith(incomplete))]


def _paths(incomplete: str) -> list[str]:
    folder, begun = os.path.split(incomplete)
    try:
        entries = sorted(Path(folder or ".").expanduser().iterdir())
    except OSError:
        return []
    return [
        os.path.join(folder, entry.name) + (os.sep if entry.is_dir() else "")
        for entry in entries
        if entry.name.startswith(begun)
        and (entry.name.startswith(".") <= begun.startswith("."))
        and (entry.is_dir() or entry.suffix in SUFFIXES)
    ]


File = Annotated[
    str,
    typer.Argument(
        metavar="FILE",
        help="A definition file, or the name of a shipped mechanism.",
        autocompletion=complete_file,
    ),
]
Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="PATH=VALUE", help="Use another value, e.g. clearances.r1.size=0.1mm."
    ),
]
TablesFrom = Annotated[
    Path | None,
    typer.Option(
        "--tables-from",
        metavar="DIR",
        help="Read files of tables below this folder, too; default: below that of FILE.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help="Folder for results; default: results/<file stem>."),
]
Figures = Annotated[bool, typer.Option(help="Draw figures.")]


class Picture(StrEnum):
    """Formats of figures."""

    PNG = "png"
    SVG = "svg"
    PDF = "pdf"


Format = Annotated[Picture, typer.Option("--format", help="Of figures; svg and pdf are vectors.")]


class Table(StrEnum):
    """Formats of tables."""

    CSV = "csv"
    XLSX = "xlsx"


class Page(StrEnum):
    """Formats of reports."""

    HTML = "html"
    PDF = "pdf"


class Template(StrEnum):
    """What a new file begins with."""

    SLIDER_CRANK = "slider-crank"
    FOUR_BAR = "four-bar"
    NINE_BAR = "nine-bar"
    EMPTY = "empty"


class Moving(StrEnum):
    """Formats of animations."""

    GIF = "gif"
    WEBP = "webp"
    MP4 = "mp4"


class Drawing(StrEnum):
    """How numbers of a sweep are drawn."""

    RANDOM = "random"
    SOBOL = "sobol"
    LATIN_HYPERCUBE = "latin-hypercube"


class Processor(StrEnum):
    """Where motions of a sweep are integrated."""

    CPU = "cpu"
    CUDA = "cuda"


class Start(StrEnum):
    """Where each value of a sweep starts."""

    SAME = "same"
    FORWARD = "forward"
    BACKWARD = "backward"
    BOTH = "both"
