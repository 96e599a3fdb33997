"""Poincaré sections: value against rate of each free coordinate, a dot for each point."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.plots.motion.curves import show_steady
from linkages.plots.motion.free_axes import Free, free_coordinates, show_output, values_of
from linkages.plots.style import PALETTE, diagrams, fitted, styled, title

if TYPE_CHECKING:
    import xarray as xr

SIZES = ((60, 4.0), (600, 2.4), (3000, 1.5))
SMALLEST = 0.9
MANY, FAINT = 3000, 0.5
"""Points beyond which dots are faint, so that what is dense looks dense; their opacity."""


@styled
def figure(data: xr.Dataset) -> Figure | None:
    """One panel for each free coordinate; None for data without points.

    Parameters
    ----------
    data
        As `linkages.poincare` returns it.
    """
    found = free_coordinates(data)
    if not found or not data.sizes["crossing"]:
        return None
    result, axes = diagrams(len(found))
    for ax, coordinate in zip(axes, found, strict=True):
        draw(ax, data, coordinate, str(data.attrs.get("name", "")) if len(found) == 1 else "")
    return result


def draw(ax: Axes, data: xr.Dataset, coordinate: Free, heading: str = "") -> Axes:
    """Draw the points of one free coordinate.

    Parameters
    ----------
    ax
        Where to draw.
    data
        With dimension ``crossing``.
    coordinate
        What to draw.
    heading
        Stands before its name in the title.
    """
    x = values_of(data, coordinate, coordinate.value)
    y = values_of(data, coordinate, coordinate.rate)
    factor = show_output(ax, "y", data, coordinate.rate, y)
    along = show_output(ax, "x", data, coordinate.value, x)
    size = marker_size(len(x))
    ax.plot(
        along * x, factor * y, "o", color=PALETTE[0], markersize=size, markeredgewidth=0, zorder=3,
        alpha=FAINT if len(x) > MANY else 1.0,
    )  # fmt: skip
    show_steady(ax, factor * y)
    _show_point(ax, along * x, factor * y)
    count = f"{len(x)} point{'' if len(x) == 1 else 's'}"
    ax.set_title(count, loc="right", fontsize=8, color="0.35")
    ax.set_title(fitted(title(heading, coordinate.name), ax.bbox.width / ax.figure.dpi - 0.9))
    return ax


def marker_size(count: int) -> float:
    """Smaller dots for more points."""
    return next((size for most, size in SIZES if count <= most), SMALLEST)


def _show_point(ax: Axes, x: np.ndarray, y: np.ndarray) -> None:
    """Points that coincide but for round-off are one: no axis a billionth wide."""
    for values, limit in ((x, ax.set_xlim), (y, ax.set_ylim)):
        middle, span = float(np.nanmean(values)), float(np.nanmax(values) - np.nanmin(values))
        if span < 1e-6 * max(1.0, abs(middle)):
            reach = 0.1 * max(1.0, abs(middle))
            limit(middle - reach, middle + reach)
