"""What is printed, and in which order, before it is text or LaTeX."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import sympy as sp

from linkages.components.contributed.functions import TIME
from linkages.equations.coefficients import Definition, SymbolicLinearSystem
from linkages.equations.derivation import SymbolicEquations
from linkages.equations.polar import Polar, Terms
from linkages.reading.paths import dotted


@dataclass(frozen=True)
class SheetFormula:
    """A general statement, given in both forms."""

    text: str
    latex: str


@dataclass(frozen=True)
class Norm:
    """The length of a sum of vectors."""

    terms: Terms


Side: TypeAlias = sp.Expr | Terms | SheetFormula | Norm


@dataclass(frozen=True)
class Line:
    """Sides that are equal, and a remark."""

    sides: tuple[Side, ...]
    remark: str = ""


@dataclass(frozen=True)
class SheetSection:
    """A heading and its lines."""

    heading: str
    lines: tuple[Line, ...]


ZERO = SheetFormula("0", "0")
KINETIC = SheetFormula(
    "T = Σ ½ m |Ẋ|² + ½ J θ̇² = ½ Σ a_uv u̇ v̇",
    r"T = \sum \frac{1}{2} m \left|\dot{\mathbf{X}}\right|^2 + \frac{1}{2} J \dot{\theta}^2"
    r" = \frac{1}{2} \sum_{u,v} a_{u,v} \dot{u} \dot{v}",
)
COEFFICIENTS = SheetFormula(
    "u̇ = Σ_i K_u,i q̇_i  with  K_u,i = ∂u/∂q_i",
    r"\dot{u} = \sum_i K_{u,i} \dot{q}_i , \quad K_{u,i} = \partial u / \partial q_i",
)
SYSTEM = SheetFormula("Φ_z K = −Φ_q", r"\Phi_z K = -\Phi_q")
INERTIA = SheetFormula("J_ij = Σ a_uv K_u,i K_v,j", r"J_{ij} = \sum_{u,v} a_{u,v} K_{u,i} K_{v,j}")
LAGRANGE = SheetFormula(
    "Σ_j J_ij q̈_j + Σ_jk (∂J_ij/∂q_k − ½ ∂J_jk/∂q_i) q̇_j q̇_k + ∂V/∂q_i = Q_i",
    r"\sum_j J_{ij} \ddot{q}_j + \sum_{j,k} \left( \frac{\partial J_{ij}}{\partial q_k}"
    r" - \frac{1}{2} \frac{\partial J_{jk}}{\partial q_i} \right) \dot{q}_j \dot{q}_k"
    r" + \frac{\partial V}{\partial q_i} = Q_i",
)


def signed(side: sp.Expr | Terms) -> list[tuple[str, sp.Expr | Polar]]:
    """Return the terms of a sum, each with its sign (+ or −) taken out."""
    terms = side if isinstance(side, tuple) else side.as_ordered_terms()
    return [("−", -term) if _negative(term) else ("+", term) for term in terms]


def _negative(term: sp.Expr | Polar) -> bool:
    if isinstance(term, Polar):
        return bool(term.length.could_extract_minus_sign())
    return bool(term.could_extract_minus_sign()) and not term.is_Add


def sections(equations: SymbolicEquations) -> tuple[SheetSection, ...]:
    """All sections that have lines."""
    found = (
        SheetSection("Coordinates", tuple(_coordinates(equations))),
        SheetSection("Closure, loop by loop", tuple(_closure(equations))),
        SheetSection("Centres of mass", tuple(_centres(equations))),
        SheetSection("Lengths of springs and dampers", tuple(_distances(equations))),
        SheetSection("Clearances that open", tuple(_definitions(iter(equations.contacts)))),
        SheetSection("Kinetic energy", (Line((KINETIC,)), *_definitions(_masses(equations)))),
        SheetSection("Potential energy", (Line((SheetFormula("V", "V"), _potential(equations))),)),
        SheetSection("Velocity coefficients, loop by loop", tuple(_coefficients(equations))),
        SheetSection("Inertia terms", (Line((INERTIA,)), *_definitions(_inertia(equations)))),
        SheetSection("Internal states", tuple(_internal(equations))),
        SheetSection("Lagrange's equations", tuple(_lagrange(equations))),
    )
    return tuple(section for section in found if section.lines)


_JOINED = {"linear": "straight lines", "pchip": "monotone cubics (pchip)", "spline": "cubic spline"}


def _indexed(letter: str, index: int) -> SheetFormula:
    latex = r"\Phi" if letter == "Φ" else letter
    return SheetFormula(f"{letter}_{index}", f"{latex}_{{{index}}}")


def _definitions(definitions: Iterator[Definition]) -> Iterator[Line]:
    return (Line((definition.symbol, definition.value)) for definition in definitions)


def _coordinates(equations: SymbolicEquations) -> Iterator[Line]:
    for index, coordinate in enumerate(equations.lagrange.coordinates, 1):
        name = _indexed("q", index)
        if coordinate in equations.drives:
            law = equations.drives[coordinate]
            yield Line((name, coordinate, law), "driven")
            yield from _derivatives(index, law, equations.symbols.time)
        else:
            yield Line((name, coordinate), "free")
    for block in equations.blocks:
        places = [loop.apex for loop in block.loops]
        what = "loop" if len(places) == 1 else "loops"
        for unknown in block.unknowns:
            yield Line((unknown,), f"dependent, from the {what} closed at {_listed(places)}")
    for definition in equations.followers:
        yield Line((definition.symbol, definition.value), "by a relation")
    for number, table in enumerate(equations.symbols.tables, 1):
        what = f"{_JOINED[table.interpolation]}{', periodic,' if table.periodic else ''}"
        of = "(t)" if table.over == TIME else ""
        function = SheetFormula(f"f_{number}{of}", f"f_{{{number}}}{of}")
        yield Line((function,), f"{what} through {len(table.places)} points: {dotted(table.path)}")


def _derivatives(index: int, law: sp.Expr, time: sp.Symbol) -> Iterator[Line]:
    """Speed and acceleration of a drive, unless its speed is constant."""
    speed = sp.diff(law, time)
    acceleration = sp.diff(speed, time)
    if acceleration != 0:
        yield Line((SheetFormula(f"q̇_{index}", rf"\dot{{q}}_{{{index}}}"), speed))
        yield Line((SheetFormula(f"q̈_{index}", rf"\ddot{{q}}_{{{index}}}"), acceleration))


def _listed(names: Sequence[str]) -> str:
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last


def _distances(equations: SymbolicEquations) -> Iterator[Line]:
    """Lengths, and the rates of those that have a damper."""
    laws = (*equations.forces.values(), *equations.internal.values())
    used = set().union(*(law.free_symbols for law in laws))
    for distance in equations.loads.lengths.values():
        yield Line((distance.symbol, Norm(distance.between)))
        if distance.rate in used:
            yield Line((distance.rate, distance.speed(equations.symbols.rates)))


def _potential(equations: SymbolicEquations) -> sp.Expr:
    return equations.gravitational + equations.elastic


def _closure(equations: SymbolicEquations) -> Iterator[Line]:
    for index, loop in enumerate(equations.loops):
        yield Line((loop.left, loop.right or ZERO), f"at {loop.apex}")
        for axis, residual in enumerate(loop.residual, 2 * index + 1):
            yield Line((_indexed("Φ", axis), residual, ZERO))


def _centres(equations: SymbolicEquations) -> Iterator[Line]:
    for body in equations.bodies:
        if body.mass != 0:
            yield Line((body.position, body.centre or ZERO))


def _masses(equations: SymbolicEquations) -> Iterator[Definition]:
    return iter(equations.lagrange.masses.values())


def _inertia(equations: SymbolicEquations) -> Iterator[Definition]:
    return iter(equations.lagrange.inertia.values())


def _coefficients(equations: SymbolicEquations) -> Iterator[Line]:
    if equations.loops:
        yield Line((COEFFICIENTS,))
    for block in equations.lagrange.blocks:
        yield from _definitions(iter(block.definitions))
        if block.system is not None:
            yield from _system(block.system)


def _system(system: SymbolicLinearSystem) -> Iterator[Line]:
    """One equation per scalar loop equation and generalised coordinate."""
    more = f"; {system.surplus} of them redundant: least squares" if system.surplus else ""
    equations, unknowns = system.matrix.shape
    size = f"{equations} equations for {unknowns} unknown{'s' if unknowns > 1 else ''}"
    yield Line((SYSTEM,), f"{size} per coordinate{more}")
    product = system.matrix * system.coefficients
    for column in range(product.cols):
        for row in range(product.rows):
            left, right = product[row, column], system.right[row, column]
            if left != 0 or right != 0:
                yield Line((left, right))


def _internal(equations: SymbolicEquations) -> Iterator[Line]:
    for state, rate in equations.internal.items():
        yield Line((equations.symbols.dotted(state), rate), "integrated with the motion")


def _lagrange(equations: SymbolicEquations) -> Iterator[Line]:
    yield Line((LAGRANGE,))
    reduced = equations.lagrange
    for index, value in enumerate(reduced.gradient, 1):
        yield Line((SheetFormula(f"∂V/∂q_{index}", rf"\partial V / \partial q_{{{index}}}"), value))
    for index, value in enumerate(reduced.forces, 1):
        yield Line((_indexed("Q", index), value))
