"""Measures: ``max(abs(crank.effort))``, ``at(0.2 s, B.x position)``: a number out of a motion.

A measure is arithmetic of numbers that series of outputs are reduced to. It is read by the grammar
of formulas, into the same trees, and never evaluated as code.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import assert_never

from linkages.operations import formula_functions
from linkages.reading.wording import shown
from linkages.spec.formulas import (
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
)
from linkages.spec.grammar import CONSTANTS, NumberError, Span, parsed
from linkages.spec.units import KNOWN, unit

OVER_TIME = {
    "max": "largest", "min": "least", "mean": "mean", "rms": "root of the mean square",
    "range": "largest less least", "stroke": "largest less least", "final": "last",
    "time_of_max": "time of the largest", "time_of_min": "time of the least",
}  # fmt: skip
"""What a series is reduced to by one argument."""

INTEGRALS = frozenset({"mean", "rms"})
"""Those that are integrals over time."""

AT = "at"
"""``at(t, x)`` is the value of a series at a time."""

ERROR = "error"
"""``error(x)`` is a series less what it is in the nominal motion at the same time."""

_WORD = re.compile(r"[^\W\d]\w*(?:\[\d+\])?")
_ELEMENT = rf"(?:'[^']+'|\"[^\"]+\"|{_WORD.pattern})"
_NEXT = r"(?: (?!(?:and|or|not)\b)[^\W\d]\w*)"
_SERIES = re.compile(rf"(?:{_ELEMENT}\.)+[^\W\d]\w*{_NEXT}*|(?!not\b)[^\W\d]\w*{_NEXT}+(?= *[,)])")


@dataclass(frozen=True)
class Measure:
    """A measure as written, and what it means: a tree with `Sensed` series and reductions."""

    text: str
    tree: Node

    @property
    def series(self) -> tuple[str, ...]:
        """Names of the series that it depends on, each once."""
        nodes = Formula(self.text, self.tree).nodes()
        return tuple(dict.fromkeys(node.word for node in nodes if isinstance(node, Sensed)))

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

        `unit_of`: name of a series → its unit.
        """

        def powers_of(node: Sensed) -> Powers:
            name = unit_of(node.word)
            return powers(unit(name)) if name not in ("", "1") else PURE

        result = _Dimensions(self.text, powers_of).of(self.tree)
        own = _one_series(self.tree)
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
        if is_series(tree):
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
        case Clock() | Sensed():
            return True
        case Call(name, arguments):
            return not reduces(name, len(arguments)) and any(map(is_series, arguments))
        case _:
            assert_never(node)


def reduces(name: str, count: int) -> bool:
    """Whether an operation with so many arguments makes a number of a series."""
    return name == AT or (name in OVER_TIME and count == 1)


class _Measures(FormulaTrees):
    """Trees of formulas with series in them, and with reductions of these."""

    def __init__(self) -> None:
        super().__init__("")

    @property
    def functions(self) -> Mapping[str, int | tuple[int, ...]]:
        """Functions of formulas, and reductions."""
        over_time: dict[str, int | tuple[int, ...]] = {**formula_functions(), AT: 2, ERROR: 1}
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
        if name == ERROR:
            return self._error(arguments, span)
        if not reduces(name, len(arguments)):
            return super().operation(name, arguments, span)
        if name == AT and is_series(arguments[0]):
            raise NumberError("'at' expects a time first, such as at(0.2 s, crank.effort)")
        if not is_series(arguments[-1]):
            raise NumberError(f"{name!r} expects what changes with time, such as crank.effort")
        return Call(name, arguments, span=span)

    @staticmethod
    def _error(arguments: tuple[Node, ...], span: Span) -> Node:
        if not is_series(arguments[0]):
            raise NumberError("'error' expects what changes with time, such as piston.position")
        if any(isinstance(n, Call) and n.name == ERROR for n in Formula("", arguments[0]).nodes()):
            raise NumberError("an error of an error is the error itself; expected a series")
        return Call(ERROR, arguments, span=span)


def _one_series(node: Node) -> str | None:
    """The series whose unit a measure is in, if it is a value of one series."""
    while isinstance(node, Call):
        if node.name.startswith("time_of"):
            return None
        if not (node.name in ("abs", "neg", ERROR) or reduces(node.name, len(node.arguments))):
            return None
        node = node.arguments[-1]
    return node.word if isinstance(node, Sensed) else None


class _Dimensions(Measuring):
    """What a measure measures; terms without a unit are in SI, whatever others are."""

    def called(
        self, name: str, found: list[Powers | None], arguments: tuple[Node, ...], span: Span
    ) -> Powers | None:
        """What an operation or a reduction measures."""
        if name == AT:
            self.alike([TIME, found[0]], (Clock(), arguments[0]), span)
            return found[1]
        if reduces(name, len(arguments)):
            return TIME if name.startswith("time_of") else found[0]
        if name == ERROR:
            return found[0]
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
