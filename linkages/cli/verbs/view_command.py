"""``view``: a page on which the mechanism moves, and can be changed."""

from __future__ import annotations

import webbrowser

from rich.console import Console
from rich.markup import escape

from linkages.cli.requests import Request
from linkages.cli.simulated import as_far_as_possible, how_far
from linkages.cli.terminal import print_notes
from linkages.errors import ComputationError

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
        [(f"{NAME}.html", html(solution))],
        solution.options,
        complete=failure is None,
        interrupted=interrupted,
    )
    if browser:
        webbrowser.open(path.absolute().as_uri())

    def show(screen: Console) -> None:
        screen.print(f"[bold]{escape(request.mechanism.name)}[/bold]: {escape(solution.summary)}")
        print_notes(solution.notes, screen)
        screen.print(f"{path}: open it in a browser", markup=False, soft_wrap=True)

    content = {**how_far(solution, failure), "bytes": path.stat().st_size,
               "notes": list(solution.notes)}  # fmt: skip
    return request.report(content, [path], show, failure=failure, listed=False)
