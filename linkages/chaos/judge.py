"""Verdict from evidence: at rest, periodic, quasi-periodic, chaotic or undecided."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.common_period import MOST_PERIODS
from linkages.chaos.exponents import Exponents, TangentSystem, Watch, lyapunov_spectrum
from linkages.chaos.indicators import Verdict
from linkages.chaos.lyapunov import PARTS
from linkages.chaos.periods import apart, differences
from linkages.chaos.stretch import Evidence, ends_alike, gathered, shrinking
from linkages.chaos.tori import PhaseCurve
from linkages.reading.wording import to_error

SIGNIFICANT = 4.0
"""Standard errors by which the largest exponent of a chaotic motion exceeds zero."""

REGULAR_GROWTH, CHAOTIC_GROWTH = 0.3, 0.6
"""Results of the 0–1 test that speak for regular and for chaotic motion."""

DRIFTING = 0.02
"""Standard deviations by which averages over both halves of a torus do not differ."""

UNSTEADY = 6.0
"""Standard errors by which those of a chaotic motion do not differ."""

SURFACE = 2
"""Directions in which tangents neither grow nor shrink where a torus is not seen as a curve."""

FEWEST_PERIODS = 200
"""The 0–1 test and the section need so many points."""

APART = f"Drives and loads have no common period (of at most {MOST_PERIODS} of one)"
"""Where the section is taken with the longest of their periods."""

LATER = 0.5
"""Part of the stretch from which on a motion has settled whose verdict is about that."""


def judged(evidence: Evidence, *, dissipative: bool) -> tuple[str, list[str]]:
    """A verdict and the sentences that lead to it."""
    reasons = [_growth(evidence)]
    regular = evidence.law is Verdict.REGULAR
    late = evidence.settled > LATER
    if evidence.rests and regular:
        reasons.append("The motion comes to rest." if evidence.settled else "Nothing moves.")
        return "at rest", reasons
    if len(evidence.points) < FEWEST_PERIODS:
        reasons.append(
            f"The Poincaré section has {len(evidence.points)} points, {FEWEST_PERIODS} are needed: "
            "the motion seldom crosses it."
        )
        return "undecided", reasons
    covered = all(curve.whole for curve in evidence.phases)
    if regular and evidence.period is not None and not late and covered:
        if evidence.autonomous and evidence.shrinks:
            reasons.append(
                "The motion comes to rest: nothing drives it, and a periodic motion would have an "
                "exponent of zero."
            )
            return "at rest", reasons
        return "periodic", [*reasons, _repeats(evidence)]
    tested = max(growth for growth, _ in evidence.tests)
    reasons.append(f"The 0–1 test gives {tested:.3f}.")
    if evidence.exponents.unsettled:
        reasons.append(evidence.exponents.unsettled)
    if evidence.period is None:
        verdict = _aperiodic(evidence, tested, dissipative, reasons)
        if verdict:
            return verdict, reasons
    result = transient(evidence) if dissipative else ""
    curves = 0 if evidence.curves is None else evidence.curves.count
    forced = "" if evidence.law is Verdict.CHAOTIC else _forced(evidence)
    if result:
        reasons.append(f"This is a transient: {result}. Skip more, or run longer.")
    elif forced:
        reasons.append(forced)
    elif curves and tested < REGULAR_GROWTH and evidence.law is Verdict.UNDECIDED:
        reasons.append(
            f"Poincaré section points lie on {_curves(curves)}, as those of quasi-periodic motions "
            "do; only tangents do not decide yet. Run more periods."
        )
    elif evidence.law is Verdict.CHAOTIC and evidence.period is not None:
        reasons.append(
            "Poincaré section points repeat within errors of integration, and yet tangents grow: "
            "what moves chaotically may be smaller than these errors. Take a smaller rtol and atol."
        )
    else:
        reasons.append("The evidence does not agree; run more periods.")
    return "undecided", reasons


def _aperiodic(
    evidence: Evidence, tested: float, dissipative: bool, reasons: list[str]
) -> str | None:
    """Chaotic, quasi-periodic, or neither."""
    exponents, curves = evidence.exponents, evidence.curves
    value, error = exponents.largest
    significant = value > SIGNIFICANT * error
    if evidence.law is Verdict.CHAOTIC:
        if not significant or tested <= CHAOTIC_GROWTH:
            return None
        positive = int((exponents.values > SIGNIFICANT * exponents.errors).sum())
        if positive > 1:
            reasons.append(f"{positive} exponents are positive (hyperchaos).")
        return "chaotic"
    steady = evidence.steady[0] <= DRIFTING
    if evidence.law is Verdict.REGULAR and not _forced(evidence) and evidence.phases:
        if evidence.shrinks or steady or not dissipative:
            reasons.append(_over_phase(evidence.phases[0]))
            return "quasi-periodic"
        return None
    if not evidence.neutral or (dissipative and not steady):
        return None
    if curves is not None and curves.count:
        reasons.append(f"Poincaré section points lie on {_curves(curves.count)}.")
        return "quasi-periodic"
    # at the end of a cascade of period doublings there is but one neutral direction
    directions = SURFACE + evidence.autonomous
    if evidence.neutral >= directions and tested < REGULAR_GROWTH and steady:
        why = "" if curves is None else f": {curves.reason}"
        reasons.append(
            f"Averages converge as on tori; Poincaré section points are on no clear curve{why}"
        )
        return "quasi-periodic"
    return None


def _curves(count: int) -> str:
    return "a closed curve" if count == 1 else f"{count} closed curves"


def _forced(evidence: Evidence) -> str:
    """Why a motion is not seen to follow drives that have no common period; empty if it is."""
    phases = evidence.phases
    if not phases:
        return ""
    if len(phases) > 1:
        return (
            f"{len(phases) + 1} drives or loads have no common period: section points would lie on "
            "surfaces, which are not looked for."
        )
    (curve,) = phases
    if not curve.whole:
        needed = math.ceil(len(evidence.points) / max(curve.covered, 1e-9))
        return (
            f"{APART}, and their phases run through {curve.covered:.1%} of a turn against each "
            f"other: run about {needed} periods."
        )
    if not curve.smooth and not evidence.shrinks:
        return (
            f"{APART}, and Poincaré section points are no function of the second phase: tori with "
            "a third frequency fill surfaces, which are not looked for."
        )
    if not curve.smooth:
        return (
            f"{APART}, and Poincaré section points are no smooth function of the second phase "
            f"(they are up to {curve.error:.0%} of their range off the curve through their "
            "neighbours): a strange nonchaotic attractor, or a torus with folds narrower than "
            f"{len(evidence.points)} points resolve. Run more periods."
        )
    return ""


def _over_phase(curve: PhaseCurve) -> str:
    """How section points follow a drive that has no common period with the stroboscope."""
    times = [
        f"every {curve.points} points" if curve.points > 1 else "",
        f"{curve.turns} turns of it" if curve.turns > 1 else "",
    ]
    closes = " and ".join(filter(None, times))
    return (
        f"{APART}; Poincaré section points are a smooth function of the second "
        f"phase{f', again after {closes}' if closes else ''}: they lie on a torus."
    )


def transient(evidence: Evidence) -> str:
    """Why a motion that dissipates is still on its way to its attractor; empty if it is there."""
    if evidence.settled:
        how = (
            "comes to rest" if evidence.rests
            else "repeats" if evidence.period is not None
            else "lies on closed curves"
        )  # fmt: skip
        return f"the motion {how} only after {evidence.settled:.0%} of the stretch"
    if evidence.rests or evidence.period is not None or (evidence.phases and evidence.shrinks):
        return ""
    if evidence.shrinks:
        return "tangents shrink, and the motion does not repeat yet"
    apart, errors = evidence.steady
    chaotic = evidence.law is Verdict.CHAOTIC
    if apart > DRIFTING and (errors > UNSTEADY or not chaotic):
        return f"averages over its halves differ by {apart:.2g} standard deviations"
    return ""


def _growth(evidence: Evidence) -> str:
    """The largest exponent, and the law of its tangents."""
    if not evidence.exponents.some:
        return (
            "Contacts that closed leave no neighbours of the motion: all Lyapunov exponents are −∞."
        )
    how = {
        Verdict.CHAOTIC: "grow exponentially, as along chaotic motions",
        Verdict.REGULAR: "grow like a power of time, as along regular motions",
        Verdict.UNDECIDED: "grow neither clearly like a power of time nor exponentially",
    }[evidence.law]
    if evidence.shrinks:
        how = "shrink exponentially, as along motions that attract their neighbours"
    value, error = evidence.exponents.largest
    shown, by = to_error(value, error)
    return f"The largest Lyapunov exponent is {shown} ± {by} 1/s; tangents {how}."


def _repeats(evidence: Evidence) -> str:
    many = f"after {evidence.period} point{'' if evidence.period == 1 else 's'}"
    if not evidence.settled:
        return f"The Poincaré section repeats {many}."
    first = round(evidence.settled * len(evidence.points))
    return f"The Poincaré section repeats {many}, from its point {first + 1} on."


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

    `section`: of the system, where it is, and whether with the smaller error: `periods` points of a
    geometric section from there on, shape (points, d), and their times; the system is left as it
    is. None for a point each period.
    `tolerance`: of the states of the later half of a stretch, shape (n, d), and their largest
    differences from those with the smaller error, shape (d,), None before they are known:
    difference of entries that counts as none, (d,).
    """

    # Time, or steps, from one section point to the next; of geometric sections about that
    period: float
    periods: int  # length of the stretch that is judged
    skip: int | None = None  # periods before; None to skip the transient, as far as it is found
    dissipative: bool = True  # whether there may be attractors, and so a transient
    # Intervals within a period after which tangents are made orthonormal again; 1 for maps
    parts: int = PARTS
    section: Callable[[T, bool], tuple[Floats, Floats]] | None = None
    # Periods of drives and loads that have none in common with `period`, the stroboscope's
    others: tuple[float, ...] = ()
    # Whether drives move something between two times: where the rest of the state does not change
    # the motion is not at rest then
    driven: Callable[[float, float], bool] = lambda _, __: False
    tolerance: Callable[[Floats, Floats | None], Floats] = _alike
    # The 0–1 test observes so many entries, the first ones; all by default
    observed: int | None = None
    # Of the system at the end of a stretch, and exponents: these, with what is known of them
    certified: Callable[[T, Exponents], Exponents] = lambda _, exponents: exponents


@dataclass(frozen=True, kw_only=True, eq=False)
class Judgement(Generic[T]):
    """A verdict with its evidence.

    `verdict`, `reasons`: as `linkages.chaos.judge.judged` gives them.
    `start`, `end`: the system where that begins, and where it ends.
    `skipped`, `how_skipped`: periods before it, and why so many.
    `again`, `end_again`, `verdict_again`: the same from the same state on with a smaller error.
    """

    verdict: str
    reasons: tuple[str, ...]
    evidence: Evidence  # of the stretch that was judged
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
    """Judge the motion of a system from where it is, which is left there."""
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

    `points`, `times`, `exponents`: as `Evidence` has them.
    """

    points: Floats
    times: Floats
    exponents: Exponents
    end: T  # the system at the end

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
    result = transient(seen.evidence(course))
    how = f"the most that is tried: {result}" if result else "the motion is settled from there on"
    return start, skipped, how, seen


def _later_half(rows: Floats) -> Floats:
    """The half that does not show how a transient began."""
    return rows[len(rows) // 2 :]


def _later(system: T, course: Course[T], periods: int) -> T:
    """The same some periods later, with tangents of length one."""
    result = copy.copy(system)
    for _ in result.grow(periods, course.period):
        pass
    return result


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
