"""Grammar of arithmetic and formulas in definition files; nothing is evaluated as code.

Nothing is ever evaluated as code. With the precedence of Python::

    sum      = product {("+" | "-") product}
    product  = signed {("*" | "/") signed}
    signed   = ("+" | "-") signed | power
    power    = atom ["**" signed]
    atom     = NUMBER [UNIT] | WORD | SERIES | name "." WORD | call | "(" either ")"
    call     = WORD "(" either {"," either} ")" | WORD "(" name {"," name} ")"
    either   = both {"or" both}
    both     = negation {"and" negation}
    negation = "not" negation | sum {("<=" | ">=" | "<" | ">") sum}
    name     = WORD | "'" TEXT "'" | '"' TEXT '"'

Units, names and calls stand in formulas only, see `linkages.spec.formulas`, and the names of series
in measures only, see `linkages.spec.measures`.
"""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import ClassVar, Generic, TypeVar

from linkages.operations import value_of
from linkages.reading.wording import suggestion

_DEEPEST = 32
_SPACE = re.compile(r"[ \t]*")
# The exponent belongs to the number only with digits after it, so that "3 em" is not misread.
_NUMBER = re.compile(r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_WORD = re.compile(r"[^\W\d]\w*")
_QUOTED = re.compile("'([^']*)'|\"([^\"]*)\"")
_SHOWN = re.compile(r"\w+")
_COMPARISONS = ("<=", ">=", "<", ">")

Span = tuple[int, int]
"""Where something begins and ends in a text."""

Value = TypeVar("Value")


class NumberError(ValueError):
    """Why a text is no number or no formula; the message continues "found '…': ".

    `message`, `hint`: what is wrong, and a clause that may follow.
    `at`: index of the character where, if there is one.
    """

    def __init__(self, message: str, hint: str = "", at: int | None = None) -> None:
        super().__init__(message + hint)
        self.message, self.hint, self.at = message, hint, at


class Builder(ABC, Generic[Value]):
    """Makes values of what the grammar finds.

    `longest` is the greatest length of a text.
    """

    longest: ClassVar[int] = 200

    @property
    def functions(self) -> Mapping[str, int | tuple[int, ...]]:
        """Names that may be called, with their numbers of arguments, all that are possible."""
        return {}

    @property
    def named(self) -> Mapping[str, int]:
        """Names of what is called with names of the mechanism, with their numbers of arguments."""
        return {}

    @abstractmethod
    def number(self, value: float) -> Value:
        """Return the value of a literal, which may be infinite."""

    def unit_end(self, text: str, at: int) -> int:  # noqa: ARG002
        """Return where a unit ends that stands behind a number at an index: there without one."""
        return at

    def series_end(self, text: str, at: int) -> int:  # noqa: ARG002
        """Return where the name of a series ends that begins at an index: there without one."""
        return at

    def series(self, name: str, span: Span) -> Value:
        """Return what the name of a series stands for, where `series_end` finds one."""
        raise NumberError(f"unknown name {name!r}", at=span[0])

    def measured(self, value: float, unit: str) -> Value:
        """Return the value of a literal with a unit, where `unit_end` finds one."""
        del value
        raise NumberError(f"this number has no unit, found {unit!r}")

    def quantity(self, word: str, names: tuple[str, ...], span: Span) -> Value:
        """Return what a name and a word stand for, or a word that is called with names."""
        raise NumberError(f"unknown name {'.'.join((*names, word))!r}", at=span[0])

    @abstractmethod
    def word(self, word: str, span: Span) -> Value | None:
        """Return the value of a name; None where a number should stand."""

    @abstractmethod
    def operation(self, name: str, arguments: tuple[Value, ...], span: Span = (0, 0)) -> Value:
        """Return an operation, a comparison, and, or, not or a function of its arguments."""


def parsed(text: str, builder: Builder[Value]) -> tuple[Value, int]:
    """Return the value that a text starts with, and the index of what follows it."""
    if len(text) > builder.longest:
        raise NumberError(f"longer than {builder.longest} characters")
    reader = _Reader(text, builder)
    return reader.sum(), reader.at


class _Reader(Generic[Value]):
    def __init__(self, text: str, builder: Builder[Value]) -> None:
        self.text = text
        self.builder = builder
        self.at = 0
        self._depth = 0
        self._skip()

    def sum(self) -> Value:
        return self._joined(self._take, {"+": "add", "-": "sub"}, self.product)

    def product(self) -> Value:
        return self._joined(self._take, {"*": "mul", "/": "div"}, self.signed)

    def _joined(
        self,
        take: Callable[..., str | None],
        operators: Mapping[str, str],
        operand: Callable[[], Value],
    ) -> Value:
        """Operands with operators between them, from left to right."""
        start, value = self.at, operand()
        while operator := take(*operators):
            value = self._made(start, operators[operator], value, operand())
        return value

    def signed(self) -> Value:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise NumberError(f"nested more than {_DEEPEST} deep")
        start, sign = self.at, self._take("+", "-")
        value = self.signed() if sign else self.power()
        self._depth -= 1
        return self._made(start, "neg", value) if sign == "-" else value

    def power(self) -> Value:
        start, base = self.at, self.atom()
        return self._made(start, "power", base, self.signed()) if self._take("**") else base

    def atom(self) -> Value:
        start = self.at
        if self._take("("):
            value = self.either() if self.builder.functions else self.sum()
            self._close()
            return value
        if (end := self.builder.series_end(self.text, start)) > start:
            self.at = end
            self._skip()
            return self.builder.series(self.text[start:end], (start, end))
        if self.builder.named and (name := self._name(followed=".")) is not None:
            return self._quantity(name, start)
        if word := self._match(_WORD):
            return self._named(word, start)
        if number := self._match(_NUMBER):
            return self._measured(float(number), start)
        raise self._expected("a number")

    def _measured(self, value: float, start: int) -> Value:
        begin = self.at
        end = self.builder.unit_end(self.text, begin)
        if end == begin:
            return self.builder.number(value)
        self.at = end
        self._skip()
        try:
            return self.builder.measured(value, self.text[begin:end])
        except NumberError as error:
            raise NumberError(error.message, error.hint, start) from None

    def _name(self, followed: str = "") -> str | None:
        """A name of the mechanism, if one stands here (and is followed by some character)."""
        start, quoted = self.at, _QUOTED.match(self.text, self.at)
        if quoted is not None:
            self.at, name = quoted.end(), quoted[1] or quoted[2] or ""
        elif word := _WORD.match(self.text, self.at):
            self.at, name = word.end(), word.group()
        else:
            return None
        self._skip()
        if followed and not self.text.startswith(followed, self.at):
            self.at = start
            return None
        return name

    def _quantity(self, name: str, start: int) -> Value:
        self.at += 1
        self._skip()
        word = self._match(_WORD)
        if word is None:
            raise self._expected(f"a word after '{name}.'")
        return self.builder.quantity(word, (name,), (start, self.at))

    def _named(self, word: str, start: int) -> Value:
        functions = self.builder.functions
        if word in self.builder.named and self.text.startswith("(", self.at):
            return self._called_with_names(word, start)
        if functions and (word in functions or self.text.startswith("(", self.at)):
            return self._called(word, start)
        try:
            value = self.builder.word(word, (start, start + len(word)))
        except NumberError as error:
            raise NumberError(error.message, error.hint, start) from None
        if value is None:
            self.at = start
            raise self._expected("a number")
        return value

    def _called(self, word: str, start: int) -> Value:
        count = self.builder.functions.get(word)
        if count is None:
            known = (*self.builder.functions, *self.builder.named)
            hint = suggestion(word, known) or f"; expected one of: {', '.join(known)}"
            raise NumberError(f"unknown function {word!r}", hint, start)
        if not self._take("("):
            raise self._expected(f"'(' after {word!r}")
        arguments = [self.either()]
        while self._take(","):
            arguments.append(self.either())
        self._close()
        self._count(word, start, count, len(arguments))
        return self._made(start, word, *arguments)

    def _called_with_names(self, word: str, start: int) -> Value:
        self._take("(")
        names = [self._required_name()]
        while self._take(","):
            names.append(self._required_name())
        self._close()
        self._count(word, start, self.builder.named[word], len(names))
        return self.builder.quantity(word, tuple(names), (start, self.at))

    def _required_name(self) -> str:
        name = self._name()
        if name is None:
            raise self._expected("a name")
        return name

    def _count(self, word: str, start: int, count: int | tuple[int, ...], found: int) -> None:
        counts = (count,) if isinstance(count, int) else count
        if found not in counts:
            wanted = f"{' or '.join(map(str, counts))} argument{'s' if max(counts) > 1 else ''}"
            raise NumberError(f"{word!r} takes {wanted}, found {found}", at=start)

    def either(self) -> Value:
        return self._joined(self._take_word, {"or": "or"}, self._both)

    def _both(self) -> Value:
        return self._joined(self._take_word, {"and": "and"}, self._negation)

    def _negation(self) -> Value:
        start = self.at
        if not self._take_word("not"):
            return self._comparison()
        self._depth += 1
        if self._depth > _DEEPEST:
            raise NumberError(f"nested more than {_DEEPEST} deep")
        value = self._made(start, "not", self._negation())
        self._depth -= 1
        return value

    def _comparison(self) -> Value:
        start, first = self.at, self.sum()
        value = first
        while sign := self._take(*_COMPARISONS):
            second = self.sum()
            compared = self._made(start, sign, first, second)
            value = compared if value is first else self._made(start, "and", value, compared)
            first = second
        return value

    def _take_word(self, word: str) -> str | None:
        """Take a word that joins conditions; a name of the mechanism is followed by a point."""
        result, start = _WORD.match(self.text, self.at), self.at
        if result is None or result.group() != word:
            return None
        self.at = result.end()
        self._skip()
        if self.text.startswith(".", self.at):
            self.at = start
            return None
        return word

    def _made(self, start: int, name: str, *arguments: Value) -> Value:
        try:
            return self.builder.operation(name, arguments, (start, self.at))
        except NumberError as error:
            at = start if error.at is None else error.at
            raise NumberError(error.message, error.hint, at) from None

    def _close(self) -> None:
        if not self._take(")"):
            raise self._expected("')'")

    def _take(self, *operators: str) -> str | None:
        for operator in operators:
            if self.text.startswith(operator, self.at) and not (
                operator == "*" and self.text.startswith("**", self.at)
            ):
                self.at += len(operator)
                self._skip()
                return operator
        return None

    def _match(self, pattern: re.Pattern[str]) -> str | None:
        match = pattern.match(self.text, self.at)
        if match is None:
            return None
        self.at = match.end()
        self._skip()
        return match.group()

    def _skip(self) -> None:
        space = _SPACE.match(self.text, self.at)
        self.at = space.end() if space else self.at

    def _expected(self, what: str) -> NumberError:
        word = _SHOWN.match(self.text, self.at)
        rest = word.group() if word else self.text[self.at : self.at + 1]
        place = f" before {rest!r}" if rest else " at the end"
        return NumberError(f"expected {what}{place}", at=self.at)


__all__ = ["CONSTANTS", "NumberError", "Numbers", "leading_number"]

CONSTANTS = {"pi": math.pi, "π": math.pi}


def leading_number(text: str) -> tuple[float, str]:
    """Return the value of the arithmetic that a text starts with, and the text that follows it.

    Every intermediate result is a finite double, so the work is bounded by the length of the text.
    """
    value, end = parsed(text, Numbers())
    return value, text[end:].strip()


class Numbers(Builder[float]):
    """Builds numbers: every operation is carried out."""

    def number(self, value: float) -> float:
        """Return a finite number."""
        if not math.isfinite(value):
            raise NumberError("too large for a number")
        return value

    def word(self, word: str, span: Span) -> float | None:  # noqa: ARG002
        """Return pi."""
        return CONSTANTS.get(word)

    def operation(
        self,
        name: str,
        arguments: tuple[float, ...],
        span: Span = (0, 0),  # noqa: ARG002
    ) -> float:
        """Return the result; not being finite or real is an error."""
        try:
            return self.number(value_of(name, *arguments))
        except ZeroDivisionError:
            raise NumberError("division by zero") from None
        except OverflowError:
            raise NumberError("too large for a number") from None
        except ValueError as error:
            if isinstance(error, NumberError):
                raise
            raise NumberError(f"{_written(name, arguments)} is not a real number") from None


def _written(name: str, arguments: tuple[float, ...]) -> str:
    if name == "power":
        return "{:g}**{:g}".format(*arguments)
    return f"{name}({', '.join(f'{a:g}' for a in arguments)})"
