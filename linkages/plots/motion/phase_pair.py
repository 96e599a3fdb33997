"""Phase diagrams of any two outputs against each other."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.plots.motion.angles import show_degrees
from linkages.plots.motion.phase import draw_curve
from linkages.plots.motion.phase_curve import wrapped
from linkages.plots.prefixes import scale_of
from linkages.plots.style import PALETTE, fitted, panels, styled
from linkages.solution.values.series import TIME, Series, data_series, find_series

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]


@styled
def figure(data: xr.Dataset, x: str, y: str, *, wrap: bool = True) -> Figure | None:
    """One output against another; None for data without samples.

    Parameters
    ----------
    data
        A solution's data.
    x, y
        What to draw, such as ``"r1.angle"``, ``"slider9.velocity"`` or ``"time"``.
    wrap
        Whether angles are taken within half a turn either way.

    Raises
    ------
    ValueError
        For names that the data do not have.
    """
    known = data_series(data)
    across, up = find_series(known, x), find_series(known, y)
    if not data.sizes["time"]:
        return None
    result, (ax,) = panels(1, 1, 3.6)
    draw(ax, data, across, up, wrap)
    heading = str(data.attrs.get("name", ""))
    ax.set_title(fitted(heading, ax.bbox.width / result.dpi - 0.7))
    return result


def draw(ax: Axes, data: xr.Dataset, x: Series, y: Series, wrap: bool = True) -> Axes:
    """Draw one series against another, angles in degrees; parameters as of `figure`.

    Over time, angles are never taken within one turn.
    """
    across, label_x = _shown(data, x)
    up, label_y = _shown(data, y)
    if TIME in (x.variable, y.variable):
        ax.plot(across, up, color=PALETTE[0], linewidth=1.0)
        ax.margins(x=0.0 if x.variable == TIME else None)
    else:
        if wrap and x.angle:
            across, up = wrapped(np.radians(across), up)
        if wrap and y.angle:
            up, across = wrapped(np.radians(up), across)
        draw_curve(ax, across, up)
    if x.angle:
        show_degrees(ax, across)
    if y.angle:
        show_degrees(ax, up, "y")
    ax.set_xlabel(label_x)
    ax.set_ylabel(label_y)
    return ax


def _shown(data: xr.Dataset, series: Series) -> tuple[Array, str]:
    """Values as they are drawn, and the label of their axis."""
    array = series.of(data)
    values = np.asarray(array, dtype=float)
    words = str(array.attrs.get("long_name", series.variable))
    label = " of ".join([words, *[".".join(series.place.values())][: bool(series.place)]])
    if series.angle:
        return np.degrees(values), f"{label} [°]"
    scale = scale_of(values, str(array.attrs.get("units", "")))
    return values * scale.factor, scale.label(label)
