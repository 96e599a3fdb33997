"""Laws of loads as straight lines: stiffness, damping, and a constant."""

from __future__ import annotations

from typing import NamedTuple, assert_never

from linkages.components.contributed.functions import (
    Function,
    Internal,
    Measured,
    Number,
    Operation,
    Table,
    Time,
)
from linkages.components.contributed.measures import Load
from linkages.operations import value_of

_PROBES = ((0.3, -0.7, 0.2), (-1.1, 0.4, 1.7), (2.3, 1.9, 5.1), (0.05, 0.01, 0.9))
_ROUND_OFF = 1e-12


class Line(NamedTuple):
    """A force c − k·x − d·v."""

    constant: float
    stiffness: float
    damping: float


def line_of(load: Load) -> Line | None:
    """The law of a load if it is a line in its own measure and rate, without time."""
    try:
        constant = _value(load.force, 0.0, 0.0, 0.0)
        slope = _value(load.force, 1.0, 0.0, 0.0) - constant
        rate = _value(load.force, 0.0, 1.0, 0.0) - constant
        for x, v, t in _PROBES:
            found, line = _value(load.force, x, v, t), constant + slope * x + rate * v
            size = abs(constant) + abs(slope * x) + abs(rate * v)
            if abs(found - line) > _ROUND_OFF * size:
                return None
    except (ArithmeticError, ValueError):  # no value there: no line
        return None
    return Line(constant, -slope, -rate)


def _value(law: Function, x: float, v: float, t: float) -> float:
    match law:
        case Number(parameter):
            return float(parameter.value)
        case Time():
            return t
        case Measured(order, None) if order < 2:
            return v if order else x
        case Measured() | Internal() | Table():
            raise ValueError("depends on more than x, v and t")
        case Operation(name, arguments):
            return value_of(name, *(_value(argument, x, v, t) for argument in arguments))
    assert_never(law)
