"""Evaluates a graph of scalar operations with NumPy, for one state or for many at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from linkages.kernel.scalars import SEVERAL, Scalar, reachable
from linkages.kernel.several import evaluate_spline, iterate, solve_systems

_NUMPY: dict[str, Callable[..., Any]] = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "neg": np.negative,
    "sqrt": np.sqrt,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "exp": np.exp,
    "log": np.log,
    "tanh": np.tanh,
    "atan": np.arctan,
    "floor": np.floor,
    "atan2": np.arctan2,
    "select": lambda c, a, b: np.where(np.asarray(c) >= 0.0, a, b),
}


class Evaluator:
    """Evaluates nodes with NumPy, for one state or for many at once.

    Intermediate values are dropped after their last use, so memory is that of the widest cut.

    Parameters
    ----------
    roots
        The nodes wanted.
    """

    def __init__(self, roots: Iterable[Scalar]) -> None:
        self._roots = tuple(roots)
        self._nodes = reachable(self._roots)
        kept = {root.index for root in self._roots}
        last = {o.index: node.index for node in self._nodes for o in node.operands}
        self._drop: dict[int, list[int]] = {}
        for argument, user in last.items():
            if argument not in kept:
                self._drop.setdefault(user, []).append(argument)

    def __call__(self, **inputs: np.ndarray) -> list[np.ndarray]:
        """Values of the roots.

        Parameters
        ----------
        inputs
            Input name → array whose first axis is the input's index; further axes broadcast.

        Returns
        -------
        One array per root. Where an argument of a square root is negative the value is nan.
        """
        values: dict[int, Any] = {}
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            for node in self._nodes:
                values[node.index] = evaluate(node, values, inputs)
                for index in self._drop.get(node.index, ()):
                    del values[index]
        return [np.asarray(values[root.index], dtype=float) for root in self._roots]


def evaluate(node: Scalar, values: dict[int, Any], inputs: dict[str, Any]) -> Any:
    """The value of a node, given those of its operands and the arguments of the kernel."""
    if node.operation == "constant":
        return node.arguments[0]
    if node.operation == "input":
        name, index = node.arguments
        return inputs[name][index]
    if node.operation in SEVERAL:
        return _several(node, values, inputs)
    if node.operation == "item":
        several, index = node.arguments
        return values[several.index][index]
    return apply(node, values)


def apply(node: Scalar, values: dict[int, Any]) -> Any:
    """The value of an elementary operation, given those of its operands."""
    return _NUMPY[node.operation](*(values[o.index] for o in node.arguments))


def _several(node: Scalar, values: dict[int, Any], inputs: dict[str, np.ndarray]) -> list[Any]:
    """All results of an operation that has several."""
    operands = [values[o.index] for o in node.operands]
    if node.operation == "solve":
        return solve_systems(operands)
    if node.operation == "spline":
        _, first, count, periodic = node.arguments
        return evaluate_spline(operands[0], inputs["p"], first.arguments[1], count, periodic)
    iteration = node.arguments[-1]
    return iterate(iteration, operands[: len(iteration.iterates)], values, apply)
