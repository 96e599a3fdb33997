"""Measures: ``max(abs(crank.effort))``, ``at(0.2 s, B.x position)``: a number out of a motion.

A measure is arithmetic of numbers that series of outputs are reduced to. It is read by the grammar
of formulas, into the same trees, and never evaluated as code.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import assert_never

from linkages.operations import formula_functions
from linkages.reading.wording import shown
from linkages.spec.formulas import (
    PARAMETER,
    PURE,
    TIME,
    Call,
    Clock,
    Constant,
    Formula,
    FormulaTrees,
    Measuring,
    Node,
    Powers,
    Sensed,
    described,
    powers,
    times,
)
from linkages.spec.grammar import CONSTANTS, NumberError, Span, parsed
from linkages.spec.units import KNOWN, unit

OVER_TIME = {
    "max": "largest", "min": "least", "mean": "mean", "rms": "root of the mean square",
    "range": "largest less least", "stroke": "largest less least", "first": "first",
    "final": "last", "time_of_max": "time of the largest", "time_of_min": "time of the least",
    "integral": "integral over time",
}  # fmt: skip
"""What a series is reduced to by one argument."""

HARMONICS = {"harmonic": "amplitude", "phase": "phase"}
"""``harmonic(n, x)``: what is known of the part of a series that has n periods in the window."""

CUMULATIVE = "cumulative"
"""``cumulative(x)`` is the integral of a series from the begin of the window, a series again."""

INTEGRALS = frozenset({"mean", "rms", "integral", CUMULATIVE, *HARMONICS})
"""What is integrated over time."""

AT = "at"
"""``at(t, x)`` is the value of a series at a time."""

DURING, LAST_TURN = "during", "last_turn"
WINDOWS: Mapping[str, int | tuple[int, ...]] = {DURING: (2, 3), LAST_TURN: 2}
"""``during(from, to, m)`` and ``last_turn(angle, m)``: a measure m of a part of the motion."""

DISTANCES = {
    "max_distance": "largest", "rms_distance": "root of the mean square",
    "sum_squared_distance": "sum of squares",
}  # fmt: skip
"""``max_distance(P, target)``: what the distances of points from the path of a joint come to."""

ERROR = "error"
"""``error(x)`` is a series less what it is in the nominal motion at the same time."""

ANGLE = unit("rad")

_WORD = re.compile(r"[^\W\d]\w*(?:\[\d+\])*")
_ELEMENT = rf"(?:'[^']+'|\"[^\"]+\"|{_WORD.pattern})"
_NEXT = r"(?: (?!(?:and|or|not)\b)[^\W\d]\w*)"
_SERIES = re.compile(
    rf"(?:{_ELEMENT}\.)+[^\W\d]\w*(?:(?:\[\d+\])+|{_NEXT}*)|[^\W\d]\w*(?:\[\d+\])+"
    rf"|(?!not\b)[^\W\d]\w*{_NEXT}+(?= *[,)])"
)
_PATH = re.compile(r"[^\W\d][^. ]*(?:\.[^. ]+)+|[^. ]+\]")


@dataclass(frozen=True)
class Measure:
    """A measure as written, and what it means: a tree with `Sensed` series and reductions."""

    text: str
    tree: Node

    @property
    def series(self) -> tuple[str, ...]:
        """Names of the series that it depends on, each once; not those of numbers."""
        nodes = [node for node in Formula(self.text, self.tree).nodes() if is_series(node)]
        return tuple(dict.fromkeys(node.word for node in nodes if isinstance(node, Sensed)))

    @property
    def numbers(self) -> tuple[str, ...]:
        """Paths of the numbers of a definition that it depends on, each once."""
        nodes = Formula(self.text, self.tree).nodes()
        named = [node for node in nodes if isinstance(node, Sensed) and node.word == PARAMETER]
        return tuple(dict.fromkeys(node.names[0] for node in named))

    def with_names(self, made: Callable[[Sensed], Node]) -> Measure:
        """The same with what names stand for in their places; raises ValueError for no measure."""
        result = replace(self, tree=_with_names(self.tree, made))
        for node in Formula(self.text, result.tree).nodes():
            _require_kinds(self.text, node)
        if is_series(result.tree):
            name = next(iter(result.series), "t")
            raise ValueError(
                f"measure {self.text!r}: it changes with time; expected outputs within a reduction "
                f"over time, such as max({spelled(name)})"
            )
        return result

    @property
    def integrates(self) -> bool:
        """Whether it has integrals over time in it."""
        nodes = Formula(self.text, self.tree).nodes()
        return any(isinstance(node, Call) and node.name in INTEGRALS for node in nodes)

    @property
    def compares(self) -> bool:
        """Whether it has errors in it, for which there must be a nominal motion."""
        nodes = Formula(self.text, self.tree).nodes()
        return any(isinstance(node, Call) and node.name == ERROR for node in nodes)

    def units(self, unit_of: Callable[[str], str]) -> str:
        """The unit that it is in, in SI; empty for a pure number.

        `unit_of`: name of a series, or path of a number → its unit.
        """

        def powers_of(node: Sensed) -> Powers:
            name = unit_of(node.names[0] if node.word == PARAMETER else node.word)
            return powers(unit(name)) if name not in ("", "1") else PURE

        result = _Dimensions(self.text, powers_of).of(self.tree)
        own = _one_name(self.tree)
        if own is not None:
            return unit_of(own)
        return "" if result is None else _unit_text(result)


def read_measure(text: str) -> Measure:
    """Read a measure.

    Raises ValueError the text is none; the message names the character, counted from 1.
    """
    plain = text.replace("−", "-")
    try:
        tree, end = parsed(plain, _Measures())
        if end < len(plain.rstrip()):
            raise NumberError(f"cannot read {shown(plain[end:])}", at=end)
        if is_series(tree) and not _may_be_number(tree):
            raise NumberError(
                "a measure is a number; expected outputs within a reduction over time, "
                "as in max(…) or mean(…)",
                at=0,
            )
    except NumberError as error:
        place = "" if error.at is None else f" (character {error.at + 1})"
        raise ValueError(f"measure {text!r}: {error.message}{place}{error.hint}") from None
    return Measure(text.strip(), tree)


def spelled(series: str) -> str:
    """The name of a series as a measure contains it: elements that are no words are quoted."""
    *elements, quantity = series.split(".")
    return ".".join([*(e if _WORD.fullmatch(e) else f"'{e}'" for e in elements), quantity])


def argument(measure: Measure) -> Node:
    """What a measure reduces, of one that reduces a series."""
    assert isinstance(measure.tree, Call)
    return measure.tree.arguments[-1]


def is_series(node: Node) -> bool:
    """Whether a node has a value at every time, and not one for the whole motion."""
    match node:
        case Constant():
            return False
        case Clock():
            return True
        case Sensed(word):
            return word != PARAMETER
        case Call(name, arguments):
            if reduces(name, len(arguments)) or name in WINDOWS or name in DISTANCES:
                return False
            return any(map(is_series, arguments))
        case _:
            assert_never(node)


def reduces(name: str, count: int) -> bool:
    """Whether an operation with so many arguments makes a number of its last one, a series."""
    return name == AT or name in HARMONICS or (name in OVER_TIME and count == 1)


def harmonic(name: str, order: Node, node: Node) -> Node:
    """Amplitude A or phase φ of A sin(2π n t/T + φ), from the begin of the window, by Fourier."""
    begin, end = (Call(which, (Clock(),)) for which in ("first", "final"))
    part = Call("div", (Call("sub", (Clock(), begin)), Call("sub", (end, begin))))
    angle = Call("mul", (Call("mul", (Constant(2.0 * math.pi), order)), part))
    cosine, sine = (
        Call("mean", (Call("mul", (node, Call(wave, (angle,)))),)) for wave in ("cos", "sin")
    )
    if name == "phase":
        return Call("atan2", (cosine, sine))
    squares = [Call("power", (each, Constant(2.0))) for each in (cosine, sine)]
    return Call("mul", (Constant(2.0), Call("sqrt", (Call("add", (squares[0], squares[1])),))))


def highest_order(measure: Measure) -> int:
    """The highest order of its harmonics, at least 1."""
    nodes = Formula(measure.text, measure.tree).nodes()
    calls = [node for node in nodes if isinstance(node, Call) and node.name in HARMONICS]
    orders = [order.value for node in calls if isinstance(order := node.arguments[0], Constant)]
    return int(max(orders, default=1.0))


def _may_be_number(node: Node) -> bool:
    """Whether all that may change with time could be numbers of a definition, by their names."""
    match node:
        case Sensed(word):
            return _PATH.fullmatch(word) is not None
        case Call(_, arguments):
            return not is_series(node) or all(map(_may_be_number, arguments))
        case _:
            return isinstance(node, Constant)


def _with_names(node: Node, made: Callable[[Sensed], Node]) -> Node:
    match node:
        case Sensed():
            return made(node)
        case Call(name, arguments, _, span):
            if name in DISTANCES:
                return made(Sensed(name, tuple(_word(each) for each in arguments), span=span))
            inner = tuple(_with_names(each, made) for each in arguments)
            return node if inner == arguments else replace(node, arguments=inner)
        case _:
            return node


def _word(node: Node) -> str:
    return node.word if isinstance(node, Sensed) else ""


def _require_kinds(text: str, node: Node) -> None:
    """Series stand where series are expected, and numbers where numbers are."""
    if not isinstance(node, Call):
        return
    try:
        _require(node.name, node.arguments, maybe=False)
    except NumberError as error:
        own = Measure(text, node.arguments[-1]).numbers
        hint = f"; {own[0]} is a number of the definition, and a measure by itself" if own else ""
        raise ValueError(f"measure {text!r}: {error.message}{hint}") from None


def _require(name: str, arguments: tuple[Node, ...], maybe: bool = True) -> None:
    """Raise for arguments of the wrong kind, with `maybe` unless names may be of either."""

    def series(node: Node) -> bool:
        return is_series(node) and not (maybe and _may_be_number(node))

    if name in (AT, DURING) and any(map(series, arguments[:-1])):
        raise NumberError(f"{name!r} expects a time first, such as {_EXAMPLES[name]}")
    if name in WINDOWS and series(arguments[-1]):
        raise NumberError(f"{name!r} expects a number last, such as {_EXAMPLES[name]}")
    if name == LAST_TURN and not is_series(arguments[0]):
        raise NumberError(f"{name!r} expects an angle first, such as {_EXAMPLES[name]}")
    reducing = reduces(name, len(arguments)) or name in (CUMULATIVE, ERROR)
    if reducing and not is_series(arguments[-1]):
        raise NumberError(f"{name!r} expects what changes with time, such as crank.effort")


_EXAMPLES = {
    AT: "at(0.2 s, crank.effort)",
    DURING: "during(1 s, 2 s, mean(crank.effort))",
    LAST_TURN: "last_turn(crank.angle, mean(crank.effort))",
}

_HIGHEST_ORDER = 1000


class _Measures(FormulaTrees):
    """Trees of formulas with series in them, and with reductions of these."""

    def __init__(self) -> None:
        super().__init__("")

    @property
    def functions(self) -> Mapping[str, int | tuple[int, ...]]:
        """Functions of formulas, and reductions."""
        over_time: dict[str, int | tuple[int, ...]] = {
            **formula_functions(), AT: 2, ERROR: 1, CUMULATIVE: 1, **WINDOWS,
            **dict.fromkeys((*HARMONICS, *DISTANCES), 2),
        }  # fmt: skip
        for name in OVER_TIME:
            both = name in formula_functions()
            over_time[name] = (1, 2) if both else 1
        return over_time

    @property
    def named(self) -> Mapping[str, int]:
        """Nothing: series are named as on axes."""
        return {}

    def series_end(self, text: str, at: int) -> int:
        """Where the name of a series ends."""
        result = _SERIES.match(text, at)
        return at if result is None else result.end()

    def series(self, name: str, span: Span) -> Node:
        """A series."""
        return Sensed(re.sub("['\"]", "", name), (), span=span)

    def word(self, word: str, span: Span) -> Node:
        """The time, a constant, or an output of the whole mechanism."""
        if word in ("t", "time"):
            return Clock()
        if word in CONSTANTS:
            return Constant(CONSTANTS[word])
        return Sensed(word, (), span=span)

    def operation(self, name: str, arguments: tuple[Node, ...], span: Span = (0, 0)) -> Node:
        """A call of a function or a reduction."""
        own = reduces(name, len(arguments)) or name in (ERROR, CUMULATIVE, *WINDOWS, *DISTANCES)
        if not own:
            return super().operation(name, arguments, span)
        _require(name, arguments)
        if name == ERROR:
            within = Formula("", arguments[0]).nodes()
            if any(isinstance(node, Call) and node.name == ERROR for node in within):
                raise NumberError("an error of an error is the error itself; expected a series")
        if name in DISTANCES and not all(isinstance(each, Sensed) for each in arguments):
            raise NumberError(f"{name!r} expects a joint and a target, such as {name}(P, wanted)")
        if name in HARMONICS:
            _require_order(name, arguments[0])
        return Call(name, arguments, span=span)


def _require_order(name: str, node: Node) -> None:
    value = node.value if isinstance(node, Constant) and node.unit is None else 0.0
    if not (1.0 <= value <= _HIGHEST_ORDER and value.is_integer()):
        raise NumberError(
            f"{name!r} expects an order first, a whole number from 1 to {_HIGHEST_ORDER}, such as "
            f"{name}(2, crank.effort)"
        )


def _one_name(node: Node) -> str | None:
    """The series or number whose unit a measure is in, if it is a value of it."""
    while isinstance(node, Call):
        if node.name.startswith("time_of") or node.name in ("integral", "phase"):
            return None
        kept = node.name in ("abs", "neg", ERROR) or node.name in WINDOWS
        if not (kept or reduces(node.name, len(node.arguments))):
            return None
        node = node.arguments[-1]
    if not isinstance(node, Sensed):
        return None
    return node.names[0] if node.word == PARAMETER else node.word


class _Dimensions(Measuring):
    """What a measure measures; terms without a unit are in SI, whatever others are."""

    def called(
        self, name: str, found: list[Powers | None], arguments: tuple[Node, ...], span: Span
    ) -> Powers | None:
        """What an operation or a reduction measures."""
        if name in (AT, DURING):
            for measured, node in zip(found[:-1], arguments[:-1], strict=True):
                self.alike([TIME, measured], (Clock(), node), span)
            return found[-1]
        if name == LAST_TURN:
            self.alike([PURE, found[0]], (Constant(1.0, ANGLE), arguments[0]), span)
            return found[-1]
        if name in ("integral", CUMULATIVE):
            return None if found[0] is None else times(found[0], TIME)
        if name == "phase":
            return PURE
        if reduces(name, len(arguments)) or name == ERROR:
            return TIME if name.startswith("time_of") else found[-1]
        return super().called(name, found, arguments, span)

    def alike(
        self, found: list[Powers | None], arguments: tuple[Node, ...], span: Span
    ) -> Powers | None:
        """What terms have in common that are no numbers in SI."""
        pairs = zip(found, arguments, strict=True)
        said = [None if _bare(node) else entry for entry, node in pairs]
        common = super().alike(said, arguments, span)
        return PURE if common is None else common


def _bare(node: Node) -> bool:
    """Whether a number stands for itself, in SI."""
    return isinstance(node, Constant) and node.unit is None


def _unit_text(found: Powers) -> str:
    """A unit in the words of outputs: that of a known dimension, or a product."""
    if not found:
        return ""
    for known in KNOWN:
        if known.unit and powers(unit(known.unit)) == found:
            return known.unit.replace("**", "^").replace("*", " ")
    return described(found).removeprefix("a quantity in ")
