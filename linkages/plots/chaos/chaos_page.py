"""A page that shows a verdict on a motion with its evidence; one file that needs no other."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from html import escape
from io import BytesIO
from string import Template
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from linkages.plots import notebook
from linkages.plots.chaos import contact, exponents, sections, spectra
from linkages.plots.style import style

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

PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>$title</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; color: #1a1a1a; background: #fff;
       max-width: 54rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; margin-bottom: .2rem; }
h2 { font-size: 1.1rem; margin: 2rem 0 .4rem; border-bottom: 1px solid #ddd; }
.source { color: #666; margin: 0 0 1rem; overflow-wrap: anywhere; }
.verdict { display: inline-block; color: #fff; background: $colour; border-radius: .3rem;
           font-size: 1.2rem; font-weight: 600; padding: .15rem .7rem; }
table { border-collapse: collapse; margin: .4rem 0; }
th, td { text-align: left; padding: .15rem 1.2rem .15rem 0; border-bottom: 1px solid #eee; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
figure { margin: 1.2rem 0; }
figure img { max-width: 100%; height: auto; display: block; }
figcaption { color: #555; font-size: .9rem; }
</style>
</head>
<body>
<h1>$title</h1>
<p class="source">$source</p>
<p><span class="verdict">$verdict</span></p>
<ul>
$reasons
</ul>
$tables
$figures
$notes
<p class="source">linkages $version</p>
</body>
</html>
""")

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


def chaos_page(report: ChaosReport, tables: Sequence[Table], figures: Mapping[str, Figure]) -> str:
    """The page as HTML; everything in it that comes from the file is escaped.

    Parameters
    ----------
    report
        From `linkages.chaos.verdicts.report.chaos`.
    tables
        Evidence in numbers.
    figures
        From `chaos_figures`; empty for a page without.
    """
    from importlib.metadata import version

    notes = [*report.notes]
    return PAGE.substitute(
        title=escape(report.name),
        version=version("linkages"),
        source=escape(report.source),
        colour=COLOURS.get(report.verdict, COLOURS["undecided"]),
        verdict=escape(report.verdict),
        reasons=_items(report.reasons),
        tables="\n".join(_table(*table) for table in tables),
        figures="\n".join(_figure(f, _caption(n, report)) for n, f in figures.items()),
        notes=f"<h2>Notes</h2>\n<ul>\n{_items(notes)}\n</ul>" if notes else "",
    )


def _items(texts: Sequence[str]) -> str:
    return "\n".join(f"<li>{escape(text)}</li>" for text in texts)


def _table(heading: str, heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    return f"<h2>{escape(heading)}</h2>\n{notebook.table(heads, rows)}"


def _caption(name: str, report: ChaosReport) -> str:
    taken = report.section.attrs
    section = "a point per period of the drives"
    if "section" in taken:
        section = f"a point wherever {taken['section']} is crossed ({taken['direction']})"
    return CAPTIONS[name].format(section=section)


def _figure(figure: Figure, text: str) -> str:
    stream = BytesIO()
    with style():
        figure.savefig(stream, format="png", metadata={"Software": None})
    source = b64encode(stream.getvalue()).decode("ascii")
    caption = escape(text)
    return (
        f'<figure><img alt="{caption}" src="data:image/png;base64,{source}">'
        f"<figcaption>{caption}</figcaption></figure>"
    )
