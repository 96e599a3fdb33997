"""What the verbs that analyse motions are asked for: files, ranges, initial states."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkages.cli.loading import mechanism_from, require_folder
from linkages.cli.published import EndedError, Published, published
from linkages.components.mechanism import Mechanism
from linkages.errors import ComputationError, InputError, Interrupted, Problem
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
    verb, options
        What is computed, and its other options: files say so, see `asks`.
    """

    file: str
    assignments: Sequence[str] = ()
    out: Path | None = None
    json: bool = False
    figures: bool = True
    format: str = "png"
    method: str | None = None
    rtol: float | None = None
    verb: str = ""
    options: Mapping[str, Any] = field(default_factory=dict)

    def asks(self, verb: str, **options: Any) -> Request:
        """The same for a verb with its own options."""
        return replace(self, verb=verb, options=options)

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
        return self._mechanism

    @cached_property
    def _mechanism(self) -> Mechanism:
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

        try:
            yield
        except ValueError as error:
            raise InputError(self.file, [Problem(message=str(error))]) from None
        except UnfinishedError as error:
            message = f"stopped {error}{self._keep(error.kept, interrupted=False)}"
            raise ComputationError(message, time=error.time) from None
        except Interrupted as error:
            raise EndedError(f"stopped {error}{self._keep(error.kept, interrupted=True)}") from None

    def _keep(self, kept: Mapping[str, Any], *, interrupted: bool) -> str:
        """Write what an analysis has that ended early, and say where."""
        from linkages.cli.results import save_netcdf

        if not kept:
            return ""
        with self.publishing(complete=False, interrupted=interrupted) as (aside, run):
            for name, data in kept.items():
                save_netcdf(data, aside.folder / f"{name}.nc")
        return "\nup to there: " + " and ".join(str(path) for path in run.files)

    @contextmanager
    def publishing(
        self, *, complete: bool = True, interrupted: bool = False
    ) -> Iterator[tuple[Request, Published]]:
        """The same request, whose folder is one aside, and where its files are at the end.

        Parameters
        ----------
        complete, interrupted
            Whether the run came to its end, and whether somebody ended it, see `published`.
        """
        options = {"method": self.method, "rtol": self.rtol, **self.options}
        with published(
            self.verb,
            self.folder,
            self.mechanism(),
            options,
            complete=complete,
            interrupted=interrupted,
        ) as run:
            yield replace(self, out=run.folder), run


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
