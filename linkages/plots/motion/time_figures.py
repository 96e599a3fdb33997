"""Quantities over time: slider motion and its errors, driving torques, clearance forces.

They are figures 3–9 of the paper.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.outputs import VARIABLES
from linkages.plots.motion.curves import (
    CurvePeak,
    annotate_peak,
    draw_curve,
    mark_peak,
    peak_of,
    peak_text,
    show_steady,
)
from linkages.plots.prefixes import Scale, scale_of
from linkages.plots.style import TOP, fitted, legend_above, line_style, panels, styled, title
from linkages.solution.resolved import per_swing
from linkages.solution.values.peaks import even

if TYPE_CHECKING:
    import xarray as xr

HEIGHT = 2.7
FEWEST = 12.0  # samples per swing: with fewer the tops of a curve look ragged
ROW, HEAD = 0.155, 0.04  # of a legend, in inches


def efforts(data: xr.Dataset, mechanism: Mechanism, variable: str) -> xr.Dataset:
    """Data with the efforts of one kind of drives: torques and forces have no common axis."""
    if "drive_effort" not in data:
        return data
    bodies, sliding = mechanism.bodies, variable == "drive_force"
    names = [n for n in data["drive"].values if (n in bodies and not bodies[n].rotates) == sliding]
    chosen = data.sel(drive=names)
    if sliding:
        force = chosen["drive_effort"].assign_attrs(units="N")
        chosen = chosen.drop_vars("drive_effort").assign(drive_force=force)
    return chosen


def varying(data: xr.Dataset, _: Mechanism, variable: str) -> xr.Dataset:
    """Data with the elements of a variable that are not the same at all times."""
    if variable not in data:
        return data
    values = data[variable]
    spread = values.max("time") - values.min("time") if values.sizes["time"] else values.sum("time")
    return data.isel({QUANTITIES[variable].dimension: np.flatnonzero(spread)})


class PlottedVariable(NamedTuple):
    """A variable over time.

    Attributes
    ----------
    dimension
        That its lines run along.
    label
        Its name on the axis.
    shown
        Data, mechanism and variable → the data that its figure shows.
    """

    dimension: str
    label: str
    shown: Callable[[xr.Dataset, Mechanism, str], xr.Dataset] = lambda data, *_: data


QUANTITIES = {
    "slider_position": PlottedVariable("slider", "displacement"),
    "slider_velocity": PlottedVariable("slider", "velocity"),
    "slider_acceleration": PlottedVariable("slider", "acceleration"),
    "slider_position_error": PlottedVariable("slider", "displacement error"),
    "slider_velocity_error": PlottedVariable("slider", "velocity error"),
    "slider_acceleration_error": PlottedVariable("slider", "acceleration error"),
    "clearance_force": PlottedVariable("clearance", "clearance force"),
    "drive_effort": PlottedVariable("drive", "driving torque", efforts),
    "drive_force": PlottedVariable("drive", "driving force", efforts),
    "load_force": PlottedVariable("force", "load", varying),
    "load_torque": PlottedVariable("torque", "load torque", varying),
}


def time_figure(variable: str) -> Callable[[xr.Dataset, Mechanism], Figure | None]:
    """The function that makes the figure of a variable over time.

    It returns None for data without the variable or without samples, and where it has nothing to
    show: of loads those that vary.
    """

    @styled
    def figure_of(data: xr.Dataset, mechanism: Mechanism) -> Figure | None:
        shown = QUANTITIES[variable].shown(data, mechanism, variable)
        if variable not in shown or shown[variable].size == 0:
            return None
        ax = draw(page(shown, variable), shown, variable, mechanism.name)
        return ax.get_figure(root=True)

    return figure_of


def page(data: xr.Dataset, variable: str) -> Axes:
    """Axes of a new figure, with room for the legend of a variable."""
    names = _names(data, variable)
    rows = -(-len(names) // _columns(names))
    legend = HEAD + rows * ROW if len(names) > 1 else 0.0
    return panels(1, 1, HEIGHT, TOP + legend)[1][0]


def draw(ax: Axes, data: xr.Dataset, variable: str, heading: str = "") -> Axes:
    """Draw a variable over time, a line for each slider, clearance or drive.

    Parameters
    ----------
    ax
        Where to draw.
    data
        SI units, named in ``attrs["units"]``; equally spaced samples.
    variable
        One of `QUANTITIES`.
    heading
        Stands before the name of a single line in the title, or over the legend.

    Returns
    -------
    Axes
        `ax`. The peak of a single line is written at its place, those of several in the legend,
        which stands above the axes and hides nothing.
    """
    quantity = QUANTITIES[variable]
    time = np.asarray(data["time"], dtype=float)
    array = data[variable].transpose("time", quantity.dimension)
    values = np.asarray(array, dtype=float)
    names = _names(data, variable)
    scales = scale_of(time, "s"), scale_of(values, str(array.attrs.get("units", "")))
    steady = (
        variable not in VARIABLES or VARIABLES[variable].smooth
    )  # as those of one kind of drive
    horizon, smooth = data.attrs.get("horizon"), steady and even(time)
    peaks = [peak_of(time, column, horizon, smooth=smooth) for column in values.T]
    lines = []
    for index, (column, peak) in enumerate(zip(values.T, peaks, strict=True)):
        look = line_style(index)
        lines.append(draw_curve(ax, time, column, scales, **look))
        if peak:
            mark_peak(ax, peak, scales, look["color"])
    _finish(ax, time, scales, quantity.label)
    if per_swing(data, [variable]) < FEWEST:
        ax.set_xlabel(f"{scales[0].label('time')}; samples do not show every swing")
    _shade_beyond_horizon(ax, data, time, scales[0])
    show_steady(ax, values * scales[1].factor)
    if len(names) > 1:
        entries = [_entry(name, peak, scales) for name, peak in zip(names, peaks, strict=True)]
        _legend(ax, lines, entries, heading, _columns(names))
    else:
        ax.set_title(fitted(title(heading, *names), ax.bbox.width / ax.figure.dpi))
        if peaks[0]:
            annotate_peak(ax, peaks[0], scales)
    return ax


def _finish(ax: Axes, time: np.ndarray, scales: tuple[Scale, Scale], label: str) -> None:
    """Limits and labels; room above and below the curve for the text at its peak."""
    ax.margins(x=0, y=0.14)
    if np.ptp(time) > 0:
        ax.set_xlim(time.min() * scales[0].factor, time.max() * scales[0].factor)
    ax.set_xlabel(scales[0].label("time"))
    ax.set_ylabel(scales[1].label(label))


def _shade_beyond_horizon(ax: Axes, data: xr.Dataset, time: np.ndarray, scale: Scale) -> None:
    """Shade the times at which the solution has fewer than three correct digits."""
    horizon = data.attrs.get("horizon")
    if horizon is None or not time.size:
        return
    begin, end = horizon * scale.factor, time[-1] * scale.factor
    ax.axvspan(begin, end, color="0.88", zorder=0, linewidth=0)
    ax.annotate(
        "not predictable",
        (begin, 0.015),
        xycoords=("data", "axes fraction"),
        xytext=(3, 0),
        textcoords="offset points",
        fontsize=8,
        color="0.35",
        ha="left" if abs(end - begin) > 0.25 * abs(time[-1] - time[0]) * scale.factor else "right",
    )


def _entry(name: str, peak: CurvePeak | None, scales: tuple[Scale, Scale]) -> str:
    """Text of the legend for one line."""
    short = fitted(name, 2.6, 8.0)
    return f"{short}: {peak_text(peak, scales)}" if peak else short


def _legend(ax: Axes, lines: list[Line2D], entries: list[str], heading: str, columns: int) -> None:
    """Above the axes, where `time_figure` leaves room for it."""
    ax.legend(
        lines,
        entries,
        **legend_above(heading),
        ncols=columns,
    )


def _names(data: xr.Dataset, variable: str) -> list[str]:
    return [str(name) for name in data[QUANTITIES[variable].dimension].values]


def _columns(names: list[str]) -> int:
    """Columns of the legend: two, if the names leave room for their peaks."""
    return 2 if max(map(len, names)) <= 16 else 1
