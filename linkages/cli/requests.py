"""What the verbs that analyse motions are asked for: files, ranges, initial states."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from linkages.cli.loading import mechanism_from, require_folder
from linkages.components.mechanism import Mechanism
from linkages.errors import ComputationError, InputError, Problem
from linkages.reading.overrides import parse_assignment

if TYPE_CHECKING:
    from linkages.chaos.varied import Axis

NEXT = re.compile(r",(?=\s*[A-Za-z_][^,={}()]*=)")
"""A comma before another assignment; commas within a value are followed by no equals sign."""


@dataclass(frozen=True, kw_only=True)
class Request:
    """Options that all analyses have.

    Parameters
    ----------
    file, assignments, out
        As on the command line.
    json, figures
        Whether to print JSON, and whether to draw.
    format
        Of figures: ``"png"``, ``"svg"`` or ``"pdf"``.
    method, rtol
        Of the integration; those of the file if None.
    """

    file: str
    assignments: Sequence[str] = ()
    out: Path | None = None
    json: bool = False
    figures: bool = True
    format: str = "png"
    method: str | None = None
    rtol: float | None = None

    @property
    def folder(self) -> Path:
        """Where results go."""
        return Path("results") / Path(self.file).stem if self.out is None else self.out

    def mechanism(self) -> Mechanism:
        """The mechanism with all values put in; its folder for results can be written.

        Raises
        ------
        InputError
            For anything wrong in the file, the assignments or the folder.
        """
        # as assignments they are checked as if the file said so
        own = {"simulate.method": self.method, "simulate.rtol": self.rtol}
        added = [f"{path}={value}" for path, value in own.items() if value is not None]
        found = mechanism_from(self.file, [*self.assignments, *added])
        require_folder(self.folder)
        return found

    @contextmanager
    def answering(self) -> Iterator[None]:
        """Turn what an analysis raises into what the program says.

        Arguments that make no sense are a ValueError of the analysis: that is wrong input. What an
        analysis has when it must end early is written.
        """
        from linkages.chaos.unfinished import UnfinishedError
        from linkages.cli.results import save_netcdf

        try:
            yield
        except ValueError as error:
            raise InputError(self.file, [Problem(message=str(error))]) from None
        except UnfinishedError as error:
            written = [
                save_netcdf(data, self.folder / f"{name}.nc") for name, data in error.kept.items()
            ]
            kept = " and ".join(str(path) for path in written)
            raise ComputationError(
                f"stopped {error}" + (f"\nup to there: {kept}" if kept else ""), time=error.time
            ) from None


def ranges(option: str, texts: Sequence[str]) -> Axis:
    """One axis from the ranges of an option, in lockstep if there are several.

    Raises
    ------
    InputError
        Lists all that cannot be read.
    """
    from linkages.chaos.varied import parse_range, together

    axes, problems = [], []
    for text in texts:
        try:
            axes.append(parse_range(text))
        except ValueError as error:
            problems.append(Problem(message=str(error)))
    if not problems:
        try:
            return together(axes)
        except ValueError as error:
            problems.append(Problem(message=str(error)))
    raise InputError(option, problems)


def initial_states(texts: Sequence[str]) -> list[dict[str, object]]:
    """Overrides for each initial state, from ``path=value,path=value``.

    Raises
    ------
    InputError
        Lists all that are no assignments.
    """
    states: list[dict[str, object]] = []
    problems: list[Problem] = []
    for text in texts:
        state: dict[str, object] = {}
        for part in NEXT.split(text):
            try:
                path, value = parse_assignment(part)
            except InputError as error:
                problems += error.problems
            else:
                state[path] = value
        states.append(state)
    if problems:
        raise InputError("--initial", problems)
    return states or [{}]
