"""``chaos``: a verdict on a motion with its evidence, on the terminal and as a page."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape

from linkages.cli.requests import File, Request
from linkages.cli.terminal import json_text, number, print_notes, table
from linkages.cli.verbs.lyapunov_command import certificate_rows, certificate_table, exponent_rows

if TYPE_CHECKING:
    from linkages.chaos.findings import ChaosReport

LOOK = {
    "at rest": "blue",
    "periodic": "blue",
    "quasi-periodic": "green",
    "chaotic": "red",
    "undecided": "yellow",
}
Table = tuple[str, list[str], list[list[str]]]


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
    tables, content = _tables(report), report.to_dict()

    def made() -> Iterator[File]:
        from linkages.plots.chaos.chaos_page import chaos_figures, chaos_page

        yield "chaos.json", json_text(content)
        yield "chaos_section", report.section
        yield "chaos_exponents", report.exponents
        figures = chaos_figures(report) if request.figures else {}
        yield from figures.items()
        yield "chaos.html", chaos_page(report, tables, figures, request.mechanism)

    files = request.write(made(), {**request.asked, "periods": report.run["periods"]})
    return request.report(content, files, partial(_print, report, tables))


def _tables(report: ChaosReport) -> list[Table]:
    """The evidence in numbers."""
    exponents = [
        [f"{row['index']}, {row['sign']}", number(row["value"]), f"{row['error']:.2g}"]
        for row in exponent_rows(report.exponents)
    ]
    lost = range(len(exponents) + 1, len(exponents) + report.exponents.attrs["lost"] + 1)
    exponents += [[f"{index}, lost", "−∞", "0"] for index in lost]
    found: list[Table] = [
        ("Lyapunov exponents", ["exponent", "value (1/s)", "standard error"], exponents),
    ]
    if report.certificate:
        found.append(certificate_table(certificate_rows(report.exponents)))
    found.append(_coordinates(report))
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
        found.append(("Forces in clearances", heads, rows))
    found.append(("Other evidence", ["what", "found"], _others(report)))
    return found


def _coordinates(report: ChaosReport) -> Table:
    heads = ["coordinate", "0–1 test", "spread", "power in lines", "motion", "mean rate"]
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
    return "Free coordinates", heads, rows


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


def _print(report: ChaosReport, tables: list[Table], screen: Console) -> None:
    look = LOOK.get(report.verdict, "default")
    screen.print(f"[bold]{escape(report.name)}[/bold]: [bold {look}]{report.verdict}[/]")
    for reason in report.reasons:
        screen.print(f"- {reason}", markup=False, soft_wrap=True)
    for heading, heads, rows in tables:
        screen.print(table(f"\n{heading}", heads, rows, numbers=len(heads) - 1))
    print_notes(report.notes, screen)
