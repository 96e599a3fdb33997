"""The table on the cost of analyses.

All times are of the processor, the least of several; ratios are to a plain integration of the same
motion by the same method, in the same run.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable

import numpy as np

import linkages
from linkages.chaos.findings import verdict
from linkages.chaos.lyapunov import characteristic_period
from linkages.kernel.system import System
from linkages.solution.plan import build_flow
from linkages.solvers.integration import integrate
from linkages.sweeps.running import Threads
from make.registry import makes, table

MASSES = np.array([0.5, 0.51, 0.52, 0.53])
SPEEDS = np.linspace(0.1, 0.4, 4)
SIZES = np.linspace(1e-4, 4e-4, 4)
GAP = linkages.Clearance(name="gap", joint="A", bar="rod", size=1e-4, angle=np.pi)
CASES = {
    "double pendulum": (
        lambda: linkages.load("double-pendulum"),
        100,
        {"free.upper.speed": SPEEDS},
        {"free.lower.speed": SPEEDS},
    ),
    "slider-crank with a clearance": (
        lambda: linkages.load("slider-crank").with_component(GAP),
        100,
        {"clearances.gap.size": SIZES},
        {"bars.rod.mass": MASSES},
    ),
    "nine-bar": (
        lambda: linkages.load("ninebar"),
        10,
        {"clearances.r1.size": SIZES},
        {"bars.link2.mass": MASSES},
    ),
}
"""Mechanism, periods, and what its map varies."""

VERDICT = 200
"""Periods of the nine-bar's motion that is judged."""


def least(function: Callable[[], object], times: int) -> float:
    """Processor time in seconds, after a run that compiles."""
    function()
    found = []
    for _ in range(times):
        start = time.process_time()
        function()
        found.append(time.process_time() - start)
    return min(found)


def plain(mechanism: linkages.Mechanism, periods: int) -> float:
    """Processor time of a plain integration over some periods."""
    system, defaults = System(mechanism), mechanism.simulation
    flow, end = build_flow(system), periods * characteristic_period(mechanism)
    how = {"method": defaults.method, "rtol": defaults.rtol, "atol": defaults.atol}
    return least(lambda: integrate(flow, system.state, [end], start=0.0, **how), 7)


def measured(name: str) -> dict[str, float]:
    """What an exponent and a point of a map cost, in plain integrations."""
    make, periods, x, y = CASES[name]
    mechanism = make()
    exponent = least(lambda: linkages.lyapunov(mechanism, periods=periods, count=1), 3)
    one = Threads(1)
    whole = least(lambda: linkages.chaos_map(mechanism, x, y, periods=10, executor=one), 3)
    return {
        "exponent": exponent / plain(mechanism, periods),
        "point": whole / 16 / plain(mechanism, 10),
    }


def judged() -> dict[str, float]:
    """Processor time of a verdict on the nine-bar, and in plain integrations of its motion."""
    mechanism = linkages.load("ninebar")
    start = time.process_time()
    verdict(mechanism, periods=VERDICT)
    spent = time.process_time() - start
    return {"seconds": spent, "ratio": spent / plain(mechanism, 20) * 20 / VERDICT}


def simulated() -> float:
    """Processor time in seconds of ``simulate ninebar --no-figures``, with a warm cache."""
    with tempfile.TemporaryDirectory() as folder:
        options = "--quiet", "simulate", "ninebar", "--no-figures"
        command = [sys.executable, "-m", "linkages", *options]

        def run() -> None:
            subprocess.run(command, check=True, cwd=folder, capture_output=True)

        run()
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        run()
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@makes("analyses.json")
def measure() -> dict:
    """Everything."""
    analyses = {name: measured(name) for name in CASES}
    return {"analyses": analyses, "verdict": judged(), "simulate": simulated()}


@makes("analyses", numbers="analyses.json")
def costs(content: dict) -> str:
    """The table as it stands on the page."""
    rows = [
        (name, f"{found['exponent']:.2f}", f"{found['point']:.2f}")
        for name, found in content["analyses"].items()
    ]
    verdict = content["verdict"]
    return (
        f"{table(('', 'largest exponent', 'point of a map'), rows, 3)}\n"
        f"A verdict on {VERDICT} periods of the nine-bar takes {verdict['seconds']:.0f} s, "
        f"{verdict['ratio']:.1f} plain integrations; `simulate ninebar --no-figures` "
        f"{content['simulate']:.1f} s, from start to end. Measured on {content['machine']}, "
        f"{content['date']}.\n"
    )
