"""Phase diagrams: a free coordinate against its rate, and any two outputs against each other."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.outputs import VARIABLES
from linkages.plots.motion.curves import BUSY, DENSE, show_steady, swings_about
from linkages.plots.motion.free_axes import (
    KINDS,
    Free,
    free_coordinates,
    show_degrees,
    show_output,
    values_of,
)
from linkages.plots.motion.phase_curve import refined, spread, wrapped
from linkages.plots.prefixes import axis_scale
from linkages.plots.style import PALETTE, diagrams, fitted, line_style, panels, styled, title
from linkages.solution.resolved import turning_points
from linkages.solution.values.series import TIME, Series, data_series, find_series

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

MANY_POINTS = 500_000
FAINT = 0.3
"""Opacity of curves that cover themselves, so that what is dense looks dense."""


OUTPUTS = tuple(
    name for kind in KINDS for name in (*kind, VARIABLES[kind[1]].rate) if name in VARIABLES
)
"""What phase diagrams of free coordinates are made of."""


@styled
def figure(data: xr.Dataset, mechanism: Mechanism) -> Figure | None:
    """One panel for each clearance and each other free angle; None if there are none."""
    found = coordinates(data, mechanism)
    if not found or data.sizes["time"] == 0:
        return None
    shown = [(coordinate, part) for coordinate in found for part in _parts(data, coordinate)]
    result, axes = diagrams(len(shown))
    for ax, (coordinate, part) in zip(axes, shown, strict=True):
        whole = part.sizes["time"] == data.sizes["time"]
        draw(ax, part, coordinate, mechanism.name if len(found) == 1 else "", start=whole)
        if not whole:
            ax.set_title(f"{coordinate.name}, a few swings")
    return result


def _parts(data: xr.Dataset, coordinate: Free) -> list[xr.Dataset]:
    """The whole motion, and a few swings of it where its curve covers itself."""
    rates = values_of(data, coordinate, coordinate.rate)
    if turning_points(rates) <= DENSE:
        return [data]
    time = np.asarray(data["time"], dtype=float)
    low, high = swings_about(time, rates, float(time[len(time) // 2]), 2)
    return [data, data.isel(time=(time >= low) & (time <= high))]


def coordinates(data: xr.Dataset, mechanism: Mechanism) -> list[Free]:
    """Clearances, then bars and sliders that are free, as far as the data have them.

    Which are free say the mechanism and the data (``attrs["free"]``, separated by spaces).
    """
    free = f" {data.attrs.get('free', '')} "
    return [
        found
        for found in free_coordinates(data)
        if (found.dimension == "clearance" and found.name in mechanism.bodies)
        or found.name in mechanism.initial
        or f" {found.name} " in free
    ]


def draw(
    ax: Axes, data: xr.Dataset, coordinate: Free, heading: str = "", *, start: bool = True
) -> Axes:
    """Draw a coordinate against its rate; angles in degrees, within half a turn either way.

    Parameters
    ----------
    ax
        Where to draw.
    data
        SI units. Accelerations, where there are any, make the curve smooth between samples.
    coordinate
        What to draw.
    heading
        Stands before the name in the title.
    start
        Whether to mark where the curve begins.
    """
    x, y = (values_of(data, coordinate, output) for output in (coordinate.value, coordinate.rate))
    angle = VARIABLES[coordinate.value.variable].angle
    acceleration = VARIABLES[coordinate.rate.variable].rate
    if acceleration in data:
        slopes = np.asarray(data[acceleration].sel({coordinate.dimension: coordinate.name}))
        time = np.asarray(data["time"], dtype=float)
        x, y = refined(time, x, y, slopes.astype(float), 2 * np.pi if angle else 0.0)
    if angle:
        degrees, y = wrapped(x, y)
        x = np.radians(degrees)
    along, up = (
        show_output(ax, way, data, output, values)
        for way, output, values in (("x", coordinate.value, x), ("y", coordinate.rate, y))
    )
    draw_curve(ax, degrees if angle else along * x, up * y, start=start)
    ax.set_title(fitted(title(heading, coordinate.name), ax.bbox.width / ax.figure.dpi - 0.7))
    return ax


def draw_curve(ax: Axes, x: Array, y: Array, *, start: bool = True) -> None:
    """A line, or dots for a run so long that lines would cover each other; and its start."""
    if len(x) > MANY_POINTS:
        ax.plot(
            *spread(x, y), "o", color=PALETTE[0], markersize=0.7, markeredgewidth=0, alpha=FAINT
        )
    else:
        turns = turning_points(y)
        look: dict[str, Any] = {
            "linewidth": 1.0 if turns < BUSY else 0.5,
            "alpha": 1.0 if turns < DENSE else FAINT,
        }
        ax.plot(x, y, color=PALETTE[0], marker="." if len(x) == 1 else "", **look)
    if start:
        ring = line_style(1) | {"linestyle": "", "marker": "o", "markersize": 5}
        ax.plot(x[:1], y[:1], **ring, markerfacecolor="white", label="start", zorder=4)
        ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0, handlelength=1.0)
    show_steady(ax, y)


@styled
def pair_figure(data: xr.Dataset, x: str, y: str, *, wrap: bool = True) -> Figure | None:
    """One output against another; None for data without samples.

    Parameters
    ----------
    data
        A solution's data.
    x, y
        What to draw, such as ``"r1.angle"``, ``"slider9.velocity"`` or ``"time"``.
    wrap
        Whether angles are taken within half a turn either way.

    Raises
    ------
    ValueError
        For names that the data do not have.
    """
    known = data_series(data)
    across, up = find_series(known, x), find_series(known, y)
    if not data.sizes["time"]:
        return None
    result, (ax,) = panels(1, 1, 3.6)
    draw_pair(ax, data, across, up, wrap)
    heading = str(data.attrs.get("name", ""))
    ax.set_title(fitted(heading, ax.bbox.width / result.dpi - 0.7))
    return result


def draw_pair(ax: Axes, data: xr.Dataset, x: Series, y: Series, wrap: bool = True) -> Axes:
    """Draw one series against another, angles in degrees; parameters as of `pair_figure`.

    Over time, angles are never taken within one turn.
    """
    across, label_x = _shown(data, x)
    up, label_y = _shown(data, y)
    if TIME in (x.variable, y.variable):
        ax.plot(across, up, color=PALETTE[0], linewidth=1.0)
        ax.margins(x=0.0 if x.variable == TIME else None)
    else:
        if wrap and x.angle:
            across, up = wrapped(np.radians(across), up)
        if wrap and y.angle:
            up, across = wrapped(np.radians(up), across)
        draw_curve(ax, across, up)
    units = {data[s.variable].attrs.get("units") for s in (x, y) if s.variable != TIME}
    if units == {"m"} and TIME not in (x.variable, y.variable):
        ax.set_aspect("equal", adjustable="datalim")
    if x.angle:
        show_degrees(ax, across)
    if y.angle:
        show_degrees(ax, up, "y")
    ax.set_xlabel(label_x)
    ax.set_ylabel(label_y)
    return ax


def _shown(data: xr.Dataset, series: Series) -> tuple[Array, str]:
    """Values as they are drawn, and the label of their axis."""
    values = np.asarray(series.of(data), dtype=float)
    attrs = data[series.variable].attrs
    known = VARIABLES[series.variable].long_name if series.variable in VARIABLES else TIME
    scale = axis_scale(values, str(attrs.get("units", "s" if series.variable == TIME else "")))
    return values * scale.factor, scale.label(series.words(str(attrs.get("long_name", known))))
