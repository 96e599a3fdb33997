"""Attractors of many starts over a parameter, with their shares and where they are lost."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from linkages.plots.chaos.basin_figures import MOST_LINES, UNDECIDED, colour_of, touch_words
from linkages.plots.chaos.diagrams import (
    OUTLINE,
    SIZES,
    cell_borders,
    parameter,
    show_parameter,
    size_of,
)
from linkages.plots.motion.phase_diagrams import show_degrees
from linkages.plots.style import BLACK, GREY, LINE, Scale, axis_scale, legend_above, panels, styled

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

HEIGHT, SHARES = 2.6, 1.3  # inches: a diagram, and the panel of shares
BAND = "#EFEFEF"
"""Behind values at which several attractors coexist."""

MOST_JUMPS = 12  # jumps that are drawn as arrows; more would hide the points
SMALLER = 0.55  # size of dots where an attractor was followed to and no start met it


def family_words(data: xr.Dataset, index: int) -> str:
    """What an attractor is, apart from its period, which changes with the parameter."""
    one = data.isel(attractor=index)
    words = [str(one["kind"].item())]
    if one["many"].item():
        words.append("one of a family")
    if int(one["cycle"]):
        count = int(one["cycle"])
        words.append(f"{count} point{'s' * (count > 1)}")
        turning = one["turns"].to_numpy()
        words += [
            f"{n} turns" for n, t in zip(one["coordinate"].to_numpy(), turning, strict=True) if t
        ]
        words += touch_words(one)
    return ", ".join(words)


@styled
def hysteresis_figure(data: xr.Dataset, *, rates: bool = False) -> Figure:
    """Points of each free coordinate over the parameter, and shares of the starts below."""
    states = _states(data, rates)
    entries = _entries(data)
    heights = [*[HEIGHT] * len(states), SHARES]
    result, axes = panels(len(heights), 1, heights, LINE * len(entries), joined=True)
    for ax, state in zip(axes, states, strict=False):
        draw_attractors(ax, data, state)
    draw_shares(axes[-1], data)
    for ax in axes:
        show_parameter(ax, data)
        ax.label_outer()
    legend_above(axes[0], entries, str(data.attrs.get("name", "")))
    return result


def _states(data: xr.Dataset, rates: bool) -> list[int]:
    """Entries of states that are values of free coordinates, or their rates."""
    free = sum("." in str(name) for name in data["state"].to_numpy()) // 2
    return list(range(free, 2 * free) if rates else range(free))


def draw_attractors(ax: Axes, data: xr.Dataset, state: int) -> Axes:
    """Draw section points of each attractor in its colour, and arrows where one is lost."""
    x, _ = parameter(data)
    points, exists = data["points"].to_numpy()[..., state], data["exists"].to_numpy()
    name, units = (str(data[key].to_numpy()[state]) for key in ("state", "state_units"))
    scale = axis_scale(points, units)
    _shade(ax, data)
    size = size_of(SIZES, len(x), SIZES[-1][1])
    for index in range(points.shape[1]):
        for how, factor in ((1, 1.0), (2, SMALLER)):
            there = exists[:, index] == how
            places = np.repeat(x[there, None], points.shape[2], axis=1)
            ax.plot(
                places.ravel(), scale.factor * points[there, index].ravel(), "o",
                color=colour_of(data, index), markersize=factor * size * 1.4, markeredgewidth=0,
                zorder=3, rasterized=points[there, index].size > 20_000,
            )  # fmt: skip
    if units == "rad":
        show_degrees(ax, scale.factor * points[np.isfinite(points)], "y")
    ax.set_ylabel(scale.label(name))
    _jumps(ax, data, points, scale)
    return ax


def _jumps(ax: Axes, data: xr.Dataset, points: Array, scale: Scale) -> None:
    """Arrows from the last points of attractors that are lost to those that follow."""
    x, _ = parameter(data)
    behind = data["behind"].to_numpy()
    values = data[str(data.attrs["varied"])].to_numpy()
    for jump in range(min(data.sizes["jump"], MOST_JUMPS)):
        lost, became = (int(data[name][jump]) - 1 for name in ("lost", "became"))
        if became < 0:
            continue
        rows = [int(np.abs(values - v).argmin()) for v in (float(data["last"][jump]), behind[jump])]
        start, end = points[rows[0], lost], points[rows[1], became]
        start, end = start[np.isfinite(start)], end[np.isfinite(end)]
        if not (len(start) and len(end)):
            continue
        near = np.abs(start[:, None] - end)
        one, other = np.unravel_index(int(near.argmin()), near.shape)
        arrow = {"arrowstyle": "->", "color": BLACK, "linewidth": 0.9, "shrinkA": 3, "shrinkB": 3}
        ax.annotate(
            "", xy=(x[rows[1]], scale.factor * end[other]),
            xytext=(x[rows[0]], scale.factor * start[one]), arrowprops=arrow, zorder=4,
        )  # fmt: skip


def draw_shares(ax: Axes, data: xr.Dataset) -> Axes:
    """Draw the share of the starts that tend to each attractor, with its interval."""
    x, _ = parameter(data)
    _shade(ax, data)
    for index in range(data.sizes["attractor"]):
        met = data["found"].to_numpy()[:, index] > 0
        if not met.any():
            continue
        colour = colour_of(data, index)
        share, low, high = (
            np.where(met, 100.0 * data[name].to_numpy()[:, index], np.nan)
            for name in ("fraction", "low", "high")
        )
        ax.fill_between(x, low, high, color=colour, alpha=0.25, linewidth=0)
        ax.plot(x, share, color=colour, marker=".", markersize=3, linewidth=0.9)
    ax.set_ylim(-4, 104)
    ax.set_ylabel("starts [%]")
    return ax


def _shade(ax: Axes, data: xr.Dataset) -> None:
    """Shade values at which several attractors coexist."""
    for first, last in _several(data):
        ax.axvspan(first, last, color=BAND, linewidth=0, zorder=0.4)


def _several(data: xr.Dataset) -> list[tuple[float, float]]:
    """Stretches of values at which several attractors coexist, to the borders of their cells."""
    decided = data["kind"].to_numpy() != UNDECIDED
    several = (data["exists"].to_numpy()[:, decided] > 0).sum(axis=1) > 1
    borders = cell_borders(parameter(data)[0])
    edges = np.flatnonzero(np.diff(several.astype(np.int8), prepend=0, append=0))
    return [(borders[a], borders[b]) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _entries(data: xr.Dataset) -> dict[str, Artist]:
    """Texts of the legend, and what stands before them."""
    shown: dict[str, Artist] = {}
    count = data.sizes["attractor"]
    for index in range(min(count, MOST_LINES)):
        text = f"{int(data['attractor'][index])}  {family_words(data, index)}"
        shown[text] = Line2D([], [], linestyle="", marker="o", color=colour_of(data, index))
    if count > MOST_LINES:
        shown[f"and {count - MOST_LINES} more"] = Patch(facecolor="none")
    if (data["exists"] == 2).any():
        look: dict[str, Any] = {"linestyle": "", "marker": "o", "color": GREY, "markersize": 3.0}
        shown["small dots: followed from its neighbour, met by no start"] = Line2D([], [], **look)
    if _several(data):
        shown["several attractors coexist"] = Patch(facecolor=BAND, **OUTLINE)
    return shown
