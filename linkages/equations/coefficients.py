"""Velocity coefficients K_zi = ∂z/∂q_i of dependent coordinates z: Φ_z K = −Φ_q, block by block.

They stay symbols, so no expression blows up: two unknowns of one loop by Cramer's rule, more of
them by a linear system that is printed as such.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from linkages.equations.closure import BlockEquations, LoopEquation
from linkages.equations.polar import Terms, components, cross, derivative
from linkages.equations.symbols import Symbols

Row = tuple[sp.Expr, ...]
Rows = dict[sp.Symbol, Row]


@dataclass(frozen=True)
class Definition:
    """A symbol and what it stands for."""

    symbol: sp.Symbol
    value: sp.Expr


@dataclass(frozen=True)
class SymbolicLinearSystem:
    """``matrix`` · K = ``right`` for the velocity coefficients of a block.

    Parameters
    ----------
    coefficients
        K: a row for each unknown, a column for each generalised coordinate that moves them.
    matrix
        Φ_z: a row for each scalar equation.
    right
        −Φ_q, with earlier velocity coefficients.
    surplus
        Number of redundant equations: those that follow from the others at positions where the
        loops close.
    """

    coefficients: sp.Matrix
    matrix: sp.Matrix
    right: sp.Matrix
    surplus: int


@dataclass(frozen=True)
class BlockCoefficients:
    """The velocity coefficients of one block: formulas, or a linear system."""

    definitions: tuple[Definition, ...] = ()
    system: SymbolicLinearSystem | None = None


def solve_block(block: BlockEquations, known: Rows, symbols: Symbols) -> BlockCoefficients:
    """Velocity coefficients of a block from those of what comes before; adds them to `known`."""
    if len(block.loops) == 1 and len(block.unknowns) == 2:
        return BlockCoefficients(definitions=_by_cramer(block.loops[0], known, symbols))
    return BlockCoefficients(system=_linear_system(block, known, symbols))


def _by_cramer(loop: LoopEquation, known: Rows, symbols: Symbols) -> tuple[Definition, ...]:
    """With a and b the derivatives of the loop by its unknowns and w the one by what is known,
    K_a a + K_b b + w = 0 gives K_a = −(w × b)/(a × b).
    """  # noqa: D205
    first, second = loop.unknowns
    given = _given(loop, known)
    definitions: list[Definition] = []
    rows: Rows = {}
    for unknown, other in ((first, second), (second, first)):
        b = derivative(loop.terms, other)
        determinant = cross(derivative(loop.terms, unknown), b)
        values = [
            -sp.Add(*(known[w][i] * cross(terms, b) for w, terms in given.items())) / determinant
            for i in range(_count(known))
        ]
        found = [_named(value, i, unknown, symbols) for i, value in enumerate(values)]
        rows[unknown] = tuple(sp.S.Zero if d is None else d.symbol for d in found)
        definitions += [d for d in found if d is not None]
    known.update(rows)
    return tuple(definitions)


def _linear_system(
    block: BlockEquations, known: Rows, symbols: Symbols
) -> SymbolicLinearSystem | None:
    matrix: list[list[sp.Expr]] = []
    right: list[list[sp.Expr]] = []
    for loop in block.loops:
        columns = [components(derivative(loop.terms, unknown)) for unknown in block.unknowns]
        given = {w: components(terms) for w, terms in _given(loop, known).items()}
        for axis in (0, 1):
            matrix.append([column[axis] for column in columns])
            right.append(
                [
                    -sp.Add(*(known[w][i] * value[axis] for w, value in given.items()))
                    for i in range(_count(known))
                ]
            )
    moving = [i for i in range(_count(known)) if any(row[i] != 0 for row in right)]
    rows = []
    for unknown in block.unknowns:
        values = [_symbol(i, unknown, symbols) if i in moving else sp.S.Zero
                  for i in range(_count(known))]  # fmt: skip
        known[unknown] = tuple(values)
        rows.append([values[i] for i in moving])
    if not moving:
        return None
    return SymbolicLinearSystem(
        coefficients=sp.Matrix(rows),
        matrix=sp.Matrix(matrix),
        right=sp.Matrix([[row[i] for i in moving] for row in right]),
        surplus=block.surplus,
    )


def _given(loop: LoopEquation, known: Rows) -> dict[sp.Symbol, Terms]:
    return {w: terms for w in known if (terms := derivative(loop.terms, w))}


def _count(known: Rows) -> int:
    """Number of generalised coordinates."""
    return len(next(iter(known.values()), ()))


def _named(value: sp.Expr, index: int, unknown: sp.Symbol, symbols: Symbols) -> Definition | None:
    if value == 0:
        return None
    return Definition(_symbol(index, unknown, symbols), sp.factor(value, deep=False))


def _symbol(index: int, unknown: sp.Symbol, symbols: Symbols) -> sp.Symbol:
    (body,) = symbols.notations[unknown].subscripts
    return symbols.define("K", body, str(index + 1))
