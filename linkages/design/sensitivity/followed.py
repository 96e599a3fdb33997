"""Numbers that stand for those of a definition while components are carried out once more."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, Self

from linkages.operations import ELEMENTARY


class FollowedNumber(ABC):
    """A number of which is recorded what becomes of it.

    It is no ``float`` and cannot be made one, so that nothing takes the record away in silence.
    It counts as true: a zero that somebody asks about is there.

    Attributes
    ----------
    value
        In SI.
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

    def __add__(self, other: Any) -> Self:
        return self.applied("add", self, other)

    def __radd__(self, other: Any) -> Self:
        return self.applied("add", other, self)

    def __sub__(self, other: Any) -> Self:
        return self.applied("sub", self, other)

    def __rsub__(self, other: Any) -> Self:
        return self.applied("sub", other, self)

    def __mul__(self, other: Any) -> Self:
        return self.applied("mul", self, other)

    def __rmul__(self, other: Any) -> Self:
        return self.applied("mul", other, self)

    def __truediv__(self, other: Any) -> Self:
        return self.applied("div", self, other)

    def __rtruediv__(self, other: Any) -> Self:
        return self.applied("div", other, self)

    def __pow__(self, exponent: Any) -> Self:
        if isinstance(exponent, FollowedNumber):
            return (exponent * self.log()).exp()
        return self.raised(exponent)

    @abstractmethod
    def raised(self, exponent: float) -> Self:
        """A power with a plain number as its exponent."""

    def __rpow__(self, base: Any) -> Self:
        return (self * ELEMENTARY["log"].value(base)).exp()

    def __neg__(self) -> Self:
        return self.applied("neg", self)

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

    def sqrt(self) -> Self:
        """The square root."""
        return self.applied("sqrt", self)

    def exp(self) -> Self:
        """The exponential."""
        return self.applied("exp", self)

    def log(self) -> Self:
        """The natural logarithm."""
        return self.applied("log", self)

    def sin(self) -> Self:
        """The sine."""
        return self.applied("sin", self)

    def cos(self) -> Self:
        """The cosine."""
        return self.applied("cos", self)

    def atan2(self, other: Any) -> Self:
        """The angle of a direction, of which this is y and the other x."""
        return self.applied("atan2", self, other)


def value_of(number: Any) -> Any:
    """The value of a followed number; others are their own."""
    return number.value if isinstance(number, FollowedNumber) else number
