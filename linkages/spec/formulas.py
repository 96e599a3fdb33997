"""Formulas of the time: ``0.5 + 0.2*sin(2*t)``, ``100*(t - 1)**2``; never evaluated as code.

A formula is read into a small tree. What consists of numbers alone is one number of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

from linkages.operations import COMPOSITE, formula_functions
from linkages.reading.wording import shown
from linkages.spec.arithmetic import CONSTANTS, Numbers
from linkages.spec.grammar import Builder, NumberError, parsed

_HIGHEST_POWER = 100
_LARGEST = 1000


@dataclass(frozen=True)
class Constant:
    """A number."""

    value: float


@dataclass(frozen=True)
class Clock:
    """The time t in seconds."""


@dataclass(frozen=True)
class Call:
    """An operation: neg, add, sub, mul, div, a function of one argument, power, or select.

    ``power`` has a whole `Constant` from 2 as its exponent; ``select`` is its second argument
    where the first is ≥ 0, otherwise its third. `size` is the number of nodes, written out.
    """

    name: str
    arguments: tuple[Node, ...]
    size: int


Node: TypeAlias = Constant | Clock | Call


@dataclass(frozen=True)
class Formula:
    """A formula as written, and what it means."""

    text: str
    tree: Node


def formula(text: str) -> Formula:
    """Read a formula.

    Raises
    ------
    NumberError
        The text is no formula; the message names the character, counted from 1.
    """
    # Printed formulas carry U+2212; it means nothing else.
    plain = text.replace("−", "-")
    try:
        tree, end = parsed(plain, _Trees())
        if end < len(plain.rstrip()):
            hint = "; numbers in formulas are in SI, without units"
            hint = "; powers are written **" if plain[end] == "^" else hint
            raise NumberError(f"cannot read {shown(plain[end:])}", hint, end)
    except NumberError as error:
        place = "" if error.at is None else f" (character {error.at + 1})"
        raise NumberError(error.message + place, error.hint, error.at) from None
    return Formula(text, tree)


class _Trees(Builder[Node]):
    longest: ClassVar[int] = 300

    @property
    def functions(self) -> Mapping[str, int]:
        return formula_functions()

    def number(self, value: float) -> Node:
        return Constant(Numbers().number(value))

    def word(self, word: str) -> Node | None:
        if word == "t":
            return Clock()
        if word in CONSTANTS:
            return Constant(CONSTANTS[word])
        raise NumberError(f"unknown name {word!r}", "; expected t or pi")

    def operation(self, name: str, arguments: tuple[Node, ...]) -> Node:
        values = [a.value for a in arguments if isinstance(a, Constant)]
        if len(values) == len(arguments):
            return Constant(Numbers().operation(name, tuple(values)))
        if name == "div" and arguments[1] == Constant(0.0):
            raise NumberError("division by zero")
        if name == "power":
            return _power(*arguments)
        if name not in COMPOSITE:
            return _call(name, *arguments)
        expanded: Node = COMPOSITE[name].expanded(_call, *arguments)
        return expanded


def _call(name: str, *arguments: Node) -> Node:
    size = 1 + sum(a.size if isinstance(a, Call) else 1 for a in arguments)
    if size > _LARGEST:  # each abs, min and max repeats its arguments
        raise NumberError("too large a formula; expected fewer nested abs, min and max")
    return Call(name, arguments, size)


def _power(base: Node, exponent: Node) -> Node:
    number = exponent.value if isinstance(exponent, Constant) else None
    if number is None or number != int(number) or abs(number) > _HIGHEST_POWER:
        found = "one that depends on t" if number is None else f"{number:g}"
        expected = f"expected a whole exponent of at most {_HIGHEST_POWER}, found {found}"
        raise NumberError(expected, "; sqrt, exp and log are there for others")
    if number == 0:
        return Constant(1.0)
    raised = base if abs(number) == 1 else _call("power", base, Constant(abs(number)))
    return _call("div", Constant(1.0), raised) if number < 0 else raised
