"""Motions in lanes against heyoka's batches: processor time at equal error, on one core.

The nine-bar from as many angles of its clearance. Lanes and batches are measured in turn at some
tolerances; of each the least time is taken, and the median error of the angles at the end. Errors
of either are differences to the other at its least tolerance, so that nobody checks himself. What
an error costs is read from a line through all tolerances, in logarithms: the order of Taylor's
method follows the tolerance in jumps, and so do its errors. heyoka compiles the numbers of the
mechanism as constants, ours are arguments. Times of lanes have all that there is to a motion, also
setting it up in Python.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import linkages
from linkages.benchmark.problem import InitialValueProblem, expressions
from linkages.solvers.integration import request
from linkages.solvers.lanes import integrate_many

Floats = NDArray[np.float64]

MOTIONS = 256
END = 0.5
ERROR = 1e-9
"""In rad, which both reach within `TOLERANCES`."""

TOLERANCES = (1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
LEAST = 2e-14
ROUNDS = 3

Solve = Callable[[], Floats]


@dataclass(frozen=True)
class Cost:
    """Of one way at some tolerances: seconds, and median errors."""

    seconds: list[float]
    errors: list[float]

    def at(self, error: float) -> float:
        """Seconds for an error.

        Raises
        ------
        ValueError
            If none of the tolerances is that loose, or that tight.
        """
        if not min(self.errors) <= error <= max(self.errors):
            raise ValueError(f"errors are {self.errors}, expected some around {error:g}")
        line = np.polyfit(np.log(self.errors), np.log(self.seconds), 1)
        return float(np.exp(np.polyval(line, np.log(error))))


def states(problem: InitialValueProblem, motions: int) -> Floats:
    """Where the motions begin, shape (motions, 2n)."""
    found = np.tile(problem.system.state, (motions, 1))
    found[:, 0] += np.linspace(0.0, 1.0, motions)
    return found


def lanes(problem: InitialValueProblem, begin: Floats, rtol: float) -> Solve:
    """Ours: coordinates at the end, shape (motions, n)."""

    def solve() -> Floats:
        asked = [
            request(problem.flow, y, [problem.end], start=0.0, method="vern9", rtol=rtol)
            for y in begin
        ]
        n = problem.flow.coordinates
        # angles within a turn, and their turns
        found = [one.final_state[:n] + 2 * np.pi * one.final_turns for one in integrate_many(asked)]
        return np.array(found)

    return solve


def batches(problem: InitialValueProblem, begin: Floats, rtol: float, batch: int) -> Solve:
    """That of heyoka; batches are compiled outside of what is timed."""
    import heyoka

    n = problem.flow.coordinates
    variables = heyoka.make_vars(*[f"y{i}" for i in range(2 * n)])
    rates = [*variables[n:], *expressions(problem, variables, heyoka)]
    system = list(zip(variables, rates, strict=True))
    integrator: Any = heyoka.taylor_adaptive_batch(system, begin[:batch].T.copy(), tol=rtol)

    def solve() -> Floats:
        found = np.empty((len(begin), n))
        for first in range(0, len(begin), batch):
            integrator.set_time(0.0)
            integrator.state[:] = begin[first : first + batch].T
            integrator.propagate_until(problem.end)
            found[first : first + batch] = integrator.state[:n].T
        return found

    return solve


WAYS: dict[str, Callable[[InitialValueProblem, Floats, float], Solve]] = {
    "lanes, vern9": lanes,
    "heyoka, batches of 4": lambda *given: batches(*given, 4),
    "heyoka, batches of 8": lambda *given: batches(*given, 8),
}


def measured(
    motions: int = MOTIONS,
    end: float = END,
    tolerances: Sequence[float] = TOLERANCES,
    rounds: int = ROUNDS,
) -> dict[str, Cost]:
    """What every way costs."""
    problem = InitialValueProblem(linkages.load("ninebar"), end)
    begin = states(problem, motions)
    ours, *theirs = WAYS
    exact = {name: WAYS[name](problem, begin, LEAST)() for name in (ours, theirs[0])}
    solves = {
        (name, rtol): way(problem, begin, rtol) for name, way in WAYS.items() for rtol in tolerances
    }
    best, errors = dict.fromkeys(solves, np.inf), dict.fromkeys(solves, np.inf)
    for _ in range(rounds):
        for key, solve in solves.items():
            clock = time.process_time()
            found = solve()
            best[key] = min(best[key], time.process_time() - clock)
            other = exact[theirs[0] if key[0] == ours else ours]
            errors[key] = float(np.median(np.abs(found - other).max(axis=1)))
    return {
        name: Cost([best[name, t] for t in tolerances], [errors[name, t] for t in tolerances])
        for name in WAYS
    }


def rows(found: dict[str, Cost], error: float = ERROR) -> list[str]:
    """A table, in lines of Markdown."""
    ours, *_ = found.values()
    lines = ["| | ms for a motion | ratio |", "|---|--:|--:|"]
    for name, cost in found.items():
        each = 1e3 * cost.at(error) / MOTIONS
        lines.append(f"| {name} | {each:.2f} | {cost.at(error) / ours.at(error):.1f} |")
    return lines


def main() -> None:
    """Measure and print."""
    found = measured()
    for name, cost in found.items():
        pairs = zip(cost.seconds, cost.errors, strict=True)
        print(f"{name:30}" + "".join(f"  {s:.3f} s: {e:.1e}" for s, e in pairs))
    print(f"{MOTIONS} motions of {END:g} s, at an error of {ERROR:g} rad:")
    print("\n".join(rows(found)))


if __name__ == "__main__":
    main()
