"""Searches for better numbers: how they converge, and what they change."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from linkages.plots import style
from linkages.plots.style import GREY, PALETTE, legend_above, panels, styled

if TYPE_CHECKING:
    import xarray as xr

MOST_PANELS = 8
"""Series that are drawn, one below the other."""


def _labelled(name: str, units: str, inches: float) -> str:
    return style.fitted(f"{name} [{units}]" if units else name, inches)


@styled
def convergence(data: xr.Dataset) -> Figure:
    """The goal of every run, and the best so far; circles are runs that miss a constraint.

    Parameters
    ----------
    data
        Of what `linkages.optimise` returns.
    """
    figure, (ax,) = panels(1, 1, 3.2, top=0.45)
    run = np.arange(1, data.sizes["run"] + 1)
    holds = data["history_violation"].to_numpy() == 0.0
    values, best = data["history_value"].to_numpy(), data["history"].to_numpy()
    ax.plot(run[holds], values[holds], ".", color=GREY, markersize=3, label="each run")
    if not holds.all():
        look: dict[str, Any] = {"color": GREY, "markersize": 3, "fillstyle": "none"}
        ax.plot(run[~holds], values[~holds], "o", label="constraints not met", **look)
    ax.step(run, best, where="post", color=PALETTE[0], label="best so far")
    known = values[np.isfinite(values)]
    if len(known):
        low = np.quantile(known, 0.05, method="lower")  # a few runs may be far away
        high = np.quantile(known, 0.95, method="higher")
        ends = [low, high, float(data["value"][1]), *best[np.isfinite(best)][:1]]
        middle = 0.5 * (max(ends) + min(ends))
        # ticks of a few digits differ, however little the runs do
        half = max(0.55 * (max(ends) - min(ends)), 0.005 * abs(middle)) or 1.0
        ax.set_ylim(middle - half, middle + half)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set_xlabel("run")
    attrs = data["history"].attrs
    ax.set_ylabel(_labelled(str(attrs["long_name"]), str(attrs["units"]), 3.2))
    ax.legend(**legend_above(str(data.attrs["name"])), ncols=3)
    return figure


@styled
def curves(data: xr.Dataset) -> Figure:
    """What goal and constraints reduce, over time, before and after.

    Parameters
    ----------
    data
        Of what `linkages.optimise` returns.
    """
    count = min(data.sizes["series"], MOST_PANELS)
    figure, axes = panels(count, 1, 3.2 if count == 1 else 1.9, top=0.45)
    time = data["time"].to_numpy()
    for place, ax in enumerate(axes):
        before, after = data["curve"].to_numpy()[:, place]
        ax.plot(time, before, color=GREY, linestyle=(0, (5, 1.6)), label="start")
        ax.plot(time, after, color=PALETTE[0], label="optimum")
        name, units = str(data["series"][place].item()), str(data["series_units"][place].item())
        ax.set_ylabel(_labelled(name, units, 3.2 if count == 1 else 1.9))
        ax.margins(x=0)
    axes[-1].set_xlabel("time [s]")
    axes[0].legend(**legend_above(str(data.attrs["name"])), ncols=2)
    return figure


@styled
def fitted(data: xr.Dataset) -> Figure:
    """Measurements with the fitted motion, and residuals below, of each output.

    Parameters
    ----------
    data
        Of what `linkages.fit` returns.
    """
    count = min(data.sizes["series"], MOST_PANELS // 2)
    figure, axes = panels(2 * count, 1, 1.7, top=0.4)
    time = data["time"].to_numpy()
    for place in range(count):
        above, below = axes[2 * place : 2 * place + 2]
        measured, computed, residual = (
            data[name].to_numpy()[place] for name in ("measured", "computed", "residual")
        )
        known = np.isfinite(measured)
        above.plot(time[known], measured[known], ".", color=GREY, markersize=3, label="measured")
        above.plot(time[known], computed[known], color=PALETTE[0], label="fit")
        name, units = str(data["series"][place].item()), str(data["series_units"][place].item())
        above.set_ylabel(_labelled(name, units, 1.7))
        below.axhline(0.0, color=PALETTE[0], linewidth=0.8)
        below.plot(time[known], residual[known], ".", color=GREY, markersize=3)
        below.set_ylabel("residual / sigma" if data.attrs["sigma_known"] else f"residual [{units}]")
        for ax in (above, below):
            ax.set_xlim(time[0], time[-1])
    axes[-1].set_xlabel("time [s]")
    axes[0].legend(**legend_above(str(data.attrs["name"])), ncols=2)
    return figure
