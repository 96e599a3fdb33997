"""Linear systems in straight-line code."""

from __future__ import annotations

from collections.abc import Sequence

from linkages.kernel.code.instructions import Instructions


def solve(code: Instructions, entries: Sequence[str], size: int) -> list[str]:
    """Write the solution of a linear system, and the determinant.

    Elimination with row exchanges, unrolled; rows are exchanged without branches.
    """
    rows = [[*entries[size * i : size * (i + 1)], entries[size * size + i]] for i in range(size)]
    sign = code.constant(1.0)
    for k in range(size):
        for i in range(k + 1, size):
            larger = code.compare("ogt", code.absolute(rows[i][k]), code.absolute(rows[k][k]))
            for j in range(k, size + 1):
                one, other = rows[k][j], rows[i][j]
                rows[k][j] = code.select(larger, other, one)
                rows[i][j] = code.select(larger, one, other)
            sign = code.select(larger, code.negate(sign), sign)
        for i in range(k + 1, size):
            factor = code.negate(code.divide(rows[i][k], rows[k][k]))
            for j in range(k + 1, size + 1):
                rows[i][j] = code.fused(factor, rows[k][j], rows[i][j])
    solution = [""] * size
    for k in reversed(range(size)):
        rest = rows[k][size]
        for j in range(k + 1, size):
            rest = code.fused(code.negate(rows[k][j]), solution[j], rest)
        solution[k] = code.divide(rest, rows[k][k])
    determinant = sign
    for k in range(size):
        determinant = code.multiply(determinant, rows[k][k])
    return [*solution, determinant]
