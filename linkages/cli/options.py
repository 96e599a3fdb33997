"""Options that several verbs have."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from linkages.cli.completion import complete_file

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
Method = Annotated[
    str | None, typer.Option(help="How to integrate; default: simulate.method of the file.")
]
Rtol = Annotated[
    float | None, typer.Option(help="Relative tolerance; default: simulate.rtol of the file.")
]
Phase = Annotated[
    float, typer.Option(help="Where in the period of the drives points are taken, from 0 to 1.")
]
Section = Annotated[
    str | None,
    typer.Option(
        metavar="ELEMENT.QUANTITY=VALUE",
        help="Take points where this is crossed instead, e.g. 'slider9.velocity=0'.",
    ),
]
Cores = Annotated[
    int | None, typer.Option(min=1, help="Computations at the same time; default: all cores.")
]


MaxSteps = Annotated[
    int | None,
    typer.Option(
        min=1, help="Steps that a point may take before it is left out; default: 100000 a period."
    ),
]


class ChangePoints(StrEnum):
    """What to do where a mechanism could go on in two ways."""

    PASS = "pass"
    STOP = "stop"


class Template(StrEnum):
    """What a new file begins with."""

    SLIDER_CRANK = "slider-crank"
    FOUR_BAR = "four-bar"
    NINE_BAR = "nine-bar"
    EMPTY = "empty"


class Moving(StrEnum):
    """Formats of moving pictures."""

    GIF = "gif"
    MP4 = "mp4"


class Direction(StrEnum):
    """How a section is crossed."""

    UP = "up"
    DOWN = "down"
    BOTH = "both"


class Start(StrEnum):
    """Where each value of a sweep starts."""

    SAME = "same"
    FORWARD = "forward"
    BACKWARD = "backward"
    BOTH = "both"


class Indicator(StrEnum):
    """What a map shows."""

    EXPONENT = "exponent"
    FLI = "fli"
    GALI = "gali"


Crossing = Annotated[Direction, typer.Option(help="How the section is crossed.")]
