"""Bifurcation diagrams; maps of an indicator of chaos and of periods over two parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LinearSegmentedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator
from numpy.typing import ArrayLike, NDArray

from linkages.chaos.periods import renamed
from linkages.chaos.strobed_motion import Regime
from linkages.orbits.loci import locus_values
from linkages.plots.motion.phase_diagrams import (
    Free,
    free_coordinate,
    free_coordinates,
    show_output,
    stepped,
    values_of,
)
from linkages.plots.panels import (
    OUTLINE,
    axes_for,
    cell_borders,
    chart,
    dot,
    draw_cells,
    draw_classes,
    labelled,
    legend_above,
    named,
    not_computed,
    panels,
    path_scale,
    runs,
    shade,
    show_path,
    shown_values,
    with_bar,
)
from linkages.plots.style import (
    BLACK,
    DASHES,
    PALE,
    PALETTE,
    figure_of,
    name_of,
    set_title,
    styled,
)
from linkages.spec.units import unit

if TYPE_CHECKING:
    import xarray as xr


Array = NDArray[np.float64]

LOST = "contact lost"
HATCHING: dict[str, Any] = {
    "facecolor": "none", "edgecolor": "#8F8F8F", "hatch": "////", "linewidth": 0.0,
}  # fmt: skip
"""How places are drawn at which a massless link would have to push."""


def contact_lost(data: xr.Dataset, *dims: str) -> NDArray[np.bool_] | None:
    """Where a massless link of any clearance pushed, in the order of `dims`; None if nowhere."""
    if "contact_lost" not in data:
        return None
    lost = (data["contact_lost"] > 0).any("clearance").transpose(*dims).to_numpy()
    return lost if lost.any() else None


HEIGHT = 2.4
SIZES = ((80, 2.0), (300, 1.4), (np.inf, 0.5))
FAINT = ((300, 1.0), (600, 0.5), (np.inf, 0.25))
"""Size and opacity of dots in so many columns: what is dense looks dense."""

WIDER = 0.45  # dots of each further start: they show beneath those of the first
BAND = 2.0  # half the width of the band about an exponent, in standard errors
FEW = 200  # values of a parameter that show columns of dots, and no lines


@styled
def bifurcation_figure(data: xr.Dataset, *, rates: bool = False) -> Figure | None:
    """Points of each free coordinate over the parameter, with the exponent below where known."""
    found, count = free_coordinates(data), data.sizes["value"]
    if not found or not count:
        return None
    below = "exponent" in data and not rates
    result, axes = panels(len(found) + below, 1, HEIGHT, joined=True)
    for ax, coordinate in zip(axes, found, strict=False):
        _draw_points(ax, data, coordinate, rates)
        if len(found) > 1:
            ax.set_title(coordinate.name, loc="right")
    if below:
        draw_exponent(axes[-1], data)
    for ax in axes:
        show_path(ax, "x", data, str(data.attrs["varied"]))
    legend_above(axes[0], _entries(data), f"{name_of(data)}{f' ({count} values)' * (count < FEW)}")
    return result


@chart
def bifurcation(
    data: xr.Dataset, name: str | None = None, ax: Axes | None = None, *, rates: bool = False
) -> Axes:
    """Points of `linkages.bifurcation` over the parameter: of the coordinate named, or the first.

    `name`: The free coordinate.
    `rates`: Whether to draw its rate instead of its value.
    """
    ax = _draw_points(axes_for(ax), data, free_coordinate(data, name), rates)
    show_path(ax, "x", data, str(data.attrs["varied"]))
    set_title(ax, name_of(data))
    return ax


def parameter(data: xr.Dataset) -> tuple[Array, str]:
    """Values of the parameter as they are drawn, and the label of its axis."""
    return shown_values(data, str(data.attrs["varied"]))


def start_names(data: xr.Dataset) -> list[str]:
    """What the initial conditions are called."""
    if "start" in data.coords:
        return [str(name) for name in data["start"].values]
    count = data.sizes["start"]
    return [""] if count == 1 else [f"initial condition {number}" for number in range(1, count + 1)]


def _draw_points(ax: Axes, data: xr.Dataset, coordinate: Free, rates: bool) -> Axes:
    """Draw the section points of one free coordinate, each initial condition in its colour."""
    output = coordinate.pair[rates]
    points = show_output(ax, "y", data, output, values_of(data, coordinate, output))
    x, _ = parameter(data)
    for index, rows in enumerate(points):
        draw_columns(
            ax, x, rows, color=PALETTE[index % len(PALETTE)], zorder=3 - 0.01 * index,
            markersize=stepped(SIZES, len(x)) * (1.0 + WIDER * index),
            alpha=stepped(FAINT, len(x)), rasterized=len(x) > SIZES[-2][0],
        )  # fmt: skip
    shade_failures(ax, data)
    return ax


def draw_columns(ax: Axes, x: Array, rows: Array, **look: Any) -> None:
    """Draw dots of several values over each x; `rows` has the shape (x, values)."""
    places = np.repeat(x[:, None], rows.shape[1], axis=1)
    ax.plot(places.ravel(), rows.ravel(), "o", markeredgewidth=0, **look)


def shade_failures(ax: Axes, data: xr.Dataset) -> None:
    """Shade values at which no start could be computed; hatch those at which all lose contact."""
    borders, lost = cell_borders(parameter(data)[0]), contact_lost(data, "start", "value")
    spans: list[tuple[NDArray[np.bool_], dict[str, Any]]] = [
        (_missing(data), {"color": PALE, "linewidth": 0, "zorder": 0.5})
    ]
    if lost is not None:
        checked = data["contact_lost"].notnull().any("clearance").transpose("start", "value")
        everywhere = (lost | ~checked.to_numpy()).all(axis=0) & lost.any(axis=0)
        spans.append((everywhere, {**HATCHING, "zorder": 0.6}))
    for chosen, look in spans:
        shade(ax, borders, chosen, **look)


def _missing(data: xr.Dataset) -> NDArray[np.bool_]:
    """Values that have no points from any initial condition, and a reason for it."""
    failed = np.asarray(data["reason"], dtype=object) != ""
    points = [array for array in data.data_vars.values() if "crossing" in array.dims]
    for array in points:
        others = [dim for dim in array.dims if dim not in ("start", "value")]
        failed &= ~array.notnull().any(others).transpose("start", "value").to_numpy()
    return np.asarray(failed.all(axis=0))


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
    shade_failures(ax, data)
    ax.set_ylabel("largest Lyapunov exponent [1/s]")
    return ax


def _entries(data: xr.Dataset) -> dict[str, Artist]:
    """Texts of the legend, and what stands before them: dots of each initial condition."""
    shown: dict[str, Artist] = {
        name: dot(PALETTE[index % len(PALETTE)])
        for index, name in enumerate(start_names(data))
        if name
    }
    shown |= not_computed(_missing(data).sum())
    if contact_lost(data, "start", "value") is not None:
        shown[LOST] = Patch(**HATCHING)
    return shown


MAP_HEIGHT = 3.9
# From light to dark in black and white, too.
KINDS = {"resting": "#FFFFFF", "mixed": "#E69F00", "libration": "#0072B2", "rotation": "#3B1C4A"}

# In even steps; in black and white, too, the darkest places are the strongest on either side.
SIGNS = ("#071A3D", "#2F6DB5", "#A9C6E3", "#FFFFFF", "#F9D29B", "#DE8A1C", "#9A4A06")


@styled
def map_figure(data: xr.Dataset) -> Figure | None:
    """The indicator as an image with a colour bar; None where it would be of one colour."""
    several = len(np.unique(_shown(data)[_finite(data)])) > 1
    lost = contact_lost(data, "y", "x") is not None
    return figure_of(indicator_map(data)) if several or lost else None


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
    if not np.nansum(np.asarray(data["touches"].sel(touch=contact), dtype=float)) > 0:
        return None
    ax = draw_touches(axes_for(None, MAP_HEIGHT), data, contact)
    ticks = LogLocator(subs=(1.0, 2.0, 5.0))
    with_bar(ax, str(data["touches"].attrs["long_name"]), format="%g", ticks=ticks)
    return figure_of(ax)


def draw_touches(ax: Axes, data: xr.Dataset, contact: str) -> Axes:
    """Draw how often a period something is touched, on average: white where never."""
    values = np.asarray(data["touches"].sel(touch=contact), dtype=float)
    touched = values[values > 0.0]
    low, high = (touched.min(), touched.max()) if touched.size else (1.0, 1.0)
    shown = np.where(values == 0.0, 0.5 * low, values)
    colours = colormaps["cividis"].with_extremes(under="#FFFFFF")
    draw_cells(ax, data, shown, colours, LogNorm(low, 1.001 * high))
    entries: dict[str, Artist] = {"never": Patch(facecolor="#FFFFFF", **OUTLINE)}
    if np.isnan(values).any():
        entries["not computed"] = Patch(color=PALE)
    legend_above(ax, entries, f"{name_of(data)}: {contact}")
    return ax


@styled
def class_figure(data: xr.Dataset, coordinate: str) -> Figure | None:
    """What a free angle does, as an image with a legend; None where it is the same everywhere."""
    several = len(np.unique(_words(data, coordinate)[_finite(data)].astype(str))) > 1
    return figure_of(rotation_map(data, coordinate)) if several else None


@chart
def indicator_map(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """The indicator of `linkages.chaos_map`, with a colour bar.

    Grey where it could not be computed, hatched where contact is lost.
    """
    ax, values = axes_for(ax, MAP_HEIGHT), _shown(data)
    signed = data.attrs.get("kind") == "exponent"  # zero is in the middle of its colours
    x, y = draw_cells(ax, data, values, *_colours(values, signed))
    lost = contact_lost(data, "y", "x")
    for row, cells in enumerate(() if lost is None else lost):  # neighbours of a row together
        spans = [(x[a], x[b] - x[a]) for a, b in runs(cells)]
        ax.broken_barh(spans, (y[row], y[row + 1] - y[row]), **HATCHING)
    legend_above(ax, _map_entries(data), name_of(data))
    with_bar(ax, indicator_label(data))
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


def _map_entries(data: xr.Dataset) -> dict[str, Artist]:
    """Texts and patches of the legend."""
    shown: dict[str, Artist] = {}
    finite, lost = _finite(data), contact_lost(data, "y", "x")
    untold = int((finite & (data["sign"] == 0)).sum()) if "sign" in data else 0
    if untold:
        share = f"{100.0 * untold / finite.size:.2g} % of points"
        shown[f"exponent zero within error ({share})"] = Patch(facecolor="#FFFFFF", **OUTLINE)
    shown |= not_computed((~finite).sum())
    if lost is not None:
        shown[f"{LOST} ({int(lost.sum())})"] = Patch(**HATCHING)
    return shown


@chart
def rotation_map(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """What a free angle does at each point of `linkages.chaos_map`: the one named, or the first.

    `name`: The free angle.
    """
    coordinate = named(name, [str(n) for n in data["coordinate"].values])
    ax, words = axes_for(ax, MAP_HEIGHT), _words(data, coordinate)
    shown = draw_classes(ax, data, words, {word: (colour, word) for word, colour in KINDS.items()})
    legend_above(ax, shown, f"{name_of(data)}: {coordinate}")
    return ax


def _words(data: xr.Dataset, coordinate: str) -> NDArray[np.object_]:
    return renamed(np.asarray(data["rotation"].sel(coordinate=coordinate), dtype=object))


def _colours(values: Array, signed: bool) -> tuple[Colormap, Normalize]:
    """Dark to light; for values with a sign blue below zero, white at zero, brown above."""
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    if not signed:
        return colormaps["cividis"], Normalize(low, high)
    largest, half = max(abs(low), abs(high)) or 1.0, len(SIGNS) // 2
    above, below = low >= 0 < high, high <= 0 > low
    shades = SIGNS[half if above else 0 : half + 1 if below else None]
    colours = LinearSegmentedColormap.from_list("signs", shades, N=512)
    return colours, Normalize(0.0 if above else -largest, 0.0 if below else largest)


def _logarithmic(data: xr.Dataset) -> bool:
    return str(data.attrs.get("kind", "")) == "gali"


OWN = 8  # periods with colours of their own; longer ones share one

# Neighbours in a cascade (1, 2, 4, 8) and frequent windows (3, 5, 6) differ in lightness as well.
PERIODS = (
    "#D6EAF8", "#5DADE2", "#F5B041", "#1F5FA8", "#58B368", "#C0392B", "#B7A5D9", "#0B2545",
    "#7D5A2F",
)  # fmt: skip
LINE, HALO = "#E6007E", "#FFFFFF"

Curves = Mapping[str, tuple[ArrayLike, ArrayLike]]
"""Label → x and y along a curve, in the units of the plane's coordinates."""


def classes(data: xr.Dataset) -> NDArray[np.int64]:
    """What each point is drawn as: its period, or −1 chaotic, −2 undecided, −3 not computed."""
    regime = data["regime"].transpose("y", "x").to_numpy()
    period = np.nan_to_num(data["indicator"].transpose("y", "x").to_numpy())
    others = {Regime.CHAOTIC: -1, Regime.UNDECIDED: -2, Regime.NOT_COMPUTED: -3}
    result = np.minimum(period, OWN + 1).astype(np.int64)
    for code, number in others.items():
        result[regime == code] = number
    return result


LOOKS = {
    **{number: (colour, f"period {number}") for number, colour in enumerate(PERIODS, 1)},
    OWN + 1: (PERIODS[-1], f"period {OWN + 1} or more"),
    -1: ("#3A3A3A", "chaotic"), -2: ("#FFF36B", "undecided"), -3: (PALE, "not computed"),
}  # fmt: skip
"""Number of a class → its colour and its words, in the order of the legend."""


@chart
def period_map(
    data: xr.Dataset, ax: Axes | None = None, *, curves: Curves | Sequence[xr.Dataset] = ()
) -> Axes:
    """The isoperiodic plane of `linkages.chaos_map` with the indicator ``"period"``.

    `curves`: What is drawn on top: loci of `linkages.follow` over the same parameters, or label → x
    and y along a curve, shape (n,) each, in the units of the coordinates of `data`. Nan ends a part
    of a curve.
    """
    own, ax = ax is None, axes_for(ax, MAP_HEIGHT)
    entries = draw_classes(ax, data, classes(data), LOOKS)
    lines = curves if isinstance(curves, Mapping) else locus_curves(data, curves)
    entries |= labelled(draw_curves(ax, data, lines))
    look: dict[str, Any] = {"handlelength": 1.6, "labelspacing": 0.45}
    if own:
        look |= {"loc": "upper left", "bbox_to_anchor": (1.02, 1.0), "borderaxespad": 0.0}
    ax.legend([*entries.values()], [*entries], **look)
    set_title(ax, name_of(data))
    return ax


def locus_curves(data: xr.Dataset, loci: Iterable[xr.Dataset]) -> Curves:
    """Loci that `linkages.follow` has found in the parameters of a plane, in its units, by kind.

    Raises ValueError if one is no locus, or one of other parameters.
    """
    paths = [str(data.attrs[dim]) for dim in ("x", "y")]
    units = [str(data[path].attrs["units"]) for path in paths]
    scales = [unit(each).scale if each else 1.0 for each in units]
    result: dict[str, NDArray[np.float64]] = {}
    for locus in loci:
        kind, values = locus_values(locus, paths)
        parts = [values / scales, np.full((1, 2), np.nan)]
        result[kind] = np.concatenate([result.get(kind, np.empty((0, 2))), *parts])
    return {kind: (values[:, 0], values[:, 1]) for kind, values in result.items()}


def draw_curves(ax: Axes, data: xr.Dataset, curves: Curves) -> list[Line2D]:
    """Draw curves over a plane, each in its dashes, within the limits that it has."""
    across, up = (path_scale(data, str(data.attrs[dim])).factor for dim in ("x", "y"))
    result: list[Line2D] = []
    for index, (label, (x, y)) in enumerate(curves.items()):
        dashes = DASHES[index % len(DASHES)]
        along = across * np.asarray(x, dtype=float), up * np.asarray(y, dtype=float)
        kept: dict[str, Any] = {"scalex": False, "scaley": False}
        ax.plot(*along, color=HALO, linewidth=2.6, **kept)
        look: dict[str, Any] = {"linewidth": 1.2, "linestyle": dashes, "label": label}
        result += ax.plot(*along, color=LINE, **look, **kept)
    return result


@styled
def period_figure(data: xr.Dataset, curves: Sequence[xr.Dataset] = ()) -> Figure | None:
    """The plane with its legend; None where it would be of one colour."""
    several = len(np.unique(classes(data))) > 1
    return figure_of(period_map(data, curves=curves)) if curves or several else None
