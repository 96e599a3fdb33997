"""Values of a graph of scalar operations by NumPy, and its exact forward derivatives.

Operations with several results (linear systems, Newton iterations, splines) are rows of `SEVERAL`:
cost, value and derivative.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.functions import evaluated
from linkages.kernel.scalars import Scalar, ScalarGraph, reachable
from linkages.operations import ELEMENTARY, ITERATIONS, OTHERS, SYSTEMS

Values = dict[int, Any]
"""Number of a node → its value; of an operation with several results a sequence."""

Tangent = dict[int, Any]
"""Number of a direction → derivative along it (of operations with several results: a list); zeros
are left out."""

MOST_ITERATIONS = 30
CLOSE = 1e-7
"""An update this small (rad, or relative to the size of the block) is the last one: convergence is
quadratic, and one more step follows in straight-line code."""

MOST_TURNED = 0.5
"""Largest correction of an angle (rad) or displacement (relative to the size of the block) that
still counts as the same assembly branch; a solver answers with a shorter step."""


@dataclass(frozen=True, eq=False)
class Iteration:
    """A Newton iteration z ← z + update(z)."""

    iterates: tuple[Scalar, ...]  # input nodes that stand for z within the iteration
    updates: tuple[Scalar, ...]  # what is added to each
    scales: tuple[float, ...]  # size of each unknown: 1 for angles, a length for displacements
    block: int  # number of the block that it solves

    @cached_property
    def body(self) -> tuple[Scalar, ...]:
        """Nodes that change from one iteration to the next, in an order to compute them."""
        moving = {node.index for node in self.iterates}
        result = []
        for node in reachable(self.updates):
            if node.index in moving:
                continue
            if any(operand.index in moving for operand in node.operands):
                moving.add(node.index)
                result.append(node)
        return tuple(result)

    @cached_property
    def external(self) -> tuple[Scalar, ...]:
        """Nodes outside that the iteration needs."""
        inside = {node.index for node in (*self.body, *self.iterates)}
        needed = {o.index: o for node in self.body for o in node.operands if o.index not in inside}
        return tuple(needed.values())


def solve_systems(entries: Sequence[Any]) -> list[np.ndarray]:
    """Solve linear systems by elimination with row exchanges."""
    size = round((np.sqrt(1 + 4 * len(entries)) - 1) / 2)
    columns = np.broadcast_arrays(*(np.asarray(entry, dtype=float) for entry in entries))
    flat = np.stack([column.ravel() for column in columns])
    matrix = flat[: size * size].T.reshape(-1, size, size)
    right = flat[size * size :].T[..., None]
    sound = np.isfinite(flat).all(axis=0)
    determinant = np.linalg.det(matrix)
    sound &= determinant != 0.0
    solution = np.full((len(matrix), size), np.nan)
    solution[sound] = np.linalg.solve(matrix[sound], right[sound])[..., 0]
    shape = columns[0].shape
    return [*(column.reshape(shape) for column in solution.T), determinant.reshape(shape)]


def iterate(
    iteration: Iteration, start: Sequence[Any], values: Values, most_turned: float = MOST_TURNED
) -> list[np.ndarray]:
    """Run an iteration for many starts at once."""
    outside = [np.asarray(values[n.index], dtype=float) for n in iteration.external]
    shape = np.broadcast_shapes(*(np.shape(s) for s in start), *(o.shape for o in outside))
    unknowns = [np.array(np.broadcast_to(s, shape), dtype=float) for s in start]
    begin = [unknown.copy() for unknown in unknowns]
    inside = dict(values)
    running = np.ones(shape, dtype=bool)
    for _ in range(MOST_ITERATIONS):
        inside |= {n.index: z for n, z in zip(iteration.iterates, unknowns, strict=True)}
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            for node in iteration.body:
                inside[node.index] = evaluate(node, inside, {})
        largest = np.zeros(shape)
        for unknown, node, scale in zip(unknowns, iteration.updates, iteration.scales, strict=True):
            update = inside[node.index]
            unknown += np.where(running, update, 0.0)
            largest = np.maximum(largest, np.abs(update) / scale)
        running &= ~(largest <= CLOSE)
        if not running.any():
            break
    failed = running
    for unknown, first, scale in zip(unknowns, begin, iteration.scales, strict=True):
        failed = failed | ~(np.abs(unknown - first) <= most_turned * scale)
    for unknown in unknowns:
        unknown[failed] = np.nan
    return unknowns


@dataclass(frozen=True)
class Several:
    """An operation with several results."""

    kind: str  # what it counts as, one of `linkages.operations.KINDS`
    # Node, values of its operands, inputs → all results
    value: Callable[[Scalar, Values, Mapping[str, np.ndarray]], Sequence[Any]]
    # Node, tangents of its operands → tangent of all results that have one
    tangent: Callable[[Scalar, Mapping[int, Tangent]], Tangent]


def system_size(node: Scalar) -> int:
    """Size n of the linear system of a ``"solve"``, which has n² + n operands."""
    return int(len(node.operands) ** 0.5)


def _solution_tangent(node: Scalar, tangents: Mapping[int, Tangent]) -> Tangent:
    """Derivative of x in A x = b: it solves A x' = b' − A' x. The determinant has no rule."""
    graph, size = node.graph, system_size(node)
    entries, right = node.operands[: size * size], node.operands[size * size :]
    matrix = [entries[size * i : size * (i + 1)] for i in range(size)]
    solution = [graph.item(node, i) for i in range(size)]
    columns = {k for operand in node.operands for k in tangents[operand.index]}

    def of(operand: Scalar, k: int) -> Any:
        return tangents[operand.index].get(k, graph.zero)

    result: Tangent = {}
    for k in sorted(columns):
        sides = [
            of(b, k) - graph.total(of(a, k) * x for a, x in zip(row, solution, strict=True))
            for b, row in zip(right, matrix, strict=True)
        ]
        result[k] = graph.solve(matrix, sides)
    return result


def _fixed_point(node: Scalar, values: Values, _inputs: object) -> Sequence[Any]:
    iteration = node.arguments[-1]
    starts = node.operands[: len(iteration.iterates)]
    return iterate(iteration, [values[start.index] for start in starts], values)


def _spline(node: Scalar, values: Values, inputs: Mapping[str, np.ndarray]) -> Sequence[Any]:
    time, first, count, periodic = node.arguments
    array, place = first.arguments
    rows = inputs[array][place : place + 5 * count + 1]
    shape = np.broadcast_shapes(*map(np.shape, rows))
    numbers = np.array([np.broadcast_to(row, shape).ravel() for row in rows])

    def of(table: NDArray[np.float64], times: Any) -> Sequence[Any]:
        coefficients = table[count + 1 :].reshape(count, 4).T
        return evaluated(table[: count + 1], coefficients, periodic, times)

    times = values[time.index]
    if (numbers == numbers[:, :1]).all():
        return of(numbers[:, 0], times)
    tables, which = np.unique(numbers, axis=1, return_inverse=True)
    which, times = np.broadcast_arrays(which.reshape(shape), times)
    result = np.empty((3, *times.shape))
    for k, table in enumerate(tables.T):
        result[:, which == k] = of(table, times[which == k])
    return [*result]


def _spline_tangent(node: Scalar, tangents: Mapping[int, Tangent]) -> Tangent:
    """A derivative by time is the next of the three results; the third has no rule.

    The derivatives of coefficients are those of another spline.
    """
    graph, (time, first) = node.graph, node.operands
    rates = tangents[time.index]
    result = {k: [graph.item(node, i) * rate for i in (1, 2)] for k, rate in rates.items()}
    for k, start in tangents[first.index].items():
        moved = graph.spline_from(time, start, *node.arguments[2:])
        known = result.get(k)
        if known is not None:
            moved = [one + other for one, other in zip(moved, known, strict=False)]
        result[k] = moved
    return result


SEVERAL = {
    "solve": Several(
        SYSTEMS,
        lambda node, values, _inputs: solve_systems([values[o.index] for o in node.operands]),
        _solution_tangent,
    ),
    # a step in straight-line code follows an iteration and has its derivative
    "newton": Several(ITERATIONS, _fixed_point, lambda _node, _tangents: {}),
    "spline": Several(OTHERS, _spline, _spline_tangent),
}


def evaluate(node: Scalar, values: Values, inputs: Mapping[str, Any]) -> Any:
    """The value of a node by NumPy, given those of its operands; all results if it has several."""
    match node.operation:
        case "constant":
            return node.arguments[0]
        case "input":
            name, index = node.arguments
            return inputs[name][index]
        case "item":
            several, index = node.arguments
            return values[several.index][index]
        case name if name in SEVERAL:
            return SEVERAL[name].value(node, values, inputs)
        case name:
            result = ELEMENTARY[name].numpy
            function = getattr(np, result) if isinstance(result, str) else result
            return function(*(values[o.index] for o in node.operands))


def solve_symmetric(
    matrix: list[list[Scalar]],
    right: list[Scalar],
    reciprocal: Callable[[int, Scalar], Scalar] = lambda _, pivot: 1.0 / pivot,
) -> list[Scalar]:
    """Solve a symmetric positive definite system by L D Lᵀ, unrolled.

    `reciprocal` of a row and its pivot is 0 for an unknown that is to be 0 where the matrix is
    singular.
    """
    count = len(right)
    lower: list[list[Scalar]] = []
    inverse: list[Scalar] = []
    for i in range(count):
        row: list[Scalar] = []  # row[j] = L_ij d_j until it is scaled below
        for j in range(i):
            value = matrix[i][j]
            for k in range(j):
                value = value - row[k] * lower[j][k]
            row.append(value)
        scaled = [value * inverse[j] for j, value in enumerate(row)]
        pivot = matrix[i][i]
        for value, factor in zip(row, scaled, strict=True):
            pivot = pivot - value * factor
        lower.append(scaled)
        inverse.append(reciprocal(i, pivot))
    forward: list[Scalar] = []
    for i in range(count):
        value = right[i]
        for j in range(i):
            value = value - lower[i][j] * forward[j]
        forward.append(value)
    solution = [value * inverse[i] for i, value in enumerate(forward)]
    for i in reversed(range(count)):
        for j in range(i):
            solution[j] = solution[j] - lower[i][j] * solution[i]
    return solution


def derivative(nodes: Sequence[Scalar], with_respect_to: Sequence[Scalar]) -> list[list[Scalar]]:
    """Partial derivatives of nodes, a row for each, with respect to independent nodes."""
    if not nodes:
        return []
    one = nodes[0].graph.one
    directions = [{variable.index: one} for variable in with_respect_to]
    return derivative_along(nodes, directions)


def derivative_along(
    nodes: Sequence[Scalar], directions: Sequence[Mapping[int, Scalar]]
) -> list[list[Scalar]]:
    """Directional derivatives of nodes."""
    if not nodes:
        return []
    graph = nodes[0].graph
    seeds: dict[int, Tangent] = {}
    for k, direction in enumerate(directions):
        for index, rate in direction.items():
            if rate is not graph.zero:
                seeds.setdefault(index, {})[k] = rate
    tangents: dict[int, Tangent] = {}
    for node in reachable(nodes):
        if node.index in seeds:
            tangents[node.index] = seeds[node.index]
        else:
            tangents[node.index] = _tangent(graph, node, tangents)
    columns = range(len(directions))
    return [[tangents[node.index].get(k, graph.zero) for k in columns] for node in nodes]


def _tangent(graph: ScalarGraph, node: Scalar, tangents: dict[int, Tangent]) -> Tangent:
    """Chain rule: the tangents of the operands, each times its partial derivative."""
    rates = [tangents[operand.index] for operand in node.operands]
    if not any(rates):
        return {}
    if node.operation in SEVERAL:
        return SEVERAL[node.operation].tangent(node, tangents)
    if node.operation == "item":
        result = {k: values[node.arguments[1]] for k, values in rates[0].items()}
    else:
        result = _elementary(graph, node, rates)
    return {k: value for k, value in result.items() if value is not graph.zero}


def _elementary(graph: ScalarGraph, node: Scalar, rates: list[Tangent]) -> Tangent:
    row = ELEMENTARY.get(node.operation)
    if row is None:
        raise ValueError(f"no rule for the derivative of '{node.operation}'")
    result: Tangent = {}
    if row.tangent is not None:
        for k in sorted(set().union(*rates)):
            moved = [rate.get(k, graph.zero) for rate in rates]
            result[k] = row.tangent(node, *node.operands, *moved)
        return result
    partials = row.partials(graph.apply, node, *node.operands)
    for rate, factor in zip(rates, map(graph.lift, partials), strict=True):
        for k, value in rate.items():
            result[k] = result.get(k, graph.zero) + factor * value
    return result


class Evaluator:
    """Evaluates nodes with NumPy, for one state or many; drops values after their last use."""

    def __init__(self, roots: Iterable[Scalar]) -> None:
        self._roots = tuple(roots)
        self._nodes = reachable(self._roots)
        inputs = {node.arguments[0] for node in self._nodes if node.operation == "input"}
        self.switched = not inputs.isdisjoint({"mode", "memory"})
        kept = {root.index for root in self._roots}
        last = {o.index: node.index for node in self._nodes for o in node.operands}
        self._drop: dict[int, list[int]] = {}
        for argument, user in last.items():
            if argument not in kept:
                self._drop.setdefault(user, []).append(argument)

    def __call__(self, **inputs: Any) -> list[np.ndarray]:
        """Values of the roots; the first axis of an input is its index, further ones broadcast."""
        values: Values = {}
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            for node in self._nodes:
                values[node.index] = evaluate(node, values, inputs)
                for index in self._drop.get(node.index, ()):
                    del values[index]
        return [np.asarray(values[root.index], dtype=float) for root in self._roots]
