"""Work against error of every method and of installed peers."""

from __future__ import annotations

import json
import math
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import takewhile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.benchmark.problem import PEERS, InitialValueProblem, seconds_per_evaluation
from linkages.benchmark.problem import Solve as PeerSolve
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, InputError
from linkages.errors import Problem as InputProblem
from linkages.solvers.integration import ADAPTIVE_METHODS, FIXED_STEP_METHODS

TOLERANCES = tuple(10.0**-k for k in range(4, 15))
TINY = 1e-300
HALVINGS = 8
"""Number of fixed steps tried, each half as long as the one before."""


@dataclass(frozen=True)
class Point:
    """One run."""

    method: str  # method or peer
    setting: float  # relative tolerance, or step in seconds
    adaptive: bool  # which of the two `setting` is
    # Largest absolute error of the coordinates at the end (rad or m), but no less than the
    # uncertainty of the reference; None if it failed
    error: float | None
    seconds: float  # median wall time
    evaluations: int | None  # of the right-hand side; None where it is not known
    failure: str | None = None  # why there is no error


Solve = Callable[[float], tuple[NDArray[np.float64], int | None]]
"""Setting → coordinates at the end, number of evaluations."""


@dataclass(frozen=True)
class _Series:
    """One method over its settings, loosest first."""

    method: str
    settings: tuple[float, ...]
    adaptive: bool
    solve: Solve


def work_precision(
    problem: InitialValueProblem, repeats: int = 5, longest: float = 5.0
) -> Iterator[Point]:
    """Run everything, method by method.

    `longest`: a method is not tried at tighter settings once a run has taken this many seconds.
    """
    for series in (*_methods(problem), *_peers(problem)):
        for setting in series.settings:
            point = _point(series, setting, problem, repeats, longest)
            yield point
            if point.seconds > longest:
                break


def _methods(problem: InitialValueProblem) -> Iterator[_Series]:
    def at_tolerance(method: str, rtol: float) -> tuple[NDArray[np.float64], int]:
        return problem.solve(method, rtol=rtol)

    def with_step(method: str, step: float) -> tuple[NDArray[np.float64], int]:
        return problem.solve(method, step=step)

    for name in ADAPTIVE_METHODS:
        yield _Series(name, TOLERANCES, True, partial(at_tolerance, name))
    coarsest = _coarsest_step(problem)
    steps = tuple(coarsest / 2**k for k in range(HALVINGS))
    for name in FIXED_STEP_METHODS:
        yield _Series(name, steps, False, partial(with_step, name))


def _peers(problem: InitialValueProblem) -> Iterator[_Series]:
    def at_tolerance(solve: PeerSolve, rtol: float) -> tuple[NDArray[np.float64], None]:
        return solve(rtol), None

    for peer in PEERS:
        if not peer.available:
            continue
        try:
            prepared = peer.prepare(problem)
        except ComputationError:
            continue
        yield _Series(peer.name, TOLERANCES, True, partial(at_tolerance, prepared))


def _coarsest_step(problem: InitialValueProblem) -> float:
    """A quarter of the step that the default method takes on average at a tolerance of 1e-4."""
    _, evaluations = problem.solve("dop853", rtol=1e-4)
    return problem.end * 12 / evaluations / 4


def _point(
    series: _Series, setting: float, problem: InitialValueProblem, repeats: int, longest: float
) -> Point:
    times: list[float] = []
    try:
        for _ in range(repeats + 1):
            begin = time.perf_counter()
            result, evaluations = series.solve(setting)
            times.append(time.perf_counter() - begin)
            if times[-1] > longest:
                break
    except ComputationError as error:
        return Point(series.method, setting, series.adaptive, None, float("nan"), None, str(error))
    if len(times) > 1:
        del times[0]  # the first run may have compiled or loaded something
    seconds = float(np.median(times))
    off = max(problem.error(result), problem.uncertainty)
    return Point(series.method, setting, series.adaptive, off, seconds, evaluations)


def seconds_at(points: list[Point], method: str, error: float) -> float | None:
    """Time that a method needs for an error, interpolated between its runs on both log scales.

    A setting counts as good enough only if all tighter ones are too: a run whose error happens to
    pass through zero at the end proves nothing.

    Returns None where the tightest setting is not good enough. Where every setting is, the method
    may need still less time than is returned.
    """
    own = sorted(
        (p.setting, math.inf if p.error is None else max(p.error, TINY), p.seconds)
        for p in points
        if p.method == method
    )
    good = list(takewhile(lambda run: run[1] <= error, own))
    if not good:
        return None
    _, best_error, best = min(good, key=lambda run: run[2])
    if len(good) == len(own):
        return best
    _, near_error, near = own[len(good)]
    if not near < best or not math.isfinite(near_error):
        return best
    share = np.log(near_error / error) / np.log(near_error / best_error)
    return float(near * (best / near) ** share)


TARGETS = (1e-3, 1e-6, 1e-9, 1e-11)
"""Errors (rad or m) for which times are compared."""


@dataclass(frozen=True)
class BenchReport:
    """Results of a benchmark.

    `mechanism`, `end`: what was solved, and for how many seconds.
    """

    mechanism: str
    end: float
    points: tuple[Point, ...]  # work against error
    uncertainty: float  # of the reference solution (rad or m)
    seconds_per_evaluation: float  # of the right-hand side in compiled code
    costs: Costs  # compiling, starting, memory

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
    """Measure a mechanism over its `simulate.end`."""
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
from linkages.cli.requests import mechanism_from
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
    """Seconds and bytes."""

    # Processor time spent in making what the cache of kernels lacks before the first simulation
    compile_seconds: float
    # From the start of a process, with everything cached, to the end of the first simulation
    warm_start_seconds: float
    simulation_seconds: float  # a simulation in a process that has made one already
    # Largest resident memory of a warm process; None where the system does not tell
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
    result = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    return json.loads(result.stdout)
