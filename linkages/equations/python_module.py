"""Equations as a Python module that needs nothing but NumPy."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import sympy as sp
from sympy.printing.numpy import NumPyPrinter

from linkages.components.contributed.functions import cubic, polynomials
from linkages.equations.derivation import SymbolicEquations
from linkages.equations.vector_loops import SymbolicLinearSystem
from linkages.operations import ELEMENTARY

Given = Mapping[str, Sequence[sp.Symbol]]


class _Printer(NumPyPrinter):
    """Writes what SymPy does not know, for scalars."""

    def _print_Select(self, expression: Any) -> str:  # noqa: N802
        condition, first, second = (self._print(argument) for argument in expression.args)
        return f"({first} if {condition} >= 0 else {second})"

    def _print_Spline(self, expression: Any) -> str:  # noqa: N802
        number, order, time = expression.args
        return f"spline(*TABLES[{int(number) - 1}], {self._print(time)}, {int(order)})"


class FunctionWriter:
    """Writes functions of arrays, each with the names that it needs taken out of them."""

    def __init__(self, equations: SymbolicEquations) -> None:
        self._equations = equations
        self._print = _Printer({"fully_qualified_modules": False}).doprint

    def scalar(self, name: str, given: Given, doc: str, value: sp.Expr) -> str:
        """Write a function that returns one number."""
        return self._function(name, given, doc, [value], [f"return {self._print(value)}"])

    def vector(self, name: str, given: Given, doc: str, values: Sequence[sp.Expr]) -> str:
        """Write a function that returns an array with one axis."""
        rows = [f"    {self._print(value)}," for value in values]
        body = ["return array([", *rows, "], dtype=float)"] if rows else ["return zeros(0)"]
        return self._function(name, given, doc, values, body)

    def matrix(self, name: str, doc: str, matrix: sp.Matrix) -> str:
        """Write a function of q that returns an array with two axes, mostly zeros."""
        body = [*self._filled("result", matrix), "return result"]
        return self._function(name, {"q": self._equations.coordinates}, doc, list(matrix), body)

    def _filled(self, name: str, matrix: sp.Matrix) -> list[str]:
        return [
            f"{name} = zeros(({matrix.rows}, {matrix.cols}))",
            *(f"{name}[{i}, {j}] = {self._print(v)}" for (i, j), v in matrix.todok().items()),
        ]

    def coefficients(self) -> str:
        """Write the function that returns K; later coefficients use earlier ones."""
        q, reduced = self._equations.coordinates, self._equations.lagrange
        body: list[str] = []
        values: list[sp.Expr] = []
        for block in reduced.blocks:
            body += [f"{d.symbol.name} = {self._print(d.value)}" for d in block.definitions]
            values += [d.value for d in block.definitions]
            if block.system is not None:
                body += self._solved(block.system)
                values += [*block.system.matrix, *block.system.right]
        rows = (", ".join(self._print(k) for k in reduced.coefficients[u]) for u in q)
        body += ["return array([", *(f"    [{row}]," for row in rows), "], dtype=float)"]
        doc = "K = ∂q/∂GENERALISED, where no block is singular."
        return self._function("velocity_coefficients", {"q": q}, doc, values, body)

    def _solved(self, system: SymbolicLinearSystem) -> list[str]:
        """Statements that solve Φ_z K = −Φ_q; with redundant equations by least squares."""
        rows = system.coefficients.tolist()
        names = ", ".join(f"({', '.join(k.name for k in row)},)" for row in rows)
        solve = "lstsq(matrix, right, rcond=None)[0]" if system.surplus else "solve(matrix, right)"
        return [
            *self._filled("matrix", system.matrix),
            *self._filled("right", system.right),
            f"({names},) = linalg.{solve}",
        ]

    def _function(
        self, name: str, given: Given, doc: str, values: Iterable[sp.Expr], body: Sequence[str]
    ) -> str:
        used: set[sp.Symbol] = set().union(*(value.free_symbols for value in values))
        before: list[str] = []
        for definition in reversed(self._equations.intermediate):
            if definition.symbol in used:
                before.insert(0, f"{definition.symbol.name} = {self._print(definition.value)}")
                used |= definition.value.free_symbols
        lines = [f"\ndef {name}({', '.join(given)}, p=PARAMETERS):", f'    """{doc}"""']
        for argument, symbols in given.items():
            names = [symbol.name for symbol in symbols]
            if names and used & set(symbols):
                lines.append(f"    {', '.join(names)}{',' * (len(names) == 1)} = {argument}")
        parameters = [symbol for symbol in self._equations.symbols.values if symbol in used]
        lines += [f'    {symbol.name} = p["{symbol.name}"]' for symbol in parameters]
        return "\n".join([*lines, *(f"    {line}" for line in [*before, *body]), ""])


_HEADER = '''"""Closure and energies of a planar linkage, written by linkages.

q: one coordinate per body, in the order of COORDINATES (rad, m); dq: their rates; p: parameters
in SI by name; t: time in s; efforts: of the drives, in the order of DRIVEN (N·m, N). z: internal
states, if there are any.
"""

'''
_NUMPY = ("array", "linalg", "pi", "zeros")


def write_python(equations: SymbolicEquations) -> str:
    """Return the text of the module; names of the definition file stand in comments only."""
    parts = [_constants(equations), *_functions(equations)]
    if equations.symbols.tables:
        parts.insert(1, _tables(equations))
    text = "\n".join(parts)
    names = {node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)}
    functions = {row.numpy for row in ELEMENTARY.values()}
    imported = ", ".join(sorted(names & {*_NUMPY, *functions}))
    return f"{_HEADER}from numpy import {imported}\n\n{text}"


def _constants(equations: SymbolicEquations) -> str:
    symbols = equations.symbols
    bodies = {coordinate: name for name, coordinate in symbols.coordinates.items()}
    lines = ["COORDINATES = ("]
    lines += [f'    "{q.name}",  # {bodies[q]!a}' for q in equations.coordinates]
    lines.append(")")
    for name, group in (("DRIVEN", equations.driven), ("FREE", equations.free)):
        lines.append(f"{name} = {tuple(q.name for q in group)!r}")
    lines += ["GENERALISED = (*DRIVEN, *FREE)", "PARAMETERS = {"]
    for symbol, value in symbols.values.items():
        lines.append(f'    "{symbol.name}": {value!r},  # {symbols.describe(symbol)!a}')
    return "\n".join([*lines, "}", ""])


def _tables(equations: SymbolicEquations) -> str:
    rows = []
    for table in equations.symbols.tables:
        result = polynomials(table)
        knots, coefficients = tuple(map(float, result.x)), tuple(map(tuple, result.c.T.tolist()))
        rows.append(f"    ({knots!r}, {coefficients!r}, {table.periodic!r}),")
    heading = "\nTABLES = (  # knots, coefficients of the cubic polynomials between them, periodic"
    return "\n".join([heading, *rows, ")", _SPLINE])


_SPLINE = '''
def spline(knots, coefficients, periodic, t, order):
    """Derivative of piecewise cubic polynomials at time t; outside the knots straight lines."""
    if periodic:
        t = knots[0] + (t - knots[0]) % (knots[-1] - knots[0])
    inner = min(max(t, knots[0]), knots[-1])
    k = max(i for i in range(len(coefficients)) if i == 0 or knots[i] <= inner)
    (d, c, b, a), x, outside = coefficients[k], inner - knots[k], t - inner
    if order == 0:
        return {}
    if order == 1:
        return {}
    return {} if outside == 0 else 0.0
'''.format(*cubic(*sp.symbols("x outside d c b a")))


def _functions(equations: SymbolicEquations) -> list[str]:
    q, time = equations.coordinates, equations.symbols.time
    dq = [equations.symbols.rates[coordinate] for coordinate in q]
    closure = sp.Matrix(equations.closure)
    jacobian = sp.Matrix(len(closure), len(q), lambda i, j: sp.diff(closure[i], q[j]))
    drives, efforts = (list(v.values()) for v in (equations.drives, equations.efforts))
    rates = [sp.diff(law, time) for law in drives]
    potential = equations.gravitational + equations.elastic
    states = list(equations.internal)
    inner = {"z": states} if states else {}
    acting: Mapping[str, Sequence[sp.Symbol]] = {
        "t": (),
        "q": q,
        "dq": dq,
        "efforts": efforts,
        **inner,
    }
    write = FunctionWriter(equations)
    return [
        write.vector("drives", {"t": ()}, "Coordinates of DRIVEN at time t.", drives),
        write.vector("drive_rates", {"t": ()}, "Their rates.", rates),
        write.vector(
            "drive_accelerations",
            {"t": ()},
            "Their second derivatives.",
            [sp.diff(rate, time) for rate in rates],
        ),
        write.vector("closure", {"q": q}, "Φ(q) in m: zero where all loops close.", list(closure)),
        write.matrix("closure_jacobian", "∂Φ/∂q.", jacobian),
        write.scalar("kinetic_energy", {"q": q, "dq": dq}, "T in J.", equations.kinetic_energy),
        write.scalar("potential_energy", {"q": q, **inner}, "V in J.", potential),
        write.vector(
            "potential_gradient",
            {"q": q},
            "∂V/∂q.",
            [equations.lagrange.slopes.get(c, sp.S.Zero) for c in q],
        ),
        write.vector(
            "generalised_forces",
            acting,
            "Q of every coordinate: of loads, dampers and drives.",
            [equations.forces.get(c, sp.S.Zero) for c in q],
        ),
        *_internal_rates(equations, write),
        write.matrix("mass_matrix", "a with 2 T = Σ a_uv u̇ v̇.", _masses(equations)),
        write.coefficients(),
        _INERTIA,
    ]


def _internal_rates(equations: SymbolicEquations, write: FunctionWriter) -> Iterator[str]:
    rates, symbols = equations.internal, equations.symbols
    if rates:
        q = equations.coordinates
        given = {"t": (), "q": q, "dq": [symbols.rates[c] for c in q], "z": list(rates)}
        doc = "Rates of the internal states z."
        yield write.vector("internal_rates", given, doc, list(rates.values()))
        if equations.updates:
            doc = "Internal states z behind an update, where all have one."
            following = [equations.updates.get(z, (z,))[0] for z in rates]
            yield write.vector("updated_states", given, doc, following)


_INERTIA = '''
def inertia(q, p=PARAMETERS):
    """J of GENERALISED: the paper's J_ij."""
    k = velocity_coefficients(q, p)
    return k.T @ mass_matrix(q, p) @ k
'''


def _masses(equations: SymbolicEquations) -> sp.Matrix:
    q = equations.coordinates
    masses = {pair: definition.value for pair, definition in equations.lagrange.masses.items()}
    zero = sp.S.Zero
    return sp.Matrix(len(q), len(q), lambda i, j: masses.get((q[min(i, j)], q[max(i, j)]), zero))
