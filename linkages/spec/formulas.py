"""Formulas such as ``-30 kN - 10 kN*sign(beam.speed)``, with the dimensions of their terms.

A unit goes on as long as names of units follow, with ``*``, ``/`` or nothing between them. What is
called, or has a quantity, is no unit (``5 N*min(…)``, ``5 N*m.angle``); nor are t, pi, and, or.

A formula is read into a small tree. What consists of plain numbers alone is one number of it.

A formula without any unit is in SI and is not looked at. As soon as one number has a unit, all
numbers are what they say: one without a unit is a pure number, and only 0 may be anything. Named
quantities and t bring their dimension along. The radian counts as one, as in SI.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import ClassVar, TypeAlias, TypeGuard, assert_never

from linkages.operations import formula_functions
from linkages.reading.wording import listed, shown, suggestion
from linkages.spec.grammar import CONSTANTS, Builder, NumberError, Numbers, Span, parsed
from linkages.spec.units import KNOWN, Dimension, Unit, UnitError, unit

_POWER = r"(?:[ \t]*(?:\*\*|\^)[ \t]*[-+]?[1-9](?![0-9.])|[²³])?"
_NAME = rf"(°|(?!(?:t|pi|π|and|or)\b)[^\W\d]\w*)(?!\w)(?![ \t]*[(.]){_POWER}"
_FIRST = re.compile(rf"[ \t]*(?:1[ \t]*/[ \t]*)?{_NAME}")
_NEXT = re.compile(rf"[ \t]*[*/·⋅×]?[ \t]*{_NAME}")


def unit_end(text: str, at: int) -> int:
    """Return the index where a unit ends that stands at another one: the same without a unit."""
    match = _FIRST.match(text, at)
    if match is None:
        return at
    try:
        unit(match[1])
    except UnitError as error:
        raise NumberError(str(error), "", match.start(1)) from None
    end = match.end()
    while (match := _NEXT.match(text, end)) and _is_unit(match[1]):
        end = match.end()
    return end


def _is_unit(name: str) -> bool:
    try:
        unit(name)
    except UnitError:
        return False
    return True


LONGEST = 2000
"""Characters of a formula."""

HIGHEST = 160
"""Operations one within the other; a sum of n terms has n − 1 of them."""

_HIGHEST_POWER = 100

VALUE = "value"
"""The word of a state that has an equation of its own."""

WORDS = ("position", "velocity", "angle", "speed", "x", "y", "vx", "vy", VALUE)
"""What a law may depend on, behind the name of a slider, bar, plate, clearance, joint or state."""

PARAMETER = "parameter"
"""The word of a number that has a name of its own in a mechanism."""

CALLED = {"distance": 2, "angle": 2}
"""What is called with two names: joints, or bodies that turn."""

_LATER = (
    "acceleration", "ax", "ay", "force", "torque", "effort", "reaction", "power", "normal_force",
)  # fmt: skip
_TURNED = {"<": ">=", ">": "<="}


@dataclass(frozen=True)
class Constant:
    """A number in SI, and the unit of SI in which it is, if it was given with one."""

    value: float
    unit: Unit | None = None


@dataclass(frozen=True)
class Clock:
    """The time t in seconds."""


@dataclass(frozen=True)
class Sensed:
    """A quantity of the mechanism."""

    word: str  # one of `WORDS` of one name, one of `CALLED` of two, or `PARAMETER`
    names: tuple[str, ...]  # as the definition has them
    rate: bool = False  # whether it is the rate of that
    span: Span = field(default=(0, 0), compare=False)  # where it stands in the text


@dataclass(frozen=True)
class Call:
    """An operation: neg, add, sub, mul, div, a function of one or two arguments, power, or where.

    ``power`` has a whole `Constant` from 2 as its exponent; ``where`` is its second argument where
    the first is ≥ 0, otherwise its third. `depth` counts operations one within the other.
    """

    name: str
    arguments: tuple[Node, ...]
    depth: int = field(default=1, compare=False)
    span: Span = field(default=(0, 0), compare=False)


Node: TypeAlias = Constant | Clock | Sensed | Call


@dataclass(frozen=True)
class Formula:
    """A formula as written, and what it means."""

    text: str
    tree: Node

    def nodes(self) -> Iterator[Node]:
        """All parts of it, from left to right."""
        waiting = [self.tree]
        while waiting:
            node = waiting.pop()
            yield node
            if isinstance(node, Call):
                waiting += reversed(node.arguments)

    @property
    def has_units(self) -> bool:
        """Whether a number in it has a unit; all then have theirs."""
        return any(isinstance(node, Constant) and node.unit is not None for node in self.nodes())


def formula(text: str, refused: str = "") -> Formula:
    """Read a formula.

    `refused`: why it may not depend on quantities of the mechanism, as the end of a sentence; empty
    where it may.
    Raises NumberError the text is no formula; the message names the character, counted from 1.
    """
    # Printed formulas carry U+2212; it means nothing else.
    plain = text.replace("−", "-")
    try:
        tree, end = parsed(plain, FormulaTrees(refused))
        if _is_condition(tree):
            raise _misplaced(tree)
        if end < len(plain.rstrip()):
            hint = "; an operator is missing, or the number its unit"
            hint = "; powers are written **" if plain[end] == "^" else hint
            joined = plain[end] in "<>=" or plain[end:].split()[0] in ("and", "or")
            hint = "; a comparison stands in 'where(…)' only" if joined else hint
            raise NumberError(f"cannot read {shown(plain[end:])}", hint, end)
    except NumberError as error:
        place = "" if error.at is None else f" (character {error.at + 1})"
        raise NumberError(error.message + place, error.hint, error.at) from None
    return Formula(text, tree)


_ORDER = ("<", "<=", ">", ">=")
_JOINED = ("and", "or", "not")


class FormulaTrees(Builder[Node]):
    """Builds trees; `refused` is as `formula` takes it."""

    longest: ClassVar[int] = LONGEST

    def __init__(self, refused: str) -> None:
        self._refused = refused

    @property
    def functions(self) -> Mapping[str, int | tuple[int, ...]]:
        """Functions of formulas."""
        return {**formula_functions(), "rate": 1}

    @property
    def named(self) -> Mapping[str, int]:
        """What is called with two names."""
        return CALLED

    def number(self, value: float) -> Node:
        """A literal."""
        return Constant(Numbers().number(value))

    def unit_end(self, text: str, at: int) -> int:
        """Where a unit ends."""
        return unit_end(text, at)

    def measured(self, value: float, unit: str) -> Node:
        """A literal with its unit."""
        try:
            result = _unit(unit)
        except UnitError as error:
            raise NumberError(str(error)) from None
        return Constant(Numbers().number(result.convert(value)), replace(result, scale=1.0))

    def word(self, word: str, span: Span) -> Node | None:
        """The time, a constant, or a parameter of the mechanism."""
        if word == "t":
            return Clock()
        if word in CONSTANTS:
            return Constant(CONSTANTS[word])
        return Sensed(PARAMETER, (word,), span=span)

    def quantity(self, word: str, names: tuple[str, ...], span: Span) -> Node:
        """A quantity of the mechanism."""
        called = word in CALLED and len(names) > 1
        written = f"{word}({', '.join(names)})" if called else ".".join((*names, word))
        if word in _LATER:
            why = "follows from accelerations, which follow from the loads"
            remedy = "; a law may depend on positions, angles and distances, and on their rates"
            raise NumberError(f"{written!r} {why}", remedy, span[0])
        if not called and word not in WORDS:
            near = suggestion(word, WORDS) or f"; expected {listed(WORDS)}"
            if names == ("parameters",):
                near = f"; in formulas a parameter is its name alone, {word}"
            raise NumberError(f"unknown quantity {written!r}", near, span[0])
        if self._refused:
            raise NumberError(f"{written!r} is refused", f": {self._refused}", span[0])
        return Sensed(word, names, span=span)

    def operation(self, name: str, arguments: tuple[Node, ...], span: Span = (0, 0)) -> Node:
        """A call, or the number that it is."""
        if name == "where":
            return self._where(arguments, span)
        if name in _JOINED:
            return _joined(name, arguments, span)
        for argument in arguments:
            if _is_condition(argument):
                raise _misplaced(argument)
        if name == "rate":
            return _rate(arguments[0], span)
        if name in _ORDER:
            return _call(name, *arguments, span=span)
        if not any(isinstance(a, Constant) and a.unit is not None for a in arguments):
            values = [a.value for a in arguments if isinstance(a, Constant)]
            if len(values) == len(arguments):
                return Constant(Numbers().operation(name, tuple(values)))
        if name == "div" and isinstance(arguments[1], Constant) and arguments[1].value == 0.0:
            raise NumberError("division by zero")
        if name == "power":
            base, exponent = arguments
            return _power(base, exponent, span)
        return _call(name, *arguments, span=span)

    def _where(self, arguments: tuple[Node, ...], span: Span) -> Node:
        """A difference that is not negative takes the place of each comparison."""
        condition, first, second = arguments
        if not isinstance(condition, Call) or not _is_condition(condition):
            raise NumberError(
                "'where' expects a comparison first, such as where(t < 1 s, 0 N, 5 N)", at=span[0]
            )
        for other in (first, second):
            if _is_condition(other):
                raise _misplaced(other)
        match condition.name, condition.arguments:
            case "not", (one,):
                return self._where((one, second, first), span)
            case "and", (one, other):
                return self._where((one, self._where((other, first, second), span), second), span)
            case "or", (one, other):
                return self._where((one, first, self._where((other, first, second), span)), span)
        sign, (a, b) = condition.name, condition.arguments
        if sign in _TURNED:  # a < b is what a >= b is not
            sign, first, second = _TURNED[sign], second, first
        left, right = (a, b) if sign == ">=" else (b, a)
        difference = self.operation("sub", (left, right), condition.span)
        if isinstance(difference, Constant):
            return first if difference.value >= 0.0 else second
        return _call("where", difference, first, second, span=span)


def _unit(text: str) -> Unit:
    return unit(" ".join(text.split()))


def _is_condition(node: Node) -> TypeGuard[Call]:
    return isinstance(node, Call) and node.name in (*_ORDER, *_JOINED)


def _joined(name: str, arguments: tuple[Node, ...], span: Span) -> Node:
    if not all(map(_is_condition, arguments)):
        example = "not t < 1 s" if name == "not" else f"t > 1 s {name} t < 2 s"
        raise NumberError(f"{name!r} expects comparisons, such as {example}", at=span[0])
    return _call(name, *arguments, span=span)


def _misplaced(condition: Call) -> NumberError:
    message = "a comparison stands first in 'where(…)' only"
    return NumberError(message, at=condition.span[0])


def _rate(argument: Node, span: Span) -> Node:
    position = isinstance(argument, Sensed) and not argument.rate
    if (
        not isinstance(argument, Sensed)
        or not position
        or argument.word in ("velocity", "speed", "vx", "vy", VALUE)
    ):
        raise NumberError(
            "'rate' expects a position, an angle or a distance, such as rate(distance(A, B))",
            at=span[0],
        )
    return Sensed(argument.word, argument.names, rate=True, span=span)


def _call(name: str, *arguments: Node, span: Span) -> Node:
    depth = 1 + max(a.depth if isinstance(a, Call) else 0 for a in arguments)
    if depth > HIGHEST:
        message = f"more than {HIGHEST} operations one within the other"
        raise NumberError(message, "; parentheses around parts of a long sum make it flat", span[0])
    return Call(name, arguments, depth, span)


def _power(base: Node, exponent: Node, span: Span) -> Node:
    number = exponent.value if isinstance(exponent, Constant) and exponent.unit is None else None
    if number is None or number != int(number) or abs(number) > _HIGHEST_POWER:
        result = "one that depends on t" if number is None else f"{number:g}"
        expected = f"expected a whole exponent of at most {_HIGHEST_POWER}, found {result}"
        raise NumberError(expected, "; sqrt, exp and log are there for others")
    if number == 0:
        return Constant(1.0)
    times = Constant(abs(number))
    raised = base if abs(number) == 1 else _call("power", base, times, span=span)
    return _call("div", Constant(1.0), raised, span=span) if number < 0 else raised


Powers: TypeAlias = dict[str, Fraction]
"""Base unit → its power, those of zero left out; None in its place: a zero, which is anything."""

PURE: Powers = {}
_ALIKE = ("add", "sub", "min", "max", "where", "atan2")
TIME: Powers = {"second": Fraction(1)}
_SYMBOLS = {"meter": "m", "kilogram": "kg", "second": "s", "kelvin": "K", "ampere": "A"}


def powers(found: Unit) -> Powers:
    """The powers of base units, without the radian."""
    return {base: Fraction(power) for base, power in found.exponents if base != "radian"}


def described(found: Powers) -> str:
    """A dimension in words, with its unit: ``"a force (N)"``."""
    if not found:
        return "an angle or a pure number"
    for known in KNOWN:
        if powers(unit(known.unit)) == found:
            return f"{known.article} ({known.unit.replace('**', '^').replace('*', ' ')})"
    return f"a quantity in {unit_of(found)}"


def unit_of(found: Powers) -> str:
    """The unit of a dimension, such as ``"kg/m/s^3"``, as it can be read again."""
    above = [_unit_power(base, power) for base, power in found.items() if power > 0]
    below = [_unit_power(base, -power) for base, power in found.items() if power < 0]
    return f"{' '.join(above) or '1'}{''.join('/' + part for part in below)}"


def unit_text(found: Unit | None) -> str:
    """The usual name of a unit of SI: ``"Pa"``; empty for a pure number and for None."""
    if found is None or not found.exponents:
        return ""
    known = (each.unit for each in KNOWN if unit(each.unit).exponents == found.exponents)
    return next(known, unit_of(powers(found)))


def _unit_power(base: str, power: Fraction) -> str:
    return _SYMBOLS.get(base, base) + ("" if power == 1 else f"^{power}")


def require(
    formula: Formula,
    expected: Dimension,
    powers_of: Callable[[Sensed], Powers | None],
    shared: bool = False,
) -> None:
    """Make sure that a formula measures what stands in its place.

    `formula`: without units it is in SI, and passes.
    `shared`: whether a parameter in it has a unit, so that all numbers are what they say.
    """
    if not (formula.has_units or shared):
        return
    result = measured(formula, powers_of)
    wanted = powers(unit(expected.unit)) if expected.unit else PURE
    if result is not None and result != wanted:
        raise NumberError(f"it is {described(result)}, not {expected.article}")


def measured(formula: Formula, powers_of: Callable[[Sensed], Powers | None]) -> Powers | None:
    """What a formula with units measures; None if it is zero. Raises as `require` does."""
    return Measuring(formula.text, powers_of).of(formula.tree)


class Measuring:
    """What the nodes of a formula measure.

    `text`: the formula, for messages.
    `powers_of`: what a named quantity measures; None if that is not said.
    """

    def __init__(self, text: str, powers_of: Callable[[Sensed], Powers | None]) -> None:
        self._text, self._powers_of = text, powers_of

    def of(self, node: Node) -> Powers | None:
        """What a node measures; None if it is zero. Raises as `require` does."""
        match node:
            case Constant(value, result):
                if result is not None:
                    return powers(result)
                return None if value == 0.0 else PURE
            case Clock():
                return TIME
            case Sensed():
                return self._powers_of(node)
            case Call("power", (base, Constant(exponent))):
                return raised(self.of(base), Fraction(int(exponent)))
            case Call(name, arguments, _, span):
                return self.called(name, [*map(self.of, arguments)], arguments, span)
            case _:
                assert_never(node)

    def called(
        self, name: str, found: list[Powers | None], arguments: tuple[Node, ...], span: Span
    ) -> Powers | None:
        """What an operation measures."""
        match name:
            case "neg" | "abs":
                return found[0]
            case "sign":
                return PURE
            case "mul" | "div":
                first, second = found
                if first is None or second is None:
                    return None
                return times(first, raised(second, Fraction(1 if name == "mul" else -1)) or PURE)
            case "sqrt":
                return raised(found[0], Fraction(1, 2))
            case _ if name in _ALIKE:
                begin = 1 if name == "where" else 0
                alike = self.alike(found[begin:], arguments[begin:], span)
                return PURE if name == "atan2" else alike
        for argument in found:
            if argument:
                message = f"{name!r} takes an angle or a pure number, found {described(argument)}"
                hint = "; multiply it by a rate, such as 2 rad/s" if argument == TIME else ""
                raise NumberError(f"{message} in {self._at(span)}{hint}", at=span[0])
        return PURE

    def alike(
        self,
        found: list[Powers | None],
        arguments: tuple[Node, ...],  # noqa: ARG002
        span: Span,
    ) -> Powers | None:
        """What terms of a sum have in common; the arguments are those of `called`."""
        known = [entry for entry in found if entry is not None]
        for other in known[1:]:
            if other != known[0]:
                both = f"{described(known[0])} and {described(other)}"
                raise NumberError(f"{both} do not go together in {self._at(span)}", at=span[0])
        return known[0] if known else None

    def _at(self, span: Span) -> str:
        return repr(self._text[slice(*span)].strip())


def raised(found: Powers | None, exponent: Fraction) -> Powers | None:
    """The dimension of a power."""
    return None if found is None else {base: power * exponent for base, power in found.items()}


def product(first: Powers, *others: tuple[Powers, int]) -> Powers:
    """A dimension times whole powers of others."""
    for other, exponent in others:
        first = times(first, raised(other, Fraction(exponent)) or PURE)
    return first


def times(first: Powers, second: Powers) -> Powers:
    """The dimension of a product."""
    total = {base: first.get(base, Fraction(0)) + second.get(base, Fraction(0))
             for base in dict.fromkeys((*first, *second))}  # fmt: skip
    return {base: power for base, power in total.items() if power}
