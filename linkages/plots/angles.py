"""Axes of angles in radians, with ticks at multiples of π."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import XAxis, YAxis
from matplotlib.ticker import FuncFormatter, MultipleLocator
from numpy.typing import ArrayLike

SMALL = np.pi / 2
"""Radians; a smaller range is shown in plain numbers."""

NEARLY_ALL = 0.8
"""Of a turn: wrapped angles that fill more of it get the whole turn."""

ROOM = {"x": 0.55, "y": 0.3}
"""Inches that a label needs along an axis."""

_STEPS = (Fraction(1, 8), Fraction(1, 4), Fraction(1, 2), *map(Fraction, (1, 2, 5, 10, 20, 50)))


def multiple_of_pi(value: float) -> str:
    """An angle as text, such as ``−3π/4``; to the nearest eighth of π."""
    part = Fraction(round(8 * value / np.pi), 8)
    if not part:
        return "0"
    sign = "−" if part < 0 else ""
    above, below = abs(part.numerator), part.denominator
    return f"{sign}{'' if above == 1 else above}π{'' if below == 1 else f'/{below}'}"


def show_angles(ax: Axes, along: str, values: ArrayLike, *, wrap: bool = True) -> None:
    """Limits and ticks of an axis of angles.

    Parameters
    ----------
    ax
        Where the values are drawn.
    along
        ``"x"`` or ``"y"``.
    values
        In radians, as drawn.
    wrap
        Whether they are within one turn; if they fill most of it, all of it is shown.
    """
    axis: XAxis | YAxis = ax.xaxis if along == "x" else ax.yaxis
    array = np.asarray(values, dtype=float)
    finite = array[np.isfinite(array)]
    span = float(np.ptp(finite)) if finite.size else 0.0
    whole = wrap and span > NEARLY_ALL * 2 * np.pi
    if whole:
        (ax.set_xlim if along == "x" else ax.set_ylim)(-np.pi, np.pi)
        span = 2 * np.pi
    if span < SMALL:
        return
    inches = (ax.bbox.width if along == "x" else ax.bbox.height) / ax.figure.dpi
    steps = (s for s in _STEPS if span <= inches / ROOM[along] * float(s) * np.pi)
    step = next(steps, Fraction(round(span / np.pi / 5)))
    axis.set_major_locator(MultipleLocator(float(step) * np.pi))
    axis.set_major_formatter(FuncFormatter(lambda value, _: multiple_of_pi(value)))
