"""Dual numbers: what components compute from the numbers of a definition, with its derivatives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from linkages.design.sensitivity.followed import FollowedNumber, value_of
from linkages.operations import ELEMENTARY

Slopes = Mapping[int, float]
"""Number of a direction → derivative along it; what does not depend on one has no entry."""


class Dual(FollowedNumber):
    """A number with its derivatives along some directions.

    Parameters
    ----------
    value
        In SI.
    slopes
        Its derivatives.
    """

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
        for operand, partial in zip(operands, row.partials(_plain, value, *values), strict=True):
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


def _plain(name: str, *operands: float) -> float:
    return float(ELEMENTARY[name].value(*operands))
