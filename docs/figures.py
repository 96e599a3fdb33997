"""Make everything that the pages show and nobody should type: figures and tables of measurements.

    python docs/figures.py                 # figures and the work-precision table
    python docs/figures.py --benchmark     # also the comparison with C (minutes, needs a compiler)

Files go to docs/_static and are committed. Figures count evaluations, not seconds, so that they do
not depend on the machine; the comparison with C gives ratios of times, with date and machine.
"""

from __future__ import annotations

import datetime
import json
import os
import platform
import re
import statistics
import subprocess
import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter
from PIL import Image

import linkages
from linkages.kernel.system import System
from linkages.plots.figures import FIGURES, write_figure
from linkages.plots.layout import panels
from linkages.plots.style import line_style, style, styled
from linkages.solution.plan import build_flow
from linkages.solvers.integration import integrate

ROOT = Path(__file__).resolve().parents[1]
STATIC = ROOT / "docs" / "_static"
REFERENCE = json.loads((ROOT / "tests/data/ninebar_states.json").read_text(encoding="utf-8"))
BENCHMARK = ROOT / "tests" / "benchmarks" / "against_c.py"
BENCHMARK_RUNS = 7
SHOWN = ("mechanism", "slider_position_error", "phase")
OVER_TIME = {
    "slider_position_error": ["slider_position_error"],
    "phase": ["clearance_angle", "clearance_speed"],
}
TOLERANCES = [10.0**-k for k in range(6, 14)]
STEPS = [4e-4, 2e-4, 1e-4, 5e-5, 2.5e-5, 1.25e-5, 6.25e-6, 3.125e-6, 1.5625e-6]
PIXELS = 1408
"""Width of dense figures: twice the text of a page."""

SETTINGS = {
    "rtol": lambda value: f"rtol {power_of_ten(value)}",
    "step": lambda value: f"step {1e6 * value:g} µs",
}
Row = tuple[str, float, int, float]


def ninebar_figures() -> None:
    """Some of the figures that `simulate ninebar.yaml` writes."""
    solution = linkages.simulate(linkages.load("ninebar.yaml"))
    for name in SHOWN:
        variables = OVER_TIME.get(name, [])
        data = solution.dense(variables) if variables else solution.data
        figure = FIGURES[name](data, solution.mechanism)
        assert figure is not None
        write_small(figure, STATIC / f"ninebar-{name.replace('_', '-')}.png", 24)


def write_small(figure: Figure, path: Path, colours: int | None = 64) -> None:
    """Write a dense figure, sharp on any screen; with a palette of its own it stays small."""
    with style():
        dpi = PIXELS / figure.get_figwidth()
        figure.savefig(path, dpi=dpi, metadata={"Software": None})
    if colours is None:
        return
    with Image.open(path) as image:
        whole = image.convert("RGB")
        # rare colours are marks, and keep their own
        whole.quantize(colours, Image.Quantize.MAXCOVERAGE).save(path, optimize=True)


def write_table(name: str, text: str) -> None:
    """Put a table between its markers into all pages that have them, README.md among them."""
    begin, end = f"<!-- table: {name} -->", "<!-- end of table -->"
    marked = re.compile(f"{re.escape(begin)}.*?{re.escape(end)}", re.DOTALL)
    block = f"{begin}\n\n{text.strip()}\n\n{end}"
    known = False
    for page in [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]:
        found = page.read_text(encoding="utf-8")
        if begin in found:
            known = True
            page.write_text(marked.sub(lambda _: block, found), encoding="utf-8")
    if not known:
        raise ValueError(f"no page has a place for the table {name!r}")


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


@styled
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


def work_precision_table(rows: dict[str, list[Row]]) -> str:
    """The same numbers as a table."""
    lines = [
        "| method | setting | evaluations | error of α at t = 2 s (rad) |",
        "|---|---|--:|--:|",
    ]
    for method, points in rows.items():
        lines += [
            f"| `{method}` | `{key}={value:.6g}` | {evaluations} | {error:.1e} |"
            for key, value, evaluations, error in points
        ]
    return "\n".join(lines) + "\n"


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
    lines = ["| quantity | median | least | greatest |", "|---|--:|--:|--:|"]
    for text, key, form in rows:
        found = [run[key] for run in runs]
        shown = (statistics.median(found), min(found), max(found))
        lines.append(f"| {text} | {' | '.join(format(value, form) for value in shown)} |")
    note = (
        f"{BENCHMARK_RUNS} runs on {datetime.date.today():%Y-%m-%d}, {machine()}; "
        f"load average {os.getloadavg()[0]:.1f} at the end."
    )
    return "\n".join([*lines, "", note, ""])


def machine() -> str:
    """Processor, operating system and versions, without the name of the host."""
    import llvmlite

    processor = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        models = [x for x in info.read_text().splitlines() if x.startswith("model name")]
        processor = models[0].split(":", 1)[1].strip() if models else processor
    return (
        f"{processor} ({os.cpu_count()} threads), {platform.system()} {platform.machine()}, "
        f"Python {platform.python_version()}, llvmlite {llvmlite.__version__}, "
        f"NumPy {np.__version__}"
    )


def main() -> None:
    """Write all files."""
    STATIC.mkdir(exist_ok=True)
    ninebar_figures()
    rows = work_precision()
    write_figure(work_precision_figure(rows), STATIC / "work-precision.svg")
    write_table("work-precision", work_precision_table(rows))
    if "--benchmark" in sys.argv:
        write_table("against-c", benchmark_table())


if __name__ == "__main__":
    main()
