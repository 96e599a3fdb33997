"""The command line: ``python -m linkages VERB FILE``.

Each verb imports what it needs when it runs, so that ``--help`` answers at once.
"""

from __future__ import annotations

import errno
import gc
import os
import sys
from contextlib import suppress
from io import TextIOWrapper, UnsupportedOperation
from pathlib import Path
from typing import Annotated, NoReturn

import typer

from linkages.cli import analyses, definitions
from linkages.cli.found import WithFound
from linkages.cli.options import (
    ChangePoints,
    Figures,
    File,
    Format,
    Json,
    Moving,
    Out,
    Picture,
    Set,
)

app = typer.Typer(
    name="linkages",
    cls=WithFound,
    help="Dynamics of planar linkages: one YAML file in, motion, forces and figures out.",
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"linkages {version('linkages')}")
        raise typer.Exit


@app.callback()
def _options(
    _wanted: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
    quiet: Annotated[
        bool,
        typer.Option("--quiet", "-q", help="Print errors only: no report, no progress."),
    ] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="Say on standard error what is done, and when.")
    ] = False,
) -> None:
    """Options before the verb."""
    from linkages.cli.verbosity import set_verbosity

    if quiet and verbose:
        raise typer.BadParameter("--quiet and --verbose are both given; expected one of them")
    set_verbosity(quiet=quiet, verbose=verbose)


@app.command()
def simulate(
    file: File,
    assignments: Set = None,
    out: Out = None,
    json: Json = False,
    figures: Figures = True,
    form: Format = Picture.PNG,
    outputs: Annotated[
        str | None,
        typer.Option(
            help="Comma-separated variables to compute, or 'all'; default: kinematics, efforts."
        ),
    ] = None,
    verify: Annotated[
        bool | None,
        typer.Option(
            help="Integrate again at a tighter tolerance and say until when the answer holds; "
            "default: for adaptive methods of high order."
        ),
    ] = None,
    change_points: Annotated[
        ChangePoints | None,
        typer.Option(
            help="Go on smoothly where the mechanism could go on in two ways, or stop there; "
            "default: pass if a coordinate other than a clearance is free."
        ),
    ] = None,
    max_steps: Annotated[
        int | None,
        typer.Option(min=1, help="Steps after which a run gives up; default: 100 million."),
    ] = None,
) -> None:
    """Compute the motion; write simulate.nc, simulate.csv and figures; print maxima."""
    from linkages.cli.simulate import run_simulate

    wanted = None if change_points is None else change_points.value
    asked = assignments or [], out, json, figures, outputs, verify, wanted, form.value, max_steps
    raise typer.Exit(run_simulate(file, *asked))


@app.command()
def check(
    file: File,
    assignments: Set = None,
    json: Json = False,
    kernel: Annotated[
        bool, typer.Option("--kernel", help="Count the operations of the kernel.")
    ] = False,
    modes: Annotated[
        bool, typer.Option("--modes", help="List all ways to put the mechanism together.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="List the modes and draw them into this folder."),
    ] = None,
    form: Format = Picture.PNG,
) -> None:
    """Report bodies, joints, loads, mobility, coordinates, blocks and condition numbers."""
    from linkages.cli.check import run_check

    raise typer.Exit(run_check(file, assignments or [], json, kernel, modes, out, form.value))


@app.command()
def equations(
    file: File,
    assignments: Set = None,
    form: Annotated[
        str, typer.Option("--format", metavar="text|latex|python", help="How to print them.")
    ] = "text",
    json: Json = False,
) -> None:
    """Print the closure equations, the energies and Lagrange's equations."""
    from linkages.cli.equations import run_equations

    raise typer.Exit(run_equations(file, assignments or [], form, json))


@app.command()
def animate(
    file: File,
    assignments: Set = None,
    out: Out = None,
    json: Json = False,
    form: Annotated[
        Moving, typer.Option("--format", help="MP4 needs the program ffmpeg.")
    ] = Moving.GIF,
    start: Annotated[float, typer.Option(help="Time in s of the first frame.")] = 0.0,
    duration: Annotated[
        float | None, typer.Option(help="How much of the motion to show, in s; default: the rest.")
    ] = None,
    slow: Annotated[
        float | None,
        typer.Option(
            help="Seconds of the film per second of the motion, e.g. 10 for slow motion; "
            "default: 1, or what makes the film last from 4 to 12 s."
        ),
    ] = None,
    fps: Annotated[float, typer.Option(help="Frames per second.")] = 25.0,
    size: Annotated[
        str | None,
        typer.Option(metavar="WIDTHxHEIGHT", help="In pixels; default: as the mechanism needs."),
    ] = None,
    dpi: Annotated[float, typer.Option(help="Pixels per inch: size of texts and symbols.")] = 80.0,
) -> None:
    """Write a moving picture: the mechanism, traces of its joints, clearances enlarged."""
    from linkages.cli.animate import Options, run_animate

    options = Options(
        format=form.value, start=start, duration=duration, slow=slow, fps=fps, size=size, dpi=dpi
    )
    raise typer.Exit(run_animate(file, assignments or [], out, json, options))


analyses.add_to(app)


@app.command()
def bench(
    file: File,
    assignments: Set = None,
    out: Out = None,
    json: Json = False,
    figures: Annotated[bool, typer.Option(help="Draw work against error.")] = True,
    form: Format = Picture.PNG,
    repeats: Annotated[int, typer.Option(min=1, help="Runs per point; the median counts.")] = 5,
) -> None:
    """Measure time against error of every method and of installed peers."""
    from linkages.cli.bench import run_bench

    raise typer.Exit(run_bench(file, assignments or [], out, json, figures, repeats, form.value))


definitions.add_to(app)


def main() -> None:
    """Run the command line; errors become messages and exit codes, never tracebacks."""
    from linkages.errors import LinkagesError

    # what imports create lives to the end of the process: collecting it again and again costs 0.2 s
    gc.set_threshold(100_000)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without ² is no reason to fail
    try:
        app(prog_name=_program_name())
    except LinkagesError as error:
        print(error, file=sys.stderr)
        sys.exit(error.exit_code)
    except BrokenPipeError:
        _close_output()
        sys.exit(1)
    except OSError as error:
        _close_output()
        if os.name == "nt" and error.errno == errno.EINVAL and not error.filename:
            sys.exit(1)  # what a broken pipe is called there
        reason = (error.strerror or str(error)).splitlines()[0]
        place = f"{error.filename}: " if error.filename else ""
        print(f"{place}cannot be written: {reason}", file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt as interrupt:
        _end(interrupt)
    except SystemExit as end:
        seen = getattr(end.__context__, "__cause__", None)
        if isinstance(seen, KeyboardInterrupt):  # by Typer, which says nothing
            _end(seen)
        raise


def _end(interrupt: KeyboardInterrupt) -> NoReturn:
    """Say that somebody ended the program while there was nothing to keep."""
    from linkages.interrupts import exit_code

    print(str(interrupt) or "interrupted", file=sys.stderr)
    sys.exit(exit_code())


def _program_name() -> str | None:
    """Shells complete programs, not modules: `python -m linkages` installs it for `linkages`."""
    return "linkages" if any("-completion" in word for word in sys.argv[1:2]) else None


def _close_output() -> None:
    """Whoever read the output has left; keep the interpreter from complaining at exit."""
    with suppress(UnsupportedOperation):  # no file, as in tests
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
