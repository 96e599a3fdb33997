"""``view``: a page on which the mechanism moves, and can be changed."""

from __future__ import annotations

import webbrowser

from linkages.cli.requests import Request, as_far_as_possible, how_far
from linkages.errors import ComputationError
from linkages.reports.report import Notes, Report, Unbroken

NAME = "view"
"""Of the file."""


def run(request: Request, outputs: str | None, browser: bool) -> int:
    """Simulate a file and write the page, as `linkages.view` does; returns the exit code."""
    from linkages.kernel.system import System
    from linkages.viewer.recorded import wanted
    from linkages.viewer.view import html

    with request.computing("simulating") as watch:
        names = wanted(System(request.mechanism), outputs)
        solution, failure, interrupted = as_far_as_possible(
            request.mechanism, outputs=names, watch=watch, **request.given
        )
    if not solution.data.sizes["time"]:
        raise ComputationError(f"nothing to show: {failure}", time=None)
    (path,) = request.write(
        [(f"{NAME}.html", html(solution))], solution.options, complete=failure is None,
        interrupted=interrupted,
    )  # fmt: skip
    if browser:
        webbrowser.open(path.absolute().as_uri())
    size, notes = path.stat().st_size, list(solution.notes)
    report = Report(
        name=request.mechanism.name,
        summary=solution.summary,
        parts=[Notes(notes), Unbroken(f"{path}: open it in a browser")],
        data={**how_far(solution, failure), "bytes": size, "notes": notes},
    )
    return request.report(report, [path], failure=failure, listed=False)
