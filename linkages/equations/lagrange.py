"""Lagrange's equations over the generalised coordinates (paper, Eqs. 4–8).

Dependent rates follow from the closure: ż = Σ_i K_zi q̇_i with the velocity coefficients of
`linkages.equations.coefficients`.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import sympy as sp

from linkages.equations.closure import BlockEquations
from linkages.equations.coefficients import BlockCoefficients, Definition, Row, solve_block
from linkages.equations.energies import MassiveBody
from linkages.equations.loads import Length
from linkages.equations.polar import derivative, dot
from linkages.equations.symbols import Symbols


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
        For each solved block what defines its K, from earlier K and coordinates.
    masses
        (u, v) → a_uv with 2 T = Σ a_uv u̇ v̇, for pairs of which v does not come before u.
    inertia
        J_ij for i ≤ j, from a and K.
    slopes
        ∂V/∂u of every coordinate u of a body.
    gradient
        ∂V/∂q_i, from ∂V/∂u and K.
    forces
        Q_i, from loads, drive efforts and K.
    """

    coordinates: tuple[sp.Symbol, ...]
    coefficients: dict[sp.Symbol, Row]
    blocks: tuple[BlockCoefficients, ...]
    masses: dict[tuple[sp.Symbol, sp.Symbol], Definition]
    inertia: dict[tuple[int, int], Definition]
    slopes: dict[sp.Symbol, sp.Expr]
    gradient: Row
    forces: Row


def reduce(
    blocks: tuple[BlockEquations, ...],
    independent: tuple[sp.Symbol, ...],
    bodies: tuple[MassiveBody, ...],
    potential: sp.Expr,
    between: Collection[Length],
    forces: Mapping[sp.Symbol, sp.Expr],
    symbols: Symbols,
) -> ReducedEquations:
    """Eliminate the dependent rates from T, V and Q."""
    coefficients = {q: tuple(sp.eye(len(independent)).row(i)) for i, q in enumerate(independent)}
    solved = tuple(solve_block(block, coefficients, symbols) for block in blocks)
    masses = _masses(bodies, symbols)
    slopes = {u: sp.factor_terms(_slope(potential, u, between)) for u in coefficients}
    return ReducedEquations(
        coordinates=independent,
        coefficients=coefficients,
        blocks=solved,
        masses=masses,
        inertia=_inertia(masses, coefficients, len(independent), symbols),
        slopes=slopes,
        gradient=_projected(slopes, coefficients),
        forces=_projected(forces, coefficients),
    )


def _slope(potential: sp.Expr, u: sp.Symbol, between: Collection[Length]) -> sp.Expr:
    """∂V/∂u, directly and through the lengths of springs."""
    through = (sp.diff(potential, d.symbol) * d.derivative(u) for d in between)
    return sp.diff(potential, u) + sp.Add(*through)


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
    """Return a body's part of a_uv: m ∂x/∂u·∂x/∂v + J ∂θ/∂u ∂θ/∂v."""
    value = body.mass * dot(derivative(body.centre, u), derivative(body.centre, v))
    return value + body.inertia * sp.diff(body.angle, u) * sp.diff(body.angle, v)


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
