"""Equations as plain text with Greek letters and ∠."""

from __future__ import annotations

import re
import textwrap
import unicodedata

import sympy as sp
from sympy.printing.str import StrPrinter

from linkages.equations.polar import Polar
from linkages.equations.sheet import Line, Norm, SheetFormula, SheetSection, Side, signed
from linkages.equations.symbols import Notation, Symbols

WIDTH = 100
_GLUE = "\xa0"  # no name contains it
_GREEK = {"theta": "θ", "alpha": "α", "phi": "φ", "omega": "ω", "mu": "μ"}
_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_DOTS = ("", "\u0307", "\u0308")


def write_text(title: str, sections: tuple[SheetSection, ...], symbols: Symbols) -> str:
    """Return all sections under a title."""
    write = _Writer(symbols)
    parts = [title]
    for section in sections:
        parts.append(f"\n{section.heading}")
        parts += [write.line(line) for line in section.lines]
    return "\n".join(parts) + "\n"


def symbol_text(notation: Notation) -> str:
    """Return how text shows a symbol; braces hold together what is not one word."""
    letter = _GREEK.get(notation.letter, notation.letter) + _DOTS[notation.dots]
    letter = unicodedata.normalize("NFC", letter)
    if not notation.subscripts:
        return letter
    subscript = ",".join(notation.subscripts)
    one_word = re.fullmatch(r"[\w,]+", subscript)
    return f"{letter}_{subscript}" if one_word else f"{letter}_{{{subscript}}}"


class _Printer(StrPrinter):
    """Writes what SymPy does not know."""

    def _print_Select(self, expression: sp.Expr) -> str:  # noqa: N802
        condition, first, second = (self._print(argument) for argument in expression.args)
        return f"[{first} if {condition} ≥ 0, else {second}]"

    def _print_Spline(self, expression: sp.Expr) -> str:  # noqa: N802
        number, order, time = expression.args
        return f"f_{number}{'′' * int(order)}({self._print(time)})"


class _Writer:
    """Writes expressions: SymPy prints identifiers, which are then replaced by their looks."""

    def __init__(self, symbols: Symbols) -> None:
        self._looks = {
            s.name: symbol_text(n).replace(" ", _GLUE) for s, n in symbols.notations.items()
        }
        self._looks["pi"] = "π"
        self._print = _Printer({"full_prec": False})

    def line(self, line: Line) -> str:
        """Return sides joined by equal signs, folded at the page width."""
        pieces: list[str] = []
        for index, side in enumerate(line.sides):
            first, *others = self._summands(side)
            pieces += [first if index == 0 else f"= {first}", *others]
        if line.remark:
            pieces.append(f"{_GLUE} ({line.remark})")
        folded = textwrap.fill(
            " ".join(map(_glued, pieces)),
            WIDTH,
            initial_indent="  ",
            subsequent_indent=" " * 8,
            break_long_words=False,
            break_on_hyphens=False,
        )
        return folded.replace(_GLUE, " ")

    def _summands(self, side: Side) -> list[str]:
        if isinstance(side, SheetFormula):
            return [side.text]
        if isinstance(side, Norm):
            *before, last = self._summands(side.terms)
            leading, *rest = [*before, f"{last}|"]
            return [f"|{leading}", *rest]
        (sign, first), *others = ((sign, self._term(term)) for sign, term in signed(side))
        start = first if sign == "+" else f"−{first}"
        return [start, *(f"{sign} {text}" for sign, text in others)]

    def _term(self, term: sp.Expr | Polar) -> str:
        return self._polar(term) if isinstance(term, Polar) else self._expression(term)

    def _expression(self, expression: sp.Expr) -> str:
        text = self._print.doprint(expression)
        text = re.sub(r"\*\*(\d+)", lambda m: m[1].translate(_RAISED), text)
        text = text.replace("**", "^").replace("*", "·").replace("-", "−").replace("sqrt(", "√(")
        return re.sub(r"[A-Za-z_][A-Za-z0-9_]*", lambda m: self._looks.get(m[0], m[0]), text)

    def _polar(self, term: Polar) -> str:
        length = self._expression(term.length)
        if term.length.is_Add:
            length = f"({length})"
        if term.angle == 0:
            return length
        quarters, rest = term.angle.as_independent(*term.angle.free_symbols)
        if rest == 0 or not term.angle.is_Add:
            quarters, rest = (term.angle, 0) if term.angle.is_number else (0, term.angle)
        parts = [] if rest == 0 else [self._expression(rest)]
        parts += [] if quarters == 0 else [f"{self._expression(sp.deg(quarters))}°"]
        angle = " + ".join(parts).replace("+ −", "− ")
        return f"{length}∠({angle})" if " " in angle else f"{length}∠{angle}"


def _glued(piece: str) -> str:
    """Keep a summand on one line, or, if it is long, what belongs closely together."""
    if len(piece) < WIDTH - 8:
        return piece.replace(" ", _GLUE)
    piece = re.sub(r"(sin|cos)\([^()]*\)", lambda m: m[0].replace(" ", _GLUE), piece)
    start = piece[:2].replace(" ", _GLUE)
    return start + re.sub(r" ([+−]) ", rf" \1{_GLUE}", piece[2:])
