"""Exact derivatives of a graph of scalar operations, as further nodes of the same graph.

Forward differentiation: subexpressions are shared among derivatives and with what is
differentiated, zeros are folded away, and nothing is approximated.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from linkages.kernel.compiled import CompiledKernel, compile_kernel
from linkages.kernel.model import Model
from linkages.kernel.program import Program, write_program
from linkages.kernel.scalars import Scalar, ScalarGraph, reachable

Tangent = dict[int, Scalar]
"""Number of an input → derivative with respect to it; zeros are left out."""


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
    graph = nodes[0].graph
    graph.section = section
    seeds = {variable.index: k for k, variable in enumerate(with_respect_to)}
    tangents: dict[int, Tangent] = {}
    for node in reachable(nodes):
        if node.index in seeds:
            tangents[node.index] = {seeds[node.index]: graph.one}
        else:
            tangents[node.index] = _tangent(graph, node, tangents)
    columns = range(len(with_respect_to))
    return [[tangents[node.index].get(k, graph.zero) for k in columns] for node in nodes]


def _tangent(graph: ScalarGraph, node: Scalar, tangents: dict[int, Tangent]) -> Tangent:
    """Chain rule: the tangents of the operands, each times its partial derivative."""
    result: Tangent = {}
    moving = [o for o in node.operands if tangents[o.index]]
    if not moving:
        return result
    if node.operation == "div":
        return _quotient(node, tangents)
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
        case "sin", (a,):
            return (graph.cos(a),)
        case "cos", (a,):
            return (-graph.sin(a),)
        case "atan2", (y, x):
            square = x * x + y * y
            return x / square, -y / square
    raise ValueError(f"no rule for the derivative of '{node.operation}'")


def jacobian_nodes(model: Model, accelerations: Sequence[Scalar]) -> list[list[Scalar]]:
    """Derivatives of accelerations with respect to the state, shape (n, 2n)."""
    n = model.inputs.coordinates
    state = [model.inputs.coordinate(i) for i in range(n)] + [
        model.inputs.rate(i) for i in range(n)
    ]
    return derivative(accelerations, state, "derivatives of the accelerations")


def write_jacobian(model: Model, accelerations: Sequence[Scalar]) -> Program:
    """Print the kernel of the derivatives of accelerations.

    The program is like that of the accelerations themselves, with a parameter array and a clock
    of its own; its function ``rates(y, p, timed, out)`` writes ``∂a_i/∂y_j`` to ``out[2n·i + j]``,
    followed by margins and their rates.
    """
    entries = [entry for row in jacobian_nodes(model, accelerations) for entry in row]
    return write_program(model, entries)


def compile_jacobian(
    model: Model, accelerations: Sequence[Scalar], parameters: np.ndarray
) -> CompiledKernel:
    """Compile the kernel of `write_jacobian` for some numbers."""
    return compile_kernel(write_jacobian(model, accelerations), parameters)
