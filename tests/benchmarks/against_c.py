"""Compare the nine-bar's compiled kernel and solvers with the hand-written C program beside this.

    python tests/benchmarks/against_c.py [--json]

All figures are ratios within one run, because machines are noisy: each pair is timed in turn,
several times, and the median is printed. Without a C compiler only our own times are shown.
"""

from __future__ import annotations

import json
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import linkages
from linkages.kernel.system import System
from linkages.solution.plan import build_flow
from linkages.solvers.integration import integrate

HERE = Path(__file__).parent
REFERENCE = json.loads((HERE.parent / "data" / "ninebar_states.json").read_text(encoding="utf-8"))
REPEATS = 7
STEPS, END = 2_000_000, 200.0
START = {
    "drives.crank1.angle": REFERENCE["drives"]["crank1"]["angle"],
    "drives.crank4.angle": REFERENCE["drives"]["crank4"]["angle"],
    "clearances.r1.angle": 0.0,
}


def compile_c(folder: Path, source: str = "ninebar") -> Path | None:
    """Build a C program beside this one; None where there is no compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        return None
    program = folder / source
    command = [compiler, "-O3", "-march=native", f"-I{folder}", "-o", str(program)]
    subprocess.run([*command, str(HERE / f"{source}.c"), "-lm"], check=True)
    return program


def seconds_of_c(program: Path) -> float:
    """Seconds that the C program needs for the long RK4 run."""
    command = [str(program), str(STEPS), str(END)]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return float(output.split()[3])


def timed(action: Callable[[], object], times: int = 1) -> float:
    """Seconds that an action takes, on average over some times in a row."""
    begin = time.perf_counter()
    for _ in range(times):
        action()
    return (time.perf_counter() - begin) / times


def loosest_tolerance(system: System, error: float) -> tuple[float, float]:
    """The largest tolerance that ends within `error` of the reference at t = 2 s."""
    flow, exact = build_flow(system), float(REFERENCE["states"][-1]["clearance_angle"])
    for rtol in np.geomspace(1e-7, 1e-12, 51):
        found = integrate(flow, system.state, [0.0, 2.0], rtol=float(rtol))
        if abs(found.unwrapped[-1, 0] - exact) <= error:
            return float(rtol), abs(found.unwrapped[-1, 0] - exact)
    raise RuntimeError(f"no tolerance reaches {error}")


def measure() -> dict[str, float]:
    """All figures, times in seconds."""
    system = System(linkages.load("ninebar.yaml", set=START))
    flow = build_flow(system)

    def rk4() -> None:
        integrate(flow, system.state, [0.0, END], method="rk4", step=END / STEPS)

    def dop853(rtol: float) -> Callable[[], object]:
        return lambda: integrate(flow, system.state, [0.0, 2.0], rtol=rtol)

    rk4()  # compiled or loaded before anything is timed
    tolerances = {error: loosest_tolerance(system, error) for error in (1e-6, 1e-9)}
    with tempfile.TemporaryDirectory() as folder:
        program = compile_c(Path(folder))
        rows: list[dict[str, float]] = []
        for _ in range(REPEATS):
            row = {"rk4": timed(rk4)}
            row |= {
                # a single call is over before a machine that slept has woken up
                f"dop853 {error:g}": timed(dop853(rtol), times=20)
                for error, (rtol, _) in tolerances.items()
            }
            if program is not None:
                row["c"] = seconds_of_c(program)
            rows.append(row)
    figures = {key: statistics.median(row[key] for row in rows) for key in rows[0]}
    figures["ns per evaluation"] = 1e9 * figures["rk4"] / (4 * STEPS)
    if "c" in figures:
        figures["ns per evaluation in C"] = 1e9 * figures["c"] / (4 * STEPS)
        figures["kernel / C"] = statistics.median(row["rk4"] / row["c"] for row in rows)
        for error in tolerances:
            key = f"dop853 {error:g}"
            ratios = [row[key] / (row["c"] / (4 * STEPS)) for row in rows]
            figures[f"{key}, C evaluations"] = statistics.median(ratios)
    for error, (rtol, reached) in tolerances.items():
        figures[f"rtol for {error:g}"], figures[f"error for {error:g}"] = rtol, reached
    return figures


def main() -> None:
    """Measure and print."""
    figures = measure()
    if "--json" in sys.argv:
        print(json.dumps(figures, indent=2))
        return
    print(f"{'nine-bar with one clearance':40s} {'value':>14s}")
    for key, value in figures.items():
        print(f"{key:40s} {value:14.6g}")


if __name__ == "__main__":
    main()
