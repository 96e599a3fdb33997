"""Figures and tables on benchmarks, from numbers in docs/_static that are measured apart.

Times depend on the machine, which is named in the numbers; ratios and errors are what to look at.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
from functools import partial
from typing import Any

from matplotlib.figure import Figure

from linkages.benchmark.work_precision import Point
from linkages.plots.study_figures import work_precision_figure
from linkages.solvers.integration import METHODS
from make.accuracy import power_of_ten
from make.registry import ROOT, makes, measured_on, table

START = ["drives.crank1.angle=0.5", "drives.crank4.angle=1.0", "clearances.r1.angle=0"]
CASES = {
    "ninebar": ("Nine-bar with one clearance, 2 s", "clearance angle", ["simulate.end=2", *START]),
    "andrews": ("Andrews' squeezer, 30 ms", "angle of K1", ["simulate.end=0.03"]),
}
"""Mechanism → title, free coordinate, and values."""


def printed(*command: str) -> Any:
    """What a program prints as JSON, run by this Python in a folder of its own."""
    with tempfile.TemporaryDirectory() as folder:
        run = [sys.executable, *command, "--json"]
        found = subprocess.run(run, check=True, capture_output=True, text=True, cwd=folder)
    return json.loads(found.stdout)


def benchmark(name: str, *options: str) -> Any:
    """Numbers of a program in tests/benchmarks."""
    return printed(str(ROOT / "tests" / "benchmarks" / f"{name}.py"), *options)


def measure(name: str) -> dict[str, Any]:
    """Run ``bench`` for a mechanism."""
    *_, assignments = CASES[name]
    options = [part for assignment in assignments for part in ("--set", assignment)]
    options += ["--out", "made", "--no-figures", "--repeats", "11"]
    content = printed("-m", "linkages", "bench", name, *options)
    del content["files"]
    return content | {"start": assignments}


def drawn(name: str, content: dict[str, Any]) -> tuple[Figure, str]:
    """Errors and times of all methods, and the table of times."""
    title, coordinate, _ = CASES[name]
    figure = work_precision_figure([Point(**row) for row in content["points"]], title)
    figure.axes[0].set_xlabel(f"error of the {coordinate} at the end [rad]")
    return figure, times(content)


for _name in CASES:
    makes(f"bench-{_name}.json")(partial(measure, _name))
    makes(f"bench-{_name}.svg", f"bench-{_name}", numbers=f"bench-{_name}.json")(
        partial(drawn, _name)
    )


def duration(seconds: float) -> str:
    """Seconds or milliseconds, three digits."""
    return f"{seconds:.2f} s" if seconds > 0.9995 else f"{1e3 * seconds:.3g} ms"


def ratio(value: float) -> str:
    """A decimal for small ratios."""
    return f"{value:.1f}" if value < 20 else f"{value:.0f}"


def times(content: dict[str, Any]) -> str:
    """Time of each method to an error, and its ratio to the fastest."""
    targets = content["seconds_at_error"]
    lines = []
    for method in next(iter(targets.values())):
        cells = []
        for seconds in targets.values():
            own, best = seconds[method], min(s for s in seconds.values() if s is not None)
            cells.append("–" if own is None else f"{duration(own)} ({ratio(own / best)})")
        lines.append((f"`{method}`" if method in METHODS else method, *cells))
    heads = (f"error {power_of_ten(float(target))}" for target in targets)
    bound = power_of_ten(10 ** math.ceil(math.log10(content["reference_uncertainty"])))
    note = f"{measured_on(content)} The reference is uncertain by at most {bound} rad."
    return f"{table(('method', *heads), lines)}\n{note}\n"


@makes("bench-costs", numbers="bench-ninebar.json")
def costs(content: dict[str, Any]) -> str:
    """Costs of a run besides integration."""
    found = content["costs"]
    peak, evaluation = found["peak_bytes"], 1e9 * content["seconds_per_evaluation"]
    rows = {
        "one evaluation of the right-hand side": f"{evaluation:.0f} ns",
        "compiling, once per topology": f"{found['compile_seconds']:.1f} s",
        "from the start of a process to the end of its first simulation":
            f"{found['warm_start_seconds']:.1f} s",
        "another simulation, with outputs at 2001 samples":
            f"{1e3 * found['simulation_seconds']:.0f} ms",
        "peak memory": "unknown" if peak is None else f"{peak / 2**20:.0f} MiB",
    }  # fmt: skip
    return table(("quantity", "cost"), rows.items())


@makes("methods")
def methods() -> str:
    """A line on each method."""
    rows = ((f"`{name}`", method.summary) for name, method in METHODS.items())
    return table(("method", "description"), rows, 2)


makes("contact-speed.json")(partial(benchmark, "contact_in_c"))


@makes("contact-speed", numbers="contact-speed.json")
def contact_speed(content: dict[str, Any]) -> str:
    """Times and evaluations of a revolution with contact, in ratios to a program by hand."""
    programs = {
        "written by hand in C": " of C",
        "`simulate`": "",
        "SciPy, equations in Python": " of SciPy",
    }
    lines = []
    for name, of in programs.items():
        seconds, evaluations = content[f"seconds{of}"], content[f"evaluations{of}"]
        own = f"{1e3 * seconds:.3g} ms", f"{seconds / content['seconds of C']:.3g}"
        lines.append((name, *own, f"{evaluations:.0f}"))
    heads = "program", "time", "ratio", "evaluations"
    return f"{table(heads, lines)}\n{measured_on(content)}\n"
