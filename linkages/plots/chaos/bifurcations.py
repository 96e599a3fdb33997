"""Bifurcation diagrams: section points over a parameter, and the largest Lyapunov exponent."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from linkages.plots.chaos.parameters import (
    HATCHING,
    LOST,
    cell_borders,
    contact_lost,
    show_path,
    shown_values,
)
from linkages.plots.chaos.sections import SMALLEST
from linkages.plots.motion.free_axes import Free, free_coordinates, show_output, values_of
from linkages.plots.style import (
    BLACK,
    BOTTOM,
    LEFT,
    PALE,
    PALETTE,
    RIGHT,
    TOP,
    WIDTH,
    patches_above,
    styled,
)

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

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
def figure(data: xr.Dataset, *, rates: bool = False) -> Figure | None:
    """Points of each free coordinate over the parameter, with the exponent below where known.

    Parameters
    ----------
    data
        As `linkages.bifurcation` returns it; names in a coordinate ``start`` stand in the legend.
    rates
        Whether to draw rates instead of values, and no exponents.

    Returns
    -------
    None for data without points.
    """
    found = free_coordinates(data)
    if not found or not data.sizes["value"]:
        return None
    below = "exponent" in data and not rates
    entries = _entries(data)
    legend = LEGEND * -(-len(entries) // _columns(entries))
    result, axes = _stacked(len(found) + below, legend, HEADED if len(found) > 1 else GAP)
    for ax, coordinate in zip(axes, found, strict=False):
        draw(ax, data, coordinate, rates=rates)
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


def draw(ax: Axes, data: xr.Dataset, coordinate: Free, *, rates: bool = False) -> Axes:
    """Draw the section points of one free coordinate, each initial condition in its colour.

    Parameters
    ----------
    ax
        Where to draw.
    data
        With dimensions ``start``, ``value``, ``crossing``.
    coordinate
        What to draw.
    rates
        Whether to draw its rate.
    """
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
