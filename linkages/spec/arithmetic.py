"""Arithmetic in definition files: ``-1.5*pi``, ``2*pi/3``, ``0.3**2``; never evaluated as code.

Grammar, with the precedence of Python::

    sum     = product {("+" | "-") product}
    product = signed {("*" | "/") signed}
    signed  = ("+" | "-") signed | power
    power   = atom ["**" signed]
    atom    = NUMBER | "pi" | "(" sum ")"
"""

from __future__ import annotations

import math
import re

_LONGEST = 200
_DEEPEST = 32
_SPACE = re.compile(r"[ \t]*")
# The exponent belongs to the number only with digits after it, so that "3 em" is not misread.
_NUMBER = re.compile(r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_PI = re.compile(r"(?:pi|π)(?!\w)")
_WORD = re.compile(r"\w+")


class NumberError(ValueError):
    """Why a text is not a finite number; the message continues "found '…': "."""


def leading_number(text: str) -> tuple[float, str]:
    """Return the value of the arithmetic that a text starts with, and the text that follows it.

    Every intermediate result is a finite double, so the work is bounded by the length of the text.

    Raises
    ------
    NumberError
        The text does not start with arithmetic, or a result is not finite.
    """
    if len(text) > _LONGEST:
        raise NumberError(f"longer than {_LONGEST} characters")
    reader = _Reader(text)
    value = reader.sum()
    return value, text[reader.at :].strip()


class _Reader:
    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        self._depth = 0
        self._skip()

    def sum(self) -> float:
        value = self.product()
        while operator := self._take("+", "-"):
            right = self.product()
            value = _finite(value + right if operator == "+" else value - right)
        return value

    def product(self) -> float:
        value = self.signed()
        while operator := self._take("*", "/"):
            right = self.signed()
            if operator == "/" and right == 0:
                raise NumberError("division by zero")
            value = _finite(value * right if operator == "*" else value / right)
        return value

    def signed(self) -> float:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise NumberError(f"nested more than {_DEEPEST} deep")
        sign = self._take("+", "-")
        value = self.signed() if sign else self.power()
        self._depth -= 1
        return -value if sign == "-" else value

    def power(self) -> float:
        base = self.atom()
        return _power(base, self.signed()) if self._take("**") else base

    def atom(self) -> float:
        if self._take("("):
            value = self.sum()
            if not self._take(")"):
                raise NumberError(f"expected ')'{self._here()}")
            return value
        if self._match(_PI):
            return math.pi
        if number := self._match(_NUMBER):
            return _finite(float(number))
        raise NumberError(f"expected a number{self._here()}")

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

    def _here(self) -> str:
        word = _WORD.match(self.text, self.at)
        rest = word.group() if word else self.text[self.at : self.at + 1]
        return f" before {rest!r}" if rest else " at the end"


def _power(base: float, exponent: float) -> float:
    try:
        return _finite(math.pow(base, exponent))
    except OverflowError:
        raise NumberError("too large for a number") from None
    except ValueError:
        raise NumberError(f"{base:g}**{exponent:g} is not a real number") from None


def _finite(value: float) -> float:
    if not math.isfinite(value):
        raise NumberError("too large for a number")
    return value
