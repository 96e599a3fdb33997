"""Times against the number of links, for chains of dyads and for chains of free bars.

    python tests/benchmarks/chains.py [--json] [links ...]
    python tests/benchmarks/chains.py --free [--json] [bars ...]
    python tests/benchmarks/chains.py --check [--json] [bars ...]

The first measures the right-hand side of a chain of dyads. A post swings about a pin on the ground.
Every further dyad has a link to the dyad before and a post of its own; both have mass. Links lie
about level and posts hang about upright, so that all dyads are far from singular. The second
measures when a motion begins and what an evaluation costs, for bars that hang from one another, all
of them free. The third measures what the command `check` does, for chains of dyads and of driven
bars. Each size is measured in a process of its own with an empty cache. Whatever else a machine
does only adds to times: of an evaluation the least of many is taken, of everything else the time of
the processor.
"""

from __future__ import annotations

import gc
import json
import math
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence

import numpy as np

from linkages import (
    AssemblyHint,
    Bar,
    Drive,
    FreeAngle,
    GroundJoint,
    Mechanism,
    SimulationDefaults,
    UniformGravity,
    load,
    loads,
    simulate,
)
from linkages.benchmark.problem import seconds_per_evaluation
from linkages.cli.verbs.check_commands import check_content
from linkages.kernel.code.program import report_kernel
from linkages.kernel.system import System
from linkages.solution.plan import build_flow, kernel_source

ROUNDS = 31
FREE_BARS = (10, 30, 100, 300)
CHECKED_BARS = (1000, 3000, 10000)
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


def free_chain(count: int) -> Mechanism:
    """A chain of equal free bars that are 1 m long together."""
    return Mechanism(
        name=f"Chain of {count} free bars",
        components=(
            UniformGravity(acceleration=(0, -9.81)),
            GroundJoint(name="J0", position=(0, 0)),
            *(
                Bar(name=f"b{i}", joints=(f"J{i}", f"J{i + 1}"), length=1 / count, mass=1)
                for i in range(count)
            ),
            *(
                FreeAngle(name=f"b{i}", angle=-1.2 + 0.1 * math.sin(i), speed=0)
                for i in range(count)
            ),
        ),
    )


def measure_free(count: int) -> Figures:
    """Seconds to the first samples and of an evaluation, terms, and peak memory in MB."""
    simulate(load("pendulum"), end=1e-4, samples=2)  # loads the compiler, compiles loops
    mechanism = free_chain(count)
    begin = time.process_time()
    simulate(mechanism, end=1e-4, samples=2)
    first = time.process_time() - begin
    system = System(mechanism)
    flow = build_flow(system)
    return {
        "bars": count,
        "terms": len(kernel_source(system.topology).model.graph.nodes),
        "first": first,
        "evaluation": min(
            seconds_per_evaluation(flow, system.state, repeats=1) for _ in range(ROUNDS)
        ),
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def driven_chain(count: int) -> Mechanism:
    """The same bars, all of them driven."""
    free = free_chain(count).components
    drives = (Drive(name=f"b{i}", angle=math.sin(i), speed=1 + i / 100) for i in range(count))
    return Mechanism(
        name=f"Chain of {count} driven bars",
        components=(*(own for own in free if not isinstance(own, FreeAngle)), *drives),
    )


def measure_check(count: int) -> Figures:
    """Seconds to read, assemble and describe chains of dyads and of driven bars."""
    result: Figures = {"bars": count}
    _described(chain(4).to_yaml())
    for kind, mechanism in (("dyads", chain(count)), ("driven", driven_chain(count))):
        text = mechanism.to_yaml()
        begin = time.process_time()
        _described(text)
        result[kind] = time.process_time() - begin
    return result


def _described(text: str) -> None:
    gc.set_threshold(100_000, 50)  # as the command does
    check_content(System(loads(text)))


KINDS = {"--free": (measure_free, FREE_BARS), "--check": (measure_check, CHECKED_BARS)}
"""What is measured instead of chains of dyads, and of which sizes."""


def fresh(links: int, *what: str) -> Figures:
    """The same in a process of its own that finds nothing compiled."""
    with tempfile.TemporaryDirectory(prefix="linkages-") as cache:
        environment = {**os.environ, "LINKAGES_CACHE_DIR": cache}
        command = [sys.executable, __file__, "--alone", *what, str(links)]
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
    what = [word for word in KINDS if word in sys.argv]
    measured, sizes = KINDS[what[0]] if what else (measure, LINKS)
    if "--alone" in sys.argv:
        print(json.dumps(measured(numbers[0])))
        return
    rows = [fresh(size, *what) for size in numbers or sizes]
    if "--json" in sys.argv:
        print(json.dumps(rows, indent=1))
        return
    if what:
        print("  ".join(rows[0]))
        for row in rows:
            print("  ".join(f"{value:{len(name)}.4g}" for name, value in row.items()))
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
