"""Arrows of drives and loads: along a line and around a point.

Lengths are typographic points; `place` is in the units of the axes.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch
from matplotlib.path import Path
from numpy.typing import NDArray

from linkages.plots.mechanism.senses import BOTH
from linkages.plots.mechanism.symbols import LAYER, Place, anchored, around
from linkages.plots.mechanism.view import per_point, pixels

Array = NDArray[np.float64]

RADII, SPAN = (11.0, 18.0), 1.9  # of the arrow about a driven body's pin
TORQUE, TORQUE_SPAN = 10.0, 4.2
STRAIGHT = 23.0


def rotation_arrow(ax: Axes, place: Place, tip: Place, sense: int, colour: str) -> Array:
    """An arc arrow about a pin, across the bar from there to `tip`; return pixels it covers."""
    bar = np.subtract(*pixels(ax, (tip, place))) / per_point(ax)
    radius = float(np.clip(0.55 * np.hypot(*bar), *RADII))
    return arc_arrow(ax, place, float(np.arctan2(bar[1], bar[0])), radius, SPAN, sense, colour)


def arc_arrow(
    ax: Axes,
    place: Place,
    middle: float,
    radius: float,
    span: float,
    sense: int,
    colour: str,
) -> Array:
    """An arc about a place with its middle in a direction; return pixels it covers.

    `sense` is positive counter-clockwise; `BOTH` gives two heads.
    """
    half = -0.5 * span if sense < 0 else 0.5 * span
    angles = np.linspace(middle - half, middle + half, 33)
    arc = radius * np.column_stack((np.cos(angles), np.sin(angles)))
    _arrow(ax, arc, place, sense, colour)
    return np.vstack([around(ax, place, angles, radius + beside) for beside in (-2, 0, 2)])


def straight_arrow(
    ax: Axes, place: Place, angle: float, start: Place, sense: int, colour: str
) -> Array:
    """An arrow in a direction; return pixels it covers.

    Parameters
    ----------
    ax, place
        Where.
    angle
        The positive direction.
    start
        Where the arrow begins, along and across the direction in which it points.
    sense
        Sign of the direction, or `BOTH`.
    colour
        Of the arrow.
    """
    if sense < 0:
        angle, start = angle + np.pi, (start[0], -start[1])
    along = np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-along[1], along[0]])
    first = start[0] if sense != BOTH else -0.5 * STRAIGHT - 3.0
    last = first + STRAIGHT if sense != BOTH else -first
    line = np.array([a * along + start[1] * across for a in np.linspace(first, last, 15)])
    _arrow(ax, line, place, sense, colour)
    points = np.vstack([line + shift * across for shift in (-2.0, 0.0, 2.0)])
    return np.asarray(anchored(ax, place).transform(points))


def _arrow(ax: Axes, line: Array, place: Place, sense: int, colour: str) -> None:
    ax.add_patch(
        FancyArrowPatch(
            path=Path(line),
            arrowstyle="<|-|>" if sense == BOTH else "-|>",
            mutation_scale=9,
            linewidth=1.2,
            color=colour,
            transform=anchored(ax, place),
            zorder=LAYER + 2,
        )
    )
