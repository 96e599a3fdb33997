"""Symmetric linear systems on a graph of scalar operations."""

from __future__ import annotations

from collections.abc import Callable

from linkages.kernel.graph.scalars import Scalar


def solve_symmetric(
    matrix: list[list[Scalar]],
    right: list[Scalar],
    reciprocal: Callable[[int, Scalar], Scalar] = lambda _, pivot: 1.0 / pivot,
) -> list[Scalar]:
    """Solve a symmetric positive definite system by L D Lᵀ, unrolled.

    Parameters
    ----------
    matrix
        Lower triangle, row by row.
    right
        Right-hand side.
    reciprocal
        Of a row and its pivot: what to multiply by, 0 for an unknown that is to be 0 where the
        matrix is singular.
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
