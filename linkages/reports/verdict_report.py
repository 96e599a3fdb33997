"""The report of a verdict with its evidence."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import TYPE_CHECKING, Any

from linkages.chaos.evidence import ALIKE
from linkages.chaos.exponents import certificate_rows, exponent_rows
from linkages.chaos.indicators import CHAOTIC_POWER, FEWEST_POINTS, REGULAR_POWER
from linkages.chaos.judge import CHAOTIC_GROWTH, FEWEST_PERIODS, REGULAR_GROWTH, SIGNIFICANT
from linkages.chaos.periods import REPEATS
from linkages.chaos.tori import COVERED, SMOOTH
from linkages.chaos.tori import FEWEST as FEWEST_ON_CURVES
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.system import System
from linkages.reading.wording import to_error
from linkages.reports.report import (
    Column,
    Definition,
    Items,
    Notes,
    Part,
    Picture,
    Report,
    Section,
    Table,
    number,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from linkages.chaos.findings import ChaosReport

COLOURS = {
    "at rest": ("bold blue", "#56B4E9"),
    "periodic": ("bold blue", "#0072B2"),
    "quasi-periodic": ("bold green", "#009E73"),
    "chaotic": ("bold red", "#D55E00"),
    "undecided": ("bold yellow", "#5A5A5A"),
}
"""Of verdicts on terminals and on pages."""

CAPTIONS = {
    "chaos_section": "Section: {section}.",
    "chaos_exponents": "Lyapunov exponents up to each time. Bands: two standard errors.",
    "chaos_spectrum": "Power spectra of the rates. Regular motions have lines only.",
    "chaos_contact": "Forces in clearances. A pin cannot pull: below zero it would leave the hole.",
}


def verdict_report(
    found: ChaosReport, mechanism: Mechanism, figures: Mapping[str, Figure]
) -> Report:
    """The verdict with its evidence; pages also have thresholds, the definition and figures."""
    drawing: list[Part] = []
    if figures:
        from linkages.plots.mechanism.drawing import start_figure

        drawing = [Picture(start_figure(System(mechanism)), "The mechanism at t = 0.")]
    tests: list[Part] = [Table("", HEADS, threshold_rows(found)), Items(MEANINGS)]
    return Report(
        name=found.name,
        summary=found.verdict,
        colours=COLOURS[found.verdict],
        parts=[
            Items(found.reasons),
            *drawing,
            Section("Tests and their thresholds", tests),
            *_tables(found),
            *(Picture(figure, _caption(name, found)) for name, figure in figures.items()),
            Notes(found.notes),
            Section("Origin", [Definition(mechanism.to_yaml())]),
        ],
        data=found.to_dict(),
    )


def _caption(name: str, report: ChaosReport) -> str:
    taken = report.section.attrs
    section = "a point per period of the drives"
    if "other_periods" in taken:
        section += f" ({taken['period']:.6g} s, and others have none in common with it)"
    if "section" in taken:
        section = f"a point wherever {taken['section']} is crossed ({taken['direction']})"
    return CAPTIONS[name].format(section=section)


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


def threshold_rows(report: ChaosReport) -> list[list[str]]:
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
            [f"power in lines, {name}", f"{item.line_share:.2%}", "nearly 100%", "less"]
            for name, item in report.spectra.items()
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


def _tables(report: ChaosReport) -> list[Table]:
    """The evidence in numbers."""
    exponents = [
        [f"{row['index']}, {row['sign']}", number(row["value"]), f"{row['error']:.2g}"]
        for row in exponent_rows(report.exponents)
    ]
    lost = range(len(exponents) + 1, len(exponents) + report.exponents.attrs["lost"] + 1)
    exponents += [[f"{index}, lost", "−∞", "0"] for index in lost]
    heads = ["exponent", "value (1/s)", "standard error"]
    result = [Table("\nLyapunov exponents", heads, exponents, numbers=2)]
    if report.certificate:
        result += certificate_tables(certificate_rows(report.exponents))
    heads = ["coordinate", "0–1 test", "spread", "power in lines", "motion", "mean rate"]
    result.append(Table("\nFree coordinates", heads, _coordinates(report), numbers=5))
    if report.contact:
        heads = ["clearance", "least (N)", "greatest (N)", "without contact", "first at t (s)"]
        rows = [
            [
                contact.clearance,
                number(contact.smallest),
                number(contact.largest),
                f"{100 * contact.share_lost:.3g} %",
                "never" if contact.first_loss is None else number(contact.first_loss),
            ]
            for contact in report.contact
        ]
        result.append(Table("\nForces in clearances", heads, rows, numbers=4))
    others = Table("\nOther evidence", ["what", "found"], _others(report), numbers=1)
    return [*result, others]


def certificate_tables(rows: list[dict[str, Any]]) -> list[Table]:
    """What is known of the exponents as a table, if anything is."""
    columns = (
        "name: invariant",
        Column("found", "found", "1/s"),
        Column("known", "expected", "1/s"),
        Column("tolerance", "tolerance", form=".2g"),
    )
    heading = "\nCertificate of the Lyapunov exponents"
    said = [{**r, "name": r["name"] + ("" if r["holds"] else ": VIOLATED")} for r in rows]
    return [Table.of(heading, said, *columns, numbers=3)] if rows else []


def _coordinates(report: ChaosReport) -> list[list[str]]:
    rows = []
    for name, spectrum in report.spectra.items():
        growth, rotation = report.zero_one.get(name), report.rotation.get(name)
        rate, unit = report.rates[name]
        rows.append(
            [
                name,
                "" if growth is None else f"{growth[0]:.3f}",
                "" if growth is None else f"{growth[1]:.2g}",
                f"{100 * spectrum.line_share:.4g} %",
                "–" if rotation is None else str(rotation.kind),
                f"{number(rate)} {unit}",
            ]
        )
    return rows


def _others(report: ChaosReport) -> list[list[str]]:
    tighter, horizon, period = report.tighter, report.horizon, report.period
    curves = 0 if report.curves is None else report.curves.count
    run = report.run
    rows = [
        ["length", f"{run['periods']} periods of {number(run['period'])} s"],
        *(["no common period with", f"{number(other)} s"] for other in run["other_periods"]),
        ["skipped before", f"{run['skip']} periods: {run['skipped']}"],
        ["integrated by", f"{run['method']}, {run['how']}"],
        ["points of the section repeat", "no" if period is None else f"after {_points(period)}"],
        ["closed curves in the section", str(curves) if curves else "none"],
        [f"verdict at {tighter['how']}", str(tighter["verdict"])],
        ["correlation dimension of the section", _dimension(report)],
        ["forces depend on speeds", "no" if report.conservative else "yes"],
    ]
    if horizon is not None:
        until = f"t = {number(horizon.time)} s"
        rows.append(["motion has correct digits until", "the end" if horizon.whole else until])
    return rows


def _dimension(report: ChaosReport) -> str:
    result = report.dimension
    if result is None:
        return f"needs {FEWEST_POINTS} points"
    return "not clear" if result.doubt else f"{result.value:.3g} ± {result.error:.1g}"
