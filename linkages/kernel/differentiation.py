"""Exact derivatives of a graph of scalar operations, and its evaluation with NumPy.

Forward differentiation: subexpressions are shared among derivatives and with what is
differentiated, zeros are folded away, and nothing is approximated.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from linkages.kernel.compound import SEVERAL, Tangent, Values, evaluate
from linkages.kernel.scalars import Scalar, ScalarGraph, reachable
from linkages.operations import ELEMENTARY


def derivative(nodes: Sequence[Scalar], with_respect_to: Sequence[Scalar]) -> list[list[Scalar]]:
    """Partial derivatives of nodes with respect to inputs, or other independent nodes.

    Returns one row for each node, with one entry for each input; raises what `derivative_along`
    does.
    """
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
        found = {k: values[node.arguments[1]] for k, values in rates[0].items()}
    else:
        found = _elementary(graph, node, rates)
    return {k: value for k, value in found.items() if value is not graph.zero}


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
        """
        values: Values = {}
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            for node in self._nodes:
                values[node.index] = evaluate(node, values, inputs)
                for index in self._drop.get(node.index, ()):
                    del values[index]
        return [np.asarray(values[root.index], dtype=float) for root in self._roots]
