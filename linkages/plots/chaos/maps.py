"""Maps of an indicator of chaos over two parameters or initial states, and of what angles do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, ListedColormap, Normalize, SymLogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from linkages.chaos.series.rotation import renamed
from linkages.plots.chaos.parameters import HATCHING, LOST, contact_lost, show_path
from linkages.plots.style import BOTTOM, GREY, LEFT, PALE, TOP, WIDTH, fitted, patches_above, styled

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

HEIGHT, BAR, GAP, LEGEND = 3.9, 0.18, 0.12, 0.3
BAR_LABELS = 0.75  # inches, to the right of the colour bar
# From light to dark in black and white, too.
KINDS = {"resting": "#FFFFFF", "mixed": "#E69F00", "libration": "#0072B2", "rotation": "#3B1C4A"}

# In even steps; in black and white, too, the darkest places are the strongest on either side.
SIGNS = ("#071A3D", "#2F6DB5", "#A9C6E3", "#FFFFFF", "#F9D29B", "#DE8A1C", "#9A4A06")
UNTOLD = "zero within its error"


@styled
def figure(data: xr.Dataset) -> Figure | None:
    """The indicator as an image with a colour bar; None where it would be of one colour."""
    several = len(np.unique(_shown(data)[_finite(data)])) > 1
    return page(data) if several or contact_lost(data, "y", "x") is not None else None


@styled
def page(data: xr.Dataset) -> Figure:
    """The indicator as an image with a colour bar, whatever it shows."""
    result, ax, bar = _page(LEGEND if _entries(data) else 0.0)
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
    """Draw how often a period something is touched, on average: grey where it is not known.

    Parameters
    ----------
    ax
        Where to draw.
    data
        With `touches`.
    contact
        Name of what is touched.
    """
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
    """Draw the indicator: grey where it could not be computed, hatched where contact is lost.

    Parameters
    ----------
    ax
        Where to draw.
    data
        As `linkages.chaos_map` returns it. Exponents that cannot be told from zero are white.
    """
    values = _shown(data)
    x, y = _frame(ax, data)
    colours, limits = _colours(values, signed=_signed(data))
    ax.pcolormesh(x, y, values, cmap=colours, norm=limits, rasterized=True)
    _hatch(ax, data, x, y)
    heading, entries = str(data.attrs.get("name", "")), _entries(data)
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


def _entries(data: xr.Dataset) -> dict[str, Patch]:
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
