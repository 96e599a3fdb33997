"""Axes of what is varied in sweeps and maps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from linkages.plots.motion.phase_diagrams import show_degrees
from linkages.plots.style import DEGREES, axis_scale, path_words

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

LOST = "contact lost"
HATCHING: dict[str, Any] = {
    "facecolor": "none", "edgecolor": "#8F8F8F", "hatch": "////", "linewidth": 0.0,
}  # fmt: skip
"""How places are drawn at which a massless link would have to push."""


def shown_values(data: xr.Dataset, path: str) -> tuple[Array, str]:
    """Values of a varied path as they are drawn, angles in degrees, and the label of its axis."""
    unit = str(data[path].attrs.get("units", ""))
    values = np.asarray(data[path], dtype=float)
    if unit == "rad":
        values, unit = DEGREES * values, "°"
    elif unit in ("deg", "degree", "degrees", "°"):
        unit = "°"
    words = path_words(path)
    shown = axis_scale([], unit).units if unit != "°" else unit
    return values, f"{words} [{shown}]" if unit else words


def show_path(ax: Axes, along: str, data: xr.Dataset, path: str) -> Array:
    """Limits, ticks and label of an axis along which a path is varied; returns borders of cells."""
    values, label = shown_values(data, path)
    if label.endswith("[°]"):
        show_degrees(ax, values, along)
    borders = cell_borders(values)
    low, high = sorted((float(borders[0]), float(borders[-1])))
    (ax.set_xlim if along == "x" else ax.set_ylim)(low, high)
    (ax.set_xlabel if along == "x" else ax.set_ylabel)(label)
    return borders


def cell_borders(places: Array) -> Array:
    """Borders half-way between neighbouring places, shape (n + 1,)."""
    middle = 0.5 * (places[1:] + places[:-1])
    first, last = places[0] - (middle[0] - places[0]), places[-1] + (places[-1] - middle[-1])
    return np.concatenate([[first], middle, [last]])


def contact_lost(data: xr.Dataset, *dims: str) -> NDArray[np.bool_] | None:
    """Where a massless link of any clearance pushed, in the order of `dims`; None if nowhere."""
    if "contact_lost" not in data:
        return None
    lost = (data["contact_lost"] > 0).any("clearance").transpose(*dims).to_numpy()
    return lost if lost.any() else None
