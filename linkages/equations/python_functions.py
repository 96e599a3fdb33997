"""Functions of a printed Python module."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import sympy as sp
from sympy.printing.numpy import NumPyPrinter

from linkages.equations.coefficients import SymbolicLinearSystem
from linkages.equations.derivation import SymbolicEquations

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
    """Writes functions of arrays, each with the names that it needs taken out of them.

    Parameters
    ----------
    equations
        Whose symbols the functions use.
    """

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
        names = ", ".join(f"({', '.join(k.name for k in row)},)" for row in _rows(system))
        solve = "lstsq(matrix, right, rcond=None)[0]" if system.surplus else "solve(matrix, right)"
        return [
            *self._filled("matrix", system.matrix),
            *self._filled("right", system.right),
            f"({names},) = linalg.{solve}",
        ]

    def _function(
        self,
        name: str,
        given: Given,
        doc: str,
        values: Iterable[sp.Expr],
        body: Sequence[str],
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


def _rows(system: SymbolicLinearSystem) -> Iterable[list[sp.Symbol]]:
    matrix = system.coefficients
    return (list(matrix.row(i)) for i in range(matrix.rows))
