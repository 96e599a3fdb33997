"""``chaos``: a verdict on a motion with its evidence, on the terminal and as a page."""

from __future__ import annotations

from collections.abc import Iterator

from linkages.cli.requests import File, Request
from linkages.cli.terminal import json_text
from linkages.reports.verdict_report import verdict_report


def run(request: Request, periods: int | None, quick: bool) -> int:
    """Judge a motion; returns the exit code."""
    from linkages.chaos.findings import verdict
    from linkages.chaos.judge import FEWEST_PERIODS

    mechanism, length = request.mechanism, FEWEST_PERIODS if periods is None and quick else periods
    with request.computing("judging") as watch:
        found = verdict(mechanism, watch=watch, **{**request.given, "periods": length})
    if quick and periods is None and found.verdict == "undecided":
        with request.computing("judging longer") as watch:
            found = verdict(mechanism, watch=watch, **{**request.given, "periods": None})

    def made() -> Iterator[File]:
        from linkages.plots.chaos.chaos_figures import chaos_figures
        from linkages.reports.pages import page

        yield "chaos.json", json_text(found.to_dict())
        yield "chaos_section", found.section
        yield "chaos_exponents", found.exponents
        figures = chaos_figures(found) if request.figures else {}
        yield from figures.items()
        yield "chaos.html", page(verdict_report(found, mechanism, figures), mechanism)

    files = request.write(made(), {**request.asked, "periods": found.run["periods"]})
    return request.report(verdict_report(found, mechanism, {}), files)
