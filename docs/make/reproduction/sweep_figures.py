"""Figures 12–15 of the paper: sections and their spread over the clearance and over the speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import (
    FixedLocator,
    FuncFormatter,
    LogLocator,
    NullFormatter,
)
from numpy.typing import NDArray

from linkages.plots.panels import panels
from linkages.plots.style import BLACK, BOTTOM, DASHES, PALETTE, RIGHT, TOP, WIDTH
from make.reproduction.reported import STARTS
from make.reproduction.spreads import PowerLaw, spread

if TYPE_CHECKING:
    import xarray as xr

GAP, LEFT = 0.1, 1.0
"""Inches between panels that share their axes, and left of them, for labels of two lines."""

DOT, FAINT_DOT, FAINT = 1.1, 0.75, 0.4
"""Sizes of dots in portraits and in diagrams, and the opacity of the latter."""

MOST = 99.8
"""Per cent of the points that a diagram shows: a few fast ones would press all others together."""


def _shared(
    rows: int, columns: int, height: float, between: float = GAP
) -> tuple[Figure, list[list[Axes]]]:
    """Panels that share their axes and stand close to each other."""
    total = TOP + rows * height + (rows - 1) * between + BOTTOM
    width = (WIDTH - LEFT - RIGHT - (columns - 1) * GAP) / columns
    figure, grid = Figure(figsize=(WIDTH, total)), []
    for row in range(rows):
        bottom = BOTTOM + (rows - 1 - row) * (height + between)
        line: list[Axes] = []
        for column in range(columns):
            left = LEFT + column * (width + GAP)
            place = (left / WIDTH, bottom / total, width / WIDTH, height / total)
            line.append(figure.add_axes(place))
        grid.append(line)
    return figure, grid


def portraits_figure(data: xr.Dataset, names: Sequence[str]) -> Figure:
    """Figs. 12 and 14: a section for each value, a row for each of our initial conditions."""
    figure, grid = _shared(len(STARTS), len(names), 1.5, 0.3)
    angle = np.degrees(data.clearance_angle.isel(clearance=0).to_numpy())
    speed = data.clearance_speed.isel(clearance=0).to_numpy()
    for row, (line, start) in enumerate(zip(grid, STARTS, strict=True)):
        reach = 1.08 * np.abs(speed[row]).max()
        low, high = angle[row].min() - 8, angle[row].max() + 8
        if high - low > 180:
            low, high = -180, 180
        for column, ax in enumerate(line):
            look = {"markersize": DOT, "markeredgewidth": 0, "color": PALETTE[row]}
            ax.plot(angle[row, column], speed[row, column], "o", **look)
            ax.set_xlim(low, high)
            ax.xaxis.set_major_locator(FixedLocator(_sparse(low, high)))
            ax.set_ylim(-reach, reach)
            if column:
                ax.tick_params(labelleft=False)
            if row == len(STARTS) - 1:
                ax.set_xlabel("α [°]", labelpad=1)
            if not row:
                ax.set_title(names[column])
        line[0].set_ylabel(f"{start}\ndα/dt [rad/s]")
    return figure


def _sparse(low: float, high: float) -> list[float]:
    """Angles in degrees so far apart that labels of neighbouring panels do not meet."""
    step = 90 if high - low > 180 else 40 if high - low > 70 else 20
    first, last = np.ceil((low + 0.1 * step) / step), np.floor((high - 0.1 * step) / step)
    return [float(step * k) for k in np.arange(first, last + 1)]


def diagram_figure(data: xr.Dataset, x: np.ndarray, label: str) -> Figure:
    """Figs. 13 and 15: section points of α̇ over the parameter, for our initial conditions."""
    figure, grid = _shared(len(STARTS), 1, 1.9)
    speed = data.clearance_speed.isel(clearance=0).to_numpy()
    for row, ((ax,), start) in enumerate(zip(grid, STARTS, strict=True)):
        places = np.repeat(x[:, None], speed.shape[2], axis=1)
        look = {"markersize": FAINT_DOT, "markeredgewidth": 0, "alpha": FAINT}
        ax.plot(places.ravel(), speed[row].ravel(), "o", color=PALETTE[row], **look)
        reach = np.nanpercentile(np.abs(speed[row]), MOST)
        ax.set_ylim(-reach, reach)
        ax.set_xlim(x.min(), x.max())
        ax.set_ylabel(f"{start}\ndα/dt [rad/s]")
        if row < len(STARTS) - 1:
            ax.tick_params(labelbottom=False)
    ax.set_xlabel(label)
    return figure


def law_figure(
    x: np.ndarray,
    data: xr.Dataset,
    label: str,
    laws: Sequence[tuple[PowerLaw, NDArray[np.bool_], str]],
    names: Sequence[str],
) -> Figure:
    """Spread of α̇ against a parameter, with a line of common slope for each initial condition.

    Parameters
    ----------
    x
        Values of the parameter as shown.
    data
        The sweep.
    label
        Of the axis.
    laws
        Power laws of the mean over all initial conditions, with the values of the parameter that
        each is fitted to, and their names.
    names
        Of the initial conditions.
    """
    figure, (ax,) = panels(1, 1, 2.9)
    for index, (row, name) in enumerate(zip(spread(data), names, strict=True)):
        look = {"color": PALETTE[index % len(PALETTE)], "marker": "os^vD*P"[index % 7]}
        ax.loglog(x, row, linestyle="", markersize=4, alpha=0.85, label=f"α = {name}", **look)
        for place, (law, part, _) in enumerate(laws):
            line = law.beside(x[part], row[part])
            ax.loglog(x[part], line, color=look["color"], linewidth=0.8, linestyle=DASHES[place])
    for place, (law, _, name) in enumerate(laws):
        style = {"color": BLACK, "linewidth": 0.8, "linestyle": DASHES[place]}
        ax.plot([], [], label=f"{name}\n{law}", **style)
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
    ax.set_xlabel(label)
    ax.set_ylabel("standard deviation of dα/dt [rad/s]")
    ax.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), borderaxespad=0.0)
    box = ax.get_position()
    ax.set_position([box.x0, box.y0, box.width * 0.7, box.height])
    return figure
