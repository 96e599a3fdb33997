"""Tolerances: how a measure is distributed, and what contributes to it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.plots.prefixes import Scale, scale_of
from linkages.plots.style import BLACK, GREY, PALETTE, fitted, panels, styled

if TYPE_CHECKING:
    import xarray as xr

BINS = 60
MOST_BARS = 12
"""Contributors that are drawn: those of the largest shares."""


@styled
def figure(data: xr.Dataset, name: str) -> Figure | None:
    """Histogram and contributors of a measure; None if no sample has it.

    Parameters
    ----------
    data
        As `linkages.tolerance` returns it.
    name
        Of the measure.
    """
    own = data.sel(measure=name)
    if not np.isfinite(own["sample"]).any():
        return None
    result, (left, right) = panels(1, 2, 2.6)
    for ax, (start, width) in ((left, (0.11, 0.38)), (right, (0.71, 0.26))):  # room for paths
        box = ax.get_position()
        ax.set_position((start, box.y0, width, box.height))
    distribution(left, own)
    contributors(right, own)
    left.set_title(fitted(name, 2.4))
    right.set_title(fitted(str(data.attrs.get("name", "")), 1.6))
    return result


def distribution(ax: Axes, own: xr.Dataset) -> Axes:
    """Histogram of the samples, that of the linear ones as a line, the nominal value and limits."""
    values, linear = own["sample"].to_numpy(), own["linear_sample"].to_numpy()
    known = np.isfinite(values)
    values, linear = values[known], linear[known]
    units, nominal = str(own["units"].values), float(own["nominal"])
    scale = _changes(values, nominal, units)
    base = nominal if _relative(values, nominal) else 0.0
    shown, predicted = (values - base) * scale.factor, (linear - base) * scale.factor
    edges = np.histogram_bin_edges(np.concatenate([shown, predicted]), min(BINS, _bins(len(shown))))
    ax.hist(shown, bins=edges.tolist(), color=PALETTE[0], alpha=0.55, label="samples")
    heights, _ = np.histogram(predicted, edges)
    ax.stairs(heights, edges, color=BLACK, linewidth=1.0, label="linear")
    ax.margins(y=0.05)
    ax.axvline((nominal - base) * scale.factor, color=GREY, linewidth=0.8)
    for limit in _limits(own):
        ax.axvline((limit - base) * scale.factor, color=PALETTE[1], linestyle="--")
    quantity = "less the nominal value" if base else "value"
    ax.set_xlabel(scale.label(quantity))
    ax.set_ylabel("draws")
    ax.legend(loc="best")
    return ax


def contributors(ax: Axes, own: xr.Dataset) -> Axes:
    """Shares of the variance, the largest at the top."""
    shares = own["share"].to_numpy()
    order = np.argsort(shares)[-MOST_BARS:]
    ax.barh(np.arange(len(order)), 100.0 * shares[order], color=PALETTE[0], height=0.7)
    names = [fitted(str(path), 1.5, 6.5) for path in own["contributor"].to_numpy()[order]]
    ax.set_yticks(np.arange(len(order)), names, fontsize=6.5)
    ax.set_xlim(0.0, 100.0)
    ax.set_xlabel("share of the variance [%]")
    ax.grid(visible=False, axis="y")
    return ax


def _relative(values: np.ndarray, nominal: float) -> bool:
    """Whether values differ so little from the nominal one that differences are shown."""
    return bool(np.ptp(values) < 0.1 * abs(nominal))


def _changes(values: np.ndarray, nominal: float, units: str) -> Scale:
    return scale_of(values - nominal if _relative(values, nominal) else values, units)


def _bins(count: int) -> int:
    return max(8, round(count**0.5))


def _limits(own: xr.Dataset) -> list[float]:
    if "limited" not in own:
        return []
    mine = own["limited"].to_numpy() == str(own["measure"].values)
    both = np.concatenate([own["limit_low"].to_numpy()[mine], own["limit_high"].to_numpy()[mine]])
    return [float(limit) for limit in np.unique(both) if np.isfinite(limit)]
