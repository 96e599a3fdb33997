"""Everything that `bench` measures about one mechanism."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from linkages.benchmark.problem import InitialValueProblem, seconds_per_evaluation
from linkages.benchmark.work_precision import Point, seconds_at, work_precision
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError
from linkages.errors import Problem as InputProblem

TARGETS = (1e-3, 1e-6, 1e-9, 1e-11)
"""Errors (rad or m) for which times are compared."""


@dataclass(frozen=True)
class BenchReport:
    """Results of a benchmark.

    Parameters
    ----------
    mechanism, end
        What was solved, and for how many seconds.
    points
        Work against error.
    uncertainty
        Of the reference solution (rad or m).
    seconds_per_evaluation
        Of the right-hand side in compiled code.
    costs
        Compiling, starting, memory.
    """

    mechanism: str
    end: float
    points: tuple[Point, ...]
    uncertainty: float
    seconds_per_evaluation: float
    costs: Costs

    @property
    def methods(self) -> tuple[str, ...]:
        """Methods and peers in the order in which they were run."""
        return tuple(dict.fromkeys(point.method for point in self.points))

    def seconds_at(self, method: str, error: float) -> float | None:
        """Time that a method needs for an error; None where it never gets there."""
        return seconds_at(list(self.points), method, error)

    def as_dict(self) -> dict[str, Any]:
        """For JSON, with the machine that it was measured on."""
        return {
            "mechanism": self.mechanism,
            "end": self.end,
            "machine": f"{platform.machine()}, Python {platform.python_version()}",
            "reference_uncertainty": self.uncertainty,
            "seconds_per_evaluation": self.seconds_per_evaluation,
            "costs": asdict(self.costs),
            "seconds_at_error": {
                f"{error:g}": {method: self.seconds_at(method, error) for method in self.methods}
                for error in TARGETS
            },
            "points": [asdict(point) for point in self.points],
        }


def run_benchmark(
    mechanism: Mechanism,
    file: str,
    assignments: Sequence[str] = (),
    *,
    repeats: int = 5,
    watch: Callable[[Point], None] | None = None,
) -> BenchReport:
    """Measure a mechanism over its `simulate.end`.

    Parameters
    ----------
    mechanism, file, assignments
        What to solve; the file and assignments again for processes of their own.
    repeats
        Runs per point; the median counts.
    watch
        Called with every point.

    Raises
    ------
    InputError
        If nothing is free to move: there is nothing to integrate.
    """
    problem = InitialValueProblem(mechanism, mechanism.simulation.end)
    if not problem.system.topology.free:
        message = "all coordinates are driven, so nothing is integrated; expected a free coordinate"
        raise InputError(mechanism.source, [InputProblem(message=message)])
    points = []
    for point in work_precision(problem, repeats=repeats):
        points.append(point)
        if watch is not None:
            watch(point)
    return BenchReport(
        mechanism=mechanism.name,
        end=problem.end,
        points=tuple(points),
        uncertainty=problem.uncertainty,
        seconds_per_evaluation=seconds_per_evaluation(problem.flow, problem.system.state),
        costs=measure_costs(file, assignments),
    )


_PROGRAM = """
import json, sys, time
begin = time.perf_counter()
from linkages.cli.loading import mechanism_from
from linkages.kernel.code import machine
from linkages.solution.simulate import simulate
compiling, kept = [], machine.kept
def timed(key, suffix, make):
    def made():
        begin = time.thread_time()
        content = make()
        compiling.append(time.thread_time() - begin)
        return content
    return kept(key, suffix, made)
machine.kept = timed
mechanism = mechanism_from(sys.argv[1], sys.argv[2:])
loaded = time.perf_counter()
simulate(mechanism)
first = time.perf_counter()
simulate(mechanism)
again = time.perf_counter()
try:
    import resource
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    peak *= 1 if sys.platform == "darwin" else 1024
except ImportError:
    peak = None
print(json.dumps({"load": loaded - begin, "first": first - loaded, "again": again - first,
                  "compiling": sum(compiling), "peak": peak}))
"""


@dataclass(frozen=True)
class Costs:
    """Seconds and bytes.

    Parameters
    ----------
    compile_seconds
        Processor time spent in making what the cache of kernels lacks before the first simulation.
    warm_start_seconds
        From the start of a process, with everything cached, to the end of the first simulation.
    simulation_seconds
        A simulation in a process that has made one already.
    peak_bytes
        Largest resident memory of a warm process; None where the system does not tell.
    """

    compile_seconds: float
    warm_start_seconds: float
    simulation_seconds: float
    peak_bytes: int | None


def measure_costs(file: str, assignments: Sequence[str]) -> Costs:
    """Simulate a file in fresh processes, first with an empty cache of its own, then warm."""
    with tempfile.TemporaryDirectory(prefix="linkages-") as cache:
        cold = _run(file, assignments, cache)
        warm = _run(file, assignments, cache)
    return Costs(
        compile_seconds=cold["compiling"],
        warm_start_seconds=warm["load"] + warm["first"],
        simulation_seconds=warm["again"],
        peak_bytes=warm["peak"],
    )


def _run(file: str, assignments: Sequence[str], cache: str) -> dict:
    environment = {**os.environ, "LINKAGES_CACHE_DIR": cache}
    command = [sys.executable, "-c", _PROGRAM, file, *assignments]
    found = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    return json.loads(found.stdout)
