"""The command line: ``python -m linkages COMMAND FILE``.

Each verb imports what it needs when it runs, so that ``--help`` answers at once.
"""

from __future__ import annotations

import errno
import gc
import os
import sys
from contextlib import suppress
from io import TextIOWrapper, UnsupportedOperation
from typing import Annotated, NoReturn

import typer

from linkages.cli.commands import PANELS, optimise
from linkages.cli.verb import Verb, Verbs

app = typer.Typer(
    name="linkages",
    cls=Verbs,
    help="Simulate planar mechanisms from one YAML file: motion, forces, contact, chaos.",
    add_completion=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
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
        bool,
        typer.Option("--verbose", "-v", help="Report each step on standard error, with times."),
    ] = False,
) -> None:
    """Options before the command."""
    from linkages.cli.terminal import set_verbosity

    if quiet and verbose:
        raise typer.BadParameter("--quiet and --verbose are both given; expected one of them")
    set_verbosity(quiet=quiet, verbose=verbose)


for panel, commands in PANELS.items():
    for command in commands:
        app.command(command.__name__, cls=Verb, rich_help_panel=panel)(command)
app.command("optimize", cls=Verb, hidden=True)(optimise)


def main() -> None:
    """Run the command line; errors become messages and exit codes, never tracebacks."""
    from linkages.errors import LinkagesError

    # what imports create lives to the end of the process: collecting it again and again costs 0.2 s
    gc.set_threshold(100_000, 50)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without ² is no reason to fail
    try:
        try:
            app(sys.argv[1:] or ["--help"], prog_name=_program_name())
        finally:
            sys.stdout.flush()  # who reads may have left: at exit it would be too late to say so
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
        if len(sys.argv) == 1:
            sys.exit(2)  # help, but nothing was asked
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
