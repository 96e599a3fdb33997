"""Polar diagrams: the way of the tip of a vector, as drawn in machine design for bearings."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.motion.curves import BUSY
from linkages.plots.motion.time_figures import at_pins
from linkages.plots.prefixes import scale_of
from linkages.plots.style import BLACK, PALETTE, fitted, panels, styled, title
from linkages.solution.resolved import turning_points

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

POLAR = ("joint_reaction", "shaking_force")
"""Vectors whose direction matters as much as their size."""

SQUARE, SMALL = 4.0, 2.34
"""Inches: of a diagram that stands alone, and of one of two in a row."""

HEADROOM = 0.34
MOST = 12
"""Diagrams in one figure."""


def polar_figure(variable: str) -> Callable[[xr.Dataset, Mechanism], Figure | None]:
    """The function that makes polar diagrams of a vector, one for each joint; None without data."""

    @styled
    def figure_of(data: xr.Dataset, mechanism: Mechanism) -> Figure | None:
        if variable not in data or not data[variable].size:
            return None
        data = at_pins(data, variable=variable)
        names = vectors(data, variable)[:MOST]
        return None if not names else polar_page(data, variable, names, mechanism.name)

    return figure_of


def vectors(data: xr.Dataset, variable: str) -> list[str]:
    """Elements whose vector is not zero all the time, nor the same as that of an earlier one."""
    array = data[variable].transpose("time", ..., "axis")
    sizes = np.abs(np.asarray(array, dtype=float)).max(axis=(0, 2), initial=0.0)
    return [str(n) for n, size in zip(data[array.dims[1]].values, sizes, strict=True) if size > 0]


def polar_page(data: xr.Dataset, variable: str, names: list[str], heading: str = "") -> Figure:
    """A figure with a diagram for each of some elements."""
    columns = min(2, len(names))
    height = SQUARE if columns == 1 else SMALL
    figure, axes = panels(-(-len(names) // columns), columns, height, HEADROOM)
    for ax, name in zip(axes, names, strict=False):
        draw_polar(ax, data, variable, name, heading if len(names) == 1 else "")
    for ax in axes[len(names) :]:
        ax.remove()
    return figure


def draw_polar(ax: Axes, data: xr.Dataset, variable: str, name: str, heading: str = "") -> Axes:
    """Draw the tip of a vector around zero, with equal scales.

    Parameters
    ----------
    ax
        Where to draw.
    data
        SI units.
    variable, name
        A vector, and the element that it is of.
    heading
        Stands before the name in the title.

    Returns
    -------
    Axes
        `ax`. A ring marks the start, a full dot the largest size.
    """
    array = data[variable].transpose("time", ..., "axis")
    tip = np.asarray(array.sel({str(array.dims[1]): name}), dtype=float)
    scale = scale_of(tip, str(array.attrs.get("units", "")))
    x, y = scale.factor * tip.T
    thin = turning_points(x) > BUSY
    ax.plot(x, y, color=PALETTE[0], linewidth=0.5 if thin else 1.1, alpha=0.7 if thin else 1.0)
    ax.plot([0], [0], "+", color=BLACK, markersize=7, zorder=3)
    ax.plot(x[:1], y[:1], "o", markersize=5, markerfacecolor="white", color=PALETTE[1], zorder=4)
    sizes = np.hypot(x, y)
    if np.isfinite(sizes).any():
        at = int(np.nanargmax(sizes))
        ax.plot([0, x[at]], [0, y[at]], color=PALETTE[1], linewidth=0.8, zorder=3)
        ax.plot(x[at], y[at], "o", markersize=4, color=PALETTE[1], zorder=4)
        most, _ = array.attrs.get("farthest", {}).get(name, (float(sizes[at]) / scale.factor, 0.0))
        said = f"{name}, up to {scale.text(most)}"
    else:
        said = name
    words = str(array.attrs.get("long_name", variable.replace("_", " ")))
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.12)
    ax.set_xlabel(scale.label(f"{words}, x"))
    ax.set_ylabel(scale.label("y"))
    ax.set_title(fitted(title(heading, said), ax.bbox.width / ax.figure.dpi))
    return ax
