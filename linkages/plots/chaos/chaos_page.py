"""A page that shows a verdict on a motion with its evidence; one file that needs no other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.system import System
from linkages.plots import pages
from linkages.plots.chaos import contact, exponents, sections, spectra, thresholds
from linkages.plots.mechanism import drawing

if TYPE_CHECKING:
    import xarray as xr

    from linkages.chaos.verdicts.findings import ChaosReport

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
        "chaos_section": sections.figure(report.section),
        "chaos_exponents": exponents.figure(report.exponents),
        "chaos_spectrum": spectra.figure(report.spectra, report.name),
    }
    if report.force is not None:
        found["chaos_contact"] = contact.figure(shown_forces(report), report.name)
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
        From `linkages.chaos.verdicts.report.chaos`.
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
            pages.table(thresholds.HEADS, thresholds.rows(report), texts=True),
            pages.items(thresholds.MEANINGS),
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
