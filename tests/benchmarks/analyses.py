"""What sections and exponents cost, in plain integrations of the same length.

    python tests/benchmarks/analyses.py [--json] [PERIODS]

Each analysis of the nine-bar from α = 90° is timed in turn with a plain simulation, several times,
and the least time of one is divided by the least of the other: other work on the machine only ever
adds to a time. What must be compiled is compiled before.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable

import linkages

PERIODS, REPEATS = 100, 8
PERIOD = 2.0
START = {
    "drives.crank1.angle": "15 deg",
    "drives.crank4.angle": "150 deg",
    "clearances.r1.angle": "90 deg",
}


def analyses(mechanism: linkages.Mechanism, periods: int) -> dict[str, Callable[[], object]]:
    """Name → what is timed."""
    return {
        "stroboscopic section": lambda: linkages.poincare(mechanism, periods=periods),
        "geometric section": lambda: linkages.poincare(
            mechanism, periods=10 * periods, end=periods * PERIOD, section="slider9.velocity=0"
        ),
        "largest exponent": lambda: linkages.lyapunov(mechanism, periods=periods, count=1),
        "both exponents": lambda: linkages.lyapunov(mechanism, periods=periods),
    }


def ratios(periods: int, repeats: int = REPEATS) -> dict[str, float]:
    """Time of each analysis over that of a plain simulation of the same length."""
    mechanism = linkages.load("ninebar", set=START)

    def plain() -> object:
        outputs = ["clearance_angle", "clearance_speed"]
        return linkages.simulate(mechanism, end=periods * PERIOD, samples=2, outputs=outputs)

    plain()
    found = {}
    for name, analysis in analyses(mechanism, periods).items():
        analysis()
        pairs = [(_seconds(analysis), _seconds(plain)) for _ in range(repeats)]
        least, least_plain = (min(times) for times in zip(*pairs, strict=True))
        found[name] = least / least_plain
    return found


def _seconds(action: Callable[[], object]) -> float:
    begin = time.perf_counter()
    action()
    return time.perf_counter() - begin


def main(arguments: list[str]) -> None:
    """Measure and print."""
    numbers = [argument for argument in arguments if not argument.startswith("-")]
    found = ratios(int(numbers[0]) if numbers else PERIODS)
    if "--json" in arguments:
        print(json.dumps(found, indent=2))
        return
    for name, ratio in found.items():
        print(f"{name:22} {ratio:.2f} plain integrations")


if __name__ == "__main__":
    main(sys.argv[1:])
