"""Poincaré sections: value against rate of each free coordinate, a dot for each point."""

from __future__ import annotations

from collections.abc import Sequence
from string import ascii_uppercase
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.plots.chaos.zooms import Zoom, coordinate_of, zoom_panels
from linkages.plots.motion.curves import show_steady
from linkages.plots.motion.free_axes import Free, free_coordinates, show_output, values_of
from linkages.plots.style import PALETTE, diagrams, fitted, styled, title

if TYPE_CHECKING:
    import xarray as xr

SIZES = ((60, 4.0), (600, 2.4), (3000, 1.5), (20_000, 0.9))
SMALLEST = 0.5
FAINT = ((3000, 1.0), (20_000, 0.5))
FAINTEST = 0.3
"""Opacity of dots up to so many points: what is dense looks dense."""


@styled
def figure(data: xr.Dataset, zooms: Sequence[Zoom] = ()) -> Figure | None:
    """One panel for each free coordinate; None for data without points.

    Parameters
    ----------
    data
        As `linkages.poincare` returns it.
    zooms
        Rectangles that are drawn once more below, two in a row; with any of them, only the free
        coordinates that they belong to are drawn.

    Raises
    ------
    ValueError
        For rectangles of no free coordinate, or of several.
    """
    found = free_coordinates(data)
    if not found or not data.sizes["crossing"]:
        return None
    if zooms:
        named = {free.name: free for free in found}
        return _zoomed(data, named[coordinate_of(zooms, list(named))], zooms)
    result, axes = diagrams(len(found))
    for ax, coordinate in zip(axes, found, strict=True):
        draw(ax, data, coordinate, _heading(data, len(found)))
    return result


def _heading(data: xr.Dataset, panels: int) -> str:
    return str(data.attrs.get("name", "")) if panels == 1 else ""


def _zoomed(data: xr.Dataset, coordinate: Free, zooms: Sequence[Zoom]) -> Figure:
    """A panel with all points, and the rectangles below it."""
    result, main, others = zoom_panels(len(zooms))
    draw(main, data, coordinate, str(data.attrs.get("name", "")))
    for ax, letter, zoom in zip(others, ascii_uppercase, zooms, strict=False):
        draw(ax, data, coordinate, zoom=zoom)
        zoom.frame(main, letter)
        ax.set_title(letter)
    return result


def draw(
    ax: Axes, data: xr.Dataset, coordinate: Free, heading: str = "", zoom: Zoom | None = None
) -> Axes:
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
    zoom
        The part of the plane that is drawn.
    """
    x = values_of(data, coordinate, coordinate.value)
    y = values_of(data, coordinate, coordinate.rate)
    factor = show_output(ax, "y", data, coordinate.rate, y)
    along = show_output(ax, "x", data, coordinate.value, x)
    x, y = along * x, factor * y
    if zoom is not None:
        x, y = zoom.inside(x, y)
    ax.plot(
        x, y, "o", color=PALETTE[0], markersize=marker_size(len(x)), markeredgewidth=0, zorder=3,
        alpha=next((opacity for most, opacity in FAINT if len(x) <= most), FAINTEST),
        rasterized=len(x) > FAINT[0][0],
    )  # fmt: skip
    if zoom is None:
        show_steady(ax, y)
        _show_point(ax, x, y)
    else:
        zoom.limit(ax)
    count = f"{len(x):,} point{'' if len(x) == 1 else 's'}"
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
