"""The table of docs/kernel.md on binding numbers.

CPU time of this process for one set of numbers: from its values to a flow that a solver takes. Each
way is measured in turn over several rounds, and the least of each counts.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

import linkages
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.solution.plan import Plan, kernel_source
from make.registry import machine, makes, table

ROUNDS = 5
MANY = 256
GAP = {"clearances": {"gap": {"joint": "B", "bar": "rod", "size": "0.1 mm"}}}
CASES: dict[str, tuple[str, dict[str, object], str, tuple[float, float]]] = {
    "double pendulum": ("double-pendulum", {}, "bars.lower.length", (0.9, 1.1)),
    "slider-crank with clearance": ("slider-crank", GAP, "clearances.gap.size", (1e-4, 5e-4)),
    "nine-bar": ("ninebar", {}, "clearances.r1.size", (1e-4, 5e-4)),
    "Andrews' squeezer": ("andrews", {}, "loads[0].torque", (0.02, 0.04)),
}


@makes("binding")
def binding() -> str:
    """Milliseconds a point, and ratios to printing everything again."""
    found = []
    for name, (file, given, path, (first, last)) in CASES.items():
        mechanism = linkages.load(file, set=given or None)
        points = [{path: float(value)} for value in np.linspace(first, last, MANY)]
        ways = _ways(mechanism, points)
        taken = dict.fromkeys(ways, np.inf)
        for _ in range(ROUNDS):
            for way, (action, count) in ways.items():
                begin = time.process_time()
                action()
                taken[way] = min(taken[way], 1e3 * (time.process_time() - begin) / count)
        cells = [f"{milliseconds:.2g} ms" for milliseconds in taken.values()]
        ratio = taken["printed"] / taken["together"]
        found.append((name, *cells, f"{ratio:.0f}"))
    heads = "printed again", "read and assembled", "bound, one by one", f"bound, {MANY} at once"
    note = f"CPU time for each set of numbers, least of {ROUNDS} rounds; {machine()}."
    return f"{table(('', *heads, 'ratio'), found)}\n{note}\n"


def _ways(
    mechanism: Mechanism, points: list[dict[str, float]]
) -> dict[str, tuple[Callable[[], object], int]]:
    """Ways to bind numbers, with how many sets each binds."""
    start = System(mechanism)
    Plan.of(start).bind(start)  # compiled once, whatever is measured
    few = points[:: len(points) // 8]

    def printed() -> None:
        for point in few:
            system = System(mechanism.with_values(point))
            assert kernel_source(system.topology).program.text
            Plan.of(system).bind(system)

    def read() -> None:
        for point in few:
            system = System(mechanism.with_values(point))
            Plan.of(system).bind(system)

    def singly() -> None:
        varying = Varying(mechanism)
        varying.at({})
        for point in points:
            system = varying.at(point)
            Plan.of(system).bind(system)

    def together() -> None:
        along = Varying(mechanism).along(points)
        for index in range(len(along)):
            system = along.system(index)
            Plan.of(system).bind(system)

    return {
        "printed": (printed, len(few)),
        "read": (read, len(few)),
        "singly": (singly, len(points)),
        "together": (together, len(points)),
    }
