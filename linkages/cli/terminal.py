"""What the command line prints: tables and progress on a terminal, one JSON object otherwise."""

from __future__ import annotations

import json
import logging
import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, TextIO, cast

from rich.console import Console
from rich.markup import escape
from rich.table import Column
from rich.table import Table as Grid

from linkages.interrupts import keep_from_now_on
from linkages.reports.report import Items, Notes, Report, Table, Unbroken

MOST_NOTES = 10
PATIENCE = 1.0
"""Seconds before a progress bar appears."""

BAR = 16
"""Its width in characters: the time that is left and some words fit beside it into 80."""


_UNBOUNDED = 100_000
"""Columns where nobody looks at a screen: a line of a file or a pipe is never wrapped."""

_quiet = False


def be_quiet(wanted: bool) -> None:
    """Print no reports, notes or progress from now on, or do so again."""
    global _quiet
    _quiet = wanted


def console(error: bool = False) -> Console:
    """A console on standard output or standard error, which prints nothing if that is wanted."""
    result = Console(stderr=error, highlight=False, soft_wrap=False, emoji=False, quiet=_quiet)
    if not result.is_terminal:
        result.width = _UNBOUNDED
        result.file = cast(TextIO, _Trimmed(sys.stderr if error else sys.stdout))
    return result


class _Trimmed:
    """A stream that leaves out the spaces with which tables fill their lines."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream

    def write(self, text: str) -> int:
        *lines, rest = text.split("\n")
        return self.stream.write("\n".join([*(line.rstrip(" \t") for line in lines), rest]))

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


def print_json(content: Mapping[str, Any]) -> None:
    """One JSON object on standard output; numbers that are not finite become null."""
    unicode = (sys.stdout.encoding or "").lower().startswith("utf")
    print(json_text(content, ascii_only=not unicode))


def json_text(content: Mapping[str, Any], ascii_only: bool = False, indent: int = 2) -> str:
    """A JSON object as text; numbers that are not finite become null."""
    return json.dumps(_plain(content), ensure_ascii=ascii_only, indent=indent, allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def present(report: Report, json: bool) -> int:
    """Print a report, as JSON if that is asked for; returns the exit code."""
    if json:
        print_json(report.data)
    else:
        print_report(report, console())
    return 0


def print_report(report: Report, screen: Console) -> None:
    """Print the name, the summary and all parts."""
    if report.name:
        colour, _ = report.colours
        summary = f": [{colour}]{escape(report.summary)}[/]" if report.summary else ""
        screen.print(f"[bold]{escape(report.name)}[/bold]{summary}")
    for part in report.parts:
        match part:
            case Table():
                screen.print(table(part))
            case Items(texts):
                for text in texts:
                    screen.print(f"- {text}", markup=False, soft_wrap=True)
            case Notes(texts):
                print_notes(texts, screen)
            case str():
                screen.print(part, markup=False, soft_wrap=isinstance(part, Unbroken))


def table(shown: Table) -> Grid:
    """A plain table, in which numbers are not broken."""
    result = Grid(title=escape(shown.heading), title_justify="left", box=None, pad_edge=False)
    headings, cells = shown.headings, shown.cells
    for index, heading in enumerate(headings):
        result.add_column(
            escape(heading),
            justify="right" if index >= len(headings) - shown.numbers else "left",
            no_wrap=all(_is_number(row[index]) for row in cells),
        )
    for row in cells:
        result.add_row(*map(escape, row))
    return result


def _is_number(cell: str) -> bool:
    """Whether a cell must not be broken: half a number is another number."""
    try:
        float(cell)
    except ValueError:
        return False
    return True


def print_notes(notes: Sequence[str], screen: Console) -> None:
    """One line for each note; of many, the first `MOST_NOTES`."""
    for note in notes[:MOST_NOTES]:
        screen.print(f"note: {note}", markup=False, soft_wrap=True)
    if len(notes) > MOST_NOTES:
        screen.print(f"{len(notes) - MOST_NOTES} more notes; --json lists all of them")


def changes_in_words(changes: Sequence[str]) -> str:
    """In what a mechanism differs from its file: ``"a.b = 1, a.c = 2"``."""
    return ", ".join(change.replace("=", " = ", 1) for change in changes)


def print_changes(changes: Sequence[str], screen: Console) -> None:
    """Print in what a mechanism differs from its file; nothing if in nothing."""
    if changes:
        whole = f"with {changes_in_words(changes)}"
        screen.print(whole, markup=False, soft_wrap=True)


@contextmanager
def progress(
    label: str, shown: bool, what: str = "of simulated time"
) -> Iterator[Callable[..., None]]:
    """A progress bar on standard error for anything that takes more than a second.

    Yields a function that takes the fraction done, and words on it; `what` says of what.
    """
    from rich.progress import (
        BarColumn,
        Progress,
        TaskProgressColumn,
        TextColumn,
        TimeRemainingColumn,
    )

    bar = Progress(
        BarColumn(BAR),
        TaskProgressColumn("[progress.percentage]{task.percentage:>4.3g}%"),  # 1.2e-05% creeps, too
        TextColumn(f"{what}, remaining"),
        TimeRemainingColumn(),
        TextColumn("{task.description}", table_column=Column(no_wrap=True)),
        console=console(error=True),
        transient=True,
    )
    room = bar.console.width - BAR - len(f" 1.2e-05% {what}, remaining -:--:-- ")
    task = bar.add_task("", total=1.0)
    visible = shown and bar.console.is_terminal and not _quiet  # a log file gets no bar
    begin = time.monotonic()
    started = False

    def update(fraction: float, words: str = "") -> None:
        nonlocal started
        keep_from_now_on()
        said = f"{words}, {label}" if words else label
        said = said if len(said) <= room else f"{said[: max(room - 1, 0)]}…"
        bar.update(task, completed=fraction, description=escape(said))
        if visible and not started and time.monotonic() - begin > PATIENCE:
            started = True  # first: an interrupt may come while it starts
            bar.start()

    try:
        yield update
    finally:
        if started:
            bar.stop()


@contextmanager
def counter(label: str, shown: bool) -> Iterator[Callable[..., None]]:
    """The last step of a computation, on standard error, where nobody knows how many there are.

    Yields a function that takes words on a step, and whether they shall stay there. On a terminal
    the others are replaced by the next ones; elsewhere nothing is written.
    """
    from rich.progress import Progress, TextColumn, TimeElapsedColumn

    text = TextColumn("{task.description}", table_column=Column(no_wrap=True))
    bar = Progress(TimeElapsedColumn(), text, console=console(error=True), transient=True)
    task = bar.add_task("")
    visible = shown and bar.console.is_terminal and not _quiet  # a log file gets no lines
    begin = time.monotonic()
    started = False

    def update(words: str, stays: bool = False) -> None:
        nonlocal started
        keep_from_now_on()
        bar.update(task, description=escape(f"{label}: {words}"))
        if visible and stays:
            bar.console.print(words, markup=False)
        if visible and not started and time.monotonic() - begin > PATIENCE:
            started = True  # first: an interrupt may come while it starts
            bar.start()

    try:
        yield update
    finally:
        if started:
            bar.stop()


LOGGER = logging.getLogger("linkages")


def set_verbosity(quiet: bool, verbose: bool) -> None:
    """Print no reports, or what the package logs as well: files, kernels, integrations."""
    be_quiet(quiet)
    for handler in [h for h in LOGGER.handlers if isinstance(h, _Handler)]:
        LOGGER.removeHandler(handler)
    LOGGER.setLevel(logging.INFO if verbose else logging.NOTSET)
    if verbose:
        LOGGER.addHandler(_Handler())
        LOGGER.info("%s", _versions())


class _Handler(logging.StreamHandler):
    """Lines on standard error with the seconds since the start of the program."""

    def __init__(self) -> None:
        super().__init__(sys.stderr)
        self.setFormatter(_Formatter())


class _Formatter(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        return f"{record.relativeCreated / 1000:7.2f} s  {record.getMessage()}"


def _versions() -> str:
    import platform
    from importlib.metadata import version

    return (
        f"linkages {version('linkages')}, Python {platform.python_version()}, "
        f"llvmlite {version('llvmlite')}, {platform.platform()}"
    )
