"""Poincaré sections, their enlarged parts, and impact maps."""

from __future__ import annotations

from collections.abc import Sequence
from string import ascii_uppercase
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from linkages.plots.layout import PAIRED, axes_for, chart, diagram_each, diagrams, mosaic
from linkages.plots.motion.curves import show_steady
from linkages.plots.motion.phase_diagrams import (
    Free,
    Output,
    free_coordinate,
    free_coordinates,
    shown_pair,
    stepped,
)
from linkages.plots.style import PALETTE, name_of, set_title, styled, title
from linkages.reading.wording import listed

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

WHOLE = 3.2  # inches: height of the panel with all points over enlarged parts


class Zoom(NamedTuple):
    """A rectangle in units of the axes, of the free coordinate named, or of the only one."""

    left: float
    right: float
    bottom: float
    top: float
    name: str = ""

    def inside(self, x: Array, y: Array) -> tuple[Array, Array]:
        """The points in it."""
        there = (x >= self.left) & (x <= self.right) & (y >= self.bottom) & (y <= self.top)
        return x[there], y[there]

    def limit(self, ax: Axes) -> None:
        """Make it the limits of axes, with few ticks: their numbers are long."""
        ax.set_xlim(self.left, self.right)
        ax.set_ylim(self.bottom, self.top)
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_locator(MaxNLocator(4, steps=(1, 2, 2.5, 5, 10)))

    def frame(self, ax: Axes, letter: str) -> None:
        """Draw its outline with a letter."""
        width, height = self.right - self.left, self.top - self.bottom
        look: dict[str, Any] = {"edgecolor": PALETTE[1], "linewidth": 1.1, "zorder": 4}
        ax.add_patch(Rectangle((self.left, self.bottom), width, height, fill=False, **look))
        ax.annotate(
            letter, (self.right, self.top), xytext=(2, 1), textcoords="offset points",
            fontweight="bold", color=PALETTE[1], zorder=5,
        )  # fmt: skip

    def within(self, other: Zoom) -> bool:
        """Whether it is a part of another one."""
        across = other.left <= self.left < self.right <= other.right
        return self is not other and across and other.bottom <= self.bottom < self.top <= other.top

    def __str__(self) -> str:
        """As it is written on the command line."""
        numbers = ",".join(f"{side:g}" for side in self[:4])
        return f"{self.name}:{numbers}" if self.name else numbers


def read_zoom(text: str) -> Zoom:
    """A rectangle as it is written on the command line."""
    name, _, sides = text.rpartition(":")
    try:
        left, right, bottom, top = map(float, sides.split(","))
    except ValueError:
        left = right = bottom = top = np.nan
    if not (left < right and bottom < top and np.isfinite([left, right, bottom, top]).all()):
        raise ValueError(f"expected LEFT,RIGHT,BOTTOM,TOP in units of the axes, found {text!r}")
    return Zoom(left, right, bottom, top, name)


def coordinate_of(zooms: Sequence[Zoom], names: Sequence[str]) -> str:
    """The free coordinate, of those named, that rectangles belong to."""
    only = names[0] if len(names) == 1 else ""
    asked = {zoom.name or only for zoom in zooms}
    if len(asked) == 1 and asked <= set(names):
        return asked.pop()
    wanted, written = listed(list(names), "or"), listed([str(zoom) for zoom in zooms], "and")
    raise ValueError(f"expected rectangles of one free coordinate, {wanted}; found {written}")


SIZES = ((60, 4.0), (600, 2.4), (3000, 1.5), (20_000, 0.9), (np.inf, 0.5))
FAINT = ((3000, 1.0), (20_000, 0.5), (np.inf, 0.3))
"""Size and opacity of dots up to so many points: what is dense looks dense."""


@styled
def section_figure(data: xr.Dataset, zooms: Sequence[Zoom] = ()) -> Figure | None:
    """One panel for each free coordinate; None for data without points.

    `zooms`: rectangles that are drawn once more below, two in a row; with any of them, only the
    free coordinates that they belong to are drawn.
    """
    found = [free.name for free in free_coordinates(data)]
    if not found or not data.sizes["crossing"]:
        return None
    if zooms:
        return _zoomed(data, coordinate_of(zooms, found), zooms)
    return diagram_each(found, lambda ax, name, of: _draw(ax, data, name, of), name_of(data))


def _zoomed(data: xr.Dataset, name: str, zooms: Sequence[Zoom]) -> Figure:
    """A panel with all points, and the rectangles below it."""
    pairs = [[k, k + 1 if k < len(zooms) else -1] for k in range(1, len(zooms) + 1, 2)]
    result, (main, *others) = mosaic([[0, 0], *pairs], [WHOLE, *[PAIRED] * len(pairs)])
    _draw(main, data, name, name_of(data))
    for ax, letter, zoom in zip(others, ascii_uppercase, zooms, strict=False):
        _draw(ax, data, name, zoom=zoom)
        for panel, whole in ((main, None), *zip(others, zooms, strict=True)):
            if whole is None or zoom.within(whole):
                zoom.frame(panel, letter)
        ax.set_title(letter)
    return result


@chart
def section(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """Points of `linkages.poincare`: of the free coordinate named, or the first.

    `name`: The free coordinate.
    """
    return _draw(axes_for(ax), data, name, name_of(data))


def _draw(
    ax: Axes, data: xr.Dataset, name: str | None, heading: str = "", zoom: Zoom | None = None
) -> Axes:
    """Draw the points of one free coordinate."""
    coordinate = free_coordinate(data, name)
    x, y = shown_pair(ax, data, coordinate, coordinate.value, coordinate.rate)
    if zoom is not None:
        x, y = zoom.inside(x, y)
    ax.plot(
        x, y, "o", color=PALETTE[0], markersize=stepped(SIZES, len(x)), markeredgewidth=0,
        alpha=stepped(FAINT, len(x)), zorder=3, rasterized=len(x) > FAINT[0][0],
    )  # fmt: skip
    if zoom is None:
        show_steady(ax, y)
        _show_point(ax, x, y)
    else:
        zoom.limit(ax)
    count = f"{len(x):,} point{'' if len(x) == 1 else 's'}"
    set_title(ax, title(heading, coordinate.name), count)
    return ax


def _show_point(ax: Axes, x: np.ndarray, y: np.ndarray) -> None:
    """Points that coincide but for round-off are one: no axis a billionth wide."""
    for values, limit in ((x, ax.set_xlim), (y, ax.set_ylim)):
        middle, span = float(np.nanmean(values)), float(np.nanmax(values) - np.nanmin(values))
        if span < 1e-6 * max(1.0, abs(middle)):
            reach = 0.1 * max(1.0, abs(middle))
            limit(middle - reach, middle + reach)


PHASE = Output("touch_phase", "phase of the period")
RATE = Output("touch_rate", "approach speed")
DIRECTION = Output("touch_direction", "direction of touches")


@styled
def impact_map_figure(data: xr.Dataset) -> Figure | None:
    """Rates over phases and directions over phases; rates over directions without a period."""
    pairs = [(PHASE, RATE), (PHASE, DIRECTION)] if PHASE.variable in data else [(DIRECTION, RATE)]
    shown = [pair for pair in pairs if {output.variable for output in pair} <= set(data.data_vars)]
    if not shown or not data.sizes["crossing"]:
        return None
    free = Free("touch", str(data["touch"].values[0]))
    result, axes = diagrams(len(shown))
    for ax, (along, upwards) in zip(axes, shown, strict=True):
        x, y = shown_pair(ax, data, free, along, upwards)
        size = stepped(SIZES, len(x))
        ax.plot(x, y, "o", color=PALETTE[0], markersize=size, markeredgewidth=0, zorder=3)
        if along is PHASE:
            ax.set_xlim(0.0, 1.0)
        if upwards is RATE and np.nanmin(y) >= 0.0:
            ax.set_ylim(bottom=0.0)
    set_title(axes[-1], "", f"{data.sizes['crossing']} touches")
    set_title(axes[0], title(name_of(data), free.name))
    return result
