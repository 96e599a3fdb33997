"""Lyapunov exponents over time: how they settle, and how sure they are in the end."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.plots.chaos.bifurcations import BAND
from linkages.plots.motion.curves import thinned
from linkages.plots.prefixes import scale_of
from linkages.plots.style import BLACK, PALETTE, TOP, legend_above, line_style, panels, styled
from linkages.reading.wording import to_error

if TYPE_CHECKING:
    import xarray as xr

HEIGHT, LEGEND, ROW = 3.0, 0.2, 0.16
SETTLING = 0.1
"""Part of the run at the beginning that may lie outside the picture."""

NONE = "all Lyapunov exponents are −∞: the motion has merged with its neighbours"
"""What is written where there is nothing to draw."""


@styled
def figure(data: xr.Dataset) -> Figure:
    """The figure of `draw`, with room for its legend."""
    ax = draw(page(data), data, str(data.attrs.get("name", "")))
    result = ax.get_figure(root=True)
    assert result is not None
    return result


def page(data: xr.Dataset) -> Axes:
    """Axes of a new figure, with room for the legend."""
    rows = -(-data.sizes["index"] // 2)
    return panels(1, 1, HEIGHT, TOP + LEGEND + rows * ROW)[1][0]


def draw(ax: Axes, data: xr.Dataset, heading: str = "") -> Axes:
    """Draw the history of each exponent, and a band of two standard errors about its last value.

    Parameters
    ----------
    ax
        Where to draw.
    data
        As `linkages.lyapunov` returns it.
    heading
        Stands over the legend.
    """
    time = np.asarray(data["time"], dtype=float)
    history, errors = np.asarray(data["history"]), np.asarray(data["error"])
    scale = scale_of(time, "s")
    ax.axhline(0.0, color=BLACK, linewidth=0.9, zorder=2)
    entries = []
    for index, (values, error) in enumerate(zip(history.T, errors, strict=True)):
        look = line_style(index)
        last = float(values[-1])
        ax.axhspan(
            last - BAND * error,
            last + BAND * error,
            color=PALETTE[index % len(PALETTE)],
            alpha=0.15,
            linewidth=0,
        )
        x, y = thinned(time, values)
        (line,) = ax.plot(x * scale.factor, y, **look)
        shown, by = to_error(last, float(error))
        shown = shown.replace("-", "−")
        entries.append((line, f"λ{_below(index + 1)} = {shown} ± {by} 1/s"))
    _limits(ax, history, errors)
    ax.set_xlim(time[0] * scale.factor, time[-1] * scale.factor)
    ax.set_xlabel(scale.label("time"))
    ax.set_ylabel("running estimate of the Lyapunov exponent [1/s]")
    if entries:
        lines, texts = zip(*entries, strict=True)
        ax.legend(lines, texts, **legend_above(heading), ncols=2)
        return ax
    ax.set_title(heading)
    ax.text(0.5, 0.75, NONE, ha="center", va="center", transform=ax.transAxes)
    return ax


def _limits(ax: Axes, history: np.ndarray, errors: np.ndarray) -> None:
    """Show what exponents do once they settle; the first of them may be much larger."""
    late = history[int(SETTLING * len(history)) :]
    last = history[-1]
    low = min(late.min(initial=0.0), (last - BAND * errors).min(initial=0.0))
    high = max(late.max(initial=0.0), (last + BAND * errors).max(initial=0.0))
    margin = 0.06 * (high - low) or 1.0
    ax.set_ylim(low - margin, high + margin)


def _below(number: int) -> str:
    return str(number).translate(str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉"))
