"""Time of the right-hand side against the number of links, for chains of dyads.

    python tests/benchmarks/chains.py [--json] [links ...]

A post swings about a pin on the ground. Every further dyad has a link to the dyad before and a post
of its own; both have mass. Links lie about level and posts hang about upright, so that all dyads
are far from singular. Each size is measured in a process of its own with an empty cache. Whatever
else a machine does only adds to times: of an evaluation the least of many is taken, of everything
else the time of the processor.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence

import numpy as np

from linkages import (
    AssemblyHint,
    Bar,
    FreeAngle,
    GroundJoint,
    Mechanism,
    SimulationDefaults,
    UniformGravity,
    load,
)
from linkages.benchmark.problem import seconds_per_evaluation
from linkages.kernel.code.program import report_kernel
from linkages.kernel.system import System
from linkages.solution.plan import build_flow, kernel_source

ROUNDS = 31
LINKS = (2, 4, 8, 16, 32, 64, 100, 150, 200)
Figures = dict[str, float]


def heads(count: int) -> list[tuple[float, float]]:
    """Where the lower ends of the posts are at t = 0: no two dyads are alike."""
    return [(i + 0.1 * math.sin(2 * i), -1 + 0.1 * math.sin(3 * i)) for i in range(count)]


def chain(links: int) -> Mechanism:
    """A post and `links`/2 dyads in a row."""
    places = heads(links // 2 + 1)
    start = math.atan2(places[0][1], places[0][0])
    bars = [_bar("post", 0, ("G0", "P0"), (0, 0), places[0])]
    for i, place in enumerate(places[1:], 1):
        bars.append(_bar("link", i, (f"P{i - 1}", f"P{i}"), places[i - 1], place))
        bars.append(_bar("post", i, (f"G{i}", f"P{i}"), (i, 0), place))
    return Mechanism(
        name=f"Chain of {links // 2} dyads",
        components=(
            UniformGravity(acceleration=(0, -9.81)),
            *(GroundJoint(name=f"G{i}", position=(i, 0)) for i in range(len(places))),
            *bars,
            FreeAngle(name="post0", angle=start, speed=0.5),
            *(AssemblyHint(name=f"P{i}", where=place) for i, place in enumerate(places) if i),
            SimulationDefaults(end=10, samples=1001),
        ),
    )


def _bar(
    kind: str,
    number: int,
    joints: tuple[str, str],
    start: tuple[float, float],
    end: tuple[float, float],
) -> Bar:
    return Bar(name=f"{kind}{number}", joints=joints, length=math.dist(start, end), mass=1)


def measure(links: int) -> Figures:
    """Seconds to analyse, to compile and to evaluate, and operations per evaluation."""
    build_flow(System(load("pendulum")))  # loads the compiler
    begin = time.process_time()
    system = System(chain(links))
    analysed = time.process_time()
    source = kernel_source(system.topology)
    program = source.program
    printed = time.process_time()
    flow = build_flow(system)
    compiled = time.process_time()
    counts = report_kernel(source.model, program).counts
    return {
        "links": links,
        "analysis": analysed - begin,
        "equations": printed - analysed,
        "compiling": compiled - printed,
        "evaluation": min(
            seconds_per_evaluation(flow, system.state, repeats=1) for _ in range(ROUNDS)
        ),
        "operations": sum(sum(part.values()) for part in counts.values()),
    }


def fresh(links: int) -> Figures:
    """The same in a process of its own that finds nothing compiled."""
    with tempfile.TemporaryDirectory(prefix="linkages-") as cache:
        environment = {**os.environ, "LINKAGES_CACHE_DIR": cache}
        command = [sys.executable, __file__, "--alone", str(links)]
        output = subprocess.run(
            command, check=True, capture_output=True, text=True, env=environment
        ).stdout
    return json.loads(output)


def line(rows: Sequence[Figures]) -> tuple[float, float]:
    """Slope (seconds per link) and offset of a straight line through the times of evaluation.

    Every row has the same weight relative to its time: sizes differ a hundredfold.
    """
    links, seconds = (np.array([row[key] for row in rows]) for key in ("links", "evaluation"))
    slope, offset = np.polyfit(links, seconds, 1, w=1.0 / seconds)
    return float(slope), float(offset)


def main() -> None:
    """Measure and print."""
    numbers = [int(word) for word in sys.argv[1:] if word.isdigit()]
    if "--alone" in sys.argv:
        print(json.dumps(measure(numbers[0])))
        return
    rows = [fresh(links) for links in numbers or LINKS]
    if "--json" in sys.argv:
        print(json.dumps(rows, indent=1))
        return
    print("links  operations  evaluation (ns)  equations (s)  compiling (s)")
    for row in rows:
        print(
            f"{row['links']:5g}  {row['operations']:10g}  {1e9 * row['evaluation']:15.1f}"
            f"  {row['equations']:13.2f}  {row['compiling']:13.2f}"
        )
    slope, offset = line(rows)
    print(f"\n{1e9 * slope:.1f} ns per link and {1e9 * offset:.0f} ns")


if __name__ == "__main__":
    main()
