"""Dual numbers: what components compute from the numbers of a definition, with its derivatives."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from typing import Any

from linkages.operations import ELEMENTARY

Slopes = Mapping[int, float]
"""Number of a direction → derivative along it; what does not depend on one has no entry."""


class Dual:
    """A number with its derivatives along some directions.

    It is no ``float`` and cannot be made one, so that nothing takes a derivative away in silence.
    It counts as true: a zero that somebody asks about is there.

    Parameters
    ----------
    value
        In SI.
    slopes
        Its derivatives.
    """

    __slots__ = ("slopes", "value")

    def __init__(self, value: float, slopes: Slopes) -> None:
        self.value, self.slopes = value, slopes

    def __repr__(self) -> str:
        return f"Dual({self.value!r}, {dict(self.slopes)!r})"

    def __add__(self, other: Any) -> Dual:
        return _applied("add", self, other)

    def __radd__(self, other: Any) -> Dual:
        return _applied("add", other, self)

    def __sub__(self, other: Any) -> Dual:
        return _applied("sub", self, other)

    def __rsub__(self, other: Any) -> Dual:
        return _applied("sub", other, self)

    def __mul__(self, other: Any) -> Dual:
        return _applied("mul", self, other)

    def __rmul__(self, other: Any) -> Dual:
        return _applied("mul", other, self)

    def __truediv__(self, other: Any) -> Dual:
        return _applied("div", self, other)

    def __rtruediv__(self, other: Any) -> Dual:
        return _applied("div", other, self)

    def __pow__(self, exponent: Any) -> Dual:
        if isinstance(exponent, Dual):
            return (exponent * self.log()).exp()
        slope = exponent * self.value ** (exponent - 1) if exponent else 0.0
        return Dual(self.value**exponent, _scaled(self.slopes, slope))

    def __rpow__(self, base: Any) -> Dual:
        return (self * ELEMENTARY["log"].value(base)).exp()

    def __neg__(self) -> Dual:
        return _applied("neg", self)

    def __pos__(self) -> Dual:
        return self

    def __abs__(self) -> Dual:
        return self if self.value >= 0.0 else -self

    def __bool__(self) -> bool:
        return True

    def __hash__(self) -> int:
        return hash(self.value)

    def __eq__(self, other: object) -> bool:
        return bool(self.value == _value(other))

    def __lt__(self, other: Any) -> bool:
        return _compared(operator.lt, self, other)

    def __le__(self, other: Any) -> bool:
        return _compared(operator.le, self, other)

    def __gt__(self, other: Any) -> bool:
        return _compared(operator.gt, self, other)

    def __ge__(self, other: Any) -> bool:
        return _compared(operator.ge, self, other)

    def sqrt(self) -> Dual:
        """The square root."""
        return _applied("sqrt", self)

    def exp(self) -> Dual:
        """The exponential."""
        return _applied("exp", self)

    def log(self) -> Dual:
        """The natural logarithm."""
        return _applied("log", self)

    def sin(self) -> Dual:
        """The sine."""
        return _applied("sin", self)

    def cos(self) -> Dual:
        """The cosine."""
        return _applied("cos", self)

    def atan2(self, other: Any) -> Dual:
        """The angle of a direction, of which this is y and the other x."""
        return _applied("atan2", self, other)


def _value(number: Any) -> Any:
    return number.value if isinstance(number, Dual) else number


def _compared(compare: Callable[[Any, Any], bool], one: Dual, other: Any) -> bool:
    return compare(one.value, _value(other))


def _scaled(slopes: Slopes, factor: float) -> dict[int, float]:
    return {k: factor * slope for k, slope in slopes.items()}


def _plain(name: str, *operands: float) -> float:
    return float(ELEMENTARY[name].value(*operands))


def _applied(name: str, *operands: Any) -> Dual:
    """An elementary operation by its row: the chain rule over its partial derivatives."""
    row, values = ELEMENTARY[name], [_value(operand) for operand in operands]
    value = float(row.value(*values))
    slopes: dict[int, float] = {}
    for operand, partial in zip(operands, row.partials(_plain, value, *values), strict=True):
        if isinstance(operand, Dual):
            for k, slope in _scaled(operand.slopes, partial).items():
                slopes[k] = slopes.get(k, 0.0) + slope
    return Dual(value, slopes)
