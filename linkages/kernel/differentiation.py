"""Exact derivatives of a graph of scalar operations, as further nodes of the same graph.

Forward differentiation: subexpressions are shared among derivatives and with what is
differentiated, zeros are folded away, and nothing is approximated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from linkages.kernel.scalars import Scalar, ScalarGraph, reachable
from linkages.kernel.several import SEVERAL, Tangent
from linkages.operations import ELEMENTARY


def derivative(nodes: Sequence[Scalar], with_respect_to: Sequence[Scalar]) -> list[list[Scalar]]:
    """Partial derivatives of nodes with respect to inputs.

    Parameters
    ----------
    nodes
        What is differentiated.
    with_respect_to
        Nodes that count as independent of each other, inputs as a rule.

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
    return derivative_along(nodes, directions)


def derivative_along(
    nodes: Sequence[Scalar], directions: Sequence[Mapping[int, Scalar]]
) -> list[list[Scalar]]:
    """Directional derivatives of nodes.

    Parameters
    ----------
    nodes
        What is differentiated.
    directions
        For each direction the rates of inputs, by the number of their node; others stand still.

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
    if not any(tangents[operand.index] for operand in node.operands):
        return result
    if node.operation == "item":
        several, index = node.arguments
        result = {k: values[index] for k, values in tangents[several.index].items()}
    elif node.operation in SEVERAL:
        return SEVERAL[node.operation].tangent(node, tangents)
    else:
        row, rates = ELEMENTARY.get(node.operation), [tangents[o.index] for o in node.operands]
        if row is None:
            raise ValueError(f"no rule for the derivative of '{node.operation}'")
        if row.tangent is not None:
            for k in sorted(set().union(*rates)):
                moved = [rate.get(k, graph.zero) for rate in rates]
                result[k] = row.tangent(node, *node.operands, *moved)
        else:
            partials = row.partials(graph.apply, node, *node.operands)
            for rate, factor in zip(rates, map(graph.lift, partials), strict=True):
                for k, value in rate.items():
                    result[k] = result.get(k, graph.zero) + factor * value
    return {k: value for k, value in result.items() if value is not graph.zero}
