"""Arithmetic in definition files: ``-1.5*pi``, ``2*pi/3``, ``0.3**2``; never evaluated as code."""

from __future__ import annotations

import math

from linkages.operations import value_of
from linkages.spec.grammar import Builder, NumberError, Span, parsed

__all__ = ["CONSTANTS", "NumberError", "Numbers", "leading_number"]

CONSTANTS = {"pi": math.pi, "π": math.pi}


def leading_number(text: str) -> tuple[float, str]:
    """Return the value of the arithmetic that a text starts with, and the text that follows it.

    Every intermediate result is a finite double, so the work is bounded by the length of the text.

    Raises
    ------
    NumberError
        The text does not start with arithmetic, or a result is not finite.
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
