"""Equations as LaTeX for the amsmath package."""

from __future__ import annotations

import sympy as sp
from sympy.printing.latex import LatexPrinter

from linkages.equations.polar import Polar
from linkages.equations.sheet import Line, Norm, SheetFormula, SheetSection, Side, signed
from linkages.equations.symbols import Notation, Symbols

_PER_ROW = 5
_SIGNS = {"+": "+", "−": "-"}
_GREEK = frozenset({"theta", "alpha", "phi", "omega", "mu"})
_DOTS = ("{}", r"\dot{{{}}}", r"\ddot{{{}}}")
_ESCAPES = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    **{c: f"\\{c}" for c in "{}$&#_%"},
}


def write_latex(title: str, sections: tuple[SheetSection, ...], symbols: Symbols) -> str:
    """Return a paragraph with an align* environment per section."""
    write = _Writer(symbols)
    parts = [rf"\section*{{{escaped(title)}}}"]
    for section in sections:
        rows = [write.line(line) for line in section.lines]
        parts += [rf"\paragraph{{{escaped(section.heading)}}}", r"\begin{align*}"]
        parts += [rf"  {row} \\" for row in rows[:-1]] + [f"  {rows[-1]}", r"\end{align*}"]
    return "\n".join(parts) + "\n"


def escaped(text: str) -> str:
    """Return a text with the characters that mean something to LaTeX escaped."""
    return "".join(_ESCAPES.get(c, c) for c in text)


def symbol_latex(notation: Notation) -> str:
    """Return how LaTeX shows a symbol."""
    letter = f"\\{notation.letter}" if notation.letter in _GREEK else notation.letter
    letter = _DOTS[notation.dots].format(letter)
    if not notation.subscripts:
        return letter
    subscript = ",".join(rf"\text{{{escaped(text)}}}" for text in notation.subscripts)
    return f"{letter}_{{{subscript}}}"


class _Printer(LatexPrinter):
    """Writes what SymPy does not know."""

    def _print_Select(self, expression: sp.Expr, exp: str | None = None) -> str:  # noqa: N802
        condition, first, second = (self._print(argument) for argument in expression.args)
        cases = rf"\begin{{cases}} {first} & {condition} \ge 0 \\ {second} & \text{{otherwise}}"
        return rf"{cases} \end{{cases}}" + ("" if exp is None else f"^{{{exp}}}")

    def _print_Spline(self, expression: sp.Expr, exp: str | None = None) -> str:  # noqa: N802
        number, order, time = expression.args
        raised = "'" * int(order)
        raised = raised if exp is None else f"^{{{raised} {exp}}}"
        return rf"f_{{{number}}}{raised}({self._print(time)})"


class _Writer:
    def __init__(self, symbols: Symbols) -> None:
        looks = {symbol: symbol_latex(n) for symbol, n in symbols.notations.items()}
        self._print = _Printer({"symbol_names": looks, "full_prec": False})

    def line(self, line: Line) -> str:
        """Return related sides, the first relation aligned, long sums folded."""
        first, *others = (self._summands(side) for side in line.sides)
        row = _folded(first) if others else f"& {_folded(first)}"
        for index, other in enumerate(others):
            row += f" {'&' if index == 0 else ''}= {_folded(other)}"
        return rf"{row} && \text{{{escaped(line.remark)}}}" if line.remark else row

    def _summands(self, side: Side) -> list[str]:
        if isinstance(side, SheetFormula):
            return [side.latex]
        if isinstance(side, Norm):
            *before, last = self._summands(side.terms)
            leading, *rest = [*before, rf"{last} \bigr|"]
            return [rf"\bigl| {leading}", *rest]
        (sign, first), *others = ((sign, self._term(term)) for sign, term in signed(side))
        start = first if sign == "+" else f"- {first}"
        return [start, *(f"{_SIGNS[sign]} {text}" for sign, text in others)]

    def _term(self, term: sp.Expr | Polar) -> str:
        return self._polar(term) if isinstance(term, Polar) else self._expression(term)

    def _expression(self, expression: sp.Expr) -> str:
        return str(self._print.doprint(expression))

    def _polar(self, term: Polar) -> str:
        length, angle = self._expression(term.length), self._expression(term.angle)
        if term.length.is_Add:
            length = rf"\left({length}\right)"
        if term.angle == 0:
            return length
        simple = term.angle.is_Symbol
        return rf"{length} \angle {angle}" if simple else rf"{length} \angle \left({angle}\right)"


def _folded(summands: list[str]) -> str:
    """Join summands, with a new row after every few."""
    rows = [" ".join(summands[i : i + _PER_ROW]) for i in range(0, len(summands), _PER_ROW)]
    return " \\\\\n  & \\quad ".join(rows)
