"""Lagrange's equations over the generalised coordinates (paper, Eqs. 4–8).

Dependent rates follow from the closure: ż = Σ_i K_zi q̇_i with velocity coefficients K_zi = ∂z/∂q_i
that solve Φ_z K = −Φ_q block by block. They stay symbols, so no expression blows up.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from linkages.equations.closure import LoopEquation
from linkages.equations.energies import MassiveBody
from linkages.equations.polar import cross, derivative, dot
from linkages.equations.symbols import Symbols

Row = tuple[sp.Expr, ...]


@dataclass(frozen=True)
class Definition:
    """A symbol and what it stands for."""

    symbol: sp.Symbol
    value: sp.Expr


@dataclass(frozen=True)
class ReducedEquations:
    """Σ_j J_ij q̈_j + Σ_jk (∂J_ij/∂q_k − ½ ∂J_jk/∂q_i) q̇_j q̇_k + ∂V/∂q_i = Q_i.

    Parameters
    ----------
    coordinates
        The generalised coordinates q: driven, then free.
    coefficients
        Coordinate u of a body → (∂u/∂q_1, …): 0, 1 or a symbol K.
    blocks
        For each solved loop the definitions of its K, from earlier K and coordinates.
    masses
        (u, v) → a_uv with 2 T = Σ a_uv u̇ v̇, for pairs of which v does not come before u.
    inertia
        J_ij for i ≤ j, from a and K.
    gradient
        ∂V/∂q_i, from ∂V/∂u and K.
    forces
        Q_i, from loads, drive efforts and K.
    """

    coordinates: tuple[sp.Symbol, ...]
    coefficients: dict[sp.Symbol, Row]
    blocks: tuple[tuple[Definition, ...], ...]
    masses: dict[tuple[sp.Symbol, sp.Symbol], Definition]
    inertia: dict[tuple[int, int], Definition]
    gradient: Row
    forces: Row


def reduce(
    loops: tuple[LoopEquation, ...],
    independent: tuple[sp.Symbol, ...],
    bodies: tuple[MassiveBody, ...],
    potential: sp.Expr,
    forces: Mapping[sp.Symbol, sp.Expr],
    symbols: Symbols,
) -> ReducedEquations:
    """Eliminate the dependent rates from T, V and Q."""
    coefficients = {q: tuple(sp.eye(len(independent)).row(i)) for i, q in enumerate(independent)}
    blocks = tuple(_solve(loop, coefficients, symbols) for loop in loops)
    masses = _masses(bodies, symbols)
    gradient = {u: sp.factor_terms(sp.diff(potential, u)) for u in coefficients}
    return ReducedEquations(
        coordinates=independent,
        coefficients=coefficients,
        blocks=blocks,
        masses=masses,
        inertia=_inertia(masses, coefficients, len(independent), symbols),
        gradient=_projected(gradient, coefficients),
        forces=_projected(forces, coefficients),
    )


def _solve(
    loop: LoopEquation, known: dict[sp.Symbol, Row], symbols: Symbols
) -> tuple[Definition, ...]:
    """Velocity coefficients of a loop's two unknowns, by Cramer's rule; adds them to `known`.

    With a and b the derivatives of the loop by its unknowns and w the one by what is known,
    K_a a + K_b b + w = 0 gives K_a = −(w × b)/(a × b).
    """
    first, second = loop.unknowns
    given = {w: terms for w in known if (terms := derivative(loop.terms, w))}
    definitions: list[Definition] = []
    rows: dict[sp.Symbol, Row] = {}
    for unknown, other in ((first, second), (second, first)):
        b = derivative(loop.terms, other)
        determinant = cross(derivative(loop.terms, unknown), b)
        values = [
            -sp.Add(*(known[w][i] * cross(terms, b) for w, terms in given.items())) / determinant
            for i in range(len(next(iter(known.values()))))
        ]
        found = [_named(value, i, unknown, symbols) for i, value in enumerate(values)]
        rows[unknown] = tuple(sp.S.Zero if d is None else d.symbol for d in found)
        definitions += [d for d in found if d is not None]
    known.update(rows)
    return tuple(definitions)


def _named(value: sp.Expr, index: int, unknown: sp.Symbol, symbols: Symbols) -> Definition | None:
    if value == 0:
        return None
    (body,) = symbols.notations[unknown].subscripts
    return Definition(symbols.define("K", body, str(index + 1)), sp.factor(value, deep=False))


def _masses(
    bodies: tuple[MassiveBody, ...], symbols: Symbols
) -> dict[tuple[sp.Symbol, sp.Symbol], Definition]:
    coordinates = list(symbols.coordinates.items())
    found: dict[tuple[sp.Symbol, sp.Symbol], Definition] = {}
    for i, (first, u) in enumerate(coordinates):
        for second, v in coordinates[i:]:
            value = sp.Add(*(_mass(body, u, v) for body in bodies))
            if value != 0:
                symbol = symbols.define("a", first, second)
                found[u, v] = Definition(symbol, sp.factor_terms(value))
    return found


def _mass(body: MassiveBody, u: sp.Symbol, v: sp.Symbol) -> sp.Expr:
    """Return a body's part of a_uv: m ∂x/∂u·∂x/∂v, and J for its own angle."""
    value = body.mass * dot(derivative(body.centre, u), derivative(body.centre, v))
    return value + body.inertia if u == v == body.coordinate else value


def _inertia(
    masses: Mapping[tuple[sp.Symbol, sp.Symbol], Definition],
    coefficients: Mapping[sp.Symbol, Row],
    count: int,
    symbols: Symbols,
) -> dict[tuple[int, int], Definition]:
    """J_ij = Σ_uv a_uv K_ui K_vj."""
    found: dict[tuple[int, int], Definition] = {}
    for i in range(count):
        for j in range(i, count):
            terms = []
            for (u, v), a in masses.items():
                terms.append(a.symbol * coefficients[u][i] * coefficients[v][j])
                if u != v:
                    terms.append(a.symbol * coefficients[v][i] * coefficients[u][j])
            index = (f"{i + 1}{j + 1}",) if count < 10 else (str(i + 1), str(j + 1))
            found[i, j] = Definition(symbols.define("J", *index), sp.Add(*terms))
    return found


def _projected(values: Mapping[sp.Symbol, sp.Expr], coefficients: Mapping[sp.Symbol, Row]) -> Row:
    count = len(next(iter(coefficients.values()), ()))
    return tuple(sp.Add(*(v * coefficients[u][i] for u, v in values.items())) for i in range(count))
