"""Impact maps: when in a period, in which direction and how fast pins touch their holes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.plots.chaos.sections import marker_size
from linkages.plots.motion.free_axes import Free, Output, show_output, values_of
from linkages.plots.style import PALETTE, diagrams, fitted, styled, title

if TYPE_CHECKING:
    import xarray as xr

PHASE = Output("touch_phase", "part of the period")
RATE = Output("touch_rate", "rate of touches")
DIRECTION = Output("touch_direction", "direction of touches")


@styled
def figure(data: xr.Dataset) -> Figure | None:
    """Rates over phases and directions over phases; rates over directions without a period.

    Parameters
    ----------
    data
        As `linkages.poincare` returns it of a section at touches.

    Returns
    -------
    None for data without touches, or with rates alone.
    """
    pairs = [(PHASE, RATE), (PHASE, DIRECTION)] if PHASE.variable in data else [(DIRECTION, RATE)]
    shown = [pair for pair in pairs if {output.variable for output in pair} <= set(data.data_vars)]
    if not shown or not data.sizes["crossing"]:
        return None
    free = Free("touch", str(data["touch"].values[0]))
    result, axes = diagrams(len(shown))
    for ax, (along, upwards) in zip(axes, shown, strict=True):
        draw(ax, data, free, along, upwards)
    count = f"{data.sizes['crossing']} touches"
    axes[-1].set_title(count, loc="right", fontsize=8, color="0.35")
    room = (axes[-1].bbox.x1 - axes[0].bbox.x0) / result.dpi - 0.9
    axes[0].set_title(fitted(title(str(data.attrs.get("name", "")), free.name), room))
    return result


def draw(ax: Axes, data: xr.Dataset, free: Free, along: Output, upwards: Output) -> Axes:
    """Draw a dot for each touch of a clearance.

    Parameters
    ----------
    ax
        Where to draw.
    data
        With dimensions ``crossing`` and ``touch``.
    free
        The clearance.
    along, upwards
        What its axes show.
    """
    x, y = (values_of(data, free, output) for output in (along, upwards))
    factors = show_output(ax, "x", data, along, x), show_output(ax, "y", data, upwards, y)
    size = marker_size(len(x))
    ax.plot(factors[0] * x, factors[1] * y, "o", color=PALETTE[0], markersize=size, mew=0, zorder=3)
    if along is PHASE:
        ax.set_xlim(0.0, 1.0)
    if upwards is RATE and np.nanmin(y) >= 0.0:
        ax.set_ylim(bottom=0.0)
    return ax
