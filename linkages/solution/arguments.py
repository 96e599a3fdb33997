"""Arguments that are numbers, checked with their names."""

from __future__ import annotations

import math
from numbers import Real
from typing import Any


def whole_number(name: str, value: Any) -> int:
    """A whole number; 20.0 is one, and NumPy's are.

    Raises
    ------
    TypeError, ValueError
        For what is no number, or no whole one.
    """
    number = real_number(name, value)
    if not (math.isfinite(number) and number == int(number)):
        raise ValueError(f"{name} must be a whole number, found {value!r}")
    return int(number)


def real_number(name: str, value: Any) -> float:
    """A number.

    Raises
    ------
    TypeError
        For what is no number.
    """
    if not isinstance(value, Real) or isinstance(value, bool):
        raise TypeError(f"{name} must be a number, found {value!r}")
    return float(value)
