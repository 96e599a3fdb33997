"""Figures of series that lie over each other, of one motion or of several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from linkages.plots.motion.compared import Compared, Curve, compared, data_of
from linkages.plots.motion.curves import (
    DENSE,
    draw_curve,
    mark_peak,
    shade_beyond_horizon,
    show_steady,
    span_words,
    swings_about,
)
from linkages.plots.motion.phase_diagrams import draw_curve as draw_phase
from linkages.plots.motion.phase_diagrams import wrapped
from linkages.plots.panels import (
    axes_for,
    chart,
    diagram_each,
    legend_above,
    mosaic,
    show_degrees,
    time_axis,
)
from linkages.plots.style import (
    BLACK,
    DEGREES,
    PALETTE,
    Scale,
    axis_scale,
    figure_of,
    line_style,
    scale_of,
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


Group = tuple[Compared, Sequence[int], bool]
"""Curves of one unit, numbers of those that share a panel, and whether these are dense."""


@styled
def figure(found: Compared, *, wrap: bool = False) -> Figure:
    """A panel for each unit, with a detail beside where curves over time are dense."""
    groups: list[Group] = []
    for unit in dict.fromkeys(curve.units for curve in found.curves):
        part = replace(found, curves=tuple(c for c in found.curves if c.units == unit))
        swings = found.over_time and any(map(dense, part.curves))
        groups.append((part, range(len(part.curves)), swings))
    return figure_of(draw_page(groups, 4.6 if is_place(found) else 2.7, wrap=wrap))


def draw_page(groups: Sequence[Group], joint: float = 2.7, *, wrap: bool = False) -> Axes:
    """A new figure with a panel for each group, and a detail beside dense ones; its first axes.

    `joint`: inches of a panel that stands alone.
    """
    first = np.cumsum([0, *(1 + swings for *_, swings in groups)])
    places = [[k, k + swings] for k, (*_, swings) in zip(first, groups, strict=False)]
    heights = [joint if len(groups) == 1 else 1.9] * len(groups)
    _, axes = mosaic(places, heights, widths=(0.7, 0.3))
    for (whole, detail), (found, lines, swings) in zip(places, groups, strict=True):
        draw(axes[whole], found, lines, wrap=wrap)
        if swings:
            _draw_detail(axes[whole], axes[detail], found, lines)
    return axes[0]


def dense(curve: Curve) -> bool:
    """Whether a curve is denser than the paper."""
    return turning_points(curve.y) > DENSE


def is_place(found: Compared) -> bool:
    """Whether lengths are drawn over lengths, with equal scales."""
    return {found.units, *(curve.units for curve in found.curves)} == {"m"}


def draw(
    ax: Axes, found: Compared, chosen: Sequence[int] | None = None, *, wrap: bool = False
) -> Axes:
    """Draw curves of one unit; ValueError for those of several, which have no common axis.

    `chosen`: numbers of those that are drawn; all if not given. `wrap`: whether angles to the right
    are taken within half a turn either way.
    """
    units = {curve.units for curve in found.curves}
    if len(units) > 1:
        shown = " and ".join(repr(unit) for unit in units)
        raise ValueError(f"series in {shown} have no common axis; expected those of one unit")
    scales, lines = scales_of(found), []
    numbers = range(len(found.curves)) if chosen is None else chosen
    curves = [found.curves[k] for k in numbers]
    many = len(curves) > 1
    for k, curve in zip(numbers, curves, strict=True):
        look = line_style(k)
        if found.over_time:
            opacity = {"alpha": VEILED} if many and dense(curve) else {}
            lines.append(draw_curve(ax, curve.x, curve.y, scales, **look, **opacity))
        else:
            lines.append(_draw_over(ax, curve, scales, look, wrap and found.units == "rad"))
    _finish(ax, found, curves, scales)
    if many:
        legend_above(ax, dict(zip(entries_of(curves), lines, strict=True)), found.heading)
    else:
        set_title(ax, title(found.heading, curves[0].name * bool(found.label)))
    peaks = {k: peak for k, curve in zip(numbers, curves, strict=True) if (peak := curve.peak)}
    if peaks:
        worst = max(peaks, key=lambda k: peaks[k].weight)
        text = peaks[worst].text(scales, found.curves[worst].name * many)
        mark_peak(ax, peaks[worst], scales, line_style(worst)["color"], text)
    return ax


def scales_of(found: Compared) -> tuple[Scale, Scale]:
    """Scales of both axes; one for both where lengths are drawn over lengths."""
    x = np.concatenate([curve.x for curve in found.curves])
    y = np.concatenate([curve.y for curve in found.curves])
    if is_place(found):
        both = scale_of(np.concatenate([x, y]), "m")
        return both, both
    across = scale_of(x, "s") if found.over_time else axis_scale(x, found.units)
    return across, axis_scale(y, found.curves[0].units)


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


def _finish(
    ax: Axes, found: Compared, curves: Sequence[Curve], scales: tuple[Scale, Scale]
) -> None:
    ax.set_xlabel(scales[0].label(found.across))
    ax.set_ylabel(scales[1].label(found.label or _common(curves)))
    if is_place(found):
        ax.set_aspect("equal", adjustable="datalim")
        return
    if found.over_time:
        ax.margins(x=0, y=0.14 if found.label else 0.05)  # room for words at a peak
        times = np.concatenate([curve.time[[0, -1]] for curve in curves])
        time_axis(ax, times)
        shade_beyond_horizon(ax, found.horizon, times, scales[0])
    elif scales[0].units == "°":
        drawn = [line.get_xdata() for line in ax.lines]
        show_degrees(ax, np.concatenate([np.asarray(x, dtype=float) for x in drawn]))
        ax.margins(x=0)
    show_steady(ax, np.concatenate([curve.y for curve in curves]) * scales[1].factor)


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


def _draw_detail(whole: Axes, ax: Axes, found: Compared, lines: Sequence[int]) -> None:
    """A few swings about the peak of the first dense curve, and where these are in the whole."""
    number = next(k for k in lines if dense(found.curves[k]))
    first, scales = found.curves[number], scales_of(found)
    at = first.peak.time if first.peak else first.time[np.nanargmax(np.abs(first.y))]
    span = swings_about(first.time, first.y, float(at))
    for k in lines:
        curve, look = found.curves[k], line_style(k)
        inside = (curve.time >= span[0]) & (curve.time <= span[1])
        x, y = curve.time[inside] * scales[0].factor, curve.y[inside] * scales[1].factor
        ax.plot(x, y, **(look if len(lines) > 1 else look | {"linestyle": "-"}))
    low, high = (scales[0].factor * end for end in span)
    ax.set_xlim(low, high)
    ax.margins(y=0.14)
    ax.xaxis.set_major_locator(MaxNLocator(3, prune="both"))
    ax.yaxis.tick_right()
    ax.ticklabel_format(axis="y", scilimits=(-3, 5))
    ax.set_xlabel(scales[0].label("time"))
    ax.set_title(f"detail, {span_words(span, scales[0])}")
    for ends in ({"ymin": 0.97}, {"ymax": 0.03}):
        whole.axvline(0.5 * (low + high), color=BLACK, linewidth=2.0, clip_on=False, **ends)
    if first.peak and span[0] <= first.peak.time <= span[1]:
        mark_peak(ax, first.peak, scales, line_style(number)["color"])


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
    _finish(ax, found, found.curves, scales)
    if curve.units == "rad":
        show_degrees(ax, up, "y")
    set_title(ax, found.heading)
    return ax


@styled
def polar_figure(found: Sequence[Compared]) -> Figure | None:
    """A diagram for each vector: the way of its tip around zero."""
    return diagram_each(
        found, lambda ax, one, of: draw_vectors(ax, replace(one, heading=of)), found[0].heading
    )


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
