"""What a system with a known answer is, and how it is judged."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass

import linkages
from linkages.chaos.verdicts.judge import Course, judge
from linkages.chaos.verdicts.report import verdict
from verdicts.own_systems import Map, Ode

Answer = tuple[str, int | None]
"""A verdict, and the section points after which a periodic motion repeats."""

PERIODS = 300


@dataclass(frozen=True)
class Known:
    """A system whose motion is known.

    Parameters
    ----------
    kind
        Maps, flows or mechanisms.
    name
        What it is, with its numbers.
    verdict, period
        The answer; a period of None is not compared.
    source
        Where it is known from.
    judged
        Judges it after so many skipped periods (None: as found) at a relative tolerance.
    dissipative
        Whether there may be a transient; otherwise nothing is skipped, whatever is asked for.
    """

    kind: str
    name: str
    verdict: str
    period: int | None
    source: str
    judged: Callable[[int | None, float], Answer]
    dissipative: bool = True

    @property
    def expected(self) -> str:
        """The answer in words."""
        return self.verdict + (f", {self.period}" if self.period else "")


def of_map(system: Callable[[], Map], *, dissipative: bool = True) -> Callable[..., Answer]:
    """Judge a map; the smaller error is a start that is displaced by that much."""

    def judged(skip: int | None, rtol: float) -> Answer:
        def displaced(start: Map) -> Map:
            found = copy.copy(start)
            found.restart(start.state * (1.0 + 0.1 * rtol))
            return found

        begin = system()
        begin.restart(begin.state * (1.0 + rtol))
        course: Course[Map] = Course(
            period=1, parts=1, periods=PERIODS, skip=skip, dissipative=dissipative
        )
        return _answer(judge(begin, course, displaced))

    return judged


def of_flow(
    system: Callable[[float], Ode],
    period: float,
    section: Callable[..., object] | None = None,
    *,
    dissipative: bool = True,
) -> Callable[..., Answer]:
    """Judge a flow, which is made for a tolerance; period as `Course` takes it."""

    def judged(skip: int | None, rtol: float) -> Answer:
        def tighter(start: Ode) -> Ode:
            found = system(0.1 * rtol)
            found.restart(start.state, time=start.time)
            return found

        def points(start: Ode, smaller: bool):  # type: ignore[no-untyped-def]
            return section(start, PERIODS, period, 0.1 * rtol if smaller else rtol)

        course: Course[Ode] = Course(
            period=period,
            periods=PERIODS,
            skip=skip,
            dissipative=dissipative,
            section=None if section is None else points,
        )
        return _answer(judge(system(rtol), course, tighter))

    return judged


def of_mechanism(mechanism: Callable[[], linkages.Mechanism]) -> Callable[..., Answer]:
    """Judge a mechanism as ``linkages chaos`` does."""

    def judged(skip: int | None, rtol: float) -> Answer:
        report = verdict(mechanism(), periods=PERIODS, skip=skip, rtol=rtol)
        return report.verdict, report.period if report.verdict == "periodic" else None

    return judged


def _answer(found) -> Answer:  # type: ignore[no-untyped-def]
    if found.verdict != found.verdict_again:
        return "undecided", None
    return found.verdict, found.evidence.period if found.verdict == "periodic" else None
