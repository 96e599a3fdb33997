"""The initial-value problem of a benchmark, and peers that solve it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError
from linkages.kernel.scalars import reachable
from linkages.kernel.system import System
from linkages.operations import ELEMENTARY
from linkages.solution.plan import build_flow
from linkages.solution.stop_messages import failure_text
from linkages.solvers.flow import Flow
from linkages.solvers.integration import integrate
from linkages.solvers.loops.scalar_stages import EVALUATE_STATE, REPEAT

REFERENCE = "gauss8"


@dataclass(frozen=True)
class InitialValueProblem:
    """Motion of a mechanism from t = 0 to `end`."""

    mechanism: Mechanism  # with at least one free coordinate
    end: float  # seconds

    @cached_property
    def system(self) -> System:
        """Its topology and equations."""
        return System(self.mechanism)

    @cached_property
    def flow(self) -> Flow:
        """Its compiled differential equation."""
        return build_flow(self.system)

    def solve(
        self, method: str, *, rtol: float = 1e-10, step: float | None = None
    ) -> tuple[NDArray[np.float64], int]:
        """Coordinates at the end, shape (n,), and the number of evaluations."""
        result = integrate(
            self.flow, self.system.state, [0.0, self.end], method=method, rtol=rtol, step=step
        )
        failure = failure_text(self.system, result)
        if failure is not None:
            raise ComputationError(f"{method} stopped {failure}", time=result.stop_time)
        return result.unwrapped[-1], result.evaluations

    @cached_property
    def _references(self) -> list[NDArray[np.float64]]:
        """Ends by the symmetric implicit method at three steps, each half of the one before.

        It makes no truncation error worth mentioning at these steps, sums with compensation, and
        shares no coefficient with the explicit methods that are measured.
        """
        _, evaluations = self.solve("dop853", rtol=1e-10)
        step = self.end * 12 / evaluations
        return [self.solve(REFERENCE, step=step / 2**k)[0] for k in (1, 2, 3)]

    @property
    def exact(self) -> NDArray[np.float64]:
        """Coordinates at the end by the best reference there is, shape (n,)."""
        return self._references[-1]

    @property
    def uncertainty(self) -> float:
        """By how much the two finest references differ: errors below it mean nothing."""
        return float(np.abs(self._references[-1] - self._references[-2]).max())

    def error(self, coordinates: NDArray[np.float64]) -> float:
        """Largest absolute error of the coordinates at the end (rad or m)."""
        return float(np.abs(coordinates - self.exact).max())


class _Arrays:
    """Memory for the right-hand side of a flow: time, state, what is written, in one array."""

    def __init__(self, flow: Flow) -> None:
        size, written = 2 * flow.coordinates, flow.written
        self._work = np.zeros(1 + size + written + max(1, flow.timed_size))
        self.time, self.state, self.out, self._timed = np.split(
            self._work, [1, 1 + size, 1 + size + written]
        )
        self._parameters = flow.parameters
        numbers = flow.parameters.ctypes.data
        self._kernel = np.array([flow.clock, flow.rates, numbers, size, written])
        self._addresses = self._kernel.ctypes.data, self._work.ctypes.data

    def evaluate(self) -> int:
        """Evaluate at a time and a state; returns the status."""
        return EVALUATE_STATE.function(*self._addresses)

    def repeat(self, count: int) -> None:
        """Evaluate at the state and many times."""
        used = (self.state, self._parameters, self._timed, self.out)
        REPEAT(*self._kernel[:2].tolist(), *(array.ctypes.data for array in used), count)


def derivative(flow: Flow) -> Callable[[float, NDArray[np.float64]], NDArray[np.float64]]:
    """The function f(t, y) of a first-order system y' = f, for integrators that want one."""
    # The function holds all arrays: compiled code writes to their addresses.
    arrays, count = _Arrays(flow), flow.coordinates

    def right_hand_side(t: float, y: NDArray[np.float64]) -> NDArray[np.float64]:
        arrays.time[0], arrays.state[:] = t, y
        if arrays.evaluate() != 0:
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
        arrays.repeat(count)
        times.append((time.perf_counter() - begin) / count)
    return float(np.median(times))


SCIPY_LEAST_RTOL = 2.3e-14
Solve = Callable[[float], NDArray[np.float64]]


@dataclass(frozen=True)
class Peer:
    """Another integrator."""

    name: str  # as printed
    available: bool  # whether it is installed
    # Problem → function of the relative tolerance that returns the coordinates at the end
    prepare: Callable[[InitialValueProblem], Solve]


def _scipy(problem: InitialValueProblem) -> Solve:
    """`scipy.integrate.solve_ivp` with DOP853 and our compiled right-hand side."""
    from scipy.integrate import solve_ivp

    right_hand_side = derivative(problem.flow)

    def solve(rtol: float) -> NDArray[np.float64]:
        result = solve_ivp(
            right_hand_side,
            (0.0, problem.end),
            problem.system.state,
            method="DOP853",
            rtol=max(rtol, SCIPY_LEAST_RTOL),
            atol=rtol,
        )
        return result.y[: problem.flow.coordinates, -1]

    return solve


def _heyoka(problem: InitialValueProblem) -> Solve:
    """Heyoka's adaptive Taylor method, which compiles the same graph of operations itself."""
    import heyoka

    names = [f"y{i}" for i in range(2 * problem.flow.coordinates)]
    variables = heyoka.make_vars(*names)
    accelerations = expressions(problem, variables, heyoka)
    rates = [*variables[problem.flow.coordinates :], *accelerations]
    system = list(zip(variables, rates, strict=True))
    built: dict[float, Any] = {}

    def solve(rtol: float) -> NDArray[np.float64]:
        if rtol not in built:  # compiled once per tolerance, outside of what is timed
            built[rtol] = heyoka.taylor_adaptive(
                system, problem.system.state.tolist(), tol=rtol, compact_mode=True
            )
        integrator = built[rtol]
        integrator.time = 0.0
        integrator.state[:] = problem.system.state
        integrator.propagate_until(problem.end)
        return np.array(integrator.state[: problem.flow.coordinates])

    return solve


def expressions(problem: InitialValueProblem, variables: list[Any], heyoka: Any) -> list[Any]:
    """The accelerations of the free coordinates in heyoka's expression system."""
    model = problem.system.model
    roots = model.changes
    numbers = problem.system.parameters
    inputs = {"t": lambda _: heyoka.time, "p": lambda i: heyoka.expression(float(numbers[i]))}
    inputs["y"] = variables.__getitem__
    values: dict[int, Any] = {}
    for node in reachable(roots):
        if node.constant is not None:
            values[node.index] = heyoka.expression(node.constant)
        elif node.operation == "input":
            name, index = node.arguments
            values[node.index] = inputs[name](index)
        else:
            row = ELEMENTARY.get(node.operation)
            operation = None if row is None else row.among(heyoka)
            if operation is None:
                raise ComputationError(f"heyoka has no {node.operation!r}")
            values[node.index] = operation(*(values[operand.index] for operand in node.operands))
    return [values[root.index] for root in roots]


PEERS = (
    Peer("scipy solve_ivp DOP853", True, _scipy),
    Peer("heyoka Taylor", find_spec("heyoka") is not None, _heyoka),
)
