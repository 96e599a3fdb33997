"""Polynomials between the values of a table; their coefficients are SciPy's.

References
----------
.. [1] F. N. Fritsch, J. Butland, "A method for constructing local monotone piecewise cubic
   interpolants", *SIAM J. Sci. Stat. Comput.* 5 (1984) 300-304: ``pchip``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

    from linkages.components.functions import Table

Interpolation: TypeAlias = Literal["linear", "pchip", "spline"]

Floats = NDArray[np.float64]


def polynomials(table: Table) -> PPoly:
    """Cubic polynomials between the knots of a table, coefficients of shape (4, intervals).

    One that is held has a constant one more on either side: outside its knots a table that does
    not repeat goes on in straight lines. Numbers that overflow leave coefficients that are not
    finite.
    """
    from scipy.interpolate import PPoly

    times, values = np.array(table.times), np.array(table.values)
    with np.errstate(all="ignore"):
        try:
            coefficients = _COEFFICIENTS[table.interpolation](times, values, table.periodic)
        except ValueError:  # slopes are not finite
            coefficients = np.full((4, len(times) - 1), np.nan)
        span = times[-1] - times[0]
    if table.held and not table.periodic:
        times = np.array([times[0] - span, *times, times[-1] + span])
        ends = np.zeros((2, 4, 1))
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


_COEFFICIENTS = {"linear": _linear, "pchip": _pchip, "spline": _spline}


def extremes(table: Table, begin: float, end: float) -> tuple[float, float]:
    """Least and largest value of a table between two times; of one that repeats, of all times."""
    found = polynomials(table)
    low, high = found.x[0], found.x[-1]
    if table.periodic:
        begin, end = low, high
    with np.errstate(all="ignore"):
        turning = found.derivative().roots(discontinuity=False, extrapolate=False)
        places = np.array([begin, end, *found.x, *turning[np.isfinite(turning)]])
        inside = places[(places >= begin) & (places <= end)]
        values = _values(found, inside)
    return float(values.min()), float(values.max())


def _values(found: PPoly, times: Sequence[float] | Floats) -> Floats:
    """With the straight lines beyond its knots."""
    inner = np.clip(times, found.x[0], found.x[-1])
    return np.asarray(found(inner) + found(inner, 1) * (times - inner))
