"""Laws with their first two derivatives by time, by truncated Taylor arithmetic.

A jet is (f, f′, f″) at one time. Tables go through SciPy's spline.
"""

import math
from collections.abc import Callable

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator, PPoly

from linkages.components.contributed.functions import (
    Function,
    Measured,
    Number,
    Operation,
    Table,
    Time,
)

Jet = tuple[float, float, float]


def _tangent(x: float) -> Jet:
    return math.tan(x), 1 / math.cos(x) ** 2, 2 * math.tan(x) / math.cos(x) ** 2


def _sign(x: float) -> Jet:
    if x == 0:  # friction holds there
        raise ValueError("sign of zero")
    return math.copysign(1.0, x), 0.0, 0.0


def _hyperbolic_tangent(x: float) -> Jet:
    slope = 1 / math.cosh(x) ** 2
    return math.tanh(x), slope, -2 * math.tanh(x) * slope


def _arcsine(x: float) -> Jet:
    root = math.sqrt(1 - x * x)
    return math.asin(x), 1 / root, x / root**3


def _arccosine(x: float) -> Jet:
    value, slope, bend = _arcsine(x)
    return math.pi / 2 - value, -slope, -bend


ELEMENTARY = {
    "neg": lambda x: (-x, -1.0, 0.0),
    "sin": lambda x: (math.sin(x), math.cos(x), -math.sin(x)),
    "cos": lambda x: (math.cos(x), -math.sin(x), -math.cos(x)),
    "tan": _tangent,
    "asin": _arcsine,
    "acos": _arccosine,
    "sinh": lambda x: (math.sinh(x), math.cosh(x), math.sinh(x)),
    "cosh": lambda x: (math.cosh(x), math.sinh(x), math.cosh(x)),
    "exp": lambda x: (math.exp(x),) * 3,
    "log": lambda x: (math.log(x), 1 / x, -1 / x**2),
    "sqrt": lambda x: (math.sqrt(x), 0.5 / math.sqrt(x), -0.25 / x**1.5),
    "tanh": _hyperbolic_tangent,
    "abs": lambda x: (abs(x), math.copysign(1.0, x), 0.0),
    "sign": _sign,
    "atan": lambda x: (math.atan(x), 1 / (1 + x * x), -2 * x / (1 + x * x) ** 2),
}
"""Name → x ↦ (g, g′, g″)."""


Sense = Callable[[Measured], float]


def _nothing(found: Measured) -> float:
    raise TypeError(f"a function of time senses nothing, found {found}")


def jet(function: Function, time: float, measured: Sense = _nothing) -> Jet:
    """Value and first two derivatives of a function of time; `measured` counts as constant."""
    if isinstance(function, Number):
        return function.parameter.value, 0.0, 0.0
    if isinstance(function, Time):
        return time, 1.0, 0.0
    if isinstance(function, Measured):
        return measured(function), 0.0, 0.0
    if isinstance(function, Table):
        over = jet(function.over, time, measured)
        return _chain(table_jet(function, over[0]), over)
    return _operation(function, time, measured)


def _operation(operation: Operation, time: float, measured: Sense) -> Jet:
    name = operation.name
    if name in ("select", "where"):
        condition, first, second = operation.arguments
        chosen = first if jet(condition, time, measured)[0] >= 0 else second
        return jet(chosen, time, measured)
    first, *others = (jet(argument, time, measured) for argument in operation.arguments)
    if name in ("min", "max"):
        return (min if name == "min" else max)(first, others[0], key=lambda found: found[0])
    if name == "power":
        return _chain(_power(first[0], others[0][0]), first)
    if name == "mul":
        return _product(first, others[0])
    if name == "div":
        x = others[0][0]
        return _product(first, _chain((1 / x, -1 / x / x, 2 / x / x / x), others[0]))
    if name == "atan2":  # of measures alone
        return math.atan2(first[0], others[0][0]), 0.0, 0.0
    if name in ("add", "sub"):
        sign = 1 if name == "add" else -1
        return tuple(a + sign * b for a, b in zip(first, others[0], strict=True))
    return _chain(ELEMENTARY[name](first[0]), first)


def _power(x: float, n: float) -> Jet:
    def term(factor: float, exponent: float) -> float:
        return factor * x**exponent if factor else 0.0

    return x**n, term(n, n - 1), term(n * (n - 1), n - 2)


def _product(a: Jet, b: Jet) -> Jet:
    return a[0] * b[0], a[1] * b[0] + a[0] * b[1], a[2] * b[0] + 2 * a[1] * b[1] + a[0] * b[2]


def _chain(outer: Jet, inner: Jet) -> Jet:
    return outer[0], outer[1] * inner[1], outer[2] * inner[1] ** 2 + outer[1] * inner[2]


def table_jet(table: Table, time: float) -> Jet:
    """Value of a table at a place, and its first two derivatives."""
    times, values = np.array(table.places), np.array(table.values)
    inside = time
    if not table.periodic:
        inside = min(max(time, table.places[0]), table.places[-1])
        if table.held and inside != time:
            return float(np.interp(time, times, values)), 0.0, 0.0
    value, slope, bend = (float(_joined(table, times, values)(inside, o)) for o in range(3))
    if inside != time:
        return value + slope * (time - inside), slope, 0.0
    return value, slope, bend


def _joined(table: Table, times: np.ndarray, values: np.ndarray) -> PPoly:
    """SciPy's interpolant; of a periodic one, three periods side by side."""
    if table.interpolation == "spline":
        ends = "periodic" if table.periodic else "natural"
        return CubicSpline(times, values, bc_type=ends)
    if table.periodic:
        span = times[-1] - times[0]
        times = np.concatenate([times[:-1] - span, times, times[1:] + span])
        values = np.concatenate([values[:-1], values, values[1:]])
    if table.interpolation == "pchip":
        return PchipInterpolator(times, values)
    return PPoly(np.array([np.diff(values) / np.diff(times), values[:-1]]), times)
