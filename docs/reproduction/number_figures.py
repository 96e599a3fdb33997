"""Where the paper's numbers lie among all starts, and what a step of RK4 costs in digits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter, NullLocator

from linkages.plots.style import BLACK, GREY, PALE, PALETTE, line_style, panels, styled
from reproduction.maxima import torque_ratio
from reproduction.reported import PRINTED, REPORTED
from reproduction.steps import StepError

PAPER, OURS = PALETTE[1], PALETTE[0]

RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


@styled
def maxima_figure(quantiles: np.ndarray, own: np.ndarray) -> Figure:
    """Share of starts with a smaller maximum, with the paper's and our own number.

    Parameters
    ----------
    quantiles
        Percentiles 0 to 100 of the five numbers and of the ratio of torques, shape (101, 6).
    own
        The five numbers of the default start.
    """
    figure, axes = panels(3, 2, 1.25, 0.36)
    for index, quantity in enumerate(REPORTED):
        columns = (quantiles[:, index], PRINTED[index], own[index])
        shown = [quantity.factor * np.asarray(column) for column in columns]
        _distribution(axes[index], *shown, f"{quantity.words} [{quantity.units}]")
    ratio = torque_ratio(PRINTED), torque_ratio(own)
    _distribution(axes[5], quantiles[:, 5], *ratio, "torque of crank 1 / torque of crank 4")
    place = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "borderaxespad": 0.2}
    lines = axes[0].lines[:3]
    axes[0].legend(lines, ["all starts", "paper", "default start"], **place, ncols=3)
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
    ax.set_ylabel("starts below [%]")


@styled
def steps_figure(found: Mapping[str, Sequence[StepError]]) -> Figure:
    """Error of α̇ at 1 s against the step, both logarithmic."""
    figure, (ax,) = panels(1, 1, 2.6)
    for index, (start, rows) in enumerate(found.items()):
        steps, errors = ([getattr(row, name) for row in rows] for name in ("step", "error"))
        look = line_style(index) | {"marker": "os"[index], "markersize": 4}
        ax.loglog(np.array(steps) * 1e6, errors, label=f"{start} start", **look)
    for digit in (1, 3):
        level = 0.5 * 10.0**-digit
        ax.axhline(level, color=BLACK, linewidth=0.8, linestyle=(0, (1.2, 1.2)))
        words = f"relative error 5·10{str(-digit - 1).translate(RAISED)}"
        ax.annotate(words, (1.05, level), (0, 2), textcoords="offset points", fontsize=8)
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.0e}"))
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_minor_formatter(NullFormatter())
    ax.set_xlabel("step of RK4 [µs]")
    ax.set_ylabel("error of dα/dt at 1 s / amplitude")
    ax.legend(loc="lower right")
    return figure
