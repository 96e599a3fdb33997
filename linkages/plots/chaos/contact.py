"""Forces in clearances over time, and where pin and hole would lose contact."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.chaos.sections.contact import lost_spans
from linkages.plots.motion.curves import draw_curve
from linkages.plots.prefixes import scale_of
from linkages.plots.style import BLACK, PALETTE, TOP, fitted, panels, styled, title

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

HEIGHT = 2.3
LOST = "#F3D9C4"


@styled
def figure(force: xr.DataArray, heading: str = "") -> Figure | None:
    """One panel for each clearance; None without clearances or samples."""
    if force.size == 0:
        return None
    names = [str(name) for name in force["clearance"].values]
    result, axes = panels(len(names), 1, HEIGHT, TOP)
    for ax, name in zip(axes, names, strict=True):
        draw(ax, force.sel(clearance=name), title(heading, name))
    return result


def draw(ax: Axes, force: xr.DataArray, heading: str = "") -> Axes:
    """Draw the force in a clearance; shaded where it is negative: a pin cannot pull at its hole.

    Parameters
    ----------
    ax
        Where to draw.
    force
        Over ``time``, in newtons; tension of the virtual link is positive.
    heading
        Title.
    """
    time, values = np.asarray(force["time"], dtype=float), np.asarray(force, dtype=float)
    scales = scale_of(time, "s"), scale_of(values, "N")
    spans = lost_spans(time, values)
    for begin, end in spans:
        ax.axvspan(
            begin * scales[0].factor, end * scales[0].factor, color=LOST, linewidth=0, zorder=0
        )
    ax.axhline(0.0, color=BLACK, linewidth=0.8, zorder=2)
    draw_curve(ax, time, values, scales, color=PALETTE[0])
    if len(time) > 1:
        ax.set_xlim(time[0] * scales[0].factor, time[-1] * scales[0].factor)
    ax.set_xlabel(scales[0].label("time"))
    ax.set_ylabel(scales[1].label("force"))
    text = "contact throughout"
    if spans:
        share = sum(end - begin for begin, end in spans) / (time[-1] - time[0])
        text = f"shaded: no contact, {100 * share:.2g} % of the time shown"
    ax.set_title(text, loc="right", fontsize=8, color="0.35")
    ax.set_title(fitted(heading, ax.bbox.width / ax.figure.dpi - 2.6))
    return ax
