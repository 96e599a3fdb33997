"""Other integrators on the same equations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.benchmark.problem import InitialValueProblem, derivative
from linkages.errors import ComputationError
from linkages.kernel.graph.scalars import reachable
from linkages.operations import ELEMENTARY

SCIPY_LEAST_RTOL = 2.3e-14
Solve = Callable[[float], NDArray[np.float64]]


@dataclass(frozen=True)
class Peer:
    """Another integrator.

    Parameters
    ----------
    name
        As printed.
    available
        Whether it is installed.
    prepare
        Problem → function of the relative tolerance that returns the coordinates at the end.
    """

    name: str
    available: bool
    prepare: Callable[[InitialValueProblem], Solve]


def _scipy(problem: InitialValueProblem) -> Solve:
    """`scipy.integrate.solve_ivp` with DOP853 and our compiled right-hand side."""
    from scipy.integrate import solve_ivp

    right_hand_side = derivative(problem.flow)

    def solve(rtol: float) -> NDArray[np.float64]:
        found = solve_ivp(
            right_hand_side,
            (0.0, problem.end),
            problem.system.state,
            method="DOP853",
            rtol=max(rtol, SCIPY_LEAST_RTOL),
            atol=rtol,
        )
        return found.y[: problem.flow.coordinates, -1]

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
    """The accelerations of the free coordinates in heyoka's expression system.

    Raises
    ------
    ComputationError
        For what is no expression: iterations, splines, conditions.
    """
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
