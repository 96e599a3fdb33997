"""Where the paper's maxima lie among all initial conditions, and what a digit costs with RK4."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator

from linkages.plots.panels import panels
from linkages.plots.style import BLACK, GREY, PALE, PALETTE, line_style
from make.accuracy import power_of_ten
from make.reproduction.maxima import torque_ratio
from make.reproduction.reported import PRINTED, REPORTED
from make.reproduction.steps import END, StepError

PAPER, OURS = PALETTE[1], PALETTE[0]

STAGES = 4
"""Evaluations of the right-hand side in a step of RK4."""


def maxima_figure(quantiles: np.ndarray, own: np.ndarray) -> Figure:
    """Cumulative share of initial conditions, with the paper's and our own maximum.

    Parameters
    ----------
    quantiles
        Percentiles 0 to 100 of the five maxima and of the ratio of torques, shape (101, 6).
    own
        The five maxima from the librating initial condition.
    """
    figure, axes = panels(3, 2, 1.4)
    for index, quantity in enumerate(REPORTED):
        columns = (quantiles[:, index], PRINTED[index], own[index])
        shown = [quantity.factor * np.asarray(column) for column in columns]
        _distribution(axes[index], *shown, f"maximum {quantity.words} [{quantity.units}]")
    ratio = torque_ratio(PRINTED), torque_ratio(own)
    _distribution(axes[5], quantiles[:, 5], *ratio, "torque of crank 1 / torque of crank 4")
    place = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "borderaxespad": 0.2}
    names = ["all initial conditions", "paper", "librating initial condition"]
    axes[0].legend(axes[0].lines[:3], names, **place, ncols=3)
    return figure


def _distribution(ax: Axes, values: np.ndarray, paper: float, own: float, label: str) -> None:
    """Percentiles over their values, logarithmic."""
    low, high = min(values[0], paper) / 1.15, max(values[-1], paper) * 1.15
    ax.fill_between(values, np.arange(101), color=PALE, linewidth=0)
    ax.plot(values, np.arange(101), color=GREY)
    ax.axvline(float(paper), color=PAPER, linewidth=1.6)
    ax.axvline(float(own), color=OURS, linewidth=1.6, linestyle=(0, (4, 1.5)))
    ax.set_xscale("log")
    ax.set_xlim(low, high)
    ax.set_ylim(0, 104)
    ax.set_yticks([0, 50, 100])
    # as many round numbers as fit
    digits = (1, 1.25, 1.6, 8) if high / low < 5 else (1, 2, 5) if high / low < 300 else (1,)
    powers = np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
    ticks = [d * 10.0**p for p in powers for d in digits if low <= d * 10.0**p <= high]
    ax.set_xticks(ticks)
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xlabel(label)
    ax.set_ylabel("share below [%]")


def steps_figure(found: Mapping[str, Sequence[StepError]]) -> Figure:
    """Work against the error of α̇ at the end, both logarithmic, with the steps on the right."""
    figure, (ax,) = panels(1, 1, 2.8)
    for index, (start, rows) in enumerate(found.items()):
        steps, errors = (np.array([getattr(r, name) for r in rows]) for name in ("step", "error"))
        look = line_style(index) | {"marker": "os"[index], "markersize": 4}
        ax.loglog(errors, STAGES * END / steps, label=f"{start} initial condition", **look)
    for digit, side in ((1, "left"), (3, "right")):
        level = 0.5 * 10.0**-digit
        ax.axvline(level, color=BLACK, linewidth=0.8, linestyle=(0, (1.2, 1.2)))
        words = f"5·{power_of_ten(0.1 * 10.0**-digit)}"
        shift = (3, -2) if side == "left" else (-3, -2)
        options = {"ha": side, "va": "top", "fontsize": 8, "textcoords": "offset points"}
        ax.annotate(words, (level, 1.0), shift, xycoords=("data", "axes fraction"), **options)
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(LogLocator(numticks=12))
        axis.set_major_formatter(FuncFormatter(power_of_ten))
        axis.set_minor_formatter(NullFormatter())
    box = ax.get_position()
    ax.set_position([box.x0, box.y0, box.width - 0.09, box.height])
    _show_steps(ax)
    ax.set_xlabel("relative error of dα/dt at t = 1 s")
    ax.set_ylabel("evaluations of the right-hand side")
    ax.legend(loc="lower left")
    return figure


def _show_steps(ax: Axes) -> None:
    """The step of RK4 on an axis to the right."""
    low, high = ax.get_ylim()
    right = ax.twinx()
    right.set_yscale("log")
    right.set_ylim(STAGES * END * 1e6 / low, STAGES * END * 1e6 / high)
    right.grid(visible=False)
    right.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    right.yaxis.set_minor_formatter(NullFormatter())
    right.set_ylabel("step of RK4 [µs]")
