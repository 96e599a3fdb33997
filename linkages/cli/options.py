"""Options that several commands have."""

from __future__ import annotations

import os
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Literal

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


Picture = Literal["png", "svg", "pdf"]
Format = Annotated[Picture, typer.Option("--format", help="Of figures; svg and pdf are vectors.")]
Template = Literal["slider-crank", "four-bar", "nine-bar", "empty"]


class Page(StrEnum):
    """Formats of reports; lists need an enumeration."""

    HTML = "html"
    PDF = "pdf"
