"""Dual numbers: values of a definition with their derivatives."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from linkages.operations import COMPOSITE, ELEMENTARY


def _operator(name: str, swapped: bool = False) -> Callable[[Any, Any], Any]:
    """A method that applies an operation to a number and another one on its right, or its left."""
    if swapped:
        return lambda self, other: self.applied(name, other, self)
    return lambda self, other: self.applied(name, self, other)


def _function(name: str) -> Callable[[Any], Any]:
    """A method that applies a function; arrays of such numbers look for it."""
    return lambda self: self.applied(name, self)


class FollowedNumber(ABC):
    """A number of which is recorded what becomes of it.

    It is no ``float`` and cannot be made one, so that no record is lost in silence. It counts as
    true, even if it is zero.
    """

    __slots__ = ("value",)

    value: float

    @classmethod
    @abstractmethod
    def applied(cls, name: str, *operands: Any) -> Self:
        """An elementary operation by its name, on such numbers and floats."""

    @classmethod
    def at_least(cls, one: Any, other: Any) -> bool:
        """Whether a number is at least as large as another: what all comparisons ask."""
        return bool(value_of(one) >= value_of(other))

    __add__, __radd__ = _operator("add"), _operator("add", swapped=True)
    __sub__, __rsub__ = _operator("sub"), _operator("sub", swapped=True)
    __mul__, __rmul__ = _operator("mul"), _operator("mul", swapped=True)
    __truediv__, __rtruediv__ = _operator("div"), _operator("div", swapped=True)
    atan2 = _operator("atan2")
    __neg__ = _function("neg")
    sqrt, exp, log, sin, cos = map(_function, ("sqrt", "exp", "log", "sin", "cos"))

    def __pow__(self, exponent: Any) -> Self:
        if isinstance(exponent, FollowedNumber):
            return (exponent * self.log()).exp()
        return self.raised(exponent)

    @abstractmethod
    def raised(self, exponent: float) -> Self:
        """A power with a plain number as its exponent."""

    def __rpow__(self, base: Any) -> Self:
        return (self * ELEMENTARY["log"].value(base)).exp()

    def __pos__(self) -> Self:
        return self

    def __abs__(self) -> Self:
        return self if self >= 0.0 else -self

    def __bool__(self) -> bool:
        return True

    def __hash__(self) -> int:
        return hash(self.value)

    def __eq__(self, other: object) -> bool:
        return bool(self.value == value_of(other))

    def __lt__(self, other: Any) -> bool:
        return not self.at_least(self, other)

    def __le__(self, other: Any) -> bool:
        return self.at_least(other, self)

    def __gt__(self, other: Any) -> bool:
        return not self.at_least(other, self)

    def __ge__(self, other: Any) -> bool:
        return self.at_least(self, other)


def value_of(number: Any) -> Any:
    """The value of a followed number; others are their own."""
    return number.value if isinstance(number, FollowedNumber) else number


Slopes = Mapping[int, float]
"""Number of a direction → derivative along it; what does not depend on one has no entry."""


class Dual(FollowedNumber):
    """A number with its derivatives along some directions."""

    __slots__ = ("slopes",)

    def __init__(self, value: float, slopes: Slopes) -> None:
        self.value, self.slopes = value, slopes

    def __repr__(self) -> str:
        return f"Dual({self.value!r}, {dict(self.slopes)!r})"

    @classmethod
    def applied(cls, name: str, *operands: Any) -> Dual:
        """By the row of the operation: the chain rule over its partial derivatives."""
        row, values = ELEMENTARY[name], [value_of(operand) for operand in operands]
        value = float(row.value(*values))
        slopes: dict[int, float] = {}
        partials = row.partials(lambda own, *each: ELEMENTARY[own].value(*each), value, *values)
        for operand, partial in zip(operands, map(float, partials), strict=True):
            if isinstance(operand, Dual):
                for k, slope in _scaled(operand.slopes, partial).items():
                    slopes[k] = slopes.get(k, 0.0) + slope
        return Dual(value, slopes)

    def raised(self, exponent: float) -> Dual:
        """A power with a plain number as its exponent."""
        slope = exponent * self.value ** (exponent - 1) if exponent else 0.0
        return Dual(self.value**exponent, _scaled(self.slopes, slope))


def _scaled(slopes: Slopes, factor: float) -> dict[int, float]:
    return {k: factor * slope for k, slope in slopes.items()}


Floats = NDArray[np.float64]


class Varied(NamedTuple):
    """Values, shape (…), and their derivatives, shape (P, …); None where there are none."""

    value: Floats
    slopes: Floats | None


def filled(found: Varied, count: int) -> Floats:
    """Derivatives by so many numbers, zero where there are none."""
    nothing = np.zeros((count, *np.shape(found.value)))
    return nothing if found.slopes is None else nothing + found.slopes


def applied(name: str, operands: Sequence[Varied | float]) -> Varied:
    """An operation of formulas on values with derivatives."""
    given = [o if isinstance(o, Varied) else Varied(np.array(o), None) for o in operands]
    if name == "power":
        base, exponent = given[0], int(given[1].value)
        slope = exponent * base.value ** (exponent - 1) if exponent else np.zeros(())
        changed = None if base.slopes is None else slope * base.slopes
        return Varied(base.value**exponent, changed)
    if name in COMPOSITE:
        result: Varied = COMPOSITE[name].expanded(lambda own, *each: applied(own, each), *given)
        return result
    if name not in ELEMENTARY:
        raise ValueError(f"no derivative is known of {name!r}")
    values = [operand.value for operand in given]
    value = np.asarray(plain_array(name, *values))
    slopes: Floats | None = None
    if any(operand.slopes is not None for operand in given):
        partials = ELEMENTARY[name].partials(plain_array, value, *values)
        for operand, partial in zip(given, partials, strict=True):
            if operand.slopes is not None:
                part = partial * operand.slopes
                slopes = part if slopes is None else slopes + part
    return Varied(value, slopes)


def plain_array(name: str, *operands: Any) -> Any:
    """An operation of formulas on arrays."""
    if name not in ELEMENTARY:
        return COMPOSITE[name].expanded(plain_array, *operands)
    function = ELEMENTARY[name].numpy
    return (getattr(np, function) if isinstance(function, str) else function)(*operands)
