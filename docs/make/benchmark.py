"""Make figures and tables of docs/benchmark.md from docs/_static/bench-….json.

    python docs/figures_benchmark.py                    # from the numbers that there are
    python docs/figures_benchmark.py --measure          # measure first (minutes; machine idle)
    python docs/figures_benchmark.py --measure andrews  # measure one mechanism only

Times depend on the machine, which is named in the numbers; ratios and errors are what to look at.
"""

from __future__ import annotations

import datetime
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

from linkages.benchmark.work_precision import Point
from linkages.plots.figures import write_figure
from linkages.plots.study_figures import work_precision_figure
from linkages.solvers.integration import METHODS
from make.accuracy import STATIC, machine, power_of_ten, write_table

START = ["drives.crank1.angle=0.5", "drives.crank4.angle=1.0", "clearances.r1.angle=0"]
CASES = {
    "ninebar": ("Nine-bar with one clearance, 2 s", "clearance angle", ["simulate.end=2", *START]),
    "andrews": ("Andrews' squeezer, 30 ms", "angle of K1", ["simulate.end=0.03"]),
}
"""Mechanism → title, free coordinate, and values."""

DIGITS = 4


def numbers(name: str) -> Path:
    """Where the numbers of a mechanism are kept."""
    return STATIC / f"bench-{name}.json"


def measure(name: str) -> None:
    """Run ``bench`` and keep its numbers with the machine and the date."""
    *_, assignments = CASES[name]
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "linkages", "bench", name, "--json"]
        command += ["--out", folder, "--no-figures", "--repeats", "11"]
        for assignment in assignments:
            command += ["--set", assignment]
        found = subprocess.run(command, check=True, capture_output=True, text=True, cwd=folder)
    content = json.loads(found.stdout)
    del content["files"]
    content |= {"machine": machine(), "date": f"{datetime.date.today():%Y-%m-%d}"}
    content["start"] = assignments
    numbers(name).write_text(compact(content), encoding="utf-8")


def compact(content: dict) -> str:
    """JSON with rounded numbers and one run a line."""
    points = content.pop("points")
    head = json.dumps(rounded(content), indent=1, ensure_ascii=False).removesuffix("\n}")
    rows = ",\n".join("  " + json.dumps(rounded(point)) for point in points)
    return f'{head},\n "points": [\n{rows}\n ]\n}}\n'


def rounded(value: object) -> object:
    """The same with `DIGITS` significant digits."""
    if isinstance(value, dict):
        return {key: rounded(part) for key, part in value.items()}
    if isinstance(value, float) and value and math.isfinite(value):
        return float(f"{value:.{DIGITS}g}")
    return value


def duration(seconds: float) -> str:
    """Seconds or milliseconds, three digits."""
    return f"{seconds:.2f} s" if seconds > 0.9995 else f"{1e3 * seconds:.3g} ms"


def ratio(value: float) -> str:
    """A decimal for small ratios."""
    return f"{value:.1f}" if value < 20 else f"{value:.0f}"


def times(content: dict) -> str:
    """Time of each method to an error, and its ratio to the fastest."""
    targets = content["seconds_at_error"]
    methods = list(next(iter(targets.values())))
    lines = [
        "| method | "
        + " | ".join(f"error {power_of_ten(float(target))}" for target in targets)
        + " |",
        "|---" + "|--:" * len(targets) + "|",
    ]
    for method in methods:
        cells = []
        for seconds in targets.values():
            own, best = seconds[method], min(s for s in seconds.values() if s is not None)
            cells.append("–" if own is None else f"{duration(own)} ({ratio(own / best)})")
        name = f"`{method}`" if method in METHODS else method
        lines.append(f"| {name} | {' | '.join(cells)} |")
    bound = power_of_ten(10 ** math.ceil(math.log10(content["reference_uncertainty"])))
    note = (
        f"Measured on {content['date']}: {content['machine']}. The reference is uncertain by at "
        f"most {bound} rad."
    )
    return "\n".join([*lines, "", note, ""])


def costs(content: dict) -> str:
    """Costs of a run besides integration."""
    found = content["costs"]
    peak = found["peak_bytes"]
    rows = [
        (
            "one evaluation of the right-hand side",
            f"{1e9 * content['seconds_per_evaluation']:.0f} ns",
        ),
        ("compiling, once per topology", f"{found['compile_seconds']:.1f} s"),
        (
            "from the start of a process to the end of its first simulation",
            f"{found['warm_start_seconds']:.1f} s",
        ),
        (
            "another simulation, with outputs at 2001 samples",
            f"{1e3 * found['simulation_seconds']:.0f} ms",
        ),
        ("peak memory", "unknown" if peak is None else f"{peak / 2**20:.0f} MiB"),
    ]
    lines = ["| quantity | cost |", "|---|--:|", *(f"| {text} | {value} |" for text, value in rows)]
    return "\n".join(lines) + "\n"


def methods() -> str:
    """A line on each method."""
    lines = ["| method | description |", "|---|---|"]
    lines += [f"| `{name}` | {method.summary} |" for name, method in METHODS.items()]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write all files."""
    asked = [name for name in CASES if name in sys.argv] or list(CASES)
    if "--measure" in sys.argv:
        for name in asked:
            measure(name)
    for name in asked:
        content = json.loads(numbers(name).read_text(encoding="utf-8"))
        points = [Point(**row) for row in content["points"]]
        title, coordinate, _ = CASES[name]
        drawn = work_precision_figure(points, title)
        drawn.axes[0].set_xlabel(f"error of the {coordinate} at the end [rad]")
        write_figure(drawn, STATIC / f"bench-{name}.svg")
        write_table(f"bench-{name}", times(content))
        if name == "ninebar":
            write_table("bench-costs", costs(content))
    write_table("methods", methods())


if __name__ == "__main__":
    main()
