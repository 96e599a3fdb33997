"""Maps of an indicator of chaos over two parameters or initial states, and of what angles do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from linkages.plots.parameters import show_path
from linkages.plots.style import BOTTOM, GREY, LEFT, PALE, TOP, WIDTH, fitted, legend_above, styled

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

HEIGHT, BAR, GAP, LEGEND = 3.9, 0.18, 0.12, 0.3
BAR_LABELS = 0.75  # inches, to the right of the colour bar
BOTH_SIGNS = 0.05
"""Part of the largest magnitude from which on the other sign gets colours of its own."""

# From light to dark in black and white, too; the same holds for both sides of zero below.
KINDS = {"resting": "#FFFFFF", "mixed": "#E69F00", "swing": "#0072B2", "rotation": "#3B1C4A"}
BELOW, ABOVE = ("#071A3D", "#2F6DB5", "#9FB4C7"), ("#E8A33D", "#F6D27A", "#FFFBE0")


@styled
def figure(data: xr.Dataset) -> Figure:
    """The indicator as an image with a colour bar."""
    result, ax, bar = _page(LEGEND if _missing(data).any() else 0.0)
    draw(ax, data)
    result.colorbar(ax.collections[0], cax=bar, label=indicator_label(data))
    return result


def indicator_label(data: xr.Dataset) -> str:
    """What the colour bar shows."""
    units = str(data["indicator"].attrs.get("units", ""))
    label = str(data["indicator"].attrs.get("long_name", "indicator"))
    if _logarithmic(data):
        label = f"log₁₀ of the {label}"
    return f"{label} [{units}]" if units else label


@styled
def class_figure(data: xr.Dataset, coordinate: str) -> Figure:
    """What a free angle does, as an image with a legend."""
    result, ax, bar = _page(LEGEND)
    bar.remove()
    draw_classes(ax, data, coordinate)
    return result


def _page(legend: float) -> tuple[Figure, Axes, Axes]:
    total = HEIGHT + TOP + BOTTOM + legend
    width = WIDTH - LEFT - GAP - BAR - BAR_LABELS
    result = Figure(figsize=(WIDTH, total))
    height = HEIGHT / total
    ax = result.add_axes((LEFT / WIDTH, BOTTOM / total, width / WIDTH, height))
    left = (LEFT + width + GAP) / WIDTH
    return result, ax, result.add_axes((left, BOTTOM / total, BAR / WIDTH, height))


def draw(ax: Axes, data: xr.Dataset) -> Axes:
    """Draw the indicator; grey where it could not be computed.

    Parameters
    ----------
    ax
        Where to draw.
    data
        As `linkages.chaos.maps.chaos_map` returns it.
    """
    values = np.asarray(data["indicator"], dtype=float)
    if _logarithmic(data):
        values = np.log10(np.maximum(values, np.finfo(float).eps))
    x, y = _frame(ax, data)
    colours, limits = _colours(values)
    ax.pcolormesh(x, y, values, cmap=colours, norm=limits, rasterized=True)
    ax.set_title(fitted(str(data.attrs.get("name", "")), 4.4))
    missing = int(_missing(data).sum())
    if missing:
        look = legend_above(str(data.attrs.get("name", ""))) | {"handlelength": 1.0}
        ax.set_title("")
        ax.legend([Patch(color=PALE)], [f"not computed ({missing})"], **look)
    return ax


def draw_classes(ax: Axes, data: xr.Dataset, coordinate: str) -> Axes:
    """Draw what a free angle does at each point.

    Parameters
    ----------
    ax
        Where to draw.
    data
        With `rotation`.
    coordinate
        Name of the angle.
    """
    words = np.asarray(data["rotation"].sel(coordinate=coordinate), dtype=object)
    numbers = np.full(words.shape, np.nan)
    for number, word in enumerate(KINDS):
        numbers[words == word] = number
    x, y = _frame(ax, data)
    colours = ListedColormap(list(KINDS.values())).with_extremes(bad=PALE)
    ax.pcolormesh(x, y, numbers, cmap=colours, vmin=-0.5, vmax=len(KINDS) - 0.5, rasterized=True)
    present = {word: colour for word, colour in KINDS.items() if (words == word).any()}
    if np.isnan(numbers).any():
        present["not computed"] = PALE
    outline: dict[str, Any] = {"edgecolor": GREY, "linewidth": 0.6}  # white is one of the colours
    shown = {word: Patch(facecolor=colour, **outline) for word, colour in present.items()}
    heading = f"{data.attrs.get('name', '')}: {coordinate}"
    look = legend_above(heading) | {"handlelength": 1.0}
    ax.legend(list(shown.values()), list(shown), **look, ncols=5)
    return ax


def _frame(ax: Axes, data: xr.Dataset) -> tuple[Array, Array]:
    """Both axes; borders of cells."""
    x, y = (show_path(ax, dim, data, str(data.attrs[dim])) for dim in ("x", "y"))
    ax.grid(False)
    return x, y


def _colours(values: Array) -> tuple[Colormap, Normalize]:
    """Dark to light; blue below zero and yellow above for values of both signs."""
    from matplotlib import colormaps
    from matplotlib.colors import LinearSegmentedColormap

    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    largest = max(abs(low), abs(high)) or 1.0
    both = low < -BOTH_SIGNS * largest and high > BOTH_SIGNS * largest
    places = [0.0, 0.3, 0.5, 0.5, 0.7, 1.0]
    signs = list(zip(places, BELOW + ABOVE, strict=True))
    base: Colormap = colormaps["cividis"]
    if both:
        base = LinearSegmentedColormap.from_list("signs", signs, N=512)
    return base.with_extremes(bad=PALE), Normalize(-largest, largest) if both else Normalize(
        low, high
    )


def _logarithmic(data: xr.Dataset) -> bool:
    return str(data.attrs.get("kind", "")) == "gali"


def _missing(data: xr.Dataset) -> NDArray[np.bool_]:
    return np.asarray(data["reason"], dtype=object) != ""
