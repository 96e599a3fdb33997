"""Sensitivities: what each number does to measures, as bars, and to series, as curves over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.plots.style import PALETTE, fitted, legend_above, line_style, panels, styled

if TYPE_CHECKING:
    import xarray as xr

    from linkages.design.sensitivity.ranked import Effect

MOST_BARS, MOST_CURVES = 12, 5
ROUND_OFF = 1e-9

PATHS, LEGEND = 0.12, 0.7
"""Part of the width that paths take, and inches above curves that names take."""


@styled
def figure(data: xr.Dataset, effects: Mapping[str, Sequence[Effect]]) -> Figure | None:
    """Bars of relative sensitivities, a panel for each measure; None if no number has one."""
    shown = {text: _relative(found) for text, found in effects.items()}
    shown = {text: found for text, found in shown.items() if found}
    if not shown:
        return None
    most = max(map(len, shown.values()))
    result, axes = panels(len(shown), 1, 0.3 + 0.22 * most)
    for ax, (text, found) in zip(axes, shown.items(), strict=True):
        left, bottom, width, height = ax.get_position().bounds
        ax.set_position((left + PATHS, bottom, width - PATHS, height))
        bars(ax, found)
        ax.set_ylim(most - 0.5, -0.5)
        ax.set_title(fitted(f"{data.attrs['name']}: {text}", 4.4))
    return result


def bars(ax: Axes, effects: Sequence[Effect]) -> Axes:
    """Draw how many percent a measure changes for one percent of each number."""
    values = [effect.relative or 0.0 for effect in effects]
    colors = [PALETTE[0] if value >= 0.0 else PALETTE[1] for value in values]
    ax.barh(np.arange(len(effects)), values, color=colors, height=0.7)
    ax.set_yticks(np.arange(len(effects)), [fitted(e.parameter, 1.8) for e in effects])
    ax.set_ylim(len(effects) - 0.5, -0.5)
    ax.axvline(0.0, color="0.3", linewidth=0.8)
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("change of the measure for 1 % of the number [%]")
    return ax


@styled
def curves(data: xr.Dataset) -> Figure | None:
    """Changes of series for one percent of the numbers that do most; None without series."""
    series = [str(name) for name, array in data.data_vars.items() if "time" in array.dims]
    if not series:
        return None
    result, axes = panels(len(series), 1, 2.2, LEGEND)
    for ax, name in zip(axes, series, strict=True):
        change(ax, data, name)
    return result


def change(ax: Axes, data: xr.Dataset, name: str) -> Axes:
    """Draw how a series changes with one percent of each of the numbers that do most."""
    changes = 0.01 * data[name].values * data["parameter_value"].values
    sizes = np.abs(np.nan_to_num(changes, nan=0.0)).max(axis=0)
    chosen = [k for k in np.argsort(-sizes, kind="stable")[:MOST_CURVES] if sizes[k] > 0.0]
    for index, k in enumerate(chosen):
        path = str(data["parameter"].values[k])
        ax.plot(data["time"], changes[:, k], label=fitted(path, 2.2), **line_style(index))
    unit = str(data[name].attrs["units"]).partition(" / ")[0]
    ax.set_xlabel("time [s]")
    ax.set_ylabel(f"change [{unit}]")
    if chosen:
        ax.legend(**legend_above(f"change of {name} for 1 % of a number"), ncols=3)
    return ax


def _relative(effects: Sequence[Effect]) -> list[Effect]:
    """Those that are more than round-off of the largest one."""
    largest = max((abs(effect.relative or 0.0) for effect in effects), default=0.0)
    return [e for e in effects if abs(e.relative or 0.0) > ROUND_OFF * largest][:MOST_BARS]
