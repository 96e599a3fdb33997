"""``export``, ``equations`` and ``bench``: for other programs, on paper, and against the clock."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.markup import escape

from linkages.cli.requests import File, Request, mechanism_from
from linkages.cli.terminal import console, json_text, print_json
from linkages.errors import InputError, Problem
from linkages.kernel.system import System, choose_free
from linkages.reading.wording import suggestion
from linkages.reports.report import Notes, Report, Table, number
from linkages.topology.topology import build_topology

if TYPE_CHECKING:
    from linkages.benchmark.work_precision import BenchReport, Point


def run_export(request: Request, to: str, **own: Any) -> int:
    """Write a file in a format, as `linkages.export` does; returns the exit code."""
    from linkages.exports import Subject, files_of, written

    request = replace(request, verb=f"export-{to}")  # each format has files of its own
    options = {name: value for name, value in own.items() if value is not None}
    with request.computing(f"exporting to {escape(to)}:"):
        subject = Subject(request.mechanism, Path(request.file).stem, None, request.given)
        files = files_of(subject, to, options)
    with request.publishing() as place:
        written(files, place.folder)
    sizes = [path.stat().st_size for path in place.files]
    report = Report(
        name=f"{request.mechanism.name} as {to}",
        parts=[Notes(subject.notes)],
        data={"format": to, "bytes": sum(sizes), "notes": subject.notes},
    )
    return request.report(report, place.files)


def run_equations(request: Request, form: str) -> int:
    """Print closure, energies and Lagrange's equations; returns the exit code."""
    from linkages.equations import FORMATS, derive, render

    if form not in FORMATS:
        near = suggestion(form, FORMATS) or f"; expected one of: {', '.join(FORMATS)}"
        message = f"unknown format {form!r}{near}"
        raise InputError("--format", [Problem(message=message)])
    mechanism = mechanism_from(request.file, request.assignments, request.tables_from, request.at)
    topology = build_topology(choose_free(mechanism))
    if topology.redundant:  # positions tell which blocks have to be solved together
        topology = System(topology.mechanism).topology
    text = render(derive(topology), form)
    if request.json:
        print_json({"mechanism": topology.mechanism.name, "format": form, "equations": text})
    else:
        print(text)
    return 0


def run_bench(request: Request, repeats: int) -> int:
    """Measure, write ``bench.json`` and a figure, print tables; returns the exit code."""
    from linkages.benchmark.work_precision import run_benchmark

    screen = console(error=True)

    def show(point: Point) -> None:
        if not request.json and screen.is_terminal:
            screen.print(f"{point.method} {number(point.setting)}: {number(point.seconds)} s")

    mechanism, assignments = request.mechanism, request.assignments
    result = run_benchmark(mechanism, request.file, assignments, repeats=repeats, watch=show)
    data = result.as_dict()

    def figures() -> Iterator[File]:
        from linkages.plots.study_figures import work_precision_figure

        title = f"{result.mechanism}, {number(result.end)} s"
        yield "work_precision", work_precision_figure(result.points, title)

    points = [
        [
            point.method,
            f"{'rtol' if point.adaptive else 'step'} {point.setting:.1e}",
            "failed" if point.error is None else f"{point.error:.1e}",
            f"{1e3 * point.seconds:.3g}",
            point.evaluations,
        ]
        for point in result.points
    ]
    heads = ["method", "setting", "error (rad or m)", "time (ms)", "evaluations"]
    costs = result.costs
    peak = "unknown" if costs.peak_bytes is None else f"{costs.peak_bytes / 2**20:.0f} MiB"
    report = Report(
        parts=[
            Table(f"{result.mechanism} to t = {number(result.end)} s", heads, points, numbers=3),
            _comparison(result),
            f"\nreference: uncertain by {result.uncertainty:.1e}",
            f"right-hand side: {1e9 * result.seconds_per_evaluation:.1f} ns per evaluation",
            f"compiling: {costs.compile_seconds:.2f} s, once per topology",
            f"warm start to the end of a simulation: {costs.warm_start_seconds:.2f} s, "
            f"another one: {costs.simulation_seconds:.3f} s",
            f"peak memory: {peak}",
        ],
        data=data,
    )
    return request.publish(report, [("bench.json", json_text(data))], figures)


def _comparison(found: BenchReport) -> Table:
    """Time for given errors, with the ratio to the fastest."""
    from linkages.benchmark.work_precision import TARGETS

    rows = []
    for method in found.methods:
        cells = []
        for error in TARGETS:
            seconds = found.seconds_at(method, error)
            others = [s for m in found.methods if (s := found.seconds_at(m, error)) is not None]
            if seconds is None:
                cells.append("–")
            else:
                cells.append(f"{1e3 * seconds:.3g} ms ({seconds / min(others):.1f}×)")
        rows.append([method, *cells])
    heads = ["method", *(f"{error:g}" for error in TARGETS)]
    title = "\nTime for an error at the end, and ratio to the fastest"
    return Table(title, heads, rows, numbers=len(TARGETS))
