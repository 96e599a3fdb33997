"""Axes of angles: in degrees, with ticks at customary ones."""

from __future__ import annotations

from math import ceil

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import XAxis, YAxis
from matplotlib.ticker import MultipleLocator
from numpy.typing import ArrayLike

NEARLY_ALL = 240.0
"""Degrees; angles within a turn that fill more of it get the whole turn."""

SMALL = 2.0
"""Degrees; a smaller range has ticks like any other number."""

ROOM = {"x": 0.55, "y": 0.3}
"""Inches that a label needs along an axis."""

_STEPS = (1, 2, 5, 10, 15, 30, 45, 90, 180)


def show_degrees(ax: Axes, degrees: ArrayLike, along: str = "x") -> None:
    """Limits and ticks of an axis of angles.

    Parameters
    ----------
    ax
        Where the angles are drawn.
    degrees
        As drawn; what is not finite is passed over.
    along
        ``"x"`` or ``"y"``.
    """
    axis: XAxis | YAxis = ax.xaxis if along == "x" else ax.yaxis
    array = np.asarray(degrees, dtype=float)
    finite = array[np.isfinite(array)]
    span = float(np.ptp(finite)) if finite.size else 0.0
    if span > NEARLY_ALL and np.abs(finite).max() <= 180.0 + 1e-9:
        (ax.set_xlim if along == "x" else ax.set_ylim)(-180.0, 180.0)
        span = 360.0
    if span <= SMALL:
        return
    inches = (ax.bbox.width if along == "x" else ax.bbox.height) / ax.figure.dpi
    most = inches / ROOM[along] + 1e-9  # labels that fit; panels of one height must agree
    turns = 360 * ceil(span / most / 360)
    axis.set_major_locator(MultipleLocator(next((s for s in _STEPS if span <= most * s), turns)))
