"""``chaos``: a verdict on a motion with its evidence, on the terminal and as a page."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from linkages.cli.requests import File, Request
from linkages.cli.terminal import json_text
from linkages.cli.verbs.lyapunov_command import certificate_rows, certificate_tables, exponent_rows
from linkages.reports.report import Items, Notes, Report, Table, number

if TYPE_CHECKING:
    from linkages.chaos.findings import ChaosReport

LOOK = {
    "at rest": "blue",
    "periodic": "blue",
    "quasi-periodic": "green",
    "chaotic": "red",
    "undecided": "yellow",
}


def run(request: Request, periods: int | None, quick: bool) -> int:
    """Judge a motion; returns the exit code."""
    from linkages.chaos.findings import verdict
    from linkages.chaos.judge import FEWEST_PERIODS

    length = FEWEST_PERIODS if periods is None and quick else periods
    with request.computing("judging") as watch:
        report = verdict(request.mechanism, watch=watch, **{**request.given, "periods": length})
    if quick and periods is None and report.verdict == "undecided":
        with request.computing("judging longer") as watch:
            report = verdict(request.mechanism, watch=watch, **{**request.given, "periods": None})
    tables = _tables(report)

    def made() -> Iterator[File]:
        from linkages.reports.verdict_report import chaos_figures, chaos_page

        yield "chaos.json", json_text(report.to_dict())
        yield "chaos_section", report.section
        yield "chaos_exponents", report.exponents
        figures = chaos_figures(report) if request.figures else {}
        yield from figures.items()
        cells = [(table.heading.strip(), table.headings, table.cells) for table in tables]
        yield "chaos.html", chaos_page(report, cells, figures, request.mechanism)

    files = request.write(made(), {**request.asked, "periods": report.run["periods"]})
    said = Report(
        name=report.name,
        summary=report.verdict,
        colour=LOOK.get(report.verdict, "default"),
        parts=[Items(report.reasons), *tables, Notes(report.notes)],
        data=report.to_dict(),
    )
    return request.report(said, files)


def _tables(report: ChaosReport) -> list[Table]:
    """The evidence in numbers."""
    exponents = [
        [f"{row['index']}, {row['sign']}", number(row["value"]), f"{row['error']:.2g}"]
        for row in exponent_rows(report.exponents)
    ]
    lost = range(len(exponents) + 1, len(exponents) + report.exponents.attrs["lost"] + 1)
    exponents += [[f"{index}, lost", "−∞", "0"] for index in lost]
    heads = ["exponent", "value (1/s)", "standard error"]
    found = [Table("\nLyapunov exponents", heads, exponents, numbers=2)]
    if report.certificate:
        found += certificate_tables(certificate_rows(report.exponents))
    heads = ["coordinate", "0–1 test", "spread", "power in lines", "motion", "mean rate"]
    found.append(Table("\nFree coordinates", heads, _coordinates(report), numbers=5))
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
        found.append(Table("\nForces in clearances", heads, rows, numbers=4))
    others = Table("\nOther evidence", ["what", "found"], _others(report), numbers=1)
    return [*found, others]


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
        ["points of the section repeat", "no" if period is None else f"after {_many(period)}"],
        ["closed curves in the section", str(curves) if curves else "none"],
        [f"verdict at {tighter['how']}", str(tighter["verdict"])],
        ["correlation dimension of the section", _dimension(report)],
        ["forces depend on speeds", "no" if report.conservative else "yes"],
    ]
    if horizon is not None:
        until = f"t = {number(horizon.time)} s"
        rows.append(["motion has correct digits until", "the end" if horizon.whole else until])
    return rows


def _many(points: int) -> str:
    return f"{points} point{'' if points == 1 else 's'}"


def _dimension(report: ChaosReport) -> str:
    from linkages.chaos.dimension import FEWEST_POINTS

    found = report.dimension
    if found is None:
        return f"needs {FEWEST_POINTS} points"
    return "not clear" if found.doubt else f"{found.value:.3g} ± {found.error:.1g}"
