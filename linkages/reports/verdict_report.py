"""The page of a verdict with its evidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from linkages.chaos.evidence import ALIKE
from linkages.chaos.indicators import CHAOTIC_POWER, REGULAR_POWER
from linkages.chaos.judge import CHAOTIC_GROWTH, FEWEST_PERIODS, REGULAR_GROWTH, SIGNIFICANT
from linkages.chaos.periods import REPEATS
from linkages.chaos.tori import COVERED, SMOOTH
from linkages.chaos.tori import FEWEST as FEWEST_ON_CURVES
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.system import System
from linkages.plots.chaos.chaos_figures import contact_figure, exponent_figure, spectrum_figure
from linkages.plots.chaos.section_figures import section_figure
from linkages.plots.mechanism import drawing
from linkages.reading.wording import to_error
from linkages.reports import pages

if TYPE_CHECKING:
    import xarray as xr

    from linkages.chaos.findings import ChaosReport

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


PERIODS = 4
"""Periods over which forces in clearances are shown."""

COLOURS = {
    "at rest": "#56B4E9",
    "periodic": "#0072B2",
    "quasi-periodic": "#009E73",
    "chaotic": "#D55E00",
    "undecided": "#5A5A5A",
}

CAPTIONS = {
    "chaos_section": "Section: {section}.",
    "chaos_exponents": "Lyapunov exponents up to each time. Bands: two standard errors.",
    "chaos_spectrum": "Power spectra of the rates. Regular motions have lines only.",
    "chaos_contact": "Forces in clearances. A pin cannot pull: below zero it would leave the hole.",
}

Table = tuple[str, Sequence[str], Sequence[Sequence[str]]]
"""Heading, heads, rows of cells; the first column is text, the others are numbers."""


def chaos_figures(report: ChaosReport) -> dict[str, Figure]:
    """Name → figure, as far as the report has something to show."""
    found: dict[str, Figure | None] = {
        "chaos_section": section_figure(report.section),
        "chaos_exponents": exponent_figure(report.exponents),
        "chaos_spectrum": spectrum_figure(report.spectra, report.name),
    }
    if report.force is not None:
        found["chaos_contact"] = contact_figure(shown_forces(report), report.name)
    return {name: figure for name, figure in found.items() if figure is not None}


def shown_forces(report: ChaosReport) -> xr.DataArray:
    """Forces over a few periods: where contact is lost first, else the last ones."""
    assert report.force is not None
    time = np.asarray(report.force["time"], dtype=float)
    taken = np.asarray(report.section["time"], dtype=float)
    period = float(np.median(np.diff(taken))) if len(taken) > 1 else float(np.ptp(time))
    losses = [found.first_loss for found in report.contact if found.first_loss is not None]
    length = PERIODS * period
    begin = min(losses) - 0.5 * period if losses else time[-1] - length
    begin = max(time[0], min(begin, time[-1] - length))
    return report.force.isel(time=(time >= begin) & (time <= begin + length))


def chaos_page(
    report: ChaosReport,
    tables: Sequence[Table],
    figures: Mapping[str, Figure],
    mechanism: Mechanism,
) -> str:
    """The page as HTML; everything in it that comes from the file is escaped.

    Parameters
    ----------
    report
        From `linkages.chaos.findings.chaos`.
    tables
        Evidence in numbers.
    figures
        From `chaos_figures`; empty for a page without any.
    mechanism
        What was judged: its drawing and its definition are on the page.
    """
    colour = COLOURS.get(report.verdict, COLOURS["undecided"])
    style = f"background: {colour}"
    body = [
        f'<p><span class="label" style="{style}">{escape(report.verdict)}</span></p>',
        pages.items(report.reasons),
        _drawing(mechanism) if figures else "",
        pages.section(
            "Tests and their thresholds",
            pages.table(HEADS, rows(report), texts=True),
            pages.items(MEANINGS),
        ),
        *(pages.section(heading, pages.table(heads, rows)) for heading, heads, rows in tables),
        *(pages.figure_with(figure, _caption(name, report)) for name, figure in figures.items()),
        pages.section("Notes", pages.items(report.notes)),
        pages.section("Origin", pages.definition(mechanism.to_yaml())),
    ]
    return pages.page(report.name, report.source, mechanism.changes, body)


def _drawing(mechanism: Mechanism) -> str:
    figure = drawing.start_figure(System(mechanism))
    return pages.figure_with(figure, "The mechanism at t = 0.")


def _caption(name: str, report: ChaosReport) -> str:
    taken = report.section.attrs
    section = "a point per period of the drives"
    if "other_periods" in taken:
        section += f" ({taken['period']:.6g} s, and others have none in common with it)"
    if "section" in taken:
        section = f"a point wherever {taken['section']} is crossed ({taken['direction']})"
    return CAPTIONS[name].format(section=section)
