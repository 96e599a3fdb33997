"""Basins of attraction over a plane, with the section points of their attractors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, Normalize, to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from linkages.plots.chaos.diagrams import draw_cells, shown_values
from linkages.plots.style import (
    BLACK,
    DEGREES,
    GREY,
    LINE,
    PALE,
    PALETTE,
    legend_above,
    panels,
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
MOST_LINES = 12  # attractors that a legend names; of more it has the first ones
UNDECIDED = "undecided"
RATES = ("speed", "velocity", "rate")


def colour_of(data: xr.Dataset, index: int) -> str:
    """Colour of an attractor, by its place among all."""
    undecided = str(data["kind"].to_numpy()[index]) == UNDECIDED
    return GREY if undecided else COLOURS[index % len(COLOURS)]


def attractor_words(data: xr.Dataset, index: int) -> str:
    """What an attractor is: kind, period, turns of free angles and touches in it."""
    one = data.isel(attractor=index)
    words = [str(one["kind"].item())]
    if one["family"].item():
        words.append("one of a family")
    period = float(one["period"])
    if np.isfinite(period):
        count = int(one["cycle"])
        words.append(f"{period:.4g} s" + (f" ({count} points)" if count > 1 else ""))
        for name, turns in zip(one["coordinate"].to_numpy(), one["turns"].to_numpy(), strict=True):
            if turns:
                times = f" {abs(turns):.0f} times" if abs(turns) > 1 else ""
                words.append(f"{name} turns{times}")
        words += touch_words(one)
    return ", ".join(words)


def touch_words(one: xr.Dataset) -> list[str]:
    """How often an attractor touches what it may touch, as far as that is known."""
    result = []
    for name, touches in zip(one["touch"].to_numpy(), one["touches"].to_numpy(), strict=True):
        if np.isfinite(touches):
            times = {1: "once"}.get(int(touches), f"{touches:.0f} times")
            result.append(f"touches {name} {times}" if touches else f"never touches {name}")
    return result


def share_words(data: xr.Dataset, index: int) -> str:
    """The share of a basin with its interval; empty without draws."""
    one = data.isel(attractor=index)
    if not np.isfinite(float(one["fraction"])):
        return ""
    share, low, high = (100.0 * float(one[name]) for name in ("fraction", "low", "high"))
    return f"{share:.1f} % ({low:.1f} to {high:.1f} %)"


@styled
def basin_figure(data: xr.Dataset) -> Figure:
    """The basins as an image, with a legend above."""
    result, (ax,) = panels(1, 1, HEIGHT, LINE * len(_entries(data)))
    draw_basins(ax, data)
    return result


@styled
def draw_basins(ax: Axes, data: xr.Dataset) -> Axes:
    """Draw the basin of each attractor in its colour, and its section points over it."""
    numbers = np.where(data["basin"] > 0, data["basin"], np.nan)
    count = data.sizes["attractor"]
    shades = [_tinted(colour_of(data, index)) for index in range(count)] or [PALE]
    draw_cells(ax, data, numbers, ListedColormap(shades), Normalize(0.5, len(shades) + 0.5))
    for index in range(count):
        places = shown_points(data, index)
        if places is not None:
            ax.plot(
                *places, "o", color=colour_of(data, index), markersize=5.5, markeredgecolor=BLACK,
                markeredgewidth=0.8, clip_on=True, zorder=4,
            )  # fmt: skip
    legend_above(ax, _entries(data), str(data.attrs.get("name", "")), handlelength=1.0)
    return ax


def _tinted(colour: str) -> str:
    red, green, blue = (TINT + (1.0 - TINT) * part for part in to_rgb(colour))
    return to_hex((red, green, blue))


def _entries(data: xr.Dataset) -> dict[str, Artist]:
    """Texts of the legend, and what stands before them."""
    shown: dict[str, Artist] = {}
    count = data.sizes["attractor"]
    for index in range(min(count, MOST_LINES)):
        number = int(data["attractor"][index])
        share = share_words(data, index)
        text = f"{number}  {attractor_words(data, index)}" + (f": {share}" if share else "")
        shown[text] = Patch(
            facecolor=_tinted(colour_of(data, index)), edgecolor=GREY, linewidth=0.6
        )
    if count > MOST_LINES:
        shown[f"and {count - MOST_LINES} more"] = Patch(facecolor="none")
    missing = int((data["basin"] < 0).sum())
    if missing:
        shown[f"not computed ({missing})"] = Patch(color=PALE)
    if any(shown_points(data, index) is not None for index in range(count)):
        dots: dict[str, Any] = {"markeredgecolor": BLACK, "markersize": 5.5, "color": "#FFFFFF"}
        shown["section points of the attractors"] = Line2D([], [], linestyle="", marker="o", **dots)
    return shown


def shown_points(data: xr.Dataset, index: int) -> tuple[Array, Array] | None:
    """Section points of an attractor in units of both axes; None where an axis is no state."""
    points = data["points"][index].to_numpy()
    points = points[np.isfinite(points).all(axis=1)]
    places = [_column(data, str(data.attrs[dim])) for dim in ("x", "y")]
    if not len(points) or places[0] is None or places[1] is None:
        return None
    x, y = (
        _on_axis(data, str(data.attrs[dim]), points[:, place])
        for dim, place in zip(("x", "y"), places, strict=True)
    )
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
