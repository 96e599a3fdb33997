"""Measures over what is varied: a curve, a band, an image, or how draws are distributed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.plots.chaos.parameters import show_path, shown_values
from linkages.plots.style import PALETTE, diagrams, fitted, styled

if TYPE_CHECKING:
    import xarray as xr

DRAW = "draw"
BAND = 0.05, 0.95
"""Quantiles between which a band lies."""

MOST_BINS = 60


@styled
def figure(data: xr.Dataset, name: str) -> Figure | None:
    """A measure over its one or two dimensions; None if there are more, or nothing to show."""
    array = data[name]
    if array.ndim > 2 or not np.isfinite(array).any():
        return None
    result, (ax,) = diagrams(1)
    draw(ax, data, name)
    return result


def draw(ax: Axes, data: xr.Dataset, name: str) -> Axes:
    """Draw a measure.

    Parameters
    ----------
    ax
        Where to draw.
    data
        As `linkages.sweep` returns it.
    name
        Of the measure.
    """
    array = data[name]
    units = str(array.attrs.get("units", ""))
    label = f"{name} [{units}]" if units else name
    dims = [str(dim) for dim in array.dims]
    if dims == [DRAW]:
        values = array.to_numpy()
        values = values[np.isfinite(values)]
        bins = min(MOST_BINS, max(1, round(len(values) ** 0.5)))
        ax.hist(values, bins=bins, color=PALETTE[0])
        ax.set_xlabel(label)
        ax.set_ylabel("draws")
    elif len(dims) == 2 and DRAW not in dims:
        up, along = dims
        x, y = show_path(ax, "x", data, along), show_path(ax, "y", data, up)
        image = ax.pcolormesh(x, y, array.to_numpy(), rasterized=True)
        ax.figure.colorbar(image, ax=ax, label=label)
    else:
        values, text = shown_values(data, dims[0])
        if DRAW in dims:
            low, middle, high = array.quantile([BAND[0], 0.5, BAND[1]], DRAW).to_numpy()
            ax.fill_between(values, low, high, color=PALETTE[0], alpha=0.3, linewidth=0)
            ax.plot(values, middle, color=PALETTE[0])
        else:
            ax.plot(values, array, color=PALETTE[0], marker="." if len(values) < 50 else "")
        ax.set_xlabel(text)
        ax.set_ylabel(label)
    ax.set_title(fitted(str(data.attrs.get("name", "")), 4.4))
    return ax
