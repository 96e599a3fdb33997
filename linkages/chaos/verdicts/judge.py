"""A verdict on any system with tangents: transient, evidence, and the same at a smaller error."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.growth.exponents import Exponents, lyapunov_spectrum
from linkages.chaos.growth.lyapunov import PARTS
from linkages.chaos.growth.systems import TangentSystem, Watch
from linkages.chaos.series.periods import apart, differences
from linkages.chaos.verdicts.stretch import Evidence, ends_alike, gathered, shrinking
from linkages.chaos.verdicts.verdict import judged, transient

Floats = NDArray[np.float64]
T = TypeVar("T", bound=TangentSystem)

FIRST_SKIP = 100
"""Periods that are always skipped where something dissipates and nobody says otherwise."""

MOST_STRETCHES = 4
"""Stretches that are looked at until one begins after the transient."""

BETWEEN = 0.5 * (math.sqrt(5.0) - 1.0)
"""Part of a period at which a motion at rest is looked at again; no simple period divides it."""


def _alike(states: Floats, _errors: Floats | None) -> Floats:
    """Difference that counts as none, where nothing else is said."""
    return np.full(states.shape[1], 1e-4)


@dataclass(frozen=True, kw_only=True)
class Course(Generic[T]):
    """How a system is followed.

    Parameters
    ----------
    period
        Time, or steps, from one section point to the next; of geometric sections about that.
    periods
        Length of the stretch that is judged.
    skip
        Periods before; None to skip the transient, as far as it is found.
    dissipative
        Whether there may be attractors, and so a transient.
    parts
        Intervals within a period after which tangents are made orthonormal again; 1 for maps.
    section
        Of the system, where it is, and whether with the smaller error: `periods` points of a
        geometric section from there on, shape (points, d), and their times; the system is left as
        it is. None for a point each period.
    others
        Periods of drives and loads that have none in common with `period`, the stroboscope's.
    driven
        Whether drives move something between two times: where the rest of the state does not change
        the motion is not at rest then.
    tolerance
        Of the states of the later half of a stretch, shape (n, d), and their largest differences
        from those with the smaller error, shape (d,), None before they are known: difference of
        entries that counts as none, (d,).
    observed
        The 0–1 test observes so many entries, the first ones; all by default.
    certified
        Of the system at the end of a stretch, and exponents: these, with what is known of them.
    """

    period: float
    periods: int
    skip: int | None = None
    dissipative: bool = True
    parts: int = PARTS
    section: Callable[[T, bool], tuple[Floats, Floats]] | None = None
    others: tuple[float, ...] = ()
    driven: Callable[[float, float], bool] = lambda _, __: False
    tolerance: Callable[[Floats, Floats | None], Floats] = _alike
    observed: int | None = None
    certified: Callable[[T, Exponents], Exponents] = lambda _, exponents: exponents


@dataclass(frozen=True, kw_only=True, eq=False)
class Judgement(Generic[T]):
    """A verdict with its evidence.

    Parameters
    ----------
    verdict, reasons
        As `linkages.chaos.verdicts.verdict.judged` gives them.
    evidence
        Of the stretch that was judged.
    start, end
        The system where that begins, and where it ends.
    skipped, how_skipped
        Periods before it, and why so many.
    again, end_again, verdict_again
        The same from the same state on with a smaller error.
    """

    verdict: str
    reasons: tuple[str, ...]
    evidence: Evidence
    start: T
    end: T
    skipped: int
    how_skipped: str
    again: Evidence
    end_again: T
    verdict_again: str


def judge(
    system: T,
    course: Course[T],
    tighter: Callable[[T], T],
    *,
    watches: tuple[Watch | None, Watch | None] = (None, None),
    keep: Callable[[Evidence, T], None] = lambda _, __: None,
) -> Judgement[T]:
    """Judge the motion of a system from where it is, which is left there.

    Parameters
    ----------
    system
        At the beginning of a period.
    course
        How it is followed.
    tighter
        Makes another one in the same state with a smaller error.
    watches
        Called with the fraction done of the first run, and of the repetition.
    keep
        Called with the evidence once it is there, and the system at the end of the stretch.

    Raises
    ------
    ComputationError
        If the motion cannot go on, or somebody interrupts.
    """
    start, skipped, how, seen = _after_transient(system, course, watches[0])
    keep(seen.evidence(course), seen.end)
    seen_again = _observed(tighter(start), course, watches[1], tight=True)
    states, states_again = (_later_half(part.exponents.states) for part in (seen, seen_again))
    errors = np.abs(apart(states, states_again, seen.end.angles)).max(axis=0)
    evidence, again = seen.evidence(course, errors), seen_again.evidence(course, errors)
    verdict, reasons = judged(evidence, dissipative=course.dissipative)
    verdict_again, _ = judged(again, dissipative=course.dissipative)
    return Judgement(
        verdict=verdict,
        reasons=tuple(reasons),
        evidence=evidence,
        start=start,
        end=seen.end,
        skipped=skipped,
        how_skipped=how,
        again=again,
        end_again=seen_again.end,
        verdict_again=verdict_again,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Stretch(Generic[T]):
    """A stretch of a motion, from which evidence is gathered.

    Parameters
    ----------
    points, times, exponents
        As `Evidence` has them.
    end
        The system at the end.
    """

    points: Floats
    times: Floats
    exponents: Exponents
    end: T

    def evidence(self, course: Course[T], errors: Floats | None = None) -> Evidence:
        """What it shows; errors as `Course.tolerance` takes them."""
        angles, states = self.end.angles, self.exponents.states
        tolerance = course.tolerance(_later_half(states), errors)
        allowed = course.tolerance(_later_half(states), None)
        # what shrinks below errors of the integration comes to rest, however well it is resolved
        resting = np.where(shrinking(states, angles), allowed, tolerance)
        rests = course.parts > 1 and ends_alike(self.exponents, angles, resting)
        if rests and not course.driven(self.end.time, self.end.time + course.period):
            tolerance = resting
            between = copy.copy(self.end)
            between.advance(BETWEEN * course.period)
            (away,) = differences(between.state[None], states[-1:], angles, tolerance)
            rests = bool(away <= 1.0)
        else:
            rests = False
        return gathered(
            self.points,
            self.times,
            angles,
            self.exponents,
            tolerance,
            autonomous=course.section is not None,
            rests=rests,
            phases=tuple(self.times / other for other in course.others),
            observed=course.observed,
        )


def _after_transient(
    system: T, course: Course[T], watch: Watch | None
) -> tuple[T, int, str, _Stretch[T]]:
    """The system where the judged stretch begins, periods before, why, the stretch."""
    searched = course.skip is None and course.dissipative
    skipped = course.skip or (FIRST_SKIP if searched else 0)
    start = _later(system, course, skipped)
    seen = _observed(start, course, watch)
    if not searched:
        how = "nothing dissipates" if course.skip is None else "as asked for"
        return start, skipped, how, seen
    for _ in range(MOST_STRETCHES - 1):
        if not transient(seen.evidence(course)):
            break
        # the wait doubles, the stretch just looked at being part of it
        further = max(course.periods, skipped)
        start = _later(seen.end, course, further - course.periods)
        skipped += further
        seen = _observed(start, course, watch)
    found = transient(seen.evidence(course))
    how = f"the most that is tried: {found}" if found else "the motion is settled from there on"
    return start, skipped, how, seen


def _later_half(rows: Floats) -> Floats:
    """The half that does not show how a transient began."""
    return rows[len(rows) // 2 :]


def _later(system: T, course: Course[T], periods: int) -> T:
    """The same some periods later, with tangents of length one."""
    found = copy.copy(system)
    for _ in found.grow(periods, course.period):
        pass
    return found


def _observed(
    start: T, course: Course[T], watch: Watch | None, *, tight: bool = False
) -> _Stretch[T]:
    """The stretch that begins where a system is, which is left there."""
    end = copy.copy(start)
    exponents = lyapunov_spectrum(
        end,
        intervals=course.periods * course.parts,
        interval=course.period / course.parts,
        watch=watch,
    )
    if not tight:
        exponents = course.certified(end, exponents)
    if course.section is None:
        each = slice(None, -1, len(exponents.growth) // course.periods)
        points, times = exponents.states[each], exponents.times[each]
    else:
        points, times = course.section(start, tight)
    return _Stretch(points=points, times=times, exponents=exponents, end=end)
