"""``phase``: two outputs of a motion against each other, as a figure and a table."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from rich.console import Console
from rich.markup import escape

from linkages.cli.requests import File, Request
from linkages.cli.simulated import as_far_as_possible
from linkages.cli.terminal import table
from linkages.errors import ComputationError, InputError, Problem
from linkages.options.option import OptionError
from linkages.options.run import SimulationOptions
from linkages.reading.wording import listed
from linkages.solution.run_options import options_of

FEWEST_SAMPLES = 10_001
"""A curve through fewer points shows corners where a clearance turns fast."""


def run(
    request: Request,
    x: Sequence[str],
    y: Sequence[str],
    wrap: bool,
    skip: float,
    samples: int | None,
) -> int:
    """Simulate, and draw one series against another; returns the exit code."""
    for flag, names in (("--x", x), ("--y", y)):
        if len(names) > 1:
            several = listed(list(names), "and")
            message = f"expected one series, found {several}; `plot` draws several"
            raise InputError(flag, [Problem(message=message)])
    return _drawn(request, x[0], y[0], wrap, skip, samples)


def file_name(*parts: str) -> str:
    """A name for files that show some series."""
    return "_".join(re.sub(r"[^\w.]+", "-", part) for part in parts)


def _drawn(request: Request, x: str, y: str, wrap: bool, skip: float, samples: int | None) -> int:
    name = file_name("phase", x, y)
    from linkages.kernel.system import System
    from linkages.solution.series import TIME, find_series, system_series, with_sizes

    mechanism = request.mechanism
    with request.computing("phase diagram of") as watch:
        known = with_sizes(system_series(System(mechanism)))
        across, up = find_series(known, x), find_series(known, y)
        asked = options_of(SimulationOptions, mechanism, request.given)
        if not 0 <= skip < asked.end:
            raise OptionError(
                "skip", f"skip must be from 0 to below {asked.end:g} s, found {skip:g}"
            )
        wanted = max(FEWEST_SAMPLES, asked.samples) if samples is None else samples
        outputs = list(dict.fromkeys(s.variable for s in (across, up) if s.variable != TIME))
        given = {**request.given, "samples": wanted, "outputs": outputs}
        solution, failure, interrupted = as_far_as_possible(mechanism, watch=watch, **given)
    data = solution.data.sel(time=slice(skip, None))
    if not data.sizes["time"]:
        raise ComputationError(f"stopped {failure}", time=solution.motion.stop_time)
    columns = {"time (s)": data["time"].to_numpy()} | {
        f"{series.name} ({data[series.variable].attrs['units']})": series.of(data).to_numpy()
        for series in (across, up)
        if series.variable != TIME
    }

    def made() -> Iterator[File]:
        yield name, data
        yield name, columns
        if request.figures:
            from linkages.plots.motion.phase_diagrams import pair_figure

            yield name, pair_figure(data, x, y, wrap=wrap)

    options = {**solution.options, **request.own, "samples": wanted}
    how = {"complete": failure is None, "interrupted": interrupted}
    files = request.write(made(), options, name=name, **how)
    rows: list[dict[str, Any]] = [
        {"name": head, "least": float(np.min(values)), "greatest": float(np.max(values))}
        for head, values in columns.items()
    ]

    def show(screen: Console) -> None:
        screen.print(f"[bold]{escape(mechanism.name)}[/bold]: phase diagram")
        cells = [[*row.values()] for row in rows]
        screen.print(table("Ranges", ["series", "least", "greatest"], cells, numbers=2))

    content = {"mechanism": mechanism.name, "stopped": failure, "series": rows}
    return request.report(content, files, show, failure=failure)
