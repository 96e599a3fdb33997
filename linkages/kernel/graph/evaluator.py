"""Evaluates a graph of scalar operations with NumPy, for one state or for many at once."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from linkages.kernel.graph.scalars import Scalar, reachable
from linkages.kernel.graph.several import Values, evaluate


class Evaluator:
    """Evaluates nodes with NumPy, for one state or for many at once.

    Intermediate values are dropped after their last use, so memory is that of the widest cut.

    Parameters
    ----------
    roots
        The nodes wanted.

    Attributes
    ----------
    switched
        Whether they depend on modes, or on what a motion remembers.
    """

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
        """Values of the roots.

        Parameters
        ----------
        inputs
            Input name → array whose first axis is the input's index, or a list of arrays; further
            axes broadcast.

        Returns
        -------
        One array per root. Where an argument of a square root is negative the value is nan.
        """
        values: Values = {}
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            for node in self._nodes:
                values[node.index] = evaluate(node, values, inputs)
                for index in self._drop.get(node.index, ()):
                    del values[index]
        return [np.asarray(values[root.index], dtype=float) for root in self._roots]
