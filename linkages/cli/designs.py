"""Commands that decide on numbers of a definition: what they are asked for."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from linkages.cli.verb import computes
from linkages.options.run import SimulationOptions

Ranges = Annotated[
    list[str],
    typer.Option(
        metavar="PATH=FROM:TO", help="What to vary, e.g. bars.rod.length=120mm:160mm; repeatable."
    ),
]


class Search(StrEnum):
    """How far an optimum is looked for."""

    LOCAL = "local"
    GLOBAL = "global"


@computes(SimulationOptions)
def optimise(
    vary: Ranges,
    minimise: Annotated[
        str | None,
        typer.Option(metavar="MEASURE", help="What shall be least, e.g. 'max(abs(crank.effort))'."),
    ] = None,
    maximise: Annotated[
        str | None, typer.Option(metavar="MEASURE", help="What shall be greatest instead.")
    ] = None,
    subject_to: Annotated[
        list[str] | None,
        typer.Option(
            metavar="COMPARISON",
            help="What must hold, e.g. 'min(transmission_angle) > 40 deg'; repeatable.",
        ),
    ] = None,
    search: Annotated[
        Search,
        typer.Option(help="From the file's numbers by derivatives, or all over the bounds."),
    ] = Search.LOCAL,
    starts: Annotated[int, typer.Option(min=1, help="Local searches from as many points.")] = 1,
    seed: Annotated[int, typer.Option(min=0, help="Of these points, and of a global search.")] = 0,
    runs: Annotated[
        int | None, typer.Option(min=1, help="Motions after which the search ends.")
    ] = None,
    cores: Annotated[
        int | None, typer.Option(min=1, help="Computations at the same time; default: all cores.")
    ] = None,
) -> None:
    """Find the numbers that make a measure least or greatest; write optimised.yaml and figures."""


@computes(SimulationOptions)
def fit(
    to: Annotated[
        Path,
        typer.Option(
            metavar="CSV",
            help="Measurements: columns 'time (s)', 'crank.angle (deg)' and the like.",
        ),
    ],
    vary: Ranges,
    sigma: Annotated[
        list[str] | None,
        typer.Option(
            metavar="OUTPUT=VALUE",
            help="Standard deviation of an output, e.g. 'crank.angle=0.5 deg'; repeatable.",
        ),
    ] = None,
    starts: Annotated[int, typer.Option(min=1, help="Fits from as many points.")] = 1,
    seed: Annotated[int, typer.Option(min=0, help="Of these points.")] = 0,
) -> None:
    """Find the numbers with which the motion goes as was measured, with their standard errors."""


COMMANDS = (optimise, fit)
