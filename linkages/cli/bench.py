"""``bench``: work against error of every method and of installed peers."""

from __future__ import annotations

import json as json_format
from collections.abc import Sequence
from pathlib import Path

from linkages.benchmark.report import TARGETS, BenchReport, run_benchmark
from linkages.benchmark.work_precision import Point
from linkages.cli.loading import mechanism_from
from linkages.cli.published import published
from linkages.cli.terminal import console, number, print_json, table
from linkages.reading.replacing import replaced


def run_bench(
    file: str,
    assignments: Sequence[str],
    out: Path | None,
    json: bool,
    figures: bool,
    repeats: int,
    format: str = "png",  # noqa: A002
) -> int:
    """Measure, write ``bench.json`` and a figure, print tables; returns the exit code."""
    mechanism = mechanism_from(file, assignments)
    screen = console(error=True)

    def show(point: Point) -> None:
        if not json and screen.is_terminal:
            screen.print(f"{point.method} {number(point.setting)}: {number(point.seconds)} s")

    report = run_benchmark(mechanism, file, assignments, repeats=repeats, watch=show)
    folder = Path("results") / Path(file).stem if out is None else out
    with published("bench", folder, mechanism, {"repeats": repeats}) as run:
        _save(report, run.folder, format if figures else None)
    written = run.files
    if json:
        print_json({**report.as_dict(), "files": [str(path) for path in written]})
    else:
        _print(report, written)
    return 0


def _save(report: BenchReport, folder: Path, format_: str | None) -> list[Path]:
    path = folder / "bench.json"
    with replaced(path) as temporary:
        temporary.write_text(json_format.dumps(report.as_dict(), indent=2), encoding="utf-8")
    if format_ is None:
        return [path]
    from linkages.plots.figures import write_figure
    from linkages.plots.work_precision import figure

    picture = folder / f"work_precision.{format_}"
    write_figure(figure(report.points, f"{report.mechanism}, {number(report.end)} s"), picture)
    return [path, picture]


def _print(report: BenchReport, written: list[Path]) -> None:
    screen = console()
    rows = [
        [
            point.method,
            f"{'rtol' if point.adaptive else 'step'} {point.setting:.1e}",
            "failed" if point.error is None else f"{point.error:.1e}",
            f"{1e3 * point.seconds:.3g}",
            "" if point.evaluations is None else str(point.evaluations),
        ]
        for point in report.points
    ]
    heads = ["method", "setting", "error (rad or m)", "time (ms)", "evaluations"]
    title = f"{report.mechanism} to t = {number(report.end)} s"
    screen.print(table(title, heads, rows, numbers=3))
    _print_comparison(report)
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
    screen.print(f"{len(written)} files in {written[0].parent}", markup=False)


def _print_comparison(report: BenchReport) -> None:
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
    console().print(table(title, heads, rows, numbers=len(TARGETS)))
