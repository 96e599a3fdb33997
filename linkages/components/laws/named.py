"""What every named law is, and the operations that their functions of time are built from."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, TypeVar

from linkages.components.functions import Function, Number, Operation, Time, constant
from linkages.components.terms import Parameter, Path

Value = TypeVar("Value")
Rate = TypeVar("Rate")
"""What a law gives, and its rate: quantities of a dimension that the field of the law fixes."""

NOTHING: Any = 0.0
"""The default of a quantity, whatever it measures."""

TIME = Time()


class NamedLaw(ABC):
    """A law that a mapping of the definition file describes."""

    @abstractmethod
    def function(self, path: Path) -> Function:
        """Return the function of time; `path` is where the mapping stands."""


def argument(path: Path, key: str, value: float, structural: bool = False) -> Number:
    """A number of the definition file."""
    return Number(Parameter((*path, key), value, structural))


def fixed(value: float) -> Number:
    """A number that belongs to the law itself."""
    return constant(float(value))


def plus(*summands: Function) -> Function:
    """The sum."""
    return _chain("add", summands)


def times(*factors: Function) -> Function:
    """The product."""
    return _chain("mul", factors)


def minus(first: Function, second: Function) -> Function:
    """The difference."""
    return Operation("sub", (first, second))


def over(first: Function, second: Function) -> Function:
    """The quotient."""
    return Operation("div", (first, second))


def sine(angle: Function) -> Function:
    """The sine."""
    return Operation("sin", (angle,))


def power(base: Function, exponent: int) -> Function:
    """A whole power."""
    return Operation("power", (base, fixed(exponent)))


def where(condition: Function, first: Function, second: Function) -> Function:
    """The first where the condition is ≥ 0, otherwise the second."""
    return Operation("select", (condition, first, second))


def _chain(name: str, arguments: tuple[Function, ...]) -> Function:
    result, *others = arguments
    for other in others:
        result = Operation(name, (result, other))
    return result
