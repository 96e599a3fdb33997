"""Equations as a Python module that needs nothing but NumPy."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence

import sympy as sp

from linkages.components.contributed.interpolation import cubic, polynomials
from linkages.equations.derivation import SymbolicEquations
from linkages.equations.python_functions import FunctionWriter
from linkages.operations import ELEMENTARY

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
        found = polynomials(table)
        knots, coefficients = tuple(map(float, found.x)), tuple(map(tuple, found.c.T.tolist()))
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
        write.matrix("closure_jacobian", "∂Φ/∂q.", _jacobian(closure, q)),
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


_INERTIA = '''
def inertia(q, p=PARAMETERS):
    """J of GENERALISED: the paper's J_ij."""
    k = velocity_coefficients(q, p)
    return k.T @ mass_matrix(q, p) @ k
'''


def _jacobian(closure: sp.Matrix, q: Sequence[sp.Symbol]) -> sp.Matrix:
    return sp.Matrix(len(closure), len(q), lambda i, j: sp.diff(closure[i], q[j]))


def _masses(equations: SymbolicEquations) -> sp.Matrix:
    q = equations.coordinates
    masses = {pair: definition.value for pair, definition in equations.lagrange.masses.items()}
    zero = sp.S.Zero
    return sp.Matrix(len(q), len(q), lambda i, j: masses.get((q[min(i, j)], q[max(i, j)]), zero))
