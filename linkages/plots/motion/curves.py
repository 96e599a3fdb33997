"""Curves over time: envelope and detail where dense, peak, horizon of predictability."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from linkages.plots.style import Scale, width_of
from linkages.solution.extremes import largest
from linkages.solution.run_options import turning_points

Array = NDArray[np.float64]

STEADY = 1e-6  # of the values: a smaller change is not drawn as one
BUSY = 80  # turning points, beyond which a thinner line shows more
ROOM = 0.08  # beside the swings of a detail, in parts of their time
DENSE = 120  # turning points, beyond which swings are narrower than a few lines


class CurvePeak(NamedTuple):
    """A value of a curve that decides, in SI units, what it is, and whether it is predictable."""

    time: float
    value: float
    late: bool = False
    word: str = "peak"

    @property
    def weight(self) -> float:
        """How much it decides: more for a larger one, and for an angle that transmits less."""
        return abs(self.value) if self.word == "peak" else -abs(np.sin(self.value))

    def text(self, scales: tuple[Scale, Scale], of: str = "") -> str:
        """The peak in words, and whose it is if that is said."""
        whose = f" of {of}" * bool(of)
        text = f"{self.word} {scales[1].text(self.value)}{whose} at {scales[0].text(self.time)}"
        return f"{text} (not predictable)" if self.late else text


def peak_of(
    time: Array, values: Array, horizon: float | None = None, *, smooth: bool = True
) -> CurvePeak | None:
    """Where a curve is farthest from zero; None if no sample is finite.

    `time`, `values`: shape (n,), times equally spaced.
    Returns: as `linkages.solution.extremes.largest` locates it between samples; the largest sample
    where some are not finite, or the curve is not smooth.
    """
    finite = np.isfinite(values)
    if not finite.any():
        return None
    if finite.all():
        result = largest(values, 0.0 if smooth else np.inf)
        place, value = result.time, result.value
    else:
        place = float(np.argmax(np.where(finite, np.abs(values), -1.0)))
        value = float(values[int(place)])
    at = float(np.interp(place, np.arange(len(time)), time))
    return CurvePeak(at, value, beyond(at, horizon))


def worst_of(time: Array, angles: Array, horizon: float | None = None) -> CurvePeak | None:
    """Where an angle from 0 to π is nearest to one of these: there it transmits least."""
    if not np.isfinite(angles).any():
        return None
    low, high = float(np.nanmin(angles)), float(np.nanmax(angles))
    base, word = (high, "least") if low <= np.pi - high else (low, "greatest")
    peak = peak_of(time, angles - base, horizon)
    return peak and peak._replace(value=peak.value + base, word=word)


def beyond(time: float, horizon: float | None) -> bool:
    """Whether a time is later than that to which the motion is predictable."""
    return horizon is not None and abs(time) > abs(horizon)


def envelope(time: Array, values: Array, columns: int) -> tuple[Array, Array, Array]:
    """Least and largest value in each of so many columns of equal width.

    `time`, `values`: shape (n,), times in order; values that are not finite are left out.
    Returns: time, low, high: the middles of columns; each reaches to the first sample of the next
    one, as a line would.
    """
    span = float(time[-1] - time[0])
    column = np.minimum(((time - time[0]) / span * columns).astype(int), columns - 1)
    used, first = np.unique(column, return_index=True)
    finite = np.isfinite(values)
    low = np.minimum.reduceat(np.where(finite, values, np.inf), first)
    high = np.maximum.reduceat(np.where(finite, values, -np.inf), first)
    following = np.append(values[first[1:]], values[-1])
    low, high = np.fmin(low, following), np.fmax(high, following)
    return time[0] + (used + 0.5) / columns * span, low, high


def draw_curve(
    ax: Axes, time: Array, values: Array, scales: tuple[Scale, Scale], **line: Any
) -> Line2D:
    """Draw a curve in shown units; a lone sample becomes a dot.

    Where it is denser than the paper, what is filled reaches from its least to its largest value in
    each column of pixels.

    `time`, `values`: shape (n,), SI units.
    """
    x, y = time * scales[0].factor, values * scales[1].factor
    turns = turning_points(values)
    if turns > DENSE:
        middle, low, high = envelope(x, y, max(2, int(ax.bbox.width)))
        colour, opacity = line.get("color"), line.get("alpha", 1.0)
        edge = {"edgecolor": colour, "linewidth": 0.6, "alpha": opacity}
        ax.fill_between(middle, low, high, facecolor=colour, **edge)
        return Line2D([], [], color=colour, linewidth=3.0, alpha=opacity)
    if turns > BUSY:
        line = {"linewidth": 0.7, **line}
    (curve,) = ax.plot(x, y, marker="." if len(x) == 1 else "", **line)
    return curve


def swings_about(time: Array, values: Array, at: float, count: int = 6) -> tuple[float, float]:
    """Earliest and latest time of so many swings of a series around a time."""
    order = 1 if time[-1] >= time[0] else -1
    time, steps = time[::order], np.diff(values[::order])
    moving = np.flatnonzero(np.abs(steps) > STEADY * np.nanmax(np.abs(values)))
    turned = np.flatnonzero(np.diff(np.sign(steps[moving])))
    turns = time[moving[turned + 1]]
    place = int(np.searchsorted(turns, at))
    first = min(max(0, place - count), max(0, len(turns) - 1 - 2 * count))
    last = min(first + 2 * count, len(turns) - 1)
    room = ROOM * (turns[last] - turns[first])
    return max(float(time[0]), turns[first] - room), min(float(time[-1]), turns[last] + room)


def span_words(span: tuple[float, float], scale: Scale) -> str:
    """Two times with as many digits as tell them apart."""
    low, high = (scale.factor * end for end in span)
    digits = int(np.clip(1 - np.floor(np.log10(max(high - low, 1e-9))), 0, 9))
    return f"{low:.{digits}f}–{high:.{digits}f} {scale.units}".replace("-", "−")


def show_steady(ax: Axes, values: Array, along: str = "y", least: float = 0.0) -> None:
    """Show values that are constant but for round-off as constant.

    `values`: in the units of the axes. `least`: what round-off is measured by at least.
    """
    finite = values[np.isfinite(values)]
    if not len(finite):
        return
    low, high = float(finite.min()), float(finite.max())
    size = max(abs(low), abs(high), least)
    if high - low < STEADY * size:
        ax.set(**{f"{along}lim": (low - 0.1 * size, high + 0.1 * size)})


def mark_peak(
    ax: Axes, peak: CurvePeak, scales: tuple[Scale, Scale], colour: str, text: str = ""
) -> None:
    """Mark a peak by a ring, and write a text beyond it: above its top or below its bottom."""
    x, y = peak.time * scales[0].factor, peak.value * scales[1].factor
    look: dict[str, Any] = {"markerfacecolor": "white", "markeredgecolor": colour}
    ax.plot([x], [y], "o", markersize=4, clip_on=False, zorder=4, **look)
    if not text:
        return
    low, high = ax.get_xlim()
    place = (x - low) / (high - low)
    side = -1 if peak.word == "least" or (peak.word == "peak" and peak.value < 0) else 1
    # beside the ring rather than over it near an end: else the text begins on the frame
    aligned, aside = ("left", 5) if place < 0.3 else ("right", -5) if place > 0.7 else ("center", 0)
    ax.annotate(
        text, (x, y), xytext=(aside, 5 * side), textcoords="offset points", ha=aligned,
        va="bottom" if side > 0 else "top",
    )  # fmt: skip


TEXT = "not predictable"
WIDE, TALL = 0.85, 0.16  # inches that the words take along a band, and across one


def shade_beyond_horizon(ax: Axes, horizon: float | None, time: Array, scale: Scale) -> None:
    """Shade the times at which the solution has fewer than three correct digits.

    The words stand within the band, upright in a narrow one; an arrow leads from them to one that
    is narrower still.
    """
    if horizon is None or not time.size:
        return
    begin, end = horizon * scale.factor, float(time[-1]) * scale.factor
    ax.axvspan(begin, end, color="0.88", zorder=0, linewidth=0)
    whole = abs(float(np.ptp(time))) * scale.factor
    width = abs(end - begin) / whole * width_of(ax) if whole else 0.0
    look: dict[str, Any] = {
        "xycoords": ("data", "axes fraction"), "textcoords": "offset points", "color": "0.35",
        "zorder": 3,
    }  # fmt: skip
    middle = 0.5 * (begin + end)
    if width >= WIDE:
        ax.annotate(TEXT, (begin, 0.015), xytext=(3, 0), **look)
    elif width >= TALL:
        ax.annotate(TEXT, (middle, 0.03), xytext=(0, 0), rotation=90, ha="center", **look)
    else:
        look["arrowprops"] = {"arrowstyle": "-|>", "color": "0.35", "linewidth": 0.7}
        ax.annotate(TEXT, (middle, 0.05), xytext=(-14, 0), ha="right", va="center", **look)
