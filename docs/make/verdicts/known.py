"""What a system with a known answer is, and how it is judged."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass

import linkages
from linkages.chaos.findings import verdict
from linkages.chaos.judge import Course, judge
from make.verdicts.own_systems import Map, Ode

PERIODS = 300

LOST = -math.inf
"""Exponent of a direction that contacts or sticking friction take away."""


@dataclass(frozen=True)
class Answer:
    """What is found of a system."""

    verdict: str  # in a word
    # section points after which a periodic motion repeats; None for other motions
    period: int | None
    # lyapunov exponents in 1/s or per step, the largest first, −∞ for lost directions, and their
    # standard errors. Empty if nothing was found
    exponents: tuple[float, ...] = ()
    errors: tuple[float, ...] = ()


@dataclass(frozen=True)
class Known:
    """A system whose motion is known."""

    name: str  # what it is, with its numbers
    verdict: str  # the answer; a period of None is not compared
    period: int | None
    source: str  # where it is known from
    # judges it after so many skipped periods (None: as found) at a relative tolerance
    judged: Callable[[int | None, float], Answer]
    # whether there may be a transient; otherwise nothing is skipped, whatever is asked for
    dissipative: bool = True
    # known Lyapunov exponents, the largest first; None if there is neither a closed form nor a
    # value from other code
    exponents: tuple[float, ...] | None = None
    within: float = 0.0  # uncertainty of these

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
        return _judged(judge(begin, course, displaced))

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
        return _judged(judge(system(rtol), course, tighter))

    return judged


def of_mechanism(mechanism: Callable[[], linkages.Mechanism]) -> Callable[..., Answer]:
    """Judge a mechanism as ``linkages chaos`` does."""

    def judged(skip: int | None, rtol: float) -> Answer:
        report = verdict(mechanism(), periods=PERIODS, skip=skip, rtol=rtol)
        found = report.exponents
        return _answer(
            report.verdict, report.period, found.exponent.values, found.error.values, found.lost
        )

    return judged


def of_definition(
    name: str,
    verdict: str,
    period: int | None,
    source: str,
    text: str,
    exponents: tuple[float, ...] | None = None,
    within: float = 0.0,
    *,
    dissipative: bool = True,
) -> Known:
    """A mechanism with its answer, from the text of its definition file."""
    judged = of_mechanism(lambda: linkages.loads(text))
    return Known(name, verdict, period, source, judged, dissipative, exponents, within)


def _judged(found) -> Answer:  # type: ignore[no-untyped-def]
    verdict = found.verdict if found.verdict == found.verdict_again else "undecided"
    exponents = found.evidence.exponents
    return _answer(
        verdict, found.evidence.period, exponents.values, exponents.errors, exponents.lost
    )


def _answer(verdict, period, exponents, errors, lost) -> Answer:  # type: ignore[no-untyped-def]
    return Answer(
        verdict,
        period if verdict == "periodic" else None,
        (*map(float, exponents), *[LOST] * lost),
        (*map(float, errors), *[0.0] * lost),
    )
