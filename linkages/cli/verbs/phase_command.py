"""``phase``: two outputs of a motion against each other, as a figure and a table."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

import numpy as np

from linkages.cli.requests import File, Request, as_far_as_possible
from linkages.errors import ComputationError, InputError, Problem
from linkages.options.option import OptionError
from linkages.options.run import SimulationOptions
from linkages.reading.wording import listed
from linkages.reports.report import Report, Table, headed
from linkages.solution.run_options import options_of

FEWEST_SAMPLES = 10_001
"""A curve through fewer points shows corners where a clearance turns fast."""


def file_name(*parts: str) -> str:
    """A name for files that show some series."""
    return "_".join(re.sub(r"[^\w.]+", "-", part) for part in parts)


def run(
    request: Request,
    x: Sequence[str],
    y: Sequence[str],
    wrap: bool,
    skip: float,
    samples: int | None,
) -> int:
    """Simulate, and draw one series against another; returns the exit code."""
    from linkages.kernel.system import System
    from linkages.solution.series import TIME, find_series, system_series, with_sizes

    for flag, names in (("--x", x), ("--y", y)):
        if len(names) > 1:
            several = listed(list(names), "and")
            message = f"expected one series, found {several}; `plot` draws several"
            raise InputError(flag, [Problem(message=message)])
    mechanism, name = request.mechanism, file_name("phase", x[0], y[0])
    with request.computing("phase diagram of") as watch:
        known = with_sizes(system_series(System(mechanism)))
        pair = [find_series(known, text) for text in (x[0], y[0])]
        asked = options_of(SimulationOptions, mechanism, request.given)
        if not 0 <= skip < asked.end:
            message = f"skip must be from 0 to below {asked.end:g} s, found {skip:g}"
            raise OptionError("skip", message)
        wanted = max(FEWEST_SAMPLES, asked.samples) if samples is None else samples
        pair = [series for series in pair if series.variable != TIME]
        outputs = list(dict.fromkeys(series.variable for series in pair))
        given = {**request.given, "samples": wanted, "outputs": outputs}
        solution, failure, interrupted = as_far_as_possible(mechanism, watch=watch, **given)
    data = solution.data.sel(time=slice(skip, None))
    if not data.sizes["time"]:
        raise ComputationError(f"stopped {failure}", time=solution.motion.stop_time)
    columns = {"time (s)": data["time"].to_numpy()}
    for series in pair:
        head = headed(series.name, data[series.variable].attrs["units"])
        columns[head] = series.of(data).to_numpy()

    def figures() -> Iterator[File]:
        from linkages.plots.motion.phase_diagrams import pair_figure

        yield name, pair_figure(data, x[0], y[0], wrap=wrap)

    rows = [
        {"name": head, "least": float(np.min(values)), "greatest": float(np.max(values))}
        for head, values in columns.items()
    ]
    heads = {"name": "series", "least": "least", "greatest": "greatest"}
    report = Report(
        name=mechanism.name,
        summary="phase diagram",
        parts=[Table("Ranges", heads, rows, numbers=2)],
        data={"mechanism": mechanism.name, "stopped": failure, "series": rows},
    )
    options = {**solution.options, **request.own, "samples": wanted}
    return request.publish(
        report, [(name, data), (name, columns)], figures, options, name=name, failure=failure,
        interrupted=interrupted,
    )  # fmt: skip
