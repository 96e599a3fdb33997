"""From evidence to a verdict: at rest, periodic, quasi-periodic, chaotic or undecided."""

from __future__ import annotations

import math

from linkages.chaos.growth.indicators import Verdict
from linkages.chaos.sections.common_period import MOST_PERIODS
from linkages.chaos.series.phase_curves import PhaseCurve
from linkages.chaos.verdicts.stretch import Evidence
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
    """A verdict and the sentences that lead to it.

    Parameters
    ----------
    evidence
        Of one stretch of a motion.
    dissipative
        Whether there are attractors; a motion may still be on its way to one then.
    """
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
    found = transient(evidence) if dissipative else ""
    curves = 0 if evidence.curves is None else evidence.curves.count
    forced = "" if evidence.law is Verdict.CHAOTIC else _forced(evidence)
    if found:
        reasons.append(f"This is a transient: {found}. Skip more, or run longer.")
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
