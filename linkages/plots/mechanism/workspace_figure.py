"""Figure of a workspace: what a point can reach, the mechanism, and the singular curves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from linkages.kernel.system import System
from linkages.plots.mechanism.drawing import start_pose, under
from linkages.plots.mechanism.inked_shapes import Inked, points_per_unit
from linkages.plots.mechanism.plane_view import Box, frame, legend_below, picture
from linkages.plots.style import BLACK, DRIVEN, FREE, styled

if TYPE_CHECKING:
    import xarray as xr

    from linkages.components.mechanisms.mechanism import Mechanism

LOOKS = {
    "inverse": (BLACK, "-", "it cannot leave (inverse)"),
    "forward": (DRIVEN, "-", "drives cannot hold it (forward)"),
    "limit": (FREE, "--", "a range ends"),
}
"""Kind of a curve → its colour, its line, and what it is."""

REACHED = "#E3EBF2"
FINEST = 181  # values of each coordinate over which what is reached is drawn


@styled
def workspace_figure(data: xr.Dataset, mechanism: Mechanism) -> Figure:
    """What `linkages.workspace` found, around the mechanism at t = 0.

    Parameters
    ----------
    data
        As `linkages.workspace` returns it.
    mechanism
        Whose workspace it is.
    """
    pose = start_pose(System(mechanism))
    places = np.array(list(pose.positions.values()), dtype=float)
    curves = np.stack([data["curve_x"], data["curve_y"]], axis=1)
    reached = np.stack([data["x"], data["y"]], axis=-1)
    box = Box.around(np.concatenate([places, curves, reached.reshape(-1, 2)]))
    result, ax = picture(box)
    factor = frame(ax, box, mechanism).factor
    for branch in reached:
        cells = PolyCollection([*(_cells(branch) * factor)], facecolor=REACHED, edgecolor=REACHED,
                               linewidth=0.4, zorder=0.5, rasterized=True)  # fmt: skip
        ax.add_collection(cells, autolim=False)
    Inked(ax, under(pose, points_per_unit(ax) * factor), pose.scaled(factor), pale=True)
    handles: list[Patch | Line2D] = [
        Patch(color=REACHED, label=f"reached by {data.attrs['point']}")
    ]
    numbers, kinds = data["curve"].to_numpy(), data["kind"].to_numpy()
    for kind, (colour, line, words) in LOOKS.items():
        look: dict[str, Any] = {"color": colour, "linestyle": line, "linewidth": 1.3}
        for number in np.unique(numbers[kinds == kind]):
            ax.plot(
                *curves[numbers == number].T * factor, zorder=2.0, gid=f"curve-{number}", **look
            )
        if (kinds == kind).any():
            handles.append(Line2D([], [], label=words, **look))
    legend_below(ax, handles)
    return result


def _cells(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Images of cells of a grid of shape (n, m, 2) whose corners exist, shape (cells, 4, 2)."""
    steps = [max(1, size // FINEST) for size in places.shape[:2]]
    grid = places[:: steps[0], :: steps[1]]
    corners = [grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]]
    cells = np.stack(corners, axis=2).reshape(-1, 4, 2)
    return np.asarray(cells[np.isfinite(cells).all(axis=(1, 2))])
