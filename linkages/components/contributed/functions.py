"""Functions as expression trees, and interpolated tables.

References
----------
.. [1] F. N. Fritsch, J. Butland, "A method for constructing local monotone piecewise cubic
   interpolants", *SIAM J. Sci. Stat. Comput.* 5 (1984) 300-304: ``pchip``.

Those of drives are functions of time; a load's may depend on positions and speeds as well.

They are data. Kernels and symbolic equations translate them node by node, so that text of a
definition file never becomes code; their numbers are parameters like all others.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import Parameter
from linkages.operations import ELEMENTARY
from linkages.reading.paths import KeyPath

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

    from linkages.components.contributed.load_measures import Measure

Interpolation: TypeAlias = Literal["linear", "pchip", "spline"]

Joined: TypeAlias = Interpolation | Literal["corners", "bends"]
"""What joins values, what is zero at corners of straight lines, and how a spline bends."""

Floats = NDArray[np.float64]


def polynomials(table: Table) -> PPoly:
    """Cubic polynomials between the knots of a table, coefficients of shape (4, intervals).

    One that is held has a constant one more on either side: outside its knots a table that does
    not repeat goes on in straight lines. Numbers that overflow leave coefficients that are not
    finite.
    """
    from scipy.interpolate import PPoly

    times, values = np.array(table.places), np.array(table.values)
    with np.errstate(all="ignore"):
        try:
            coefficients = _COEFFICIENTS[table.interpolation](times, values, table.periodic)
        except ValueError:  # slopes are not finite
            coefficients = np.full((4, len(times) - 1), np.nan)
        span = times[-1] - times[0]
    if table.held and not table.periodic:
        times = np.array([times[0] - span, *times, times[-1] + span])
        ends = np.zeros((2, 4, 1))
        if table.interpolation != "bends":  # a natural spline goes on in straight lines
            ends[:, 3, 0] = values[0], values[-1]
        coefficients = np.hstack([ends[0], coefficients, ends[1]])
    return PPoly.construct_fast(coefficients, times)


def _linear(times: Floats, values: Floats, periodic: bool) -> Floats:  # noqa: ARG001
    zero = np.zeros(len(times) - 1)
    return np.array([zero, zero, np.diff(values) / np.diff(times), values[:-1]])


def _pchip(times: Floats, values: Floats, periodic: bool) -> Floats:
    """Monotone between values [1]_; slopes at a seam are those of any other place."""
    from scipy.interpolate import PchipInterpolator

    if not periodic:
        return np.asarray(PchipInterpolator(times, values).c)
    before, after = times[0] - (times[-1] - times[-2]), times[-1] + (times[1] - times[0])
    around = PchipInterpolator([before, *times, after], [values[-2], *values, values[1]])
    return np.asarray(around.c[:, 1:-1])


def _spline(times: Floats, values: Floats, periodic: bool) -> Floats:
    """Two continuous derivatives; without a seam the second one is zero at both ends."""
    from scipy.interpolate import CubicSpline

    ends = "periodic" if periodic else "natural"
    return np.asarray(CubicSpline(times, values, bc_type=ends).c)


def _corners(places: Floats, values: Floats, periodic: bool) -> Floats:  # noqa: ARG001
    """Parabolas of alternating sign that are zero, with a slope of ±1, where straight lines meet.

    With one continuous derivative: a crossing of zero is a corner, and nothing else is.
    """
    lengths = np.diff(places)
    signs = (-1.0) ** np.arange(len(lengths))
    zero = np.zeros(len(lengths))
    return np.array([zero, -signs / lengths, signs, zero])


def _bends(times: Floats, values: Floats, periodic: bool) -> Floats:
    """The second derivative of a spline: straight lines."""
    cubic, square, *_ = _spline(times, values, periodic)
    zero = np.zeros_like(cubic)
    return np.array([zero, zero, 6.0 * cubic, 2.0 * square])


_COEFFICIENTS = {
    "linear": _linear,
    "pchip": _pchip,
    "spline": _spline,
    "corners": _corners,
    "bends": _bends,
}


def unpaired(points: Mapping[str, Sequence[Any]], least: str) -> tuple[str, str] | None:
    """What is wrong with points of a table, and with which of both; None if nothing is.

    `points`: names of places and of values → both, at `least` so many of them, in words or digits.
    """
    (at, places), (of, values) = points.items()
    if len(places) < ({"two": 2, "three": 3}.get(least) or int(least)):
        return at, f"expected at least {least} {at}, found {len(places)}"
    if len(values) != len(places):
        counts = f"{len(places)} {at} and {len(values)} {of}"
        return of, f"expected as many {of} as {at}, found {counts}"
    for before, after in pairwise(places):
        if after <= before:
            return at, f"expected increasing {at}, found {after:g} after {before:g}"
    return None


def extremes(table: Table, begin: float, end: float) -> tuple[float, float]:
    """Least and largest value of a table between two places; of one that repeats, of all."""
    result = polynomials(table)
    low, high = result.x[0], result.x[-1]
    if table.periodic:
        begin, end = low, high
    with np.errstate(all="ignore"):
        turning = result.derivative().roots(discontinuity=False, extrapolate=False)
        places = np.array([begin, end, *result.x, *turning[np.isfinite(turning)]])
        inside = places[(places >= begin) & (places <= end)]
        values, _, _ = evaluated(result.x, result.c, False, inside)
    return float(values.min()), float(values.max())


def evaluated(
    knots: Floats, coefficients: Floats, periodic: bool, times: Any
) -> tuple[Floats, Floats, Floats]:
    """Value and two derivatives of piecewise cubics, with the straight lines beyond their knots.

    `knots`, `coefficients`: of shapes (intervals + 1,) and (4, intervals), the cubic one first.
    `periodic`: whether they repeat.
    `times`: any shape.
    """
    first, last = knots[0], knots[-1]
    t = np.asarray(times, dtype=float)
    if periodic:
        t = first + np.mod(t - first, last - first)
    inner = np.clip(t, first, last)
    interval = np.clip(np.searchsorted(knots, inner, side="right") - 1, 0, len(knots) - 2)
    outside = t - inner
    value, slope, curvature = cubic(inner - knots[interval], outside, *coefficients[:, interval])
    return value, slope, np.where(outside == 0.0, curvature, 0.0)


def cubic(x: Any, outside: Any, d: Any, c: Any, b: Any, a: Any) -> tuple[Any, Any, Any]:
    """Value, slope and curvature of a + b·x + c·x² + d·x³, and of the straight line beyond its end.

    The one formula of tables: for arrays, and for symbols of which programs are printed. The
    curvature is that within the interval.

    `x`: time since the beginning of the interval, at most its length.
    `outside`: time beyond the end, where the slope stays what it is.
    `d`, `c`, `b`, `a`: coefficients.
    """
    slope = b + x * (2 * c + x * 3 * d)
    value = a + x * (b + x * (c + x * d)) + outside * slope
    return value, slope, 2 * c + 6 * d * x


OF_NUMPY = {each.numpy: name for name, each in ELEMENTARY.items() if isinstance(each.numpy, str)}
OF_NUMPY |= {"absolute": "abs", "maximum": "max", "minimum": "min", "sign": "sign"}
"""Names of NumPy's functions → operations."""


def _operator(name: str, reflected: bool = False) -> Callable[..., Operation]:
    """One of Python's operators on functions and plain numbers."""
    if reflected:
        return lambda self, other: applied(name, other, self)
    return lambda self, *others: applied(name, self, *others)


class Arithmetic:
    """Python's operators and NumPy's functions make operations of functions: ``np.sin(-X)``.

    Plain numbers in them are constants.
    """

    def __array_ufunc__(self, ufunc: Any, method: str, *operands: Any, **options: Any) -> Operation:
        if method != "__call__" or options:
            return NotImplemented
        if ufunc.__name__ not in OF_NUMPY:
            known = ", ".join(sorted(OF_NUMPY))
            raise TypeError(f"laws know no {ufunc.__name__}; expected one of: {known}")
        return applied(OF_NUMPY[ufunc.__name__], *operands)

    __add__, __radd__ = _operator("add"), _operator("add", reflected=True)
    __sub__, __rsub__ = _operator("sub"), _operator("sub", reflected=True)
    __mul__, __rmul__ = _operator("mul"), _operator("mul", reflected=True)
    __truediv__, __rtruediv__ = _operator("div"), _operator("div", reflected=True)
    __pow__, __neg__, __abs__ = map(_operator, ("power", "neg", "abs"))


@dataclass(frozen=True)
class Number(Arithmetic):
    """A number of the definition file, or a constant of a formula (then its path is empty)."""

    parameter: Parameter


@dataclass(frozen=True)
class Time(Arithmetic):
    """The time t in seconds."""


@dataclass(frozen=True)
class Measured(Arithmetic):
    """A measure's value x (`order` 0; m, rad), or its rate v (`order` 1)."""

    # 0 or 1; laws of contact may also use the rate at which x became positive the last time (2),
    # laws of friction the force that presses surfaces together (3)
    order: int
    measure: Measure | None = None  # whose; None for the one that the load itself acts along


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
    """Cubic polynomials between given values; see `linkages.components.contributed.functions`.

    Before the first and after the last place a periodic table repeats itself, one that is held
    keeps the value that it has there, and any other goes on in a straight line.
    """

    path: KeyPath  # where it stands in the definition file
    # Places on the axis of what it is a function of, increasing, and the values there
    places: tuple[float, ...]
    values: tuple[float, ...]
    periodic: bool = False  # whether it repeats; first and last value are then equal
    # "linear", "pchip" (one continuous derivative, never outside the values beside it) or "spline"
    # (two continuous derivatives, natural where it is not periodic)
    interpolation: Joined = "spline"
    held: bool = False  # whether the first and the last value last beyond the places
    over: Function = TIME  # what it is a function of: time in seconds, or anything else in SI
    # Whether a turn is a whole number of its periods, so that whole turns do not count
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
