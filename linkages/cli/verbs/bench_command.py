"""``bench``: work against error of every method and of installed peers."""

from __future__ import annotations

from collections.abc import Iterator

from linkages.benchmark.work_precision import TARGETS, BenchReport, Point, run_benchmark
from linkages.cli.requests import File, Request
from linkages.cli.terminal import console, json_text
from linkages.reports.report import Report, Table, number


def run(request: Request, repeats: int) -> int:
    """Measure, write ``bench.json`` and a figure, print tables; returns the exit code."""
    screen = console(error=True)

    def show(point: Point) -> None:
        if not request.json and screen.is_terminal:
            screen.print(f"{point.method} {number(point.setting)}: {number(point.seconds)} s")

    mechanism, assignments = request.mechanism, request.assignments
    found = run_benchmark(mechanism, request.file, assignments, repeats=repeats, watch=show)
    data = found.as_dict()

    def figures() -> Iterator[File]:
        from linkages.plots.study_figures import work_precision_figure

        title = f"{found.mechanism}, {number(found.end)} s"
        yield "work_precision", work_precision_figure(found.points, title)

    points = [
        [
            point.method,
            f"{'rtol' if point.adaptive else 'step'} {point.setting:.1e}",
            "failed" if point.error is None else f"{point.error:.1e}",
            f"{1e3 * point.seconds:.3g}",
            point.evaluations,
        ]
        for point in found.points
    ]
    heads = ["method", "setting", "error (rad or m)", "time (ms)", "evaluations"]
    costs = found.costs
    peak = "unknown" if costs.peak_bytes is None else f"{costs.peak_bytes / 2**20:.0f} MiB"
    report = Report(
        parts=[
            Table(f"{found.mechanism} to t = {number(found.end)} s", heads, points, numbers=3),
            _comparison(found),
            f"\nreference: uncertain by {found.uncertainty:.1e}",
            f"right-hand side: {1e9 * found.seconds_per_evaluation:.1f} ns per evaluation",
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
