"""The tests of a verdict: what each gave, and its thresholds."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

from linkages.chaos.growth.indicators import CHAOTIC_POWER, REGULAR_POWER
from linkages.chaos.series.closed_curves import COVERED
from linkages.chaos.series.closed_curves import FEWEST as FEWEST_ON_CURVES
from linkages.chaos.series.periods import REPEATS
from linkages.chaos.series.phase_curves import SMOOTH
from linkages.chaos.verdicts.evidence import ALIKE
from linkages.chaos.verdicts.verdict import (
    CHAOTIC_GROWTH,
    FEWEST_PERIODS,
    REGULAR_GROWTH,
    SIGNIFICANT,
)
from linkages.reading.wording import to_error

if TYPE_CHECKING:
    from linkages.chaos.verdicts.findings import ChaosReport

HEADS = ("test", "found", "regular", "chaotic")

MEANINGS = (
    "Largest Lyapunov exponent: the mean rate at which neighbouring motions separate. It tells of "
    f"chaos if it exceeds zero by {SIGNIFICANT:g} standard errors; it is zero for quasi-periodic "
    "motion, and negative where a periodic orbit, or a torus that drives impose, attracts its "
    "neighbours.",
    "Growth of tangents (fast Lyapunov indicator): the power of time with which tangents grew "
    "while time last doubled. Along regular motions it is about 1, or negative where they attract; "
    "along chaotic motions it rises as long as the run goes on.",
    "0–1 test K (Gottwald and Melbourne, 2009): a correlation near 0 for regular motion and near 1 "
    f"for chaos, with its spread over frequencies. It needs {FEWEST_PERIODS} section points; the "
    "largest K decides.",
    "Poincaré section repeats: a motion is periodic if its section points come back within "
    f"{ALIKE:g} of their range, or within errors of the integration, {REPEATS} times or more.",
    f"Closed curves: a motion is quasi-periodic if {COVERED:.0%} of its section points lie on "
    f"closed curves, at least {FEWEST_ON_CURVES} on each; or, where two drives have no common "
    f"period, if all are within {SMOOTH:.0%} of their range on a curve over the second phase.",
    "Power in lines: the part of the power spectrum of a rate that single lines carry. It has no "
    "threshold and decides nothing: nearly all for regular motion, less for chaos.",
    "Repetition: a classification that changes with the tolerance rests on numerical error.",
)
"""A sentence or two for each test, in the order of the table."""


def rows(report: ChaosReport) -> list[list[str]]:
    """What each test gave, and its thresholds."""
    curves = 0 if report.curves is None else report.curves.count
    many = "no" if report.period is None else f"after {_points(report.period)}"
    correlation = _limits("", REGULAR_GROWTH, CHAOTIC_GROWTH)
    again, limit = report.tighter, f"up to {SMOOTH:g}"
    return [
        _exponent(report),
        [
            "growth of tangents",
            f"t^{report.power:.3g}" if isfinite(report.power) else "none left",
            *_limits("t^", REGULAR_POWER, CHAOTIC_POWER),
        ],
        *(
            [f"0–1 test, {name}", f"{k:.3f} ± {spread:.2g}", *correlation]
            for name, (k, spread) in report.zero_one.items()
        ),
        ["Poincaré section repeats", many, "if so", "no"],
        ["closed curves", str(curves), "1 or more", "0"],
        *(
            ["off a curve over the phase of another drive", f"{curve.error:.2g}", limit, "more"]
            for curve in report.phases
        ),
        *(
            [f"power in lines, {name}", f"{found.line_share:.2%}", "nearly 100%", "less"]
            for name, found in report.spectra.items()
        ),
        [f"repetition, {again['how']}", str(again["verdict"]), *["the same classification"] * 2],
    ]


def _limits(before: str, regular: float, chaotic: float) -> list[str]:
    return [f"below {before}{regular:g}", f"above {before}{chaotic:g}"]


def _exponent(report: ChaosReport) -> list[str]:
    """The largest exponent with its error, beside as many errors as it must exceed."""
    test = "largest Lyapunov exponent"
    if not report.exponents.sizes["index"]:
        return [test, "−∞", "up to 0", "above 0"]
    value, error = (float(report.exponents[name][0]) for name in ("exponent", "error"))
    shown, by = to_error(value, error)
    limit = f"{SIGNIFICANT * error:.2g} 1/s"
    return [test, f"{shown} ± {by} 1/s", f"up to {limit}", f"above {limit}"]


def _points(count: int) -> str:
    return f"{count} point{'' if count == 1 else 's'}"
