"""The compiled right-hand side as a function that Python calls, and how long one call takes."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from linkages.solvers.flow import Flow
from linkages.solvers.steps.compiled import call_clock, call_rates, entry


@entry
def evaluate(
    clock: int, rates: int, t: float, state: int, parameters: int, timed: int, out: int
) -> int:
    """Time-dependent part, then state-dependent part; all arrays are addresses."""
    status = call_clock(clock, t, parameters, timed)
    if status != 0:
        return status
    return call_rates(rates, state, parameters, timed, out)


@entry
def repeat(
    clock: int, rates: int, state: int, parameters: int, timed: int, out: int, count: int
) -> int:
    """Evaluate many times at times 1 µs apart."""
    status = 0
    for i in range(count):
        status |= call_clock(clock, 1e-6 * i, parameters, timed)
        status |= call_rates(rates, state, parameters, timed, out)
    return status


class _Arrays:
    """Memory for the right-hand side of a flow."""

    def __init__(self, flow: Flow) -> None:
        self.state = np.zeros(2 * flow.coordinates)
        self.timed = np.zeros(max(1, flow.timed_size))
        self.out = np.zeros(flow.written)
        self.parameters = flow.parameters
        self.addresses = [
            array.ctypes.data for array in (self.state, self.parameters, self.timed, self.out)
        ]


def derivative(flow: Flow) -> Callable[[float, NDArray[np.float64]], NDArray[np.float64]]:
    """The function f(t, y) of a first-order system y' = f, for integrators that want one."""
    # The function holds all arrays: compiled code writes to their addresses.
    arrays, count = _Arrays(flow), flow.coordinates

    def right_hand_side(t: float, y: NDArray[np.float64]) -> NDArray[np.float64]:
        arrays.state[:] = y
        if evaluate(flow.clock, flow.rates, t, *arrays.addresses) != 0:
            return np.full(2 * count, np.nan)
        return np.concatenate([arrays.state[count:], arrays.out[:count]])

    return right_hand_side


def seconds_per_evaluation(flow: Flow, state: NDArray[np.float64], repeats: int = 7) -> float:
    """Median time of one evaluation of the whole right-hand side in compiled code."""
    arrays, count = _Arrays(flow), 100_000
    arrays.state[:] = state
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        repeat(flow.clock, flow.rates, *arrays.addresses, count)
        times.append((time.perf_counter() - begin) / count)
    return float(np.median(times))
