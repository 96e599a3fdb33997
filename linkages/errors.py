"""What can go wrong, as exceptions that carry everything a message needs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any


class LinkagesError(Exception):
    """Base of all errors that this package raises on purpose."""

    exit_code = 1


@dataclass(frozen=True, kw_only=True)
class Problem:
    """One thing that is wrong in the input.

    `line`, `column`: position in the file, counted from 1; None where the input has no text.
    """

    message: str  # what was found, what is expected and, where there is one, the nearest right word
    path: str = ""  # dotted path in the definition file, for example ``"bars.rocker.length"``
    line: int | None = None
    column: int | None = None

    def __str__(self) -> str:
        place = []
        if self.line is not None:
            place.append(f"line {self.line}, column {self.column}")
        if self.path:
            place.append(self.path)
        return f"{', '.join(place)}: {self.message}" if place else self.message


class InputError(LinkagesError):
    """The input cannot be used; lists every problem at once.

    Parameters
    ----------
    source
        The file (or other origin) that the problems were found in.
    problems
        All problems found, in the order of the file.
    """

    exit_code = 2

    def __init__(self, source: str, problems: Iterable[Problem]) -> None:
        self.source = source
        self.problems = tuple(
            sorted(problems, key=lambda p: (p.line is None, p.line or 0, p.column or 0))
        )
        super().__init__(source, self.problems)

    def __str__(self) -> str:
        count = len(self.problems)
        head = f"{self.source}: {count} problem{'s' if count != 1 else ''}"
        return "\n".join([head, *(f"  {problem}" for problem in self.problems)])


class ComputationError(LinkagesError):
    """The computation could not be completed; says when, where and why.

    Parameters
    ----------
    message
        One sentence with the time, the joint and block concerned, and a remedy.
    time
        Simulated time in seconds at which the computation stopped.
    """

    def __init__(self, message: str, *, time: float | None = None) -> None:
        super().__init__(message)
        self.time = time


class UnfinishedError(ComputationError):
    """An analysis ended early, since the motion could not go on.

    After Ctrl-C it is `Interrupted` that has what there is.

    `message`: when, where and why.
    `kept`: name of a result → what there is of it.
    `time`: as of a `ComputationError`.
    """

    def __init__(self, message: str, kept: Mapping[str, Any], *, time: float | None = None) -> None:
        super().__init__(message, time=time)
        self.kept = dict(kept)


class Interrupted(KeyboardInterrupt):
    """Ctrl-C ended a computation; has what there was up to then.

    It is a KeyboardInterrupt and no Exception: a loop that goes on after errors ends.

    Parameters
    ----------
    message
        When that was.
    time
        Simulated time in seconds that was reached, where there is one.
    kept
        Name of a result → what there is of it, as the interrupted function returns it.
    solution
        Of `linkages.simulate`: everything up to there.
    """

    def __init__(
        self,
        message: str,
        *,
        time: float | None = None,
        kept: Mapping[str, Any] | None = None,
        solution: Any = None,
    ) -> None:
        super().__init__(message)
        self.time = time
        self.kept = dict(kept or {})
        self.solution = solution
