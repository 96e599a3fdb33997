"""The times at which a motion is not predictable, behind its curves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from linkages.plots.prefixes import Scale

if TYPE_CHECKING:
    import xarray as xr

TEXT = "not predictable"
WIDE, TALL = 0.85, 0.16
"""Inches that the words take along a band, and across one."""


def shade_beyond_horizon(
    ax: Axes, data: xr.Dataset, time: NDArray[np.float64], scale: Scale
) -> None:
    """Shade the times at which the solution has fewer than three correct digits.

    The words stand within the band, upright in a narrow one; an arrow leads from them to one that
    is narrower still.
    """
    horizon = data.attrs.get("horizon")
    if horizon is None or not time.size:
        return
    begin, end = horizon * scale.factor, float(time[-1]) * scale.factor
    ax.axvspan(begin, end, color="0.88", zorder=0, linewidth=0)
    whole = abs(float(np.ptp(time))) * scale.factor
    width = abs(end - begin) / whole * ax.bbox.width / ax.figure.dpi if whole else 0.0
    look: dict[str, Any] = {
        "xycoords": ("data", "axes fraction"), "textcoords": "offset points", "fontsize": 8,
        "color": "0.35", "zorder": 3,
    }  # fmt: skip
    if width >= WIDE:
        ax.annotate(TEXT, (begin, 0.015), xytext=(3, 0), **look)
    elif width >= TALL:
        middle = 0.5 * (begin + end)
        ax.annotate(TEXT, (middle, 0.03), xytext=(0, 0), rotation=90, ha="center", **look)
    else:
        arrow = {"arrowstyle": "-|>", "color": "0.35", "linewidth": 0.7}
        place = (0.5 * (begin + end), 0.05)
        ax.annotate(TEXT, place, xytext=(-14, 0), ha="right", va="center", arrowprops=arrow, **look)
