"""Equations as a Python module that needs nothing but NumPy."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import sympy as sp
from sympy.printing.numpy import NumPyPrinter

from linkages.equations.derivation import Equations

Given = dict[str, Sequence[sp.Symbol]]

_HEADER = '''"""Closure and energies of a planar linkage, written by linkages.

q: one coordinate per body, in the order of COORDINATES (rad, m); dq: their rates; p: parameters
in SI by name; efforts: of the drives, in the order of DRIVEN (N·m, N).
"""

from numpy import array, cos, pi, sin, zeros  # noqa: F401
'''


def write_python(equations: Equations) -> str:
    """Return the text of the module; names of the definition file stand in comments only."""
    parts = [_HEADER, _constants(equations), *_functions(equations)]
    return "\n".join(parts)


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


def _functions(equations: Equations) -> list[str]:
    q = equations.coordinates
    dq = [equations.symbols.rates[coordinate] for coordinate in q]
    closure = sp.Matrix(equations.closure)
    drives, efforts = (list(v.values()) for v in (equations.drives, equations.efforts))
    potential = equations.potential_energy
    write = _FunctionWriter(equations)
    return [
        write.vector("drives", {"t": ()}, "Coordinates of DRIVEN at time t.", drives),
        write.vector("closure", {"q": q}, "Φ(q) in m: zero where all loops close.", list(closure)),
        write.matrix("closure_jacobian", "∂Φ/∂q.", _jacobian(closure, q)),
        write.scalar("kinetic_energy", {"q": q, "dq": dq}, "T in J.", equations.kinetic_energy),
        write.scalar("potential_energy", {"q": q}, "V in J.", potential),
        write.vector("potential_gradient", {"q": q}, "∂V/∂q.", [sp.diff(potential, c) for c in q]),
        write.vector(
            "generalised_forces",
            {"efforts": efforts},
            "Q of every coordinate.",
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


class _FunctionWriter:
    def __init__(self, equations: Equations) -> None:
        self._equations = equations
        self._print = NumPyPrinter({"fully_qualified_modules": False}).doprint

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
        body = [f"result = zeros(({matrix.rows}, {matrix.cols}))"]
        for (i, j), value in matrix.todok().items():
            body.append(f"result[{i}, {j}] = {self._print(value)}")
        body.append("return result")
        return self._function(name, {"q": self._equations.coordinates}, doc, list(matrix), body)

    def coefficients(self) -> str:
        """Write the function that returns K; later coefficients use earlier ones."""
        q, reduced = self._equations.coordinates, self._equations.lagrange
        definitions = [definition for block in reduced.blocks for definition in block]
        body = [f"{d.symbol.name} = {self._print(d.value)}" for d in definitions]
        rows = (", ".join(self._print(k) for k in reduced.coefficients[u]) for u in q)
        body += ["return array([", *(f"    [{row}]," for row in rows), "], dtype=float)"]
        doc = "K = ∂q/∂GENERALISED, where no block is singular."
        values = [d.value for d in definitions]
        return self._function("velocity_coefficients", {"q": q}, doc, values, body)

    def _function(
        self,
        name: str,
        given: Given,
        doc: str,
        values: Iterable[sp.Expr],
        body: Sequence[str],
    ) -> str:
        used = set().union(*(value.free_symbols for value in values))
        lines = [f"\ndef {name}({', '.join(given)}, p=PARAMETERS):", f'    """{doc}"""']
        for argument, symbols in given.items():
            names = [symbol.name for symbol in symbols]
            if names and used & set(symbols):
                lines.append(f"    {', '.join(names)}{',' * (len(names) == 1)} = {argument}")
        parameters = [symbol for symbol in self._equations.symbols.values if symbol in used]
        lines += [f'    {symbol.name} = p["{symbol.name}"]' for symbol in parameters]
        return "\n".join([*lines, *(f"    {line}" for line in body), ""])
