"""Outputs over time.

Those of sliders, drives and clearances are figures 3–9 of the paper.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.outputs import VARIABLES
from linkages.plots.layout import legend_above, time_axis
from linkages.plots.motion import curves
from linkages.plots.style import (
    axis_scale,
    figure_of,
    line_style,
    scale_of,
    set_title,
    styled,
    title,
)
from linkages.solution.extremes import even
from linkages.solution.run_options import turning_points
from linkages.solution.series import PIN, REACTION

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

MOST_LINES = 8  # in one panel: more can not be told apart
POLE = 12.0  # medians beyond which a value that may be infinite is not drawn
FORCE = "drive_force"  # efforts of drives that push: torques and forces have no common axis
WORST = ("transmission_angle",)
"""Angles that are bad near 0 and 180°; the peaks of others that count turns say nothing."""


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
    kept = np.flatnonzero(np.ptp(changes, axis=0) > curves.STEADY * np.abs(changes).max(axis=0))
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
    "drive_effort": efforts, FORCE: efforts, "load_force": varying, "load_torque": varying,
    REACTION: at_pins, "bar_angle": telling, "bar_speed": telling,
}  # fmt: skip
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
    def draw_figure(data: xr.Dataset, mechanism: Mechanism) -> Figure | None:
        chosen = SHOWN[variable](data, mechanism, variable) if variable in SHOWN else data
        if variable not in chosen or chosen[variable].size == 0:
            return None
        return figure_of(draw_page(chosen, variable, mechanism.name))

    return draw_figure


class Lines:
    """The series of a variable, as they are drawn; equal ones are one line.

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
        names = [
            ", ".join(place) for place in product(*([str(n) for n in data[d].values] for d in dims))
        ]
        values = values.reshape(len(self.time), len(names))
        item = VARIABLES.get(variable)
        if item is not None and item.reciprocal:
            values = without_poles(values)
        same = [_first_like(values, k) for k in range(len(names))]
        kept = [k for k, first in enumerate(same) if first == k]
        self.values: Array = values[:, kept]
        self.names = [
            ", ".join(n for n, f in zip(names, same, strict=True) if f == k) for k in kept
        ]
        self.scales = (
            scale_of(self.time, "s"), axis_scale(self.values, str(array.attrs.get("units", ""))),
        )  # fmt: skip
        self.label = str(array.attrs.get("long_name", item.long_name if item else variable))
        self.turning = item is not None and item.angle
        known: Mapping[str, tuple[float, float]] = array.attrs.get("farthest", {})
        smooth = (item is None or item.smooth) and even(self.time)
        horizon = data.attrs.get("horizon")
        self.peaks: list[curves.CurvePeak | None] = []
        for name, column in zip((names[k] for k in kept), self.values.T, strict=True):
            if item is not None and (item.reciprocal or item.angle):
                self.peaks.append(None)
            elif variable in WORST:
                self.peaks.append(curves.worst_of(self.time, column, horizon))
            elif name in known:
                value, time = known[name]
                self.peaks.append(curves.CurvePeak(time, value, curves.beyond(time, horizon)))
            else:
                self.peaks.append(curves.peak_of(self.time, column, horizon, smooth=smooth))

    @property
    def groups(self) -> list[tuple[list[int], bool]]:
        """Lines that share a panel: a dense one has its own, and angles of what turns round."""
        every = range(len(self.names))
        dense = [k for k in every if turning_points(self.values[:, k]) > curves.DENSE]
        round_ = [k for k in every if self.turning and np.ptp(self.values[:, k]) > 2 * np.pi]
        parts = [
            [k for k in every if k not in dense and (k in round_) == turns]
            for turns in (False, True)
        ]
        smooth = [p[k : k + MOST_LINES] for p in parts for k in range(0, len(p), MOST_LINES)]
        return [*((lines, False) for lines in smooth), *(([k], True) for k in dense)]

    def critical(self, lines: Iterable[int]) -> int | None:
        """The line whose peak decides: the largest, or the least one of angles that transmit."""

        def size(k: int) -> float:
            peak = self.peaks[k]
            assert peak is not None
            return abs(peak.value) if peak.word == "peak" else -abs(np.sin(peak.value))

        return max((k for k in lines if self.peaks[k] is not None), key=size, default=None)


def _first_like(values: Array, k: int) -> int:
    """The first column that is the same but for round-off."""
    least = curves.STEADY * np.abs(np.nan_to_num(values[:, k])).max(initial=0.0)
    apart = np.abs(values[:, : k + 1] - values[:, k : k + 1])
    return int(np.argmax((np.nan_to_num(apart, nan=0.0) <= least).all(axis=0)))


def without_poles(values: Array) -> Array:
    """Values without those near poles, which would hide all others, shape (samples, series)."""
    sizes = np.abs(np.where(np.isfinite(values), values, np.nan))
    most = POLE * np.nanmedian(sizes) if np.isfinite(sizes).any() else np.inf
    return np.where(sizes <= most, values, np.nan)


def draw_page(data: xr.Dataset, variable: str, heading: str = "") -> Axes:
    """A new figure of a variable over time; the axes of its first panel."""
    lines = Lines(data, variable)
    panels = curves.page(lines.groups)
    for panel in panels:
        _draw(panel.whole, lines, panel.lines, heading)
        if panel.detail is not None:
            _draw_detail(panel, lines)
    return panels[0].whole


def draw(ax: Axes, data: xr.Dataset, variable: str, heading: str = "") -> Axes:
    """Draw a variable over time, a line for each element; parameters as those of `Lines`.

    `heading`: stands before the name of a single line in the title, or over the legend.
    """
    lines = Lines(data, variable)
    return _draw(ax, lines, range(len(lines.names)), heading)


def _draw(ax: Axes, lines: Lines, chosen: Iterable[int], heading: str) -> Axes:
    """Draw some of the lines, and mark the peak that decides."""
    time, scales, drawn = lines.time, lines.scales, {}
    for k in chosen:
        drawn[k] = curves.draw_curve(ax, time, lines.values[:, k], scales, **line_style(k))
    ax.margins(x=0, y=0.14)
    time_axis(ax, time)
    ax.set_ylabel(scales[1].label(lines.label))
    curves.shade_beyond_horizon(ax, lines.data, time, scales[0])
    curves.show_steady(ax, lines.values[:, [*drawn]] * scales[1].factor)
    names = [lines.names[k] for k in drawn]
    if len(drawn) > 1:
        legend_above(ax, dict(zip(names, drawn.values(), strict=True)), heading)
    else:
        set_title(ax, title(heading, names[0]))
    worst = lines.critical(drawn)
    if worst is not None and (peak := lines.peaks[worst]):
        text = peak.text(scales, lines.names[worst] if len(drawn) > 1 else "")
        curves.mark_peak(ax, peak, scales, line_style(worst)["color"], text)
    return ax


def _draw_detail(panel: curves.Panel, lines: Lines) -> None:
    """A few swings around the peak of a line."""
    (k,) = panel.lines
    values, peak = lines.values[:, k], lines.peaks[k]
    colour = line_style(k)["color"]
    span = curves.swings_about(
        lines.time, values, peak.time if peak else lines.time[len(values) // 2]
    )
    curves.draw_detail(panel, [(lines.time, values, {"color": colour})], lines.scales, span)
    if peak and panel.detail and span[0] <= peak.time <= span[1]:
        curves.mark_peak(panel.detail, peak, lines.scales, colour)
