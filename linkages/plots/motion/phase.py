"""Phase diagrams: angle against angular speed (figure 10 of the paper)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.motion.angles import show_degrees
from linkages.plots.motion.curves import BUSY, show_steady
from linkages.plots.motion.phase_curve import refined, spread, wrapped
from linkages.plots.prefixes import scale_of
from linkages.plots.style import PALETTE, fitted, line_style, panels, styled, title
from linkages.solution.resolved import turning_points

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

MANY_POINTS = 50_000


class Coordinate(NamedTuple):
    """A free coordinate: ``name`` along ``dimension``."""

    dimension: str
    name: str


class Kind(NamedTuple):
    """Variables and axis labels of the coordinates along one dimension."""

    variables: tuple[str, str, str]
    labels: tuple[str, str]


def _angle(dimension: str, symbol: str) -> Kind:
    position, speed, acceleration = (
        f"{dimension}_{what}" for what in ("angle", "speed", "acceleration")
    )
    labels = f"{dimension} angle {symbol} [°]", f"{dimension} speed d{symbol}/dt"
    return Kind((position, speed, acceleration), labels)


KINDS = {
    "clearance": _angle("clearance", "α"),
    "bar": _angle("bar", "θ"),
    "slider": Kind(
        ("slider_position", "slider_velocity", "slider_acceleration"),
        ("slider displacement s", "slider velocity ds/dt"),
    ),
}


@styled
def figure(data: xr.Dataset, mechanism: Mechanism) -> Figure | None:
    """One panel for each clearance and each other free angle; None if there are none."""
    found = coordinates(data, mechanism)
    if not found or data.sizes["time"] == 0:
        return None
    columns = 1 if len(found) == 1 else 2
    rows = -(-len(found) // columns)
    result, axes = panels(rows, columns, 3.6 if len(found) == 1 else 2.5)
    for ax, coordinate in zip(axes, found, strict=False):
        draw(ax, data, coordinate, mechanism.name if len(found) == 1 else "")
    for ax in axes[len(found) :]:
        ax.remove()
    return result


def coordinates(data: xr.Dataset, mechanism: Mechanism) -> list[Coordinate]:
    """Clearances, then bars and sliders that are free, as far as the data have them.

    Which are free say the mechanism and the data (``attrs["free"]``, separated by spaces).
    """
    free = f" {data.attrs.get('free', '')} "
    return [
        Coordinate(dimension, str(name))
        for dimension, kind in KINDS.items()
        if set(kind.variables[:2]) <= set(data.data_vars)
        for name in data[dimension].values
        if dimension == "clearance" or name in mechanism.initial or f" {name} " in free
    ]


def draw(ax: Axes, data: xr.Dataset, coordinate: Coordinate, heading: str = "") -> Axes:
    """Draw a coordinate against its rate; angles in degrees, within half a turn either way.

    Parameters
    ----------
    ax
        Where to draw.
    data
        SI units, with the variables that `KINDS` names. Accelerations, where there are any,
        make the curve smooth between samples.
    coordinate
        What to draw.
    heading
        Stands before the name in the title.
    """
    dimension, name = coordinate
    kind = KINDS[dimension]
    known = [variable for variable in kind.variables if variable in data]
    motion = [np.asarray(data[v].sel({dimension: name}), dtype=float) for v in known]
    if len(motion) == 3:
        turn = 0.0 if dimension == "slider" else 2 * np.pi
        position, speed, acceleration = motion
        time = np.asarray(data["time"], dtype=float)
        motion = [*refined(time, position, speed, acceleration, turn)]
    rate = scale_of(motion[1], str(data[known[1]].attrs.get("units", "")))
    if dimension == "slider":
        scale = scale_of(motion[0], "m")
        x, y = motion[0] * scale.factor, motion[1] * rate.factor
        ax.set_xlabel(scale.label(kind.labels[0]))
    else:
        x, y = wrapped(motion[0], motion[1] * rate.factor)
        show_degrees(ax, x)
        ax.set_xlabel(kind.labels[0])
    draw_curve(ax, x, y)
    ax.set_ylabel(rate.label(kind.labels[1]))
    ax.set_title(fitted(title(heading, name), ax.bbox.width / ax.figure.dpi - 0.7))
    return ax


def draw_curve(ax: Axes, x: Array, y: Array) -> None:
    """A line, or dots for a run so long that lines would cover each other; and its start."""
    if len(x) > MANY_POINTS:
        ax.plot(*spread(x, y), "o", color=PALETTE[0], markersize=0.7, markeredgewidth=0)
    else:
        width = 1.0 if turning_points(y) < BUSY else 0.5
        ax.plot(x, y, color=PALETTE[0], linewidth=width, marker="." if len(x) == 1 else "")
    look = line_style(1) | {"linestyle": "", "marker": "o", "markersize": 5}
    ax.plot(x[:1], y[:1], **look, markerfacecolor="white", label="start", zorder=4)
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0, handlelength=1.0)
    show_steady(ax, y)
