"""Outputs over time.

Those of sliders, drives and clearances are figures 3–9 of the paper.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.outputs import VARIABLES
from linkages.plots.motion.curves import (
    DENSE,
    STEADY,
    CurvePeak,
    annotate_peak,
    beyond,
    draw_curve,
    mark_peak,
    mark_place,
    peak_of,
    peak_text,
    shade_beyond_horizon,
    show_steady,
    swings_about,
)
from linkages.plots.style import (
    BOTTOM,
    LEFT,
    RIGHT,
    TOP,
    WIDTH,
    Scale,
    axis_scale,
    fitted,
    legend_above,
    line_style,
    scale_of,
    styled,
    title,
)
from linkages.solution.extremes import even
from linkages.solution.run_options import turning_points
from linkages.solution.series import PIN, REACTION

if TYPE_CHECKING:
    import xarray as xr

HEIGHT, LOW = 2.7, 1.9
"""Inches: of a panel that stands alone, and of one of several."""

ROW, HEAD = 0.155, 0.04
"""Inches: a row of a legend, and what it keeps from the panel."""

ZOOM, GAP, SCALE = 0.29, 0.36, 0.5
"""Part of the width that a few swings get; inches between, and for the numbers at the right."""


class Group(NamedTuple):
    """Lines that share a panel: numbers of them, and whether they are denser than the paper."""

    lines: tuple[int, ...]
    dense: bool


class Panel(NamedTuple):
    """Axes of a group, and those of a few of its swings if it is dense."""

    whole: Axes
    swings: Axes | None


def rows_of_legend(entries: int, columns: int) -> float:
    """Inches that a legend above a panel takes beyond a title."""
    return HEAD + -(-entries // columns) * ROW if entries > 1 else 0.0


def page(groups: list[Group], columns: int) -> list[Panel]:
    """A new figure with a panel for each group, one below the other."""
    height = HEIGHT if len(groups) == 1 else LOW
    tops = [TOP + rows_of_legend(len(group.lines), columns) for group in groups]
    total = sum(tops) + len(groups) * (height + BOTTOM)
    figure = Figure(figsize=(WIDTH, total))
    panels, above = [], 0.0
    for group, top in zip(groups, tops, strict=True):
        bottom = (total - above - top - height) / total
        above += top + height + BOTTOM

        def axes(left: float, right: float, bottom: float = bottom) -> Axes:
            box = (left / WIDTH, bottom, (right - left) / WIDTH, height / total)
            return figure.add_axes(box)

        if not group.dense:
            panels.append(Panel(axes(LEFT, WIDTH - RIGHT), None))
            continue
        split = WIDTH - SCALE - ZOOM * (WIDTH - LEFT - SCALE)
        panels.append(Panel(axes(LEFT, split - GAP / 2), axes(split + GAP / 2, WIDTH - SCALE)))
    return panels


Array = NDArray[np.float64]

MOST_LINES = 8
"""In one panel: more can not be told apart."""

POLE = 12.0
"""Medians beyond which a value that may be infinite is not drawn."""

FORCE = "drive_force"
"""Efforts of drives that push: torques and forces have no common axis."""


def efforts(data: xr.Dataset, mechanism: Mechanism, variable: str) -> xr.Dataset:
    """Data with the efforts of one kind of drives."""
    if "drive_effort" not in data:
        return data
    sliding, known = variable == FORCE, {*mechanism.bodies, *mechanism.actuations}
    pushes = [n in known and not mechanism.twisting(n) for n in data["drive"].values]
    names = [n for n, push in zip(data["drive"].values, pushes, strict=True) if push == sliding]
    chosen = data.sel(drive=names)
    words = {"units": "N", "long_name": "driving force"} if sliding else {"units": "N m"}
    effort = chosen["drive_effort"].assign_attrs(words)
    return chosen.drop_vars("drive_effort").assign({variable: effort})


def varying(data: xr.Dataset, _: Mechanism, variable: str) -> xr.Dataset:
    """Data with the elements of a variable that are not the same at all times."""
    if variable not in data:
        return data
    values = data[variable]
    spread = values.max("time") - values.min("time") if values.sizes["time"] else values.sum("time")
    return data.isel({str(values.dims[1]): np.flatnonzero(spread)})


def telling(data: xr.Dataset, _: Mechanism, variable: str) -> xr.Dataset:
    """Data without bars that turn steadily, as cranks do, where there are others."""
    if variable not in data or data.sizes["time"] < 3:
        return data
    array = data[variable].transpose("time", ...)
    values = np.asarray(array, dtype=float)
    changes = np.diff(values, axis=0) if VARIABLES[variable].angle else values
    kept = np.flatnonzero(np.ptp(changes, axis=0) > STEADY * np.abs(changes).max(axis=0))
    return data.isel({str(array.dims[1]): kept}) if kept.size else data


def at_pins(data: xr.Dataset, _: Mechanism | None = None, variable: str = REACTION) -> xr.Dataset:
    """Reactions of joints; where three bodies or more meet, that of the body with the largest."""
    if variable != REACTION or not {REACTION, PIN} <= {*map(str, data)} or not data.sizes["time"]:
        return data
    reaction, pins = (data[name].transpose("time", ..., "axis") for name in (REACTION, PIN))
    sizes = np.linalg.norm(pins, axis=-1).max(axis=0)
    largest = {  # the last one for a joint is kept
        str(data["pin"].values[k]).rpartition(".")[0]: k for k in np.argsort(sizes)
    }
    joints = [str(name) for name in data["joint"].values]
    shown = reaction.to_numpy().copy()
    for joint, k in largest.items():
        shown[:, joints.index(joint)] = pins[:, k]
    names = [str(data["pin"].values[largest[j]]) if j in largest else j for j in joints]
    result = reaction.copy(data=shown).assign_coords(joint=np.array(names, dtype=object))
    return result.to_dataset(name=REACTION).assign_attrs(data.attrs)


SHOWN: Mapping[str, Callable[[xr.Dataset, Mechanism, str], xr.Dataset]] = {
    "drive_effort": efforts,
    FORCE: efforts,
    "load_force": varying,
    "load_torque": varying,
    REACTION: at_pins,
    "bar_angle": telling,
    "bar_speed": telling,
}
"""Variable → the data that its figure shows, of those whose figure does not show all."""


def drawable(variable: str) -> bool:
    """Whether a variable has a figure over time: numbers, or vectors with a magnitude."""
    if variable == FORCE:
        return True
    result = VARIABLES[variable]
    return not result.flags and (result.magnitude or "axis" not in result.dims)


def time_figure(variable: str) -> Callable[[xr.Dataset, Mechanism], Figure | None]:
    """The function that makes the figure of a variable over time.

    It returns None for data without the variable or without samples, and where it has nothing to
    show: of loads those that vary.
    """

    @styled
    def figure_of(data: xr.Dataset, mechanism: Mechanism) -> Figure | None:
        chosen = SHOWN[variable](data, mechanism, variable) if variable in SHOWN else data
        if variable not in chosen or chosen[variable].size == 0:
            return None
        return draw_page(chosen, variable, mechanism.name).get_figure(root=True)

    return figure_of


class Lines:
    """The series of a variable, as they are drawn.

    `data`: SI units, named in ``attrs["units"]``; equally spaced samples. A variable may say where
    its series are farthest from zero: ``attrs["farthest"]``, name → value and time.
    `variable`: what is drawn; of vectors the magnitudes.
    """

    def __init__(self, data: xr.Dataset, variable: str) -> None:
        array = data[variable].transpose("time", ...)
        values = np.asarray(array, dtype=float)
        dims = [str(dim) for dim in array.dims[1:]]
        if "axis" in dims:
            values, dims = np.hypot.reduce(values, axis=-1), dims[:-1]
        self.data, self.time = data, np.asarray(data["time"], dtype=float)
        self.names = [
            ", ".join(place) for place in product(*([str(n) for n in data[d].values] for d in dims))
        ]
        self.values: Array = values.reshape(len(self.time), len(self.names))
        if variable in VARIABLES and VARIABLES[variable].reciprocal:
            self.values = without_poles(self.values)
        units = str(array.attrs.get("units", ""))
        self.scales = scale_of(self.time, "s"), axis_scale(self.values, units)
        known = VARIABLES[variable].long_name if variable in VARIABLES else variable
        self.label = str(array.attrs.get("long_name", known))
        self.peaks = self._peaks(variable, array.attrs.get("farthest", {}))

    def _peaks(
        self, variable: str, known: Mapping[str, tuple[float, float]]
    ) -> list[CurvePeak | None]:
        horizon = self.data.attrs.get("horizon")
        result = VARIABLES.get(variable)
        smooth = (result is None or result.smooth) and even(self.time)
        if result is not None and result.reciprocal:
            return [None] * len(self.names)
        peaks: list[CurvePeak | None] = []
        for name, column in zip(self.names, self.values.T, strict=True):
            if name in known:
                value, time = known[name]
                peaks.append(CurvePeak(time, value, beyond(time, horizon)))
            else:
                peaks.append(peak_of(self.time, column, horizon, smooth=smooth))
        return peaks

    @property
    def columns(self) -> int:
        """Columns of the legend: two, if the names leave room for their peaks."""
        return 2 if max(map(len, self.names)) <= 16 else 1

    @property
    def groups(self) -> list[Group]:
        """Lines that share a panel: a dense one has its own."""
        dense = [k for k, row in enumerate(self.values.T) if turning_points(row) > DENSE]
        others = [k for k in range(len(self.names)) if k not in dense]
        smooth = [others[k : k + MOST_LINES] for k in range(0, len(others), MOST_LINES)]
        return [
            *(Group(tuple(lines), dense=False) for lines in smooth),
            *(Group((k,), dense=True) for k in dense),
        ]


def without_poles(values: Array) -> Array:
    """Values without those near poles, which would hide all others, shape (samples, series)."""
    sizes = np.abs(np.where(np.isfinite(values), values, np.nan))
    most = POLE * np.nanmedian(sizes) if np.isfinite(sizes).any() else np.inf
    return np.where(sizes <= most, values, np.nan)


def draw_page(data: xr.Dataset, variable: str, heading: str = "") -> Axes:
    """A new figure of a variable over time; the axes of its first panel."""
    lines = Lines(data, variable)
    groups = lines.groups
    panels = page(groups, lines.columns)
    for group, panel in zip(groups, panels, strict=True):
        _draw(panel.whole, lines, group.lines, heading)
        if panel.swings is not None:
            _draw_swings(panel, panel.swings, lines, group.lines[0])
    return panels[0].whole


def draw(ax: Axes, data: xr.Dataset, variable: str, heading: str = "") -> Axes:
    """Draw a variable over time, a line for each element.

    Parameters
    ----------
    ax
        Where to draw.
    data, variable
        As `Lines` takes them.
    heading
        Stands before the name of a single line in the title, or over the legend.

    Returns
    -------
    Axes
        `ax`. The peak of a single line is written at its place, those of several in the legend,
        which stands above the axes and hides nothing.
    """
    lines = Lines(data, variable)
    return _draw(ax, lines, range(len(lines.names)), heading)


def _draw(ax: Axes, lines: Lines, chosen: Iterable[int], heading: str) -> Axes:
    """Draw some of the lines."""
    scales, drawn = lines.scales, {}
    for k in chosen:
        look, peak = line_style(k), lines.peaks[k]
        drawn[k] = draw_curve(ax, lines.time, lines.values[:, k], scales, **look)
        if peak:
            mark_peak(ax, peak, scales, look["color"])
    _finish(ax, lines)
    shade_beyond_horizon(ax, lines.data, lines.time, scales[0])
    show_steady(ax, lines.values[:, [*drawn]] * scales[1].factor)
    if len(drawn) > 1:
        entries = [_entry(lines.names[k], lines.peaks[k], scales) for k in drawn]
        ax.legend([*drawn.values()], entries, **legend_above(heading), ncols=lines.columns)
        return ax
    (only,) = drawn
    ax.set_title(fitted(title(heading, lines.names[only]), ax.bbox.width / ax.figure.dpi))
    if peak := lines.peaks[only]:
        annotate_peak(ax, peak, scales)
    return ax


def _draw_swings(panel: Panel, ax: Axes, lines: Lines, k: int) -> None:
    """A few swings around the peak of a line, and where they are in the whole of it."""
    scale, shown = lines.scales
    values, peak = lines.values[:, k], lines.peaks[k]
    at = lines.time[len(values) // 2] if peak is None else peak.time
    low, high = swings_about(lines.time, values, at)
    inside = (lines.time >= low) & (lines.time <= high)
    colour = line_style(k)["color"]
    ax.plot(lines.time[inside] * scale.factor, values[inside] * shown.factor, color=colour)
    if peak and low <= peak.time <= high:
        mark_peak(ax, peak, lines.scales, colour)
    ax.set_xlim(low * scale.factor, high * scale.factor)
    ax.margins(y=0.14)
    ax.xaxis.set_major_locator(MaxNLocator(3, prune="both"))
    ax.yaxis.tick_right()
    ax.ticklabel_format(axis="y", scilimits=(-3, 5))
    ax.set_xlabel(scale.label("time"))
    ax.set_title("a few swings")
    mark_place(panel.whole, 0.5 * (low + high) * scale.factor)


def _finish(ax: Axes, lines: Lines) -> None:
    """Limits and labels; room above and below the curve for the text at its peak."""
    time, scales = lines.time, lines.scales
    ax.margins(x=0, y=0.14)
    if np.ptp(time) > 0:
        ax.set_xlim(time.min() * scales[0].factor, time.max() * scales[0].factor)
    ax.set_xlabel(scales[0].label("time"))
    ax.set_ylabel(scales[1].label(lines.label))


def _entry(name: str, peak: CurvePeak | None, scales: tuple[Scale, Scale]) -> str:
    """Text of the legend for one line."""
    short = fitted(name, 2.6, 8.0)
    return f"{short}: {peak_text(peak, scales)}" if peak else short
