"""Cost of derivatives by P numbers against plain runs: at most 1.5 (1 + P) of them.

    python tests/benchmarks/sensitivities.py

Processor times of the same call with and without derivatives, in turn, the least of several rounds
each; and evaluations of the equations, which derivatives share.
"""

from __future__ import annotations

import time

import numpy as np

import linkages
from linkages.design.differentiated import Differentiated
from linkages.reading.document import shipped
from linkages.solution.series import system_series

ROUNDS = 5


def measure_of(found: Differentiated) -> str:
    """A measure that every mechanism has."""
    known = [name for name in system_series(found.system) if name.endswith((".effort", ".angle"))]
    return f"rms({known[0]})"


def cost(name: str) -> tuple[int, float, float, float]:
    """Numbers, seconds without and with derivatives, and their ratio."""
    mechanism = linkages.load(name)
    run = {"end": mechanism.simulation.end * (0.1 if mechanism.initial else 1.0)}
    if name == "n-four-bar":
        run["end"] = 0.5  # before the first change point
    paths = Differentiated(mechanism, [], ["*"], run=run).paths
    found = Differentiated(mechanism, [], paths, run=run)
    found = Differentiated(mechanism, [measure_of(found)], paths, run=run)
    found.at(found.values)  # compiles
    best = [np.inf, np.inf]
    for _ in range(ROUNDS):
        for asked in (False, True):
            begun = time.process_time()
            found.at(found.values, derivatives=asked)
            best[asked] = min(best[asked], time.process_time() - begun)
    return len(paths), best[0], best[1], best[1] / best[0]


def main() -> None:
    """Print a row for each shipped mechanism."""
    print(f"{'mechanism':24}{'numbers':>8}{'plain s':>10}{'with s':>10}{'ratio':>8}{'allowed':>9}")
    for name in shipped():
        count, plain, whole, ratio = cost(name)
        allowed = 1.5 * (1 + count)
        print(f"{name:24}{count:8}{plain:10.4f}{whole:10.4f}{ratio:8.2f}{allowed:9.1f}", flush=True)


if __name__ == "__main__":
    main()
