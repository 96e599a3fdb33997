"""Phase and polar diagrams."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.outputs import VARIABLES
from linkages.plots.motion.curves import BUSY, DENSE, show_steady, span_words, swings_about
from linkages.plots.panels import axes_for, chart, diagram_each, named, show_axis
from linkages.plots.style import (
    PALETTE,
    line_style,
    scale_of,
    set_title,
    styled,
    title,
)
from linkages.solution.run_options import turning_points

if TYPE_CHECKING:
    import xarray as xr

    from linkages.solution.solution import Solution

Array = NDArray[np.float64]

ROUND_OFF = 1e-12  # SI units; smaller values are zero, and get no prefix of their own


PAIRS = {
    **{
        VARIABLES[value].dims[0]: (value, VARIABLES[value].rate)
        for value in (
            "clearance_angle", "offset_position", "tilt_angle", "bar_angle", "slider_position",
        )
    },
    "touch": ("touch_phase", "touch_rate"),
}  # fmt: skip
"""Dimension of free coordinates → the variables of their values and of their rates."""

TOUCHES = {
    "touch_phase": "phase of the period",
    "touch_rate": "approach speed",
    "touch_direction": "direction of touches",
}
"""Variables of touches, which are no outputs, and what their axes are called."""


class Free(NamedTuple):
    """A free coordinate: ``name`` along ``dimension``."""

    dimension: str
    name: str

    @property
    def pair(self) -> tuple[str, str]:
        """The variables of its value and of its rate."""
        return PAIRS[self.dimension]


def free_coordinates(data: xr.Dataset) -> list[Free]:
    """All free coordinates that a dataset has values and rates of; only touches if it has those."""
    result = [
        Free(dimension, str(name))
        for dimension, pair in PAIRS.items()
        if {*pair} <= set(data.data_vars)
        for name in data[dimension].values
    ]
    return [free for free in result if free.dimension == "touch"] or result


def values_of(data: xr.Dataset, coordinate: Free, variable: str) -> Array:
    """Values of a variable in SI, in the shape of the other dimensions."""
    chosen = data[variable].sel({coordinate.dimension: coordinate.name})
    return np.asarray(chosen, dtype=float)


def free_coordinate(data: xr.Dataset, name: str | None) -> Free:
    """The free coordinate of a name, or the first one."""
    known = {coordinate.name: coordinate for coordinate in free_coordinates(data)}
    return known[named(name, known)]


def show_output(ax: Axes, along: str, data: xr.Dataset, variable: str, values: Array) -> Array:
    """Values in SI as an axis shows them, which gets its label and ticks."""
    words = VARIABLES[variable].long_name if variable in VARIABLES else TOUCHES[variable]
    clear = np.where(np.abs(values) < ROUND_OFF, 0.0, values)
    units = str(data[variable].attrs.get("units", ""))
    return show_axis(ax, along, clear, units, words).factor * values


def shown_pair(
    ax: Axes, data: xr.Dataset, coordinate: Free, pair: tuple[str, str]
) -> tuple[Array, Array]:
    """Values of two variables of a coordinate as axes show them, which get labels and ticks."""
    values = [values_of(data, coordinate, variable) for variable in pair]
    x, y = map(show_output, (ax, ax), "xy", (data, data), pair, values)
    return x, y


def stepped(steps: Sequence[tuple[float, float]], count: int) -> float:
    """What belongs to so many: the value of the first step that is not below them."""
    return next(value for most, value in steps if count <= most)


PARTS = 6  # of the interval between two samples
MANY = 20_000  # samples that need no points between them


def refined(
    time: Array, position: Array, speed: Array, acceleration: Array, turn: float = 2 * np.pi
) -> tuple[Array, Array]:
    """Position and speed with points between the samples, by cubic Hermite interpolation.

    A clearance swings within a few samples; straight lines between them would show corners.
    The curve passes through every sample with the slope that it has there.

    `time`, `position`, `speed`, `acceleration`: shape (n,), SI units and radians.
    Returns: position, speed: the position without such jumps. Long runs stay as they are.
    """
    parts = min(PARTS, MANY // max(1, len(time)))
    if parts < 2 or len(time) < 2:
        return position, speed
    if turn:
        position = _continuous(time, position, speed, turn)
    return _hermite(time, position, speed, parts), _hermite(time, speed, acceleration, parts)


def _continuous(time: Array, position: Array, speed: Array, turn: float) -> Array:
    """The position without jumps of whole turns: each step is that nearest to speed × time."""
    steps = np.diff(position)
    expected = 0.5 * (speed[:-1] + speed[1:]) * np.diff(time)
    steps -= turn * np.round((steps - expected) / turn)
    return position[0] + np.append(0.0, np.cumsum(steps))


def _hermite(time: Array, values: Array, slopes: Array, parts: int) -> Array:
    """Values at `parts` points of each interval (from its start), and the last value."""
    u = np.arange(parts) / parts
    step = np.diff(time)[:, None]  # 0 where a sample is there twice
    start, end = values[:-1, None], values[1:, None]
    bend = slopes[:-1, None] * u * (1 - u) ** 2 - slopes[1:, None] * u**2 * (1 - u)
    inner = start + (end - start) * u**2 * (3 - 2 * u) + step * bend
    return np.append(inner.ravel(), values[-1])


def wrapped(angle: Array, speed: Array) -> tuple[Array, Array]:
    """The curve with its angle within ±180°, broken where it passes from one end to the other.

    `angle`, `speed`: shape (n,); the angle in radians, within a turn or not.
    Returns: angle, speed: the angle in degrees. At each passage stand the point on one end, a NaN,
    and the point on the other end, so that the curve reaches both ends and never crosses the
    picture.
    """
    degrees = np.degrees(angle)
    inside = (degrees + 180.0) % 360.0 - 180.0
    inside[inside >= 180.0] = -180.0  # the remainder of a tiny negative number rounds to 360
    passages = np.flatnonzero(np.abs(np.diff(inside)) > 180.0)
    before, after = inside[passages], inside[passages + 1]
    end = np.where(before > after, 180.0, -180.0)
    share = (end - before) / (after + 2.0 * end - before)
    between = speed[passages] + share * (speed[passages + 1] - speed[passages])
    gap = np.full_like(between, np.nan)
    at = np.repeat(passages + 1, 3)
    return (
        np.insert(inside, at, np.column_stack((end, gap, -end)).ravel()),
        np.insert(speed, at, np.column_stack((between, gap, between)).ravel()),
    )


MANY_POINTS = 500_000
FAINT = 0.3  # opacity of curves that cover themselves, so that what is dense looks dense


OUTPUTS = tuple(
    name
    for value, rate in PAIRS.values()
    if value in VARIABLES
    for name in (value, rate, VARIABLES[rate].rate)
    if name in VARIABLES
)
"""What phase diagrams of free coordinates are made of."""


@styled
def figure(data: xr.Dataset, mechanism: Mechanism) -> Figure | None:
    """One panel for each clearance and each other free angle, and a detail; None without any."""
    if data.sizes["time"] == 0:
        return None
    found, time = coordinates(data, mechanism), data["time"]
    shown = [(coordinate, span) for coordinate in found for span in _spans(data, coordinate)]

    def draw_part(ax: Axes, part: tuple[Free, tuple[float, float] | None], heading: str) -> None:
        coordinate, span = part
        if span is None:
            draw(ax, data, coordinate, heading)
            return
        inside = data.isel(time=((time >= span[0]) & (time <= span[1])).to_numpy())
        draw(ax, inside, coordinate, start=False)
        words = span_words(span, scale_of(time, "s"))
        set_title(ax, f"{coordinate.name}, detail, {words}")

    return diagram_each(shown, draw_part, mechanism.name)


def _spans(data: xr.Dataset, coordinate: Free) -> list[tuple[float, float] | None]:
    """The whole motion, and times of a few swings where its curve covers itself."""
    rates = values_of(data, coordinate, coordinate.pair[1])
    if turning_points(rates) <= DENSE:
        return [None]
    time = np.asarray(data["time"], dtype=float)
    return [None, swings_about(time, rates, float(time[len(time) // 2]), 2)]


def coordinates(data: xr.Dataset, mechanism: Mechanism) -> list[Free]:
    """Clearances, then bars and sliders that are free, as far as the data have them.

    Which are free say the mechanism and the data (``attrs["free"]``, separated by spaces).
    """
    free = f" {data.attrs.get('free', '')} "
    return [
        item
        for item in free_coordinates(data)
        if (item.dimension == "clearance" and item.name in mechanism.bodies)
        or item.name in mechanism.initial
        or f" {item.name} " in free
    ]


@chart
def phase_diagram(solution: Solution, name: str | None = None, ax: Axes | None = None) -> Axes:
    """Rate against value of a free coordinate: of the one named, or the first.

    `name`: The free coordinate.
    """
    data, mechanism = solution.data, solution.mechanism
    known = {coordinate.name: coordinate for coordinate in coordinates(data, mechanism)}
    return draw(axes_for(ax), data, known[named(name, known)], mechanism.name)


def draw(
    ax: Axes, data: xr.Dataset, coordinate: Free, heading: str = "", *, start: bool = True
) -> Axes:
    """Draw a coordinate against its rate; angles in degrees, within half a turn either way.

    Accelerations, where there are any, make the curve smooth between samples. `heading`: before
    the name in the title. `start`: whether to mark where the curve begins.
    """
    (value, rate), time = coordinate.pair, np.asarray(data["time"], dtype=float)
    x, y = (values_of(data, coordinate, variable) for variable in coordinate.pair)
    angle, acceleration = VARIABLES[value].angle, VARIABLES[rate].rate
    if acceleration in data:
        slopes = values_of(data, coordinate, acceleration)
        x, y = refined(time, x, y, slopes, 2 * np.pi if angle else 0.0)
    if angle:
        degrees, y = wrapped(x, y)
        x = np.radians(degrees)
    x, y = show_output(ax, "x", data, value, x), show_output(ax, "y", data, rate, y)
    draw_curve(ax, x, y, start=start)
    set_title(ax, title(heading, coordinate.name))
    return ax


def draw_curve(ax: Axes, x: Array, y: Array, *, start: bool = True) -> None:
    """A line, or dots for a run so long that lines would cover each other; and its start."""
    look: dict[str, Any]
    if len(x) > MANY_POINTS:
        look = {"markersize": 0.7, "markeredgewidth": 0, "alpha": 0.5 * FAINT, "rasterized": True}
        ax.plot(x, y, "o", color=PALETTE[0], **look)
    else:
        turns = turning_points(y)
        look = {
            "linewidth": 1.0 if turns < BUSY else 0.5,
            "alpha": 1.0 if turns < DENSE else FAINT,
        }
        ax.plot(x, y, color=PALETTE[0], marker="." if len(x) == 1 else "", **look)
    if start:
        ring = line_style(1) | {"linestyle": "", "marker": "o", "markersize": 5}
        ax.plot(x[:1], y[:1], **ring, markerfacecolor="white", label="start", zorder=4)
        ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0, handlelength=1.0)
    show_steady(ax, y)
