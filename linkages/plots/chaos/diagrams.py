"""Bifurcation diagrams, and maps of an indicator of chaos."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, ListedColormap, Normalize, SymLogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from linkages.chaos.periods import renamed
from linkages.plots.chaos.section_figures import SMALLEST
from linkages.plots.motion.phase_diagrams import (
    Free,
    free_coordinates,
    show_degrees,
    show_output,
    values_of,
)
from linkages.plots.style import (
    BLACK,
    BOTTOM,
    DEGREES,
    GREY,
    LEFT,
    PALE,
    PALETTE,
    RIGHT,
    TOP,
    WIDTH,
    axis_scale,
    fitted,
    patches_above,
    path_words,
    styled,
)

if TYPE_CHECKING:
    import xarray as xr


Array = NDArray[np.float64]

LOST = "contact lost"
HATCHING: dict[str, Any] = {
    "facecolor": "none", "edgecolor": "#8F8F8F", "hatch": "////", "linewidth": 0.0,
}  # fmt: skip
"""How places are drawn at which a massless link would have to push."""


def shown_values(data: xr.Dataset, path: str) -> tuple[Array, str]:
    """Values of a varied path as they are drawn, angles in degrees, and the label of its axis."""
    unit = str(data[path].attrs.get("units", ""))
    values = np.asarray(data[path], dtype=float)
    if unit == "rad":
        values, unit = DEGREES * values, "°"
    elif unit in ("deg", "degree", "degrees", "°"):
        unit = "°"
    words = path_words(path)
    shown = axis_scale([], unit).units if unit != "°" else unit
    return values, f"{words} [{shown}]" if unit else words


def show_path(ax: Axes, along: str, data: xr.Dataset, path: str) -> Array:
    """Limits, ticks and label of an axis along which a path is varied; returns borders of cells."""
    values, label = shown_values(data, path)
    if label.endswith("[°]"):
        show_degrees(ax, values, along)
    borders = cell_borders(values)
    low, high = sorted((float(borders[0]), float(borders[-1])))
    (ax.set_xlim if along == "x" else ax.set_ylim)(low, high)
    (ax.set_xlabel if along == "x" else ax.set_ylabel)(label)
    return borders


def cell_borders(places: Array) -> Array:
    """Borders half-way between neighbouring places, shape (n + 1,)."""
    middle = 0.5 * (places[1:] + places[:-1])
    first, last = places[0] - (middle[0] - places[0]), places[-1] + (places[-1] - middle[-1])
    return np.concatenate([[first], middle, [last]])


def contact_lost(data: xr.Dataset, *dims: str) -> NDArray[np.bool_] | None:
    """Where a massless link of any clearance pushed, in the order of `dims`; None if nowhere."""
    if "contact_lost" not in data:
        return None
    lost = (data["contact_lost"] > 0).any("clearance").transpose(*dims).to_numpy()
    return lost if lost.any() else None


HEIGHT, GAP, LEGEND = 2.4, 0.14, 0.16
HEADED = 0.3  # inches between panels, instead of GAP, where they have headings
SIZES = ((80, 2.0), (300, 1.4))
WIDER = 0.45  # dots of each further start: they show beneath those of the first
FAINT = ((300, 1.0), (600, 0.5))
FAINTEST = 0.25
"""Opacity of dots in so many columns at most, and in more: what is dense looks dense."""

BAND = 2.0
"""Half the width of the band about an exponent, in standard errors."""


@styled
def bifurcation_figure(data: xr.Dataset, *, rates: bool = False) -> Figure | None:
    """Points of each free coordinate over the parameter, with the exponent below where known."""
    found = free_coordinates(data)
    if not found or not data.sizes["value"]:
        return None
    below = "exponent" in data and not rates
    entries = _entries(data)
    legend = LEGEND * -(-len(entries) // _columns(entries))
    result, axes = _stacked(len(found) + below, legend, HEADED if len(found) > 1 else GAP)
    for ax, coordinate in zip(axes, found, strict=False):
        draw_bifurcation(ax, data, coordinate, rates=rates)
        if len(found) > 1:
            ax.set_title(coordinate.name, loc="right", fontsize=8)
    if below:
        draw_exponent(axes[-1], data)
    for ax in axes:
        show_parameter(ax, data)
    for ax in axes[:-1]:
        ax.set_xlabel("")
        ax.tick_params(labelbottom=False)
    heading = str(data.attrs.get("name", ""))
    if entries:
        patches_above(axes[0], entries, heading, _columns(entries))
    else:
        axes[0].set_title(heading)
    return result


def _stacked(rows: int, legend: float, gap: float) -> tuple[Figure, list[Axes]]:
    """Panels that stand close to each other, with room for a legend above the first."""
    total = rows * HEIGHT + (rows - 1) * gap + TOP + legend + BOTTOM
    result = Figure(figsize=(WIDTH, total))
    width = (WIDTH - LEFT - RIGHT) / WIDTH
    axes = []
    for row in range(rows):
        bottom = BOTTOM + (rows - 1 - row) * (HEIGHT + gap)
        axes.append(result.add_axes((LEFT / WIDTH, bottom / total, width, HEIGHT / total)))
    return result, axes


def parameter(data: xr.Dataset) -> tuple[Array, str]:
    """Values of the parameter as they are drawn, and the label of its axis."""
    return shown_values(data, str(data.attrs["varied"]))


def start_names(data: xr.Dataset) -> list[str]:
    """What the initial conditions are called."""
    if "start" in data.coords:
        return [str(name) for name in data["start"].values]
    count = data.sizes["start"]
    return [""] if count == 1 else [f"initial condition {number}" for number in range(1, count + 1)]


def draw_bifurcation(ax: Axes, data: xr.Dataset, coordinate: Free, *, rates: bool = False) -> Axes:
    """Draw the section points of one free coordinate, each initial condition in its colour."""
    output = coordinate.rate if rates else coordinate.value
    points = values_of(data, coordinate, output)
    x, _ = parameter(data)
    factor = show_output(ax, "y", data, output, points)
    size = next((size for most, size in SIZES if len(x) <= most), SMALLEST)
    for index, rows in enumerate(points):
        places = np.repeat(x[:, None], rows.shape[1], axis=1)
        ax.plot(
            places.ravel(),
            factor * rows.ravel(),
            "o",
            color=PALETTE[index % len(PALETTE)],
            markersize=size * (1.0 + WIDER * index),
            markeredgewidth=0,
            alpha=next((opacity for most, opacity in FAINT if len(x) <= most), FAINTEST),
            zorder=3 - 0.01 * index,
            rasterized=len(x) > SIZES[-1][0],
        )
    shade_missing(ax, data)
    hatch_lost(ax, data)
    return ax


def shade_missing(ax: Axes, data: xr.Dataset) -> None:
    """Shade values at which nothing could be computed from any initial condition."""
    x, _ = parameter(data)
    missing = _missing(data)
    borders = cell_borders(x)
    for index in np.flatnonzero(missing):
        ax.axvspan(borders[index], borders[index + 1], color=PALE, linewidth=0, zorder=0.5)


def _missing(data: xr.Dataset) -> NDArray[np.bool_]:
    """Values that have no points from any initial condition, and a reason for it."""
    failed = np.asarray(data["reason"], dtype=object) != ""
    points = [array for array in data.data_vars.values() if "crossing" in array.dims]
    for array in points:
        others = [dim for dim in array.dims if dim not in ("start", "value")]
        failed &= ~array.notnull().any(others).transpose("start", "value").to_numpy()
    return np.asarray(failed.all(axis=0))


def hatch_lost(ax: Axes, data: xr.Dataset) -> None:
    """Hatch values at which contact in a clearance is lost, from all initial conditions."""
    lost = contact_lost(data, "start", "value")
    if lost is None:
        return
    checked = data["contact_lost"].notnull().any("clearance").transpose("start", "value")
    borders = cell_borders(parameter(data)[0])
    for index in np.flatnonzero((lost | ~checked.to_numpy()).all(axis=0) & lost.any(axis=0)):
        ax.axvspan(borders[index], borders[index + 1], **HATCHING, zorder=0.6)


def draw_exponent(ax: Axes, data: xr.Dataset) -> Axes:
    """Draw largest Lyapunov exponents with bands of two standard errors."""
    x, _ = parameter(data)
    values, errors = np.asarray(data["exponent"]), np.asarray(data["error"])
    ax.axhline(0.0, color=BLACK, linewidth=0.8, zorder=2)
    for index, (value, error) in enumerate(zip(values, errors, strict=True)):
        colour = PALETTE[index % len(PALETTE)]
        low, high = value - BAND * error, value + BAND * error
        ax.fill_between(x, low, high, color=colour, alpha=0.25, linewidth=0)
        lone = "." if np.isfinite(value).sum() < 40 else ""
        ax.plot(x, value, color=colour, linewidth=0.8, marker=lone, markersize=3)
    shade_missing(ax, data)
    hatch_lost(ax, data)
    ax.set_ylabel("largest Lyapunov exponent [1/s]")
    return ax


def show_parameter(ax: Axes, data: xr.Dataset) -> None:
    """Limits, ticks and label of the axis of the parameter."""
    show_path(ax, "x", data, str(data.attrs["varied"]))


def _entries(data: xr.Dataset) -> dict[str, Artist]:
    """Texts of the legend, and what stands before them: dots of each initial condition."""
    shown: dict[str, Artist] = {
        name: Line2D([], [], linestyle="", marker="o", color=PALETTE[index % len(PALETTE)])
        for index, name in enumerate(start_names(data))
        if name
    }
    missing = int(_missing(data).sum())
    if missing:
        shown[f"not computed ({missing})"] = Patch(color=PALE)
    if contact_lost(data, "start", "value") is not None:
        shown[LOST] = Patch(**HATCHING)
    return shown


def _columns(entries: Mapping[str, Artist]) -> int:
    longest = max(map(len, entries), default=0)
    return 4 if longest < 18 else 2 if longest < 45 else 1


MAP_HEIGHT, BAR, MAP_GAP, MAP_LEGEND = 3.9, 0.18, 0.12, 0.3
BAR_LABELS = 0.75  # inches, to the right of the colour bar
# From light to dark in black and white, too.
KINDS = {"resting": "#FFFFFF", "mixed": "#E69F00", "libration": "#0072B2", "rotation": "#3B1C4A"}

# In even steps; in black and white, too, the darkest places are the strongest on either side.
SIGNS = ("#071A3D", "#2F6DB5", "#A9C6E3", "#FFFFFF", "#F9D29B", "#DE8A1C", "#9A4A06")
UNTOLD = "zero within its error"


@styled
def map_figure(data: xr.Dataset) -> Figure | None:
    """The indicator as an image with a colour bar; None where it would be of one colour."""
    several = len(np.unique(_shown(data)[_finite(data)])) > 1
    return page(data) if several or contact_lost(data, "y", "x") is not None else None


@styled
def page(data: xr.Dataset) -> Figure:
    """The indicator as an image with a colour bar, whatever it shows."""
    result, ax, bar = _page(MAP_LEGEND if _map_entries(data) else 0.0)
    draw_map(ax, data)
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
def touch_figure(data: xr.Dataset, contact: str) -> Figure | None:
    """How often something is touched, as an image with a colour bar; None where it never is."""
    values = np.asarray(data["touches"].sel(touch=contact), dtype=float)
    return touch_page(data, contact) if np.nansum(values) > 0 else None


@styled
def touch_page(data: xr.Dataset, contact: str) -> Figure:
    """How often something is touched, as an image with a colour bar, whatever it shows."""
    result, ax, bar = _page(0.0)
    draw_touches(ax, data, contact)
    label = str(data["touches"].attrs["long_name"])
    result.colorbar(ax.collections[0], cax=bar, label=label, format="%g")
    return result


def draw_touches(ax: Axes, data: xr.Dataset, contact: str) -> Axes:
    """Draw how often a period something is touched, on average: grey where it is not known."""
    values = np.asarray(data["touches"].sel(touch=contact), dtype=float)
    x, y = _frame(ax, data)
    colours, _ = _colours(values, signed=False)
    most = max(1.0, float(np.nanmax(values, initial=1.0)))
    limits = SymLogNorm(1.0, vmin=0.0, vmax=most)  # small numbers differ more than large ones
    ax.pcolormesh(x, y, values, cmap=colours, norm=limits, rasterized=True)
    ax.set_title(fitted(f"{data.attrs.get('name', '')}: {contact}", 4.4))
    return ax


@styled
def class_figure(data: xr.Dataset, coordinate: str) -> Figure | None:
    """What a free angle does, as an image with a legend; None where it is the same everywhere."""
    several = len(np.unique(_words(data, coordinate)[_finite(data)].astype(str))) > 1
    return class_page(data, coordinate) if several else None


@styled
def class_page(data: xr.Dataset, coordinate: str) -> Figure:
    """What a free angle does, as an image with a legend, whatever it shows."""
    result, ax, bar = _page(MAP_LEGEND)
    bar.remove()
    draw_classes(ax, data, coordinate)
    return result


def _page(legend: float) -> tuple[Figure, Axes, Axes]:
    total = MAP_HEIGHT + TOP + BOTTOM + legend
    width = WIDTH - LEFT - MAP_GAP - BAR - BAR_LABELS
    result = Figure(figsize=(WIDTH, total))
    height = MAP_HEIGHT / total
    ax = result.add_axes((LEFT / WIDTH, BOTTOM / total, width / WIDTH, height))
    left = (LEFT + width + MAP_GAP) / WIDTH
    return result, ax, result.add_axes((left, BOTTOM / total, BAR / WIDTH, height))


def draw_map(ax: Axes, data: xr.Dataset) -> Axes:
    """Draw the indicator: grey where it could not be computed, hatched where contact is lost."""
    values = _shown(data)
    x, y = _frame(ax, data)
    colours, limits = _colours(values, signed=_signed(data))
    ax.pcolormesh(x, y, values, cmap=colours, norm=limits, rasterized=True)
    _hatch(ax, data, x, y)
    heading, entries = str(data.attrs.get("name", "")), _map_entries(data)
    if entries:
        patches_above(ax, entries, heading, 3)
    else:
        ax.set_title(fitted(heading, 4.4))
    return ax


def _shown(data: xr.Dataset) -> Array:
    """Values as they are drawn: exponents that cannot be told from zero as zero."""
    values = np.asarray(data["indicator"], dtype=float)
    if _logarithmic(data):
        return np.asarray(np.log10(np.maximum(values, np.finfo(float).eps)))
    if "sign" in data:
        return np.where(np.isfinite(values) & (data["sign"].to_numpy() == 0), 0.0, values)
    return values


def _finite(data: xr.Dataset) -> NDArray[np.bool_]:
    return np.isfinite(np.asarray(data["indicator"], dtype=float))


def _signed(data: xr.Dataset) -> bool:
    """Whether values have a sign that says something, and zero is in the middle of colours."""
    return str(data.attrs.get("kind", "")) == "exponent"


def _map_entries(data: xr.Dataset) -> dict[str, Patch]:
    """Texts and patches of the legend."""
    shown: dict[str, Patch] = {}
    missing = int((~_finite(data)).sum())
    untold = int((_finite(data) & (data["sign"] == 0)).sum()) if "sign" in data else 0
    if untold:
        shown[f"{UNTOLD} ({untold})"] = Patch(facecolor="#FFFFFF", edgecolor=GREY, linewidth=0.6)
    if missing:
        shown[f"not computed ({missing})"] = Patch(color=PALE)
    lost = contact_lost(data, "y", "x")
    if lost is not None:
        shown[f"{LOST} ({int(lost.sum())})"] = Patch(**HATCHING)
    return shown


def _hatch(ax: Axes, data: xr.Dataset, x: Array, y: Array) -> None:
    """Hatch cells at which contact in a clearance is lost, neighbours of a row together."""
    lost = contact_lost(data, "y", "x")
    for row, cells in enumerate(() if lost is None else lost):
        edges = np.flatnonzero(np.diff(cells.astype(np.int8), prepend=0, append=0))
        spans = [(x[a], x[b] - x[a]) for a, b in zip(edges[::2], edges[1::2], strict=True)]
        ax.broken_barh(spans, (y[row], y[row + 1] - y[row]), **HATCHING)


def draw_classes(ax: Axes, data: xr.Dataset, coordinate: str) -> Axes:
    """Draw what a free angle does at each point."""
    words = _words(data, coordinate)
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
    patches_above(ax, shown, f"{data.attrs.get('name', '')}: {coordinate}", 5)
    return ax


def _words(data: xr.Dataset, coordinate: str) -> NDArray[np.object_]:
    words = np.asarray(data["rotation"].sel(coordinate=coordinate), dtype=object)
    return renamed(words)


def _frame(ax: Axes, data: xr.Dataset) -> tuple[Array, Array]:
    """Both axes; borders of cells."""
    x, y = (show_path(ax, dim, data, str(data.attrs[dim])) for dim in ("x", "y"))
    ax.grid(False)
    return x, y


def _colours(values: Array, signed: bool) -> tuple[Colormap, Normalize]:
    """Dark to light; for values with a sign blue below zero, white at zero, brown above."""
    from matplotlib import colormaps
    from matplotlib.colors import LinearSegmentedColormap

    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    base: Colormap = colormaps["cividis"]
    if signed:
        largest = max(abs(low), abs(high)) or 1.0
        half = len(SIGNS) // 2
        above, below = low >= 0 < high, high <= 0 > low
        shades = SIGNS[half if above else 0 : half + 1 if below else None]
        base = LinearSegmentedColormap.from_list("signs", shades, N=512)
        low, high = (0.0 if above else -largest), (0.0 if below else largest)
    return base.with_extremes(bad=PALE), Normalize(low, high)


def _logarithmic(data: xr.Dataset) -> bool:
    return str(data.attrs.get("kind", "")) == "gali"
