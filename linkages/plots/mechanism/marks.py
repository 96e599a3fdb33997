"""Marks at equal times on paths: close together where a joint is slow."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.numbers.laws import law_values
from linkages.plots.mechanism.inked import points_per_unit
from linkages.plots.prefixes import nice_below, scale_for

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

FEWEST = 12
"""Marks in a turn of the fastest drive, or in a motion without one; 2.5 times as many at most."""

HALF, WIDTH = 2.4, 0.8
"""Points: half the length of a mark, and how wide it is."""


def mark_times(data: xr.Dataset, mechanism: Mechanism) -> Array:
    """Times of marks within the first turn of a drive, or the whole motion; at least two samples.

    They are multiples of one, two or five times a power of ten, after the beginning.
    """
    time = np.asarray(data["time"], dtype=float)
    turn = _turn(time, mechanism)
    step = nice_below(turn / FEWEST)
    count = int(np.floor(turn / step * (1.0 + 1e-9)))
    forward = np.sign(time[-1] - time[0])  # a motion may go back in time
    return np.asarray(time[0] + forward * step * np.arange(1, count + 1))


def _turn(time: Array, mechanism: Mechanism) -> float:
    """How long the first turn of a drive takes; as long as the motion if there is none."""
    duration = float(abs(time[-1] - time[0]))
    found = [duration]
    for name, drive in mechanism.prescribed.items():
        if mechanism.bodies[name].rotates:
            gone = np.abs(law_values(drive.law, time) - law_values(drive.law, time[:1]))
            after = np.flatnonzero(gone >= 2.0 * np.pi * (1.0 - 1e-9))
            found += [float(abs(time[after[0]] - time[0]))] if len(after) else []
    return min(found)


def draw_marks(ax: Axes, path: Array, time: Array, at: Array, colour: str) -> None:
    """Draw marks across a path of shape (time, 2); there are none where the joint stands still.

    Parameters
    ----------
    ax
        With its limits.
    path, time
        Samples in the units of the axes, and their times.
    at
        Times of the marks.
    colour
        Of the path.
    """
    moving = np.append(True, np.hypot(*np.diff(path, axis=0).T) > 0.0)
    known = np.isfinite(path).all(axis=1) & moving
    if known.sum() < 2:
        return
    path, time = path[known], time[known]
    at = at[(at >= time[0]) & (at <= time[-1])]
    after = np.clip(np.searchsorted(time, at), 1, len(time) - 1)
    way = path[after] - path[after - 1]
    across = np.column_stack((-way[:, 1], way[:, 0])) / np.hypot(*way.T)[:, None]
    middle = np.column_stack([np.interp(at, time, column) for column in path.T])
    reach = HALF / points_per_unit(ax) * across
    gap = np.full_like(middle, np.nan)
    ends = np.stack((middle - reach, middle + reach, gap), axis=1).reshape(-1, 2)
    ax.plot(*ends.T, color=colour, linewidth=WIDTH, solid_capstyle="butt", zorder=2.4)


def note_marks(ax: Axes, at: Array) -> None:
    """Say below the axes how far marks are apart."""
    step = float(at[1] - at[0])
    text = f"marks every {scale_for(step, 's').text(step)}"
    below = -0.3 / (ax.bbox.height / ax.figure.dpi)
    ax.text(0.0, below, text, transform=ax.transAxes, fontsize=8, va="top", color="0.35",
            gid="marks")  # fmt: skip
