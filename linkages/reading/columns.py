"""A number with many values at once, which goes through a definition as one number does."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NoReturn, TypeAlias

if TYPE_CHECKING:  # numbers of a definition are read without NumPy
    import numpy as np
    from numpy.typing import NDArray

    Floats: TypeAlias = NDArray[np.float64]


class UndecidedError(ValueError):
    """What is asked of a column has no answer that all of its values share."""


class Column:
    """Values of one number, each treated as it would be alone, the same in all bits.

    Arithmetic is NumPy's. Comparisons are answered where all values agree. Whatever takes a column
    for a single number is refused with `UndecidedError` or `TypeError`: nothing is lost in silence.

    Parameters
    ----------
    values
        Shape (n,).
    """

    __array_ufunc__ = None
    __hash__ = object.__hash__

    def __init__(self, values: Floats) -> None:
        self.values = values

    def _with(self, operation: Callable[..., Floats], *operands: Any) -> Any:
        if not all(isinstance(each, Column | int | float) for each in operands):
            return NotImplemented
        return Column(operation(*map(values_of, operands)))

    def __add__(self, other: Any) -> Any:
        return self._with(operator.add, self, other)

    def __radd__(self, other: Any) -> Any:
        return self._with(operator.add, other, self)

    def __sub__(self, other: Any) -> Any:
        return self._with(operator.sub, self, other)

    def __rsub__(self, other: Any) -> Any:
        return self._with(operator.sub, other, self)

    def __mul__(self, other: Any) -> Any:
        return self._with(operator.mul, self, other)

    def __rmul__(self, other: Any) -> Any:
        return self._with(operator.mul, other, self)

    def __truediv__(self, other: Any) -> Any:
        return self._with(operator.truediv, self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return self._with(operator.truediv, other, self)

    def __neg__(self) -> Column:
        return Column(-self.values)

    def __abs__(self) -> Column:
        return Column(abs(self.values))

    def __round__(self) -> Column:
        return Column(self.values.round())

    def _decided(self, other: Any, comparison: Callable[..., Any]) -> Any:
        if not isinstance(other, Column | int | float):
            return NotImplemented
        found = comparison(self.values, values_of(other))
        if found.any() and not found.all():
            raise UndecidedError("true of some values and not of others")
        return bool(found.all())

    def __lt__(self, other: Any) -> Any:
        return self._decided(other, operator.lt)

    def __le__(self, other: Any) -> Any:
        return self._decided(other, operator.le)

    def __gt__(self, other: Any) -> Any:
        return self._decided(other, operator.gt)

    def __ge__(self, other: Any) -> Any:
        return self._decided(other, operator.ge)

    def __eq__(self, other: object) -> Any:
        return self._decided(other, operator.eq)

    def __ne__(self, other: object) -> Any:
        return self._decided(other, operator.ne)

    def __bool__(self) -> bool:
        return bool(self != 0.0)

    def __float__(self) -> NoReturn:
        raise UndecidedError("a column is no single number")

    def __array__(self, *_: Any, **__: Any) -> NoReturn:
        raise UndecidedError("a column is no array of numbers")


def values_of(number: Any) -> Any:
    """The values of a column; any other number itself."""
    return number.values if isinstance(number, Column) else number
