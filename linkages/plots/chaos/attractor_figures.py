"""Attractors: basins over a plane with section points; shares and jumps over a parameter."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, Normalize, to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from linkages.plots.chaos.diagrams import SIZES, draw_columns, parameter
from linkages.plots.motion.phase_diagrams import stepped
from linkages.plots.panels import (
    OUTLINE,
    cell_borders,
    dot,
    draw_cells,
    legend_above,
    not_computed,
    panels,
    shade,
    show_axis,
    show_path,
    shown_values,
)
from linkages.plots.style import (
    BLACK,
    DEGREES,
    GREY,
    PALE,
    PALETTE,
    Scale,
    name_of,
    styled,
)
from linkages.reading.paths import split
from linkages.spec.units import unit

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

COLOURS = tuple(colour for colour in PALETTE if colour != "#000000")
TINT = 0.5  # part of white in the colours of basins, so that points show on them
HEIGHT = 4.2  # inches: of the picture
DOTS: dict[str, Any] = {
    "markersize": 5.5, "markeredgecolor": BLACK, "markeredgewidth": 0.8, "zorder": 4,
}  # fmt: skip
MOST_LINES = 12  # attractors that a legend names; of more it has the first ones
UNDECIDED = "undecided"
RATES = ("speed", "velocity", "rate")


def colour_of(data: xr.Dataset, index: int) -> str:
    """Colour of an attractor, by its place among all."""
    undecided = str(data["kind"].to_numpy()[index]) == UNDECIDED
    return GREY if undecided else COLOURS[index % len(COLOURS)]


def attractor_words(data: xr.Dataset, index: int) -> str:
    """What an attractor is: kind, period, turns of free angles and touches in it.

    Over a parameter without numbers that change with it: the period, and how often angles turn.
    """
    one = data.isel(attractor=index)
    words, swept, count = [str(one["kind"].item())], "many" in one, int(one["cycle"])
    if one["many" if swept else "family"].item():
        words.append("one of a family")
    if swept:
        lasting = f"{count} point{'s' * (count > 1)}" * bool(count)
    else:
        period = f"{float(one['period']):.4g} s" + f" ({count} points)" * (count > 1)
        lasting = period * bool(np.isfinite(one["period"]))
    if lasting:
        words += [lasting, *_turn_words(one, counted=not swept), *_touch_words(one)]
    return ", ".join(words)


def _turn_words(one: xr.Dataset, counted: bool) -> Iterator[str]:
    """Which free angles turn within an attractor, and how often if that is `counted`."""
    for name, turns in zip(one["coordinate"].to_numpy(), one["turns"].to_numpy(), strict=True):
        if turns:
            times = f" {abs(turns):.0f} times" if counted and abs(turns) > 1 else ""
            yield f"{name} turns{times}"


def _touch_words(one: xr.Dataset) -> Iterator[str]:
    """How often an attractor touches what it may touch, as far as that is known."""
    for name, touches in zip(one["touch"].to_numpy(), one["touches"].to_numpy(), strict=True):
        if np.isfinite(touches):
            times = {1: "once"}.get(int(touches), f"{touches:.0f} times")
            yield f"touches {name} {times}" if touches else f"never touches {name}"


def share_words(data: xr.Dataset, index: int) -> str:
    """The share of a basin with its interval; empty without draws."""
    one = data.isel(attractor=index)
    if not np.isfinite(float(one["fraction"])):
        return ""
    share, low, high = (100.0 * float(one[name]) for name in ("fraction", "low", "high"))
    return f"{share:.1f} % ({low:.1f} to {high:.1f} %)"


@styled
def basin_figure(data: xr.Dataset) -> Figure:
    """The basin of each attractor in its colour, and its section points over it."""
    result, (ax,) = panels(1, 1, HEIGHT)
    numbers = np.where(data["basin"] > 0, data["basin"], np.nan)
    count = data.sizes["attractor"]
    shades = [_tinted(colour_of(data, index)) for index in range(count)] or [PALE]
    draw_cells(ax, data, numbers, ListedColormap(shades), Normalize(0.5, len(shades) + 0.5))
    shown = [(index, shown_points(data, index)) for index in range(count)]
    for index, places in shown:
        if places is not None:
            ax.plot(*places, "o", color=colour_of(data, index), **DOTS)

    def entry(index: int) -> tuple[str, Artist]:
        share = share_words(data, index)
        text = attractor_words(data, index) + f": {share}" * bool(share)
        look: dict[str, Any] = {"edgecolor": GREY, "linewidth": 0.6}
        return text, Patch(facecolor=_tinted(colour_of(data, index)), **look)

    entries = _attractors(data, entry)
    entries |= not_computed(int((data["basin"] < 0).sum()))
    if any(places is not None for _, places in shown):
        entries["section points of the attractors"] = dot("#FFFFFF", **DOTS)
    legend_above(ax, entries, name_of(data), handlelength=1.0)
    return result


def _attractors(data: xr.Dataset, entry: Callable[[int], tuple[str, Artist]]) -> dict[str, Artist]:
    """Texts of a legend with the first attractors, and what stands before them."""
    count, shown = data.sizes["attractor"], dict[str, Artist]()
    for index in range(min(count, MOST_LINES)):
        text, artist = entry(index)
        shown[f"{int(data['attractor'][index])}  {text}"] = artist
    if count > MOST_LINES:
        shown[f"and {count - MOST_LINES} more"] = Patch(facecolor="none")
    return shown


def _tinted(colour: str) -> str:
    red, green, blue = (TINT + (1.0 - TINT) * part for part in to_rgb(colour))
    return to_hex((red, green, blue))


def shown_points(data: xr.Dataset, index: int) -> tuple[Array, Array] | None:
    """Section points of an attractor in units of both axes; None where an axis is no state."""
    points = data["points"][index].to_numpy()
    points = points[np.isfinite(points).all(axis=1)]
    paths = [str(data.attrs[dim]) for dim in ("x", "y")]
    places = [_column(data, path) for path in paths]
    if not len(points) or None in places:
        return None
    x, y = (_on_axis(data, *each) for each in zip(paths, points.T[places], strict=True))
    return x, y


def _column(data: xr.Dataset, path: str) -> int | None:
    """The entry of states whose initial value a path is."""
    keys = split(path) or ()
    states = [str(name) for name in data["state"].to_numpy()]
    if len(keys) != 3 or keys[0] not in ("free", "clearances"):
        return None
    own = [n for n, state in enumerate(states) if state.rpartition(".")[0] == str(keys[1])]
    place = int(str(keys[2]) in RATES)
    return own[place] if len(own) == 2 else None


def _on_axis(data: xr.Dataset, path: str, values: Array) -> Array:
    """Values in SI as an axis has them; angles by whole turns within its range."""
    shown, label = shown_values(data, path)
    if label.endswith("[°]"):
        middle = 0.5 * float(shown.min() + shown.max())
        degrees = DEGREES * values
        return np.asarray(degrees - 360.0 * np.round((degrees - middle) / 360.0))
    units = str(data[path].attrs.get("units", ""))
    return values / unit(units).convert(1.0) if units else values


DIAGRAM, SHARES = 2.6, 1.3  # inches: a diagram, and the panel of shares
SEVERAL = "#EFEFEF"
"""Behind values at which several attractors coexist."""

MOST_JUMPS = 12  # jumps that are drawn as arrows; more would hide the points
SMALLER = 0.55  # size of dots where an attractor was followed to and no start met it


@styled
def hysteresis_figure(data: xr.Dataset, *, rates: bool = False) -> Figure:
    """Points of each free coordinate over the parameter, and shares of the starts below."""
    free = sum("." in str(name) for name in data["state"].to_numpy()) // 2
    heights = [*[DIAGRAM] * free, SHARES]
    result, axes = panels(len(heights), 1, heights, joined=True)
    for state, ax in enumerate(axes[:-1], free if rates else 0):
        _draw_attractors(ax, data, state)
    _draw_shares(axes[-1], data)
    decided = data["kind"].to_numpy() != UNDECIDED
    several = (data["exists"].to_numpy()[:, decided] > 0).sum(axis=1) > 1
    for ax in axes:
        shade(ax, cell_borders(parameter(data)[0]), several, color=SEVERAL, linewidth=0, zorder=0.4)
        show_path(ax, "x", data, str(data.attrs["varied"]))

    def entry(index: int) -> tuple[str, Artist]:
        return attractor_words(data, index), dot(colour_of(data, index))

    entries = _attractors(data, entry)
    if (data["exists"] == 2).any():
        words = "small dots: followed from its neighbour, met by no start"
        entries[words] = dot(GREY, markersize=3.0)
    if several.any():
        entries["several attractors coexist"] = Patch(facecolor=SEVERAL, **OUTLINE)
    legend_above(axes[0], entries, name_of(data))
    return result


def _draw_attractors(ax: Axes, data: xr.Dataset, state: int) -> None:
    """Draw section points of each attractor in its colour, and arrows where one is lost."""
    x, _ = parameter(data)
    points, exists = data["points"].to_numpy()[..., state], data["exists"].to_numpy()
    name, units = (str(data[key].to_numpy()[state]) for key in ("state", "state_units"))
    scale = show_axis(ax, "y", points, units, name)
    size = 1.4 * max(stepped(SIZES, len(x)), SIZES[-2][1])
    for index in range(points.shape[1]):
        for how, factor in ((1, 1.0), (2, SMALLER)):
            there = exists[:, index] == how
            own = scale.factor * points[there, index]
            look = {"color": colour_of(data, index), "markersize": factor * size, "zorder": 3}
            draw_columns(ax, x[there], own, rasterized=own.size > 20_000, **look)
    _jumps(ax, data, points, scale)


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


def _draw_shares(ax: Axes, data: xr.Dataset) -> None:
    """Draw the share of the starts that tend to each attractor, with its interval."""
    x, _ = parameter(data)
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
