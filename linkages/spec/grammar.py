"""The grammar of arithmetic and formulas: a text becomes values of whatever kind is built.

Nothing is ever evaluated as code. With the precedence of Python::

    sum     = product {("+" | "-") product}
    product = signed {("*" | "/") signed}
    signed  = ("+" | "-") signed | power
    power   = atom ["**" signed]
    atom    = NUMBER | WORD | WORD "(" sum {"," sum} ")" | "(" sum ")"
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar, Generic, TypeVar

from linkages.reading.wording import suggestion

_DEEPEST = 32
_SPACE = re.compile(r"[ \t]*")
# The exponent belongs to the number only with digits after it, so that "3 em" is not misread.
_NUMBER = re.compile(r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_WORD = re.compile(r"[^\W\d]\w*")
_SHOWN = re.compile(r"\w+")

Value = TypeVar("Value")


class NumberError(ValueError):
    """Why a text is no number or no formula; the message continues "found '…': ".

    Parameters
    ----------
    message, hint
        What is wrong, and a clause that may follow.
    at
        Index of the character where, if there is one.
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
    def functions(self) -> Mapping[str, int]:
        """Names that may be called, with their numbers of arguments."""
        return {}

    @abstractmethod
    def number(self, value: float) -> Value:
        """Return the value of a literal, which may be infinite."""

    @abstractmethod
    def word(self, word: str) -> Value | None:
        """Return the value of a name; None where a number should stand."""

    @abstractmethod
    def operation(self, name: str, arguments: tuple[Value, ...]) -> Value:
        """Return neg, add, sub, mul, div, power or one of the functions of its arguments."""


def parsed(text: str, builder: Builder[Value]) -> tuple[Value, int]:
    """Return the value that a text starts with, and the index of what follows it.

    Raises
    ------
    NumberError
        The text does not start with a value, or the builder refuses it.
    """
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
        start, value = self.at, self.product()
        while operator := self._take("+", "-"):
            value = self._made(start, "add" if operator == "+" else "sub", value, self.product())
        return value

    def product(self) -> Value:
        start, value = self.at, self.signed()
        while operator := self._take("*", "/"):
            value = self._made(start, "mul" if operator == "*" else "div", value, self.signed())
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
            value = self.sum()
            self._close()
            return value
        if word := self._match(_WORD):
            return self._named(word, start)
        if number := self._match(_NUMBER):
            return self.builder.number(float(number))
        raise self._expected("a number")

    def _named(self, word: str, start: int) -> Value:
        functions = self.builder.functions
        if functions and (word in functions or self.text.startswith("(", self.at)):
            return self._called(word, start)
        try:
            value = self.builder.word(word)
        except NumberError as error:
            raise NumberError(error.message, error.hint, start) from None
        if value is None:
            self.at = start
            raise self._expected("a number")
        return value

    def _called(self, word: str, start: int) -> Value:
        count = self.builder.functions.get(word)
        if count is None:
            hint = suggestion(word, self.builder.functions)
            hint = hint or f"; expected one of: {', '.join(self.builder.functions)}"
            raise NumberError(f"unknown function {word!r}", hint, start)
        if not self._take("("):
            raise self._expected(f"'(' after {word!r}")
        arguments = [self.sum()]
        while self._take(","):
            arguments.append(self.sum())
        self._close()
        if len(arguments) != count:
            wanted = f"{count} argument{'s' if count > 1 else ''}"
            raise NumberError(f"{word!r} takes {wanted}, found {len(arguments)}", at=start)
        return self._made(start, word, *arguments)

    def _made(self, start: int, name: str, *arguments: Value) -> Value:
        try:
            return self.builder.operation(name, arguments)
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
