"""``bench``: work against error of every method and of installed peers."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from rich.console import Console

from linkages.benchmark.work_precision import TARGETS, BenchReport, Point, run_benchmark
from linkages.cli.requests import File, Request
from linkages.cli.terminal import console, json_text, number, table


def run(request: Request, repeats: int) -> int:
    """Measure, write ``bench.json`` and a figure, print tables; returns the exit code."""
    screen = console(error=True)

    def show(point: Point) -> None:
        if not request.json and screen.is_terminal:
            screen.print(f"{point.method} {number(point.setting)}: {number(point.seconds)} s")

    mechanism, assignments = request.mechanism, request.assignments
    report = run_benchmark(mechanism, request.file, assignments, repeats=repeats, watch=show)
    content = report.as_dict()

    def made() -> Iterator[File]:
        yield "bench.json", json_text(content)
        if request.figures:
            from linkages.plots.study_figures import work_precision_figure

            title = f"{report.mechanism}, {number(report.end)} s"
            yield "work_precision", work_precision_figure(report.points, title)

    return request.report(content, request.write(made()), partial(_print, report))


def _print(report: BenchReport, screen: Console) -> None:
    rows = [
        [
            point.method,
            f"{'rtol' if point.adaptive else 'step'} {point.setting:.1e}",
            "failed" if point.error is None else f"{point.error:.1e}",
            f"{1e3 * point.seconds:.3g}",
            point.evaluations,
        ]
        for point in report.points
    ]
    heads = ["method", "setting", "error (rad or m)", "time (ms)", "evaluations"]
    title = f"{report.mechanism} to t = {number(report.end)} s"
    screen.print(table(title, heads, rows, numbers=3))
    _print_comparison(report, screen)
    costs = report.costs
    peak = "unknown" if costs.peak_bytes is None else f"{costs.peak_bytes / 2**20:.0f} MiB"
    screen.print(
        f"\nreference: uncertain by {report.uncertainty:.1e}\n"
        f"right-hand side: {1e9 * report.seconds_per_evaluation:.1f} ns per evaluation\n"
        f"compiling: {costs.compile_seconds:.2f} s, once per topology\n"
        f"warm start to the end of a simulation: {costs.warm_start_seconds:.2f} s, "
        f"another one: {costs.simulation_seconds:.3f} s\n"
        f"peak memory: {peak}"
    )


def _print_comparison(report: BenchReport, screen: Console) -> None:
    """Time for given errors, with the ratio to the fastest."""
    rows = []
    for method in report.methods:
        cells = []
        for error in TARGETS:
            seconds = report.seconds_at(method, error)
            others = [s for m in report.methods if (s := report.seconds_at(m, error)) is not None]
            if seconds is None:
                cells.append("–")
            else:
                cells.append(f"{1e3 * seconds:.3g} ms ({seconds / min(others):.1f}×)")
        rows.append([method, *cells])
    heads = ["method", *(f"{error:g}" for error in TARGETS)]
    title = "\nTime for an error at the end, and ratio to the fastest"
    screen.print(table(title, heads, rows, numbers=len(TARGETS)))
