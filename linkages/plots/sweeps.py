"""Measures over what is varied: a curve, a band, an image, or how draws are distributed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.plots.chaos.parameters import show_path, shown_values
from linkages.plots.style import PALETTE, diagrams, fitted, legend_above, line_style, styled

if TYPE_CHECKING:
    import xarray as xr

DRAW = "draw"
BAND = 0.05, 0.95
"""Quantiles between which a band lies."""

MOST_BINS = 60

FEW = 6
"""Values that are a list and no range: they get a line or a tick each."""

MARKED = 50
"""Points from which on a line needs no marks."""

Array = NDArray[np.float64]


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
    title = fitted(str(data.attrs.get("name", "")), 4.4)
    dims = [str(dim) for dim in array.dims]
    if dims == [DRAW]:
        _histogram(ax, array.to_numpy(), label)
    elif DRAW in dims:
        _spread(ax, data, array, label)
    elif len(dims) == 2 and min(array.shape) > FEW:
        up, along = dims
        x, y = show_path(ax, "x", data, along), show_path(ax, "y", data, up)
        image = ax.pcolormesh(x, y, array.to_numpy(), rasterized=True)
        ax.figure.colorbar(image, ax=ax, label=label)
    elif len(dims) == 2:
        several, along = sorted(dims, key=lambda dim: data.sizes[dim])
        across, heading = shown_values(data, several)
        for place, value in enumerate(across):
            _line(ax, data, array.isel({several: place}), label, f"{value:.6g}", place)
        ax.legend(**legend_above(", ".join(filter(None, (title, heading)))), ncols=len(across))
        return ax
    else:
        _line(ax, data, array, label)
    ax.set_title(title)
    return ax


def _histogram(ax: Axes, values: Array, label: str) -> None:
    values = values[np.isfinite(values)]
    bins = min(MOST_BINS, max(1, round(len(values) ** 0.5)))
    ax.hist(values, bins=bins, color=PALETTE[0])
    ax.set_xlabel(label)
    ax.set_ylabel("draws")


def _spread(ax: Axes, data: xr.Dataset, array: xr.DataArray, label: str) -> None:
    """The median of draws, and a band or bars in which most of them lie."""
    (dim,) = (str(dim) for dim in array.dims if dim != DRAW)
    values = _shown_along(ax, data, dim)
    low, middle, high = array.quantile([BAND[0], 0.5, BAND[1]], DRAW).to_numpy()
    if len(values) <= FEW:
        apart = np.stack([middle - low, high - middle])
        ax.errorbar(values, middle, apart, fmt="o", color=PALETTE[0], capsize=4)
    else:
        ax.fill_between(values, low, high, color=PALETTE[0], alpha=0.3, linewidth=0)
        ax.plot(values, middle, color=PALETTE[0])
    ax.set_ylabel(label)


def _line(
    ax: Axes, data: xr.Dataset, array: xr.DataArray, label: str, name: str = "", place: int = 0
) -> None:
    """A measure over one dimension; one of several lines if it has a name."""
    values = _shown_along(ax, data, str(array.dims[0]))
    few = len(values) <= FEW
    look = line_style(place) | {"marker": "o" if few else "." if len(values) < MARKED else ""}
    ax.plot(values, array.to_numpy(), label=name or None, **look)
    ax.set_ylabel(label)


def _shown_along(ax: Axes, data: xr.Dataset, dim: str) -> Array:
    """Values along the axis to the right, which has ticks at them if they are few."""
    values, text = shown_values(data, dim)
    if len(values) <= FEW:
        ax.set_xticks(np.unique(values), [f"{value:.6g}" for value in np.unique(values)])
        ax.margins(x=0.1)
    ax.set_xlabel(text)
    return values
