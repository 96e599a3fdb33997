"""Joint reactions as nodes of a model: the linear system of forces, to be printed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from linkages.components.contributed.terms import Parameter
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.model import Model
from linkages.solution.values.reactions import Statics

MOST = 200
"""Unknown forces; a program that solves for more at every time takes seconds for a motion."""


def reaction_nodes(model: Model) -> list[Scalar]:
    """Reactions in the order of `row_of`: x and y of one joint after the other, then of pins.

    None at all for mechanisms with more than `MOST` unknown forces.
    """
    graph = model.graph

    def nodes(wanted: Sequence[Scalar]) -> Any:
        return np.array([*wanted, None], dtype=object)[:-1, None]  # None keeps it from being empty

    def number(parameter: Parameter) -> Scalar:
        if parameter.path:
            return model.inputs.parameter(parameter)
        return graph.number(parameter.value)  # structure

    statics = Statics(model, model.topology, 1, nodes, number)
    matrix, right = (part[0] for part in statics.equations())
    if sum(matrix.shape) > MOST:
        return []
    forces = _solved(model, matrix, right)
    if not len(forces):
        return [graph.zero] * 2 * len(model.topology.joints)
    found = statics.at_places(np.array([forces], dtype=object))
    return [graph.lift(entry) for entry in found.ravel()]


def _solved(model: Model, matrix: Any, right: Any) -> list[Scalar]:
    """The forces; those with the least sum of squares where constraints are redundant.

    These are f = Aᵀ λ with A f = b, one larger system: products of A with itself would be worse
    conditioned.
    """
    graph, (rows, columns) = model.graph, matrix.shape
    if rows != columns:
        above = np.hstack([np.eye(columns), -matrix.T])
        below = np.hstack([matrix, np.zeros((rows, rows))])
        matrix, right = np.vstack([above, below]), np.concatenate([np.zeros(columns), right])
    entries = [[graph.lift(entry) for entry in row] for row in matrix]
    return graph.solve(entries, [graph.lift(entry) for entry in right])[:columns]
