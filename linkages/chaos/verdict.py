"""From evidence to a verdict: periodic, quasi-periodic, chaotic or undecided."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from linkages.chaos.closed_curves import ClosedCurves
from linkages.chaos.exponents import Exponents
from linkages.chaos.indicators import Verdict, classify

SIGNIFICANT = 4.0
"""Standard errors by which the largest exponent of a chaotic motion exceeds zero."""

REGULAR_GROWTH, CHAOTIC_GROWTH = 0.3, 0.6
"""Results of the 0–1 test that speak for regular and for chaotic motion."""

FEWEST_PERIODS = 200
"""The 0–1 test and the section need so many points."""


def judged(
    exponents: Exponents,
    tests: Mapping[str, tuple[float, float]],
    period: int | None,
    curves: ClosedCurves | None,
    points: int = FEWEST_PERIODS,
) -> tuple[str, list[str]]:
    """A verdict and the sentences that lead to it.

    Parameters
    ----------
    exponents
        With the growth of tangents in every interval.
    tests
        Free coordinate → growth of the 0–1 test and its spread; empty without enough points.
    period
        Section points until the motion repeats; None if it does not.
    curves
        Whether section points lie on closed curves; None where that was not looked for.
    points
        Number of section points.
    """
    value, error = float(exponents.values[0]), float(exponents.errors[0])
    significant, shrinking = value > SIGNIFICANT * error, value < -SIGNIFICANT * error
    growth = np.cumsum(exponents.growth[:, 0] * np.diff(exponents.times))
    law = classify(exponents.times[1:] - exponents.times[0], growth)
    how = {
        Verdict.CHAOTIC: "grow exponentially, as along chaotic motions.",
        Verdict.REGULAR: "grow like a power of time, as along regular motions.",
        Verdict.UNDECIDED: "grow neither clearly like a power of time nor exponentially.",
    }[law]
    if shrinking:
        how = "shrink exponentially, as along motions that attract their neighbours."
    reasons = [f"The largest exponent is {value:.4g} ± {error:.2g} 1/s; tangents {how}"]
    if points < FEWEST_PERIODS:
        reasons.append(
            f"The section has {points} points, {FEWEST_PERIODS} are needed: the motion comes to "
            "rest, or seldom crosses it."
        )
        return "undecided", reasons
    tested = max(tests.values(), key=lambda found: found[0])[0]
    reasons.append(f"The 0–1 test gives {tested:.3f}.")
    if exponents.unsettled:
        reasons.append(exponents.unsettled)
    if law is Verdict.CHAOTIC and significant and tested > CHAOTIC_GROWTH:
        return "chaotic", reasons
    calm = law is Verdict.REGULAR or shrinking
    if calm and period is not None:
        reasons.append(f"The section repeats after {period} point{'s' if period > 1 else ''}.")
        return "periodic", reasons
    if calm and curves is not None and curves.count:
        number = "a closed curve" if curves.count == 1 else f"{curves.count} closed curves"
        reasons.append(f"Section points lie on {number}.")
        return "quasi-periodic", reasons
    if calm and tested < REGULAR_GROWTH:
        if curves is not None:
            reasons.append(f"Section points are not clearly on a curve: {curves.reason}")
        return "quasi-periodic", reasons
    reasons.append("The evidence does not agree; run more periods.")
    return "undecided", reasons
