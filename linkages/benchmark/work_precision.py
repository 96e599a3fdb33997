"""Work against error of every method and of installed peers."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import takewhile

import numpy as np
from numpy.typing import NDArray

from linkages.benchmark.peers import PEERS
from linkages.benchmark.peers import Solve as PeerSolve
from linkages.benchmark.problem import InitialValueProblem
from linkages.errors import ComputationError
from linkages.solvers.methods.named import ADAPTIVE_METHODS, FIXED_STEP_METHODS

TOLERANCES = tuple(10.0**-k for k in range(4, 15))
TINY = 1e-300
HALVINGS = 8
"""Number of fixed steps tried, each half as long as the one before."""


@dataclass(frozen=True)
class Point:
    """One run.

    Parameters
    ----------
    method
        Method or peer.
    setting
        Relative tolerance, or step in seconds.
    adaptive
        Which of the two `setting` is.
    error
        Largest absolute error of the coordinates at the end (rad or m), but no less than the
        uncertainty of the reference; None if it failed.
    seconds
        Median wall time.
    evaluations
        Of the right-hand side; None where it is not known.
    failure
        Why there is no error.
    """

    method: str
    setting: float
    adaptive: bool
    error: float | None
    seconds: float
    evaluations: int | None
    failure: str | None = None


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

    Parameters
    ----------
    problem
        What to solve.
    repeats
        Runs per point; the median counts.
    longest
        A method is not tried at tighter settings once a run has taken this many seconds.
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
            found, evaluations = series.solve(setting)
            times.append(time.perf_counter() - begin)
            if times[-1] > longest:
                break
    except ComputationError as error:
        return Point(series.method, setting, series.adaptive, None, float("nan"), None, str(error))
    if len(times) > 1:
        del times[0]  # the first run may have compiled or loaded something
    seconds = float(np.median(times))
    off = max(problem.error(found), problem.uncertainty)
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
