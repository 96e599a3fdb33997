"""Functions as trees of operations: what laws of drives and loads consist of.

Those of drives are functions of time; a load's may depend on what it is measured along as well.

They are data. Kernels and symbolic equations translate them node by node, so that text of a
definition file never becomes code; their numbers are parameters like all others.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

from linkages.components.contributed.interpolation import Interpolation
from linkages.components.contributed.terms import Parameter, Path


class Arithmetic:
    """Python's operators make operations of functions; plain numbers in them are constants."""

    def __add__(self, other: Function | float) -> Operation:
        return applied("add", self, other)

    def __radd__(self, other: float) -> Operation:
        return applied("add", other, self)

    def __sub__(self, other: Function | float) -> Operation:
        return applied("sub", self, other)

    def __rsub__(self, other: float) -> Operation:
        return applied("sub", other, self)

    def __mul__(self, other: Function | float) -> Operation:
        return applied("mul", self, other)

    def __rmul__(self, other: float) -> Operation:
        return applied("mul", other, self)

    def __truediv__(self, other: Function | float) -> Operation:
        return applied("div", self, other)

    def __pow__(self, exponent: int) -> Operation:
        return applied("power", self, exponent)


@dataclass(frozen=True)
class Number(Arithmetic):
    """A number of the definition file, or a constant of a formula (then its path is empty)."""

    parameter: Parameter


@dataclass(frozen=True)
class Time(Arithmetic):
    """The time t in seconds."""


@dataclass(frozen=True)
class Measured(Arithmetic):
    """What a load is measured along: its value x (`order` 0; m, rad), or its rate v (`order` 1)."""

    order: int


X, V = Measured(0), Measured(1)


@dataclass(frozen=True)
class Operation(Arithmetic):
    """An elementary operation.

    Parameters
    ----------
    name
        One of `linkages.operations.ELEMENTARY`, or ``"power"`` of a base and a whole exponent (a
        constant).
    arguments
        Its operands.
    """

    name: str
    arguments: tuple[Function, ...]


@dataclass(frozen=True)
class Table(Arithmetic):
    """Cubic polynomials between values at given times.

    See `linkages.components.contributed.interpolation`.

    Before the first and after the last time a periodic table repeats itself, one that is held
    keeps the value that it has there, and any other goes on in a straight line.

    Parameters
    ----------
    path
        Where it stands in the definition file.
    times, values
        Times in seconds, increasing, and the values there.
    periodic
        Whether it repeats; first and last value are then equal.
    interpolation
        ``"linear"``, ``"pchip"`` (one continuous derivative, never outside the values beside it)
        or ``"spline"`` (two continuous derivatives, natural where it is not periodic).
    held
        Whether the first and the last value last beyond the times.
    """

    path: Path
    times: tuple[float, ...]
    values: tuple[float, ...]
    periodic: bool = False
    interpolation: Interpolation = "spline"
    held: bool = False


Function: TypeAlias = Number | Time | Measured | Operation | Table


def constant(value: float) -> Number:
    """A fixed number of a formula, which is part of its structure."""
    return Number(Parameter((), float(value)))


def applied(name: str, *operands: Any) -> Operation:
    """An operation on functions and plain numbers."""
    return Operation(
        name, tuple(constant(o) if isinstance(o, int | float) else o for o in operands)
    )


def linear(start: Parameter, speed: Parameter) -> Function:
    """Return start + speed·t."""
    return Number(start) + Number(speed) * Time()
