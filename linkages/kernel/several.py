"""Operations with several results: linear systems, Newton iterations, splines.

Here is what they mean to NumPy; `linkages.kernel.printing` says the same to the compiler.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from linkages.kernel.scalars import Scalar, reachable

MOST_ITERATIONS = 30
CLOSE = 1e-7
"""An update this small (rad, or relative to the size of the block) is the last one: convergence is
quadratic, and one more step follows in straight-line code."""

MOST_TURNED = 0.5
"""Largest correction of an angle (rad) or displacement (relative to the size of the block) that
still counts as the same assembly mode; a solver answers with a shorter step."""


@dataclass(frozen=True, eq=False)
class Iteration:
    """A Newton iteration z ← z + update(z).

    Parameters
    ----------
    iterates
        Input nodes that stand for z within the iteration.
    updates
        What is added to each.
    scales
        Size of each unknown: 1 for angles, a length for displacements.
    block
        Number of the block that it solves.
    """

    iterates: tuple[Scalar, ...]
    updates: tuple[Scalar, ...]
    scales: tuple[float, ...]
    block: int

    @cached_property
    def body(self) -> tuple[Scalar, ...]:
        """Nodes that change from one iteration to the next, in an order to compute them."""
        moving = {node.index for node in self.iterates}
        found = []
        for node in reachable(self.updates):
            if node.index in moving:
                continue
            if any(operand.index in moving for operand in node.operands):
                moving.add(node.index)
                found.append(node)
        return tuple(found)

    @cached_property
    def external(self) -> tuple[Scalar, ...]:
        """Nodes outside that the iteration needs."""
        inside = {node.index for node in (*self.body, *self.iterates)}
        needed = {o.index: o for node in self.body for o in node.operands if o.index not in inside}
        return tuple(needed.values())


def solve_systems(entries: Sequence[Any]) -> list[np.ndarray]:
    """Solve linear systems by elimination with row exchanges.

    Parameters
    ----------
    entries
        The matrix row by row, then the right-hand side; arrays that broadcast.

    Returns
    -------
    The solution, then the determinant.
    """
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
    iteration: Iteration,
    start: Sequence[Any],
    values: dict[int, Any],
    apply: Callable[[Scalar, dict[int, Any]], Any],
    most_turned: float = MOST_TURNED,
) -> list[np.ndarray]:
    """Run an iteration for many starts at once.

    Parameters
    ----------
    iteration
        What is iterated.
    start
        Values to start from, arrays that broadcast.
    values
        Node number → value of the nodes outside.
    apply
        Computes an elementary operation.
    most_turned
        Largest correction.

    Returns
    -------
    One array per unknown, nan where the iteration did not converge.
    """
    outside = [np.asarray(values[n.index], dtype=float) for n in iteration.external]
    shape = np.broadcast_shapes(*(np.shape(s) for s in start), *(o.shape for o in outside))
    unknowns = [np.array(np.broadcast_to(s, shape), dtype=float) for s in start]
    begin = [unknown.copy() for unknown in unknowns]
    inside = dict(values)
    running = np.ones(shape, dtype=bool)
    for _ in range(MOST_ITERATIONS):
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            updates = _updates(iteration, unknowns, inside, apply)
        largest = np.zeros(shape)
        for unknown, update, scale in zip(unknowns, updates, iteration.scales, strict=True):
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


def _updates(
    iteration: Iteration,
    unknowns: Sequence[np.ndarray],
    inside: dict[int, Any],
    apply: Callable[[Scalar, dict[int, Any]], Any],
) -> list[Any]:
    for node, unknown in zip(iteration.iterates, unknowns, strict=True):
        inside[node.index] = unknown
    for node in iteration.body:
        if node.operation == "solve":
            inside[node.index] = solve_systems([inside[o.index] for o in node.operands])
        elif node.operation == "item":
            several, index = node.arguments
            inside[node.index] = inside[several.index][index]
        else:
            inside[node.index] = apply(node, inside)
    return [inside[node.index] for node in iteration.updates]


def evaluate_spline(
    time: Any, parameters: np.ndarray, place: int, count: int, periodic: bool
) -> list[np.ndarray]:
    """Value and two derivatives of piecewise cubics; their numbers stand from `place` on."""
    numbers = parameters[place : place + 5 * count + 1]
    numbers = numbers if numbers.ndim == 1 else numbers[:, 0]
    knots, coefficients = numbers[: count + 1], numbers[count + 1 :].reshape(count, 4)
    t = np.asarray(time, dtype=float)
    if periodic:
        t = knots[0] + np.mod(t - knots[0], knots[-1] - knots[0])
    inner = np.clip(t, knots[0], knots[-1])
    interval = np.clip(np.searchsorted(knots, inner, side="right") - 1, 0, count - 1)
    d, c, b, a = (coefficients[interval, k] for k in range(4))
    x = inner - knots[interval]
    slope = b + x * (2.0 * c + x * 3.0 * d)
    outside = t - inner
    curvature = np.where(outside == 0.0, 2.0 * c + 6.0 * d * x, 0.0)
    return [a + x * (b + x * (c + x * d)) + outside * slope, slope, curvature]
