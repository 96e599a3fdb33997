"""``plot``: any outputs of one motion or of several over each other, as a figure and a table."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from inspect import signature
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli.requests import (
    File,
    Request,
    as_far_as_possible,
    each_read,
    mechanism_from,
)
from linkages.cli.verbs.phase_command import file_name
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError, Problem
from linkages.kernel.system import System
from linkages.opened import ENDING
from linkages.opened import open as opened
from linkages.options.option import OptionError
from linkages.reports.report import Report, Table
from linkages.solution.series import TIME, example_series, find_series, system_series, with_sizes
from linkages.solution.simulate import simulate
from linkages.solution.solution import Solution

if TYPE_CHECKING:
    from linkages.plots.motion.compared import Compared

MOST = 12
"""Motions in one figure: more can not be told apart."""


def run(
    request: Request,
    others: Sequence[str] | None,
    y: Sequence[str] | None,
    against: str,
    vary: Sequence[str] | None,
    difference: bool,
    polar: bool,
    wrap: bool,
) -> int:
    """Simulate what is asked for, and draw it; returns the exit code."""
    from linkages.plots.motion.compared import compared, told_apart, vectors

    if not y:
        example = example_series(System(request.mechanism))
        message = f"expected what to draw, such as --y {shlex.quote(example)}"
        raise InputError("--y", [Problem(message=message)])
    if polar and (against != TIME or difference):
        flag = "--difference" if difference else "--against"
        message = f"--polar draws y over x of a vector; {flag} does not go with it"
        raise InputError("--polar", [Problem(message=message)])
    files = [request.file, *(others or ())]
    failures, sources = [], []
    with request.computing("plot of") as watch:
        asked = _asked(request, files, vary or ())
        for mechanism, arguments in asked:
            outputs = _outputs(mechanism, [*y, against])
            how = {**arguments, **request.given, "outputs": outputs}
            solution, failure, interrupted = as_far_as_possible(mechanism, watch=watch, **how)
            sources.append(solution)
            failures += [failure] if failure else []
            if interrupted:
                break
        stems = [Path(file).stem for file in files for _ in range(len(asked) // len(files))]
        labels = told_apart([m for m, _ in asked[: len(sources)]], stems[: len(sources)])
        motions: dict[str, Solution] = dict(zip(labels, sources, strict=True))
        found = (
            vectors(motions, y)
            if polar
            else (compared(motions, y, against, difference=difference),)
        )
    over = [f"over-{against}"] if against != TIME else []
    kind = [word for word, wanted in (("polar", polar), ("difference", difference)) if wanted]
    name = file_name("plot", *y, *over, *kind)
    failure = failures[0] if failures else None

    def figures() -> Iterator[File]:
        from linkages.plots.motion import overlay

        yield name, overlay.polar_figure(found) if polar else overlay.figure(found[0], wrap=wrap)

    rows = [
        {
            "name": curve.name, "of": curve.source, "least": curve.least,
            "greatest": curve.greatest, "units": curve.units,
        }
        for one in found
        for curve in one.curves
    ]  # fmt: skip
    columns = {
        "name": "series", "of": "of", "least": "least", "greatest": "greatest", "units": "unit",
    }  # fmt: skip
    report = Report(
        name=request.mechanism.name,
        summary=f"over {against}",
        parts=[Table("Ranges", columns, rows)],
        data={"mechanism": request.mechanism.name, "stopped": failure, "series": rows},
    )
    options = {**sources[0].options, **request.own}
    return request.publish(
        report, [(name, _columns(found))], figures, options, name=name, failure=failure,
        interrupted=interrupted,
    )  # fmt: skip


def _asked(
    request: Request, files: Sequence[str], vary: Sequence[str]
) -> list[tuple[Mechanism, dict[str, Any]]]:
    """What is to be simulated, and with which arguments of saved results."""
    from linkages.sweeps.axes import parse_axis

    axes = each_read("--vary", vary, parse_axis)
    places = [*product(*(range(len(axis)) for axis in axes))]
    if len(places) * len(files) > MOST:
        raise OptionError("vary", f"expected up to {MOST} motions, found {len(places)}")
    found = []
    for file in files:
        mechanism = mechanism_from(file, request.assignments, request.tables_from)
        arguments: dict[str, Any] = {}
        if Path(file).suffix == ENDING:
            saved = opened(file)
            if saved.analysis != "simulate":
                message = f"expected results of simulate, found those of {saved.analysis}"
                raise InputError(file, [Problem(message=message)])
            known = signature(simulate).parameters.keys() - {"events", "outputs"}
            arguments = {n: value for n, value in saved.arguments.items() if n in known}
        for place in places:
            values: dict[str, object] = {}
            for axis, index in zip(axes, place, strict=True):
                values |= axis.at(index)
            found.append((mechanism.with_values(values) if values else mechanism, arguments))
    return found


def _outputs(mechanism: Mechanism, names: Sequence[str]) -> list[str]:
    """Outputs that some series are of."""
    known = with_sizes(system_series(System(mechanism)))
    found = [find_series(known, name).variable for name in names]
    return [name for name in dict.fromkeys(found) if name != TIME]


def _columns(found: Sequence[Compared]) -> dict[str, Any]:
    """Columns of a table: shorter motions have empty cells at the end."""
    columns: dict[str, Any] = {}
    for one in found:
        for curve in one.curves:
            whose = f", {curve.source}" if curve.source else ""
            columns[f"{TIME} (s){whose}"] = curve.time
            if one.across != TIME:
                columns[f"{one.across} ({one.units}){whose}"] = curve.x
            columns[f"{curve.name} ({curve.units}){whose}"] = curve.y
    longest = max(len(column) for column in columns.values())
    return {
        head: np.append(column, np.full(longest - len(column), np.nan))
        for head, column in columns.items()
    }
