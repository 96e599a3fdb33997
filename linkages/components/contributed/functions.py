"""Functions as trees of operations: what laws of drives and loads consist of.

Those of drives are functions of time; a load's may depend on positions and speeds as well.

They are data. Kernels and symbolic equations translate them node by node, so that text of a
definition file never becomes code; their numbers are parameters like all others.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

from linkages.components.contributed.interpolation import Joined
from linkages.components.contributed.terms import Parameter, Path

if TYPE_CHECKING:
    from linkages.components.contributed.measures import Measure


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
    """A measure's value x (`order` 0; m, rad), or its rate v (`order` 1).

    Parameters
    ----------
    order
        0 or 1; laws of contact may also use the rate at which x became positive the last time (2),
        laws of friction the force that presses surfaces together (3).
    measure
        Whose; None for the one that the load itself acts along.
    """

    order: int
    measure: Measure | None = None


X, V, FIRST, PRESSED = Measured(0), Measured(1), Measured(2), Measured(3)


@dataclass(frozen=True)
class Internal(Arithmetic):
    """The value of an internal state of the mechanism, by its name."""

    name: str


@dataclass(frozen=True)
class Operation(Arithmetic):
    """An elementary operation.

    Parameters
    ----------
    name
        One of `linkages.operations.ELEMENTARY` or `COMPOSITE`; ``"power"`` is that of a base and a
        whole exponent (a constant).
    arguments
        Its operands.
    """

    name: str
    arguments: tuple[Function, ...]


TIME = Time()


@dataclass(frozen=True)
class Table(Arithmetic):
    """Cubic polynomials between given values; see `linkages.components.contributed.interpolation`.

    Before the first and after the last place a periodic table repeats itself, one that is held
    keeps the value that it has there, and any other goes on in a straight line.

    Parameters
    ----------
    path
        Where it stands in the definition file.
    places, values
        Places on the axis of what it is a function of, increasing, and the values there.
    periodic
        Whether it repeats; first and last value are then equal.
    interpolation
        ``"linear"``, ``"pchip"`` (one continuous derivative, never outside the values beside it)
        or ``"spline"`` (two continuous derivatives, natural where it is not periodic).
    held
        Whether the first and the last value last beyond the places.
    over
        What it is a function of: time in seconds, or anything else in SI.
    turning
        Whether a turn is a whole number of its periods, so that whole turns do not count.
    """

    path: Path
    places: tuple[float, ...]
    values: tuple[float, ...]
    periodic: bool = False
    interpolation: Joined = "spline"
    held: bool = False
    over: Function = TIME
    turning: bool = False

    @property
    def bends(self) -> Table:
        """The second derivative of a spline, which has a derivative of its own."""
        path = (*self.path, "bends")
        return replace(self, path=path, interpolation="bends", held=True)

    @property
    def corners(self) -> Table | None:
        """A function of the same that is zero where straight lines meet; None without any.

        Its sign alternates. It must repeat with the table, for whole turns of an angle may not
        count, so that the last one of an odd number of lines has a zero in its middle as well.
        """
        if self.interpolation != "linear":
            return None
        places = self.places
        if self.periodic and len(places) % 2 == 0:
            places = (*places[:-1], (places[-2] + places[-1]) / 2, places[-1])
        path, none = (*self.path, "corners"), (0.0,) * len(places)
        return Table(path, places, none, self.periodic, "corners", over=self.over)


Function: TypeAlias = Number | Time | Measured | Internal | Operation | Table


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
