"""Equations as plain text and LaTeX."""

from __future__ import annotations

import re
import textwrap
import unicodedata
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

import sympy as sp
from sympy.printing.latex import LatexPrinter
from sympy.printing.str import StrPrinter

from linkages.components.contributed.functions import TIME
from linkages.equations.derivation import SymbolicEquations
from linkages.equations.expressions import Notation, Polar, Symbols, Terms
from linkages.equations.vector_loops import Definition, SymbolicLinearSystem
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


class _SheetWriter(ABC):
    """Writes sides of equations as the summands that lines are folded at."""

    form: ClassVar[str]  # which form of a general statement it writes
    bars: ClassVar[tuple[str, str]]  # what is before and behind a norm
    signs: ClassVar[dict[str, str]]
    leading: ClassVar[str]  # a minus sign before the first summand

    def _summands(self, side: Side) -> list[str]:
        if isinstance(side, SheetFormula):
            return [getattr(side, self.form)]
        if isinstance(side, Norm):
            *before, last = self._summands(side.terms)
            first, *rest = [*before, last + self.bars[1]]
            return [self.bars[0] + first, *rest]
        (sign, first), *others = (
            (sign, self._polar(term) if isinstance(term, Polar) else self._expression(term))
            for sign, term in signed(side)
        )
        start = first if sign == "+" else f"{self.leading}{first}"
        return [start, *(f"{self.signs[sign]} {text}" for sign, text in others)]

    @abstractmethod
    def _expression(self, expression: sp.Expr) -> str: ...

    @abstractmethod
    def _polar(self, term: Polar) -> str: ...


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
    reduced, potential = equations.lagrange, equations.gravitational + equations.elastic
    result = (
        SheetSection("Coordinates", tuple(_coordinates(equations))),
        SheetSection("Closure, loop by loop", tuple(_closure(equations))),
        SheetSection("Centres of mass", tuple(_centres(equations))),
        SheetSection("Lengths of springs and dampers", tuple(_distances(equations))),
        SheetSection("Clearances that open", tuple(_definitions(equations.contacts))),
        SheetSection("Kinetic energy", (Line((KINETIC,)), *_definitions(reduced.masses.values()))),
        SheetSection("Potential energy", (Line((SheetFormula("V", "V"), potential)),)),
        SheetSection("Velocity coefficients, loop by loop", tuple(_coefficients(equations))),
        SheetSection("Inertia terms", (Line((INERTIA,)), *_definitions(reduced.inertia.values()))),
        SheetSection("Internal states", tuple(_internal(equations))),
        SheetSection("Lagrange's equations", tuple(_lagrange(equations))),
    )
    return tuple(section for section in result if section.lines)


_JOINED = {"linear": "straight lines", "pchip": "monotone cubics (pchip)", "spline": "cubic spline"}


def _indexed(letter: str, index: int) -> SheetFormula:
    latex = r"\Phi" if letter == "Φ" else letter
    return SheetFormula(f"{letter}_{index}", f"{latex}_{{{index}}}")


def _definitions(definitions: Iterable[Definition]) -> Iterator[Line]:
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
    updates = (following for following, _ in equations.updates.values())
    laws = (*equations.forces.values(), *equations.internal.values(), *updates)
    used = set().union(*(law.free_symbols for law in laws))
    for distance in equations.loads.lengths.values():
        yield Line((distance.symbol, Norm(distance.between)))
        if distance.rate in used:
            yield Line((distance.rate, distance.speed(equations.symbols.rates)))


def _closure(equations: SymbolicEquations) -> Iterator[Line]:
    for index, loop in enumerate(equations.loops):
        yield Line((loop.left, loop.right or ZERO), f"at {loop.apex}")
        for axis, residual in enumerate(loop.residual, 2 * index + 1):
            yield Line((_indexed("Φ", axis), residual, ZERO))


def _centres(equations: SymbolicEquations) -> Iterator[Line]:
    for body in equations.bodies:
        if body.mass != 0:
            yield Line((body.position, body.centre or ZERO))


def _coefficients(equations: SymbolicEquations) -> Iterator[Line]:
    if equations.loops:
        yield Line((COEFFICIENTS,))
    for block in equations.lagrange.blocks:
        yield from _definitions(block.definitions)
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
        if state not in equations.updates:
            yield Line((equations.symbols.dotted(state), rate), "integrated with the motion")
    for state, (following, period) in equations.updates.items():
        every = f"at every multiple of {equations.symbols.values[period]:g} s"
        yield Line((state, following), f"{every}, constant between")


def _lagrange(equations: SymbolicEquations) -> Iterator[Line]:
    yield Line((LAGRANGE,))
    reduced = equations.lagrange
    for index, value in enumerate(reduced.gradient, 1):
        yield Line((SheetFormula(f"∂V/∂q_{index}", rf"\partial V / \partial q_{{{index}}}"), value))
    for index, value in enumerate(reduced.forces, 1):
        yield Line((_indexed("Q", index), value))


WIDTH = 100
_GLUE = "\xa0"  # no name contains it
_GREEK = {"theta": "θ", "alpha": "α", "phi": "φ", "omega": "ω", "mu": "μ"}
_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_DOTS = ("", "\u0307", "\u0308")


def write_text(title: str, sections: tuple[SheetSection, ...], symbols: Symbols) -> str:
    """Return all sections under a title."""
    write = _TextWriter(symbols)
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


class _TextPrinter(StrPrinter):
    def _print_Select(self, expression: sp.Expr) -> str:  # noqa: N802
        condition, first, second = (self._print(argument) for argument in expression.args)
        return f"[{first} if {condition} ≥ 0, else {second}]"

    def _print_Spline(self, expression: sp.Expr) -> str:  # noqa: N802
        number, order, time = expression.args
        return f"f_{number}{'′' * int(order)}({self._print(time)})"


class _TextWriter(_SheetWriter):
    """Writes expressions: SymPy prints identifiers, which are then replaced by their looks."""

    form, bars, signs, leading = "text", ("|", "|"), {"+": "+", "−": "−"}, "−"

    def __init__(self, symbols: Symbols) -> None:
        self._looks = {
            s.name: symbol_text(n).replace(" ", _GLUE) for s, n in symbols.notations.items()
        }
        self._looks["pi"] = "π"
        self._print = _TextPrinter({"full_prec": False})

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


_PER_ROW = 5
_LATEX_GREEK = frozenset({"theta", "alpha", "phi", "omega", "mu"})
_ACCENTS = ("{}", r"\dot{{{}}}", r"\ddot{{{}}}")
_ESCAPES = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    **{c: f"\\{c}" for c in "{}$&#_%"},
}


def write_latex(title: str, sections: tuple[SheetSection, ...], symbols: Symbols) -> str:
    """Return a paragraph with an align* environment per section."""
    write = _LatexWriter(symbols)
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
    letter = f"\\{notation.letter}" if notation.letter in _LATEX_GREEK else notation.letter
    letter = _ACCENTS[notation.dots].format(letter)
    if not notation.subscripts:
        return letter
    subscript = ",".join(rf"\text{{{escaped(text)}}}" for text in notation.subscripts)
    return f"{letter}_{{{subscript}}}"


class _LatexPrinter(LatexPrinter):
    def _print_Select(self, expression: sp.Expr, exp: str | None = None) -> str:  # noqa: N802
        condition, first, second = (self._print(argument) for argument in expression.args)
        cases = rf"\begin{{cases}} {first} & {condition} \ge 0 \\ {second} & \text{{otherwise}}"
        return rf"{cases} \end{{cases}}" + ("" if exp is None else f"^{{{exp}}}")

    def _print_Spline(self, expression: sp.Expr, exp: str | None = None) -> str:  # noqa: N802
        number, order, time = expression.args
        raised = "'" * int(order)
        raised = raised if exp is None else f"^{{{raised} {exp}}}"
        return rf"f_{{{number}}}{raised}({self._print(time)})"


class _LatexWriter(_SheetWriter):
    form, leading = "latex", "- "
    bars, signs = (r"\bigl| ", r" \bigr|"), {"+": "+", "−": "-"}

    def __init__(self, symbols: Symbols) -> None:
        looks = {symbol: symbol_latex(n) for symbol, n in symbols.notations.items()}
        self._print = _LatexPrinter({"symbol_names": looks, "full_prec": False})

    def line(self, line: Line) -> str:
        """Return related sides, the first relation aligned, long sums folded."""
        first, *others = (self._summands(side) for side in line.sides)
        row = _folded(first) if others else f"& {_folded(first)}"
        for index, other in enumerate(others):
            row += f" {'&' if index == 0 else ''}= {_folded(other)}"
        return rf"{row} && \text{{{escaped(line.remark)}}}" if line.remark else row

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
