"""Figures of series that lie over each other, of one motion or of several."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.outputs import VARIABLES
from linkages.plots.layout import axes_for, chart, diagrams, legend_above
from linkages.plots.motion.compared import Compared, Curve, compared, data_of
from linkages.plots.motion.curves import (
    DENSE,
    Panel,
    draw_curve,
    draw_detail,
    page,
    show_steady,
    swings_about,
)
from linkages.plots.motion.phase_diagrams import draw_curve as draw_phase
from linkages.plots.motion.phase_diagrams import show_degrees, wrapped
from linkages.plots.motion.time_figures import at_pins
from linkages.plots.style import (
    BLACK,
    DEGREES,
    PALETTE,
    Scale,
    axis_scale,
    figure_of,
    line_style,
    scale_of,
    set_heading,
    set_title,
    styled,
    title,
)
from linkages.solution.run_options import turning_points
from linkages.solution.series import TIME

if TYPE_CHECKING:
    import xarray as xr

    from linkages.solution.solution import Solution

VEILED = 0.55  # opacity of an envelope that lies over another one
THIN = 0.6  # width of a line that is denser than the paper, over what is not time


@styled
def figure(found: Compared, *, wrap: bool = False) -> Figure:
    """A panel for each unit, with a detail beside where curves over time are dense."""
    units: dict[str, list[int]] = {}
    for k, curve in enumerate(found.curves):
        units.setdefault(curve.units, []).append(k)
    groups = [
        (lines, found.over_time and any(dense(found.curves[k]) for k in lines))
        for lines in units.values()
    ]
    parts = [replace(found, curves=tuple(found.curves[k] for k in lines)) for lines, _ in groups]
    panels = page(groups, 4.6 if is_place(found) else 2.7)
    for panel, part in zip(panels, parts, strict=True):
        draw(panel.whole, part, wrap=wrap)
        if panel.detail is not None:
            _draw_detail(panel, part)
    return figure_of(panels[0].whole)


def dense(curve: Curve) -> bool:
    """Whether a curve is denser than the paper."""
    return turning_points(curve.y) > DENSE


def is_place(found: Compared) -> bool:
    """Whether lengths are drawn over lengths, with equal scales."""
    return {found.units, *(curve.units for curve in found.curves)} == {"m"}


def draw(ax: Axes, found: Compared, *, wrap: bool = False) -> Axes:
    """Draw curves of one unit; ValueError for those of several, which have no common axis.

    `wrap`: whether angles to the right are taken within half a turn either way.
    """
    units = {curve.units for curve in found.curves}
    if len(units) > 1:
        shown = " and ".join(repr(unit) for unit in units)
        raise ValueError(f"series in {shown} have no common axis; expected those of one unit")
    scales = scales_of(found)
    lines, many = [], len(found.curves) > 1
    for k, curve in enumerate(found.curves):
        look = line_style(k)
        if found.over_time:
            opacity = {"alpha": VEILED} if many and dense(curve) else {}
            lines.append(draw_curve(ax, curve.x, curve.y, scales, **look, **opacity))
        else:
            lines.append(_draw_over(ax, curve, scales, look, wrap and found.units == "rad"))
    _finish(ax, found, scales)
    if many:
        entries = dict(zip(entries_of(found.curves), lines, strict=True))
        legend_above(ax, entries, found.heading)
    else:
        set_title(ax, found.heading)
    return ax


def scales_of(found: Compared) -> tuple[Scale, Scale]:
    """Scales of both axes; one for both where lengths are drawn over lengths."""
    x = np.concatenate([curve.x for curve in found.curves])
    y = np.concatenate([curve.y for curve in found.curves])
    if is_place(found):
        both = scale_of(np.concatenate([x, y]), "m")
        return both, both
    return axis_scale(x, found.units), axis_scale(y, found.curves[0].units)


def _draw_over(
    ax: Axes, curve: Curve, scales: tuple[Scale, Scale], look: dict[str, object], wrap: bool
) -> Line2D:
    """Draw a curve over something else than time."""
    x, y = curve.x * scales[0].factor, curve.y * scales[1].factor
    if wrap:
        degrees, y = wrapped(curve.x, y)
        x = degrees / DEGREES * scales[0].factor
    if dense(curve):
        look = look | {"linewidth": THIN, "linestyle": "-", "alpha": VEILED}
    (line,) = ax.plot(x, y, marker="." if len(x) == 1 else "", **look)  # type: ignore[arg-type]
    return line


def _finish(ax: Axes, found: Compared, scales: tuple[Scale, Scale]) -> None:
    ax.set_xlabel(scales[0].label(found.across))
    ax.set_ylabel(scales[1].label(_common(found.curves)))
    if is_place(found):
        ax.set_aspect("equal", adjustable="datalim")
        return
    show_steady(ax, np.concatenate([curve.y for curve in found.curves]) * scales[1].factor)
    if found.over_time:
        ends = np.concatenate([curve.x[[0, -1]] for curve in found.curves]) * scales[0].factor
        if np.ptp(ends) > 0:
            ax.set_xlim(ends.min(), ends.max())
    elif scales[0].units == "°":
        drawn = [line.get_xdata() for line in ax.lines]
        show_degrees(ax, np.concatenate([np.asarray(x, dtype=float) for x in drawn]))
        ax.margins(x=0)


def _common(curves: Sequence[Curve]) -> str:
    """What curves have in common: the name of a series, or that of a quantity."""
    for words in ({c.name for c in curves}, {c.quantity for c in curves}):
        if len(words) == 1:
            return words.pop()
    return " or ".join(dict.fromkeys(curve.quantity for curve in curves))


def entries_of(curves: Sequence[Curve]) -> list[str]:
    """What curves differ in: the series, or the motion, or both."""
    series = len({curve.name for curve in curves}) > 1
    return [
        ", ".join(part for part in ((curve.name if series else ""), curve.source) if part)
        for curve in curves
    ]


def _draw_detail(panel: Panel, found: Compared) -> None:
    """A few swings of all curves where the first dense one is largest."""
    first = next(curve for curve in found.curves if dense(curve))
    span = swings_about(first.time, first.y, float(first.time[np.nanargmax(np.abs(first.y))]))
    lines = [(curve.time, curve.y, line_style(k)) for k, curve in enumerate(found.curves)]
    draw_detail(panel, lines, scales_of(found), span)


@styled
def pair_figure(data: xr.Dataset, x: str, y: str, *, wrap: bool = True) -> Figure | None:
    """One output against another; None for data without samples."""
    return figure_of(pair(data, x, y, wrap=wrap)) if data.sizes[TIME] else None


@chart
def pair(
    source: Solution | xr.Dataset, x: str, y: str, ax: Axes | None = None, *, wrap: bool = True
) -> Axes:
    """One output against another, such as ``"r1.angle"`` and ``"slider9.velocity"``.

    `x`: Name of a series: an element and a quantity, or an output that has no elements.
    `y`: Another one.
    `wrap`: Whether angles are taken within half a turn either way.
    """
    ax = axes_for(ax)
    found = compared({"": data_of(source)}, [y], x)
    (curve,), scales = found.curves, scales_of(found)
    across, up = scales[0].factor * curve.x, scales[1].factor * curve.y
    if TIME in (found.across, curve.name):
        ax.plot(across, up, color=PALETTE[0], linewidth=1.0)
    else:
        if wrap and found.units == "rad":
            across, up = wrapped(np.radians(across), up)
        if wrap and curve.units == "rad":
            up, across = wrapped(np.radians(up), across)
        draw_phase(ax, across, up)
    _finish(ax, found, scales)
    if curve.units == "rad":
        show_degrees(ax, up, "y")
    set_title(ax, found.heading)
    return ax


POLAR = ("joint_reaction", "shaking_force")  # vectors whose direction matters as much as their size
MOST = 12  # diagrams in one figure


def polar_of(variable: str) -> Callable[[xr.Dataset, Mechanism], Figure | None]:
    """The function that makes polar diagrams of a vector, one for each joint; None without data."""

    @styled
    def draw_figure(data: xr.Dataset, _: Mechanism) -> Figure | None:
        if variable not in data or not data[variable].size:
            return None
        data = at_pins(data, variable=variable)
        names = moving_vectors(data, variable)[:MOST]
        return polar_figure([tips(data, variable, name) for name in names]) if names else None

    return draw_figure


def moving_vectors(data: xr.Dataset, variable: str) -> list[str]:
    """Elements whose vector is not zero all the time."""
    array = data[variable].transpose("time", ..., "axis")
    sizes = np.abs(np.asarray(array, dtype=float)).max(axis=(0, 2), initial=0.0)
    return [str(n) for n, size in zip(data[array.dims[1]].values, sizes, strict=True) if size > 0]


def tips(data: xr.Dataset, variable: str, name: str) -> Compared:
    """The tip of the vector of an element, as data have it."""
    array = data[variable].transpose("time", ..., "axis")
    x, y = np.asarray(array.sel({str(array.dims[1]): name}), dtype=float).T
    words = str(array.attrs.get("long_name", VARIABLES[variable].long_name))
    sizes, units = np.hypot(x, y), str(array.attrs.get("units", ""))
    known = float(np.nanmax(sizes)) if np.isfinite(sizes).any() else np.nan
    most, _ = array.attrs.get("farthest", {}).get(name, (known, 0.0))
    time = data[TIME].to_numpy().astype(float)
    curve = Curve("", name, words, units, time, x, y, 0.0, most)
    return Compared((curve,), f"{words}, x", units, str(data.attrs.get("name", "")))


@styled
def polar_figure(found: Sequence[Compared]) -> Figure:
    """A diagram for each vector: the way of its tip around zero."""
    result, axes = diagrams(len(found))
    for ax, one in zip(axes, found, strict=True):
        draw_vectors(ax, one if len(found) == 1 else replace(one, heading=""))
    if len(found) > 1:
        set_heading(result, found[0].heading)
    return result


def draw_vectors(ax: Axes, found: Compared) -> Axes:
    """Draw the tips of vectors around zero, with equal scales.

    Of a single one a ring marks the start, a full dot the largest size.
    """
    size = np.concatenate([np.hypot(curve.x, curve.y) for curve in found.curves])
    scale, lines = axis_scale(size, found.units), {}
    for k, curve in enumerate(found.curves):
        look = line_style(k) | ({"linewidth": THIN, "alpha": VEILED} if dense(curve) else {})
        (lines[curve.source],) = ax.plot(curve.x * scale.factor, curve.y * scale.factor, **look)
    ax.plot([0], [0], "+", color=BLACK, markersize=7, zorder=3)
    ax.margins(0.12)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel(scale.label(found.across))
    ax.set_ylabel(scale.label("y"))
    if len(found.curves) > 1:
        legend_above(ax, lines, found.heading)
        return ax
    (curve,) = found.curves
    x, y = scale.factor * curve.x, scale.factor * curve.y
    mark: dict[str, Any] = {"color": PALETTE[1], "zorder": 4}
    ax.plot(x[:1], y[:1], "o", markersize=5, markerfacecolor="white", **mark)
    if np.isfinite(curve.greatest):
        at = int(np.nanargmax(np.hypot(x, y)))
        ax.plot([0, x[at]], [0, y[at]], linewidth=0.8, **mark)
        ax.plot(x[at], y[at], "o", markersize=4, **mark)
        set_title(ax, title(found.heading, f"{curve.name}, up to {scale.text(curve.greatest)}"))
    return ax
