"""Equations as a Python module that needs nothing but NumPy."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence

import sympy as sp

from linkages.equations.derivation import Equations
from linkages.equations.python_functions import FunctionWriter

_HEADER = '''"""Closure and energies of a planar linkage, written by linkages.

q: one coordinate per body, in the order of COORDINATES (rad, m); dq: their rates; p: parameters
in SI by name; t: time in s; efforts: of the drives, in the order of DRIVEN (N·m, N).
"""

'''
_NUMPY = (
    "arctan", "array", "cos", "exp", "linalg", "log", "pi", "sin", "sqrt", "tan", "tanh", "zeros",
)  # fmt: skip


def write_python(equations: Equations) -> str:
    """Return the text of the module; names of the definition file stand in comments only."""
    parts = [_constants(equations), *_functions(equations)]
    if equations.symbols.tables:
        parts.insert(1, _tables(equations))
    text = "\n".join(parts)
    names = {node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)}
    imported = ", ".join(name for name in _NUMPY if name in names)
    return f"{_HEADER}from numpy import {imported}\n\n{text}"


def _constants(equations: Equations) -> str:
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


def _tables(equations: Equations) -> str:
    tables = equations.symbols.tables
    rows = [f"    ({t.times!r}, {t.values!r}, {t.periodic!r})," for t in tables]
    return "\n".join(["\nTABLES = (  # times, values, periodic", *rows, ")", _SPLINE])


_SPLINE = '''
def spline(times, values, periodic, t, order):
    """Derivative of a cubic spline at time t, from its second derivatives at all times."""
    steps = [b - a for a, b in zip(times, times[1:])]
    slopes = [(b - a) / step for a, b, step in zip(values, values[1:], steps)]
    last = len(steps)
    matrix, right = zeros((last + 1, last + 1)), zeros(last + 1)
    for k in range(1, last):
        matrix[k, k - 1 : k + 2] = steps[k - 1], 2 * (steps[k - 1] + steps[k]), steps[k]
        right[k] = 6 * (slopes[k] - slopes[k - 1])
    matrix[0, 0] = matrix[last, last] = 1.0
    if periodic:
        matrix[0, last] = -1.0
        matrix[last, 0], matrix[last, 1] = 2 * steps[0], steps[0]
        matrix[last, last - 1], matrix[last, last] = steps[-1], 2 * steps[-1]
        right[last] = 6 * (slopes[0] - slopes[-1])
        t = times[0] + (t - times[0]) % (times[-1] - times[0])
    curved = linalg.solve(matrix, right)
    inner = min(max(t, times[0]), times[-1])
    k = max(i for i in range(last) if i == 0 or times[i] <= inner)
    step, before, after = steps[k], inner - times[k], times[k + 1] - inner
    slope = slopes[k] + (
        (3 * before**2 - step**2) * curved[k + 1] - (3 * after**2 - step**2) * curved[k]
    ) / (6 * step)
    if order == 0:
        straight = (values[k] * after + values[k + 1] * before) / step
        bent = before * (before**2 - step**2) * curved[k + 1]
        bent = bent + after * (after**2 - step**2) * curved[k]
        return straight + bent / (6 * step) + slope * (t - inner)
    if order == 1:
        return slope
    return (curved[k] * after + curved[k + 1] * before) / step if inner == t else 0.0
'''


def _functions(equations: Equations) -> list[str]:
    q, time = equations.coordinates, equations.symbols.time
    dq = [equations.symbols.rates[coordinate] for coordinate in q]
    closure = sp.Matrix(equations.closure)
    drives, efforts = (list(v.values()) for v in (equations.drives, equations.efforts))
    rates = [sp.diff(law, time) for law in drives]
    potential = equations.gravitational + equations.elastic
    acting: Mapping[str, Sequence[sp.Symbol]] = {"t": (), "q": q, "dq": dq, "efforts": efforts}
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
        write.scalar("potential_energy", {"q": q}, "V in J.", potential),
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
        write.matrix("mass_matrix", "a with 2 T = Σ a_uv u̇ v̇.", _masses(equations)),
        write.coefficients(),
        _INERTIA,
    ]


_INERTIA = '''
def inertia(q, p=PARAMETERS):
    """J of GENERALISED: the paper's J_ij."""
    k = velocity_coefficients(q, p)
    return k.T @ mass_matrix(q, p) @ k
'''


def _jacobian(closure: sp.Matrix, q: Sequence[sp.Symbol]) -> sp.Matrix:
    return sp.Matrix(len(closure), len(q), lambda i, j: sp.diff(closure[i], q[j]))


def _masses(equations: Equations) -> sp.Matrix:
    q = equations.coordinates
    masses = {pair: definition.value for pair, definition in equations.lagrange.masses.items()}
    zero = sp.S.Zero
    return sp.Matrix(len(q), len(q), lambda i, j: masses.get((q[min(i, j)], q[max(i, j)]), zero))
