"""Processor time of motions side by side against that of the same motions one after the other.

    python tests/benchmarks/motions.py [--motions 64] [--turns 1.0] [ninebar|contact|rigid]

The nine-bar, or the slider-crank with contact, at as many sizes of the clearance, with and without
tangents. Both ways are measured in
turn, and of each the least time is taken: whatever else a machine does only adds to times.
"""

from __future__ import annotations

import argparse
import logging
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

import linkages
from linkages.kernel.varying import Varying
from linkages.solution.plan import Plan
from linkages.solvers.integration import IntegrationRequest, carry_out, request
from linkages.solvers.lanes import LOGGER, integrate_many
from linkages.solvers.trajectory import Trajectory

LANES = (4, 8, 16)
ROUNDS = 3


class Case(NamedTuple):
    """A mechanism, what is varied, a turn in seconds, and what is different from its file."""

    mechanism: str
    path: str
    turn: float
    values: dict[str, object]


RIGID = {"joint": "B", "bar": "rod", "contact": "restitution", "restitution": 0.9, "size": 1e-4}
CASES = {
    "ninebar": Case("ninebar", "clearances.r1.size", 1.0, {}),
    "contact": Case("slider-crank-contact", "clearances.gap.size", 0.012, {}),
    "rigid": Case("slider-crank-contact", "clearances.gap.size", 0.012, {"clearances.gap": RIGID}),
}


def requests(
    name: str, motions: int, tangents: int, method: str, turns: float
) -> Callable[[], list[IntegrationRequest]]:
    """What makes the integrations that are asked for; each is carried out once."""
    case = CASES[name]
    points = [{case.path: size} for size in np.linspace(1e-4, 4e-4, motions)]
    mechanism, end = linkages.load(case.mechanism).with_values(case.values), turns * case.turn
    along = Varying(mechanism).along(points)
    systems = [along.system(index) for index in range(motions)]
    plan = Plan.of(systems[0], tangents=tangents)
    columns = np.eye(2 * len(systems[0].topology.free))[:, :tangents]
    held = [system.starting_held() for system in systems]
    holds = [np.append(h, np.zeros(plan.layout.held - len(h))) for h in held]
    vectors = [plan.layout.packed(system.state, 0.0, columns) for system in systems]
    flows = [plan.bind(system) for system in systems]

    def made() -> list[IntegrationRequest]:
        starts = zip(flows, vectors, holds, strict=True)
        return [
            request(f, y, [end], start=0.0, method=method, rtol=1e-10, holds=h)
            for f, y, h in starts
        ]

    return made


def measured(
    run: Callable[[list[IntegrationRequest]], Sequence[Trajectory]],
    made: Callable[[], list[IntegrationRequest]],
) -> tuple[float, float]:
    """Seconds of processor time and evaluations."""
    begin = time.process_time()
    found = run(made())
    return time.process_time() - begin, sum(one.evaluations for one in found)


def one_by_one(asked: list[IntegrationRequest]) -> list[Trajectory]:
    """The motions one after the other."""
    return [carry_out(one) for one in asked]


class Use(logging.Handler):
    """Keeps the part of the lanes' trials that counted."""

    part = 0.0

    def emit(self, record: logging.LogRecord) -> None:
        """Take it from what integrating says."""
        assert isinstance(record.args, tuple)
        self.part = float(record.args[-2])  # type: ignore[arg-type]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--motions", type=int, default=64)
    parser.add_argument("--turns", type=float, default=1.0)
    parser.add_argument("case", choices=CASES, nargs="?", default="ninebar")
    options, use = parser.parse_args(), Use()
    LOGGER.addHandler(use)
    LOGGER.setLevel(logging.INFO)
    print("method  tangents  lanes  ns per evaluation  ratio  lanes in use")
    for method in ("dop853", "vern9"):
        for tangents in (0, 1, 2):
            made = requests(options.case, options.motions, tangents, method, options.turns)
            ways = {1: one_by_one} | {w: lambda asked, w=w: integrate_many(asked, w) for w in LANES}
            best = dict.fromkeys(ways, np.inf)
            part = dict.fromkeys(ways, 1.0)
            for _ in range(ROUNDS):
                for lanes, run in ways.items():
                    seconds, evaluations = measured(run, made)
                    best[lanes] = min(best[lanes], seconds / evaluations)
                    part[lanes] = use.part if lanes > 1 else 1.0
            for lanes, found in best.items():
                print(
                    f"{method:7} {tangents:8} {lanes:6} {found * 1e9:18.1f} "
                    f"{best[1] / found:6.2f} {part[lanes]:13.3f}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
