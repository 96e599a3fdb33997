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

from linkages.plots.motion.curves import show_steady
from linkages.plots.motion.phase_diagrams import (
    Free,
    Output,
    free_coordinates,
    show_output,
    values_of,
)
from linkages.plots.style import (
    BOTTOM,
    PAIRED,
    PALETTE,
    TOP,
    WIDTH,
    diagrams,
    set_title,
    styled,
    title,
)
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


def zoom_panels(count: int) -> tuple[Figure, Axes, list[Axes]]:
    """A figure with a wide panel, and so many below it, two in a row."""
    rows = -(-count // 2)
    size = WIDTH, WHOLE + rows * PAIRED + (1 + rows) * (TOP + BOTTOM)
    result = Figure(figsize=size, layout="constrained")
    grid = result.add_gridspec(1 + rows, 2, height_ratios=[WHOLE, *[PAIRED] * rows])
    main = result.add_subplot(grid[0, :])
    return result, main, [result.add_subplot(grid[1 + k // 2, k % 2]) for k in range(count)]


SIZES = ((60, 4.0), (600, 2.4), (3000, 1.5), (20_000, 0.9))
SMALLEST = 0.5
FAINT = ((3000, 1.0), (20_000, 0.5))
FAINTEST = 0.3  # opacity of dots up to so many points: what is dense looks dense


@styled
def section_figure(data: xr.Dataset, zooms: Sequence[Zoom] = ()) -> Figure | None:
    """One panel for each free coordinate; None for data without points.

    `zooms`: rectangles that are drawn once more below, two in a row; with any of them, only the
    free coordinates that they belong to are drawn.
    """
    found = free_coordinates(data)
    if not found or not data.sizes["crossing"]:
        return None
    if zooms:
        named = {free.name: free for free in found}
        return _zoomed(data, named[coordinate_of(zooms, list(named))], zooms)
    result, axes = diagrams(len(found))
    heading = str(data.attrs.get("name", "")) if len(found) == 1 else ""
    for ax, coordinate in zip(axes, found, strict=True):
        draw_section(ax, data, coordinate, heading)
    return result


def _zoomed(data: xr.Dataset, coordinate: Free, zooms: Sequence[Zoom]) -> Figure:
    """A panel with all points, and the rectangles below it."""
    result, main, others = zoom_panels(len(zooms))
    draw_section(main, data, coordinate, str(data.attrs.get("name", "")))
    for ax, letter, zoom in zip(others, ascii_uppercase, zooms, strict=False):
        draw_section(ax, data, coordinate, zoom=zoom)
        for panel, whole in ((main, None), *zip(others, zooms, strict=True)):
            if whole is None or zoom.within(whole):
                zoom.frame(panel, letter)
        ax.set_title(letter)
    return result


def draw_section(
    ax: Axes, data: xr.Dataset, coordinate: Free, heading: str = "", zoom: Zoom | None = None
) -> Axes:
    """Draw the points of one free coordinate."""
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
    set_title(ax, title(heading, coordinate.name), count)
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
        draw_impact_map(ax, data, free, along, upwards)
    count = f"{data.sizes['crossing']} touches"
    set_title(axes[-1], "", count)
    set_title(axes[0], title(str(data.attrs.get("name", "")), free.name))
    return result


def draw_impact_map(ax: Axes, data: xr.Dataset, free: Free, along: Output, upwards: Output) -> Axes:
    """Draw a dot for each touch of a clearance."""
    x, y = (values_of(data, free, output) for output in (along, upwards))
    factors = show_output(ax, "x", data, along, x), show_output(ax, "y", data, upwards, y)
    size = marker_size(len(x))
    ax.plot(factors[0] * x, factors[1] * y, "o", color=PALETTE[0], markersize=size, mew=0, zorder=3)
    if along is PHASE:
        ax.set_xlim(0.0, 1.0)
    if upwards is RATE and np.nanmin(y) >= 0.0:
        ax.set_ylim(bottom=0.0)
    return ax
