"""Exact derivatives of a graph of scalar operations, as further nodes of the same graph.

Forward differentiation: subexpressions are shared among derivatives and with what is
differentiated, zeros are folded away, and nothing is approximated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from linkages.kernel.scalars import Scalar, ScalarGraph, reachable

Tangent = dict[int, Any]
"""Number of an input → derivative with respect to it (of operations with several results: a list);
zeros are left out."""


def derivative(
    nodes: Sequence[Scalar], with_respect_to: Sequence[Scalar], section: str = "derivatives"
) -> list[list[Scalar]]:
    """Partial derivatives of nodes with respect to inputs.

    Parameters
    ----------
    nodes
        What is differentiated.
    with_respect_to
        Nodes that count as independent of each other, inputs as a rule.
    section
        Heading of the new nodes in printed code.

    Returns
    -------
    One row for each node, with one entry for each input.

    Raises
    ------
    ValueError
        For an operation without a rule.
    """
    if not nodes:
        return []
    one = nodes[0].graph.one
    directions = [{variable.index: one} for variable in with_respect_to]
    return derivative_along(nodes, directions, section)


def derivative_along(
    nodes: Sequence[Scalar],
    directions: Sequence[Mapping[int, Scalar]],
    section: str = "derivatives",
) -> list[list[Scalar]]:
    """Directional derivatives of nodes.

    Parameters
    ----------
    nodes
        What is differentiated.
    directions
        For each direction the rates of inputs, by the number of their node; others stand still.
    section
        Heading of the new nodes in printed code.

    Returns
    -------
    One row for each node, with one entry for each direction.

    Raises
    ------
    ValueError
        For an operation without a rule.
    """
    if not nodes:
        return []
    graph = nodes[0].graph
    graph.section = section
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
    result: Tangent = {}
    moving = [o for o in node.operands if tangents[o.index]]
    if not moving:
        return result
    match node.operation:
        case "div":
            return _quotient(node, tangents)
        case "solve":
            return _solution(graph, node, tangents)
        case "spline":
            return _spline(graph, node, tangents)
        case "newton":
            return result  # a step in straight-line code follows it and has the derivative
        case "item":
            several, index = node.arguments
            found = {k: values[index] for k, values in tangents[several.index].items()}
            return {k: value for k, value in found.items() if value is not graph.zero}
    for operand, factor in zip(node.operands, _partials(graph, node), strict=True):
        for k, value in tangents[operand.index].items():
            result[k] = result.get(k, graph.zero) + factor * value
    return {k: value for k, value in result.items() if value is not graph.zero}


def _quotient(node: Scalar, tangents: dict[int, Tangent]) -> Tangent:
    """Derivative of a quotient c = a/b, as (a' - c b')/b: one division for each."""
    a, b = node.operands
    upper, lower = tangents[a.index], tangents[b.index]
    zero = node.graph.zero
    numerators = {
        k: upper.get(k, zero) - node * lower.get(k, zero) for k in sorted(upper.keys() | lower)
    }
    return {k: value / b for k, value in numerators.items() if value is not zero}


def _solution(graph: ScalarGraph, node: Scalar, tangents: dict[int, Tangent]) -> Tangent:
    """Derivative of x in A x = b: it solves A x' = b' − A' x. The determinant has no rule."""
    size = int(len(node.operands) ** 0.5)
    entries, right = node.operands[: size * size], node.operands[size * size :]
    matrix = [entries[size * i : size * (i + 1)] for i in range(size)]
    solution = [graph.item(node, i) for i in range(size)]
    columns = {k for operand in node.operands for k in tangents[operand.index]}

    def of(operand: Scalar, k: int) -> Scalar:
        return tangents[operand.index].get(k, graph.zero)

    result: Tangent = {}
    for k in sorted(columns):
        sides = [
            of(b, k) - graph.total(of(a, k) * x for a, x in zip(row, solution, strict=True))
            for b, row in zip(right, matrix, strict=True)
        ]
        result[k] = graph.solve(matrix, sides)
    return result


def _spline(graph: ScalarGraph, node: Scalar, tangents: dict[int, Tangent]) -> Tangent:
    """A derivative is the next of the three results; the third has no rule."""
    time = node.operands[0]
    return {
        k: [graph.item(node, order) * value for order in (1, 2)]
        for k, value in tangents[time.index].items()
    }


def _partials(graph: ScalarGraph, node: Scalar) -> tuple[Scalar, ...]:
    """Partial derivatives of an operation with respect to its operands."""
    one = graph.one
    match node.operation, node.operands:
        case "add", _:
            return one, one
        case "sub", _:
            return one, -one
        case "neg", _:
            return (-one,)
        case "mul", (a, b):
            return b, a
        case "sqrt", _:
            return (0.5 / node,)
        case "tan", _:
            return (1.0 + node * node,)
        case "exp", _:
            return (node,)
        case "log", (a,):
            return (1.0 / a,)
        case "tanh", _:
            return (1.0 - node * node,)
        case "atan", (a,):
            return (1.0 / (1.0 + a * a),)
        case "floor", _:
            return (graph.zero,)
        case "select", (c, _, _):
            return graph.zero, graph.select(c, one, graph.zero), graph.select(c, graph.zero, one)
        case "sin", (a,):
            return (graph.cos(a),)
        case "cos", (a,):
            return (-graph.sin(a),)
        case "atan2", (y, x):
            square = x * x + y * y
            return x / square, -y / square
    raise ValueError(f"no rule for the derivative of '{node.operation}'")
