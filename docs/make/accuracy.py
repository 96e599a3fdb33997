"""The work-precision diagram of the nine-bar, and times in units of those of a program in C.

Figures count evaluations, not seconds, so that they do not depend on the machine.
"""

from __future__ import annotations

import datetime
import json
import os
import statistics
import subprocess
import sys

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

import linkages
from linkages.kernel.system import System
from linkages.plots.panels import panels
from linkages.plots.style import line_style
from linkages.solution.plan import build_flow
from linkages.solvers.integration import integrate
from make.registry import ROOT, machine, makes, table

REFERENCE = json.loads((ROOT / "tests/data/ninebar_states.json").read_text(encoding="utf-8"))
BENCHMARK = ROOT / "tests" / "benchmarks" / "against_c.py"
BENCHMARK_RUNS = 7
TOLERANCES = [10.0**-k for k in range(6, 14)]
STEPS = [4e-4, 2e-4, 1e-4, 5e-5, 2.5e-5, 1.25e-5, 6.25e-6, 3.125e-6, 1.5625e-6]
SETTINGS = {
    "rtol": lambda value: f"rtol {power_of_ten(value)}",
    "step": lambda value: f"step {1e6 * value:g} µs",
}
Row = tuple[str, float, int, float]


def work_precision() -> dict[str, list[Row]]:
    """Method → rows of (setting, value, evaluations, error of the clearance angle at the end)."""
    drives = REFERENCE["drives"]
    start = {f"drives.{name}.angle": drive["angle"] for name, drive in drives.items()}
    clearance = REFERENCE["clearance"]
    start |= {f"clearances.r1.{key}": clearance[key] for key in ("size", "angle", "speed")}
    system = System(linkages.load("ninebar.yaml", set=start))
    flow, last = build_flow(system), REFERENCE["states"][-1]
    settings = [("dop853", "rtol", value) for value in TOLERANCES]
    settings += [("rk4", "step", value) for value in STEPS]
    rows: dict[str, list[Row]] = {}
    for method, key, value in settings:
        found = integrate(flow, system.state, [0.0, last["t"]], method=method, **{key: value})
        error = abs(found.unwrapped[-1, 0] - float(last["clearance_angle"]))
        rows.setdefault(method, []).append((key, value, found.evaluations, error))
    return rows


def power_of_ten(value: float, _place: int = 0) -> str:
    """Tick label in plain text: the style of the project does not parse formulas."""
    digits = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
    return "10" + str(round(float(np.log10(value)))).translate(digits)


def logarithmic(axes: Axes) -> None:
    """Powers of ten in plain text on both axes."""
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(FuncFormatter(power_of_ten))
        axis.set_minor_formatter(NullFormatter())


def work_precision_figure(rows: dict[str, list[Row]]) -> Figure:
    """Evaluations against the error that they leave, both logarithmic."""
    figure, (axes,) = panels(1, 1, 3.2)
    for index, (method, points) in enumerate(rows.items()):
        _, values, evaluations, errors = zip(*points, strict=True)
        axes.loglog(errors, evaluations, marker="o", markersize=4, **line_style(index))
        # the method above its most accurate run, two settings beside theirs
        axes.annotate(
            method,
            (errors[-1], evaluations[-1]),
            xytext=(-2, 8),
            textcoords="offset points",
            color=line_style(index)["color"],
        )
        for place in (3, len(values) - 2):
            axes.annotate(
                SETTINGS[points[place][0]](values[place]),
                (errors[place], evaluations[place]),
                xytext=(6, 5),
                textcoords="offset points",
                fontsize=8,
            )
    logarithmic(axes)
    axes.set_xlabel("error of the clearance angle at t = 2 s [rad]")
    axes.set_ylabel("evaluations of the right-hand side")
    axes.set_title("Nine-bar with one clearance, 2 s")
    low, high = axes.get_ylim()
    axes.set_ylim(low, 1.6 * high)
    return figure


@makes("work-precision.svg", "work-precision")
def both() -> tuple[Figure, str]:
    """The figure, and the same numbers as a table."""
    rows = work_precision()
    lines = [
        (f"`{method}`", f"`{key}={value:.6g}`", evaluations, f"{error:.1e}")
        for method, points in rows.items()
        for key, value, evaluations, error in points
    ]
    heads = "method", "setting", "evaluations", "error of α at t = 2 s (rad)"
    return work_precision_figure(rows), table(heads, lines, 2)


@makes("against-c")
def benchmark_table() -> str:
    """Ratios of times of the benchmark against C: medians of several runs, with their range.

    One run is no result: a short call may wait for a processor as long as it computes.
    """
    command = [sys.executable, str(BENCHMARK), "--json"]
    runs = []
    for _ in range(BENCHMARK_RUNS):
        output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        runs.append(json.loads(output))
    if "kernel / C" not in runs[0]:
        raise SystemExit("no C compiler: nothing to compare with")
    rows = [("RK4: time of `linkages` / time of the C program", "kernel / C", ".2f")]
    rows += [
        (
            f"DOP853, 2 s to an error of {error} rad, in units of one evaluation in C",
            f"dop853 {error}, C evaluations",
            ",.0f",
        )
        for error in ("1e-06", "1e-09")
    ]
    lines = []
    for text, key, form in rows:
        found = [run[key] for run in runs]
        shown = (statistics.median(found), min(found), max(found))
        lines.append((text, *(format(value, form) for value in shown)))
    note = (
        f"{BENCHMARK_RUNS} runs on {datetime.date.today():%Y-%m-%d}, {machine()}; "
        f"load average {os.getloadavg()[0]:.1f} at the end."
    )
    return f"{table(('quantity', 'median', 'least', 'greatest'), lines)}\n{note}\n"
