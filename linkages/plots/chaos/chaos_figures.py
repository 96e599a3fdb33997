"""Poincaré sections, exponents over time, power spectra, and forces in clearances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from string import ascii_uppercase
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from linkages.chaos.contact_log import lost_spans
from linkages.plots.chaos.diagrams import BAND
from linkages.plots.motion.curves import draw_curve, show_steady
from linkages.plots.motion.phase_diagrams import (
    TOUCHES,
    Free,
    free_coordinate,
    free_coordinates,
    shown_pair,
    stepped,
)
from linkages.plots.panels import (
    PAIRED,
    axes_for,
    chart,
    diagram_each,
    diagrams,
    labelled,
    legend_above,
    mosaic,
    panels,
    time_axis,
)
from linkages.plots.style import (
    BLACK,
    PALETTE,
    figure_of,
    line_style,
    name_of,
    scale_of,
    set_title,
    styled,
    title,
)
from linkages.reading.wording import listed, to_error

if TYPE_CHECKING:
    import xarray as xr

    from linkages.chaos.findings import ChaosReport
    from linkages.chaos.indicators import PowerSpectrum

Array = NDArray[np.float64]

WHOLE = 3.2  # inches: height of the panel with all points over enlarged parts


class Zoom(NamedTuple):
    """A rectangle in units of the axes, of the free coordinate named, or of the only one."""

    left: float
    right: float
    bottom: float
    top: float
    name: str = ""

    def inside(self, x: Array, y: Array) -> tuple[Array, Array]:
        """The points in it."""
        there = (x >= self.left) & (x <= self.right) & (y >= self.bottom) & (y <= self.top)
        return x[there], y[there]

    def limit(self, ax: Axes) -> None:
        """Make it the limits of axes, with few ticks: their numbers are long."""
        ax.set_xlim(self.left, self.right)
        ax.set_ylim(self.bottom, self.top)
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_locator(MaxNLocator(4, steps=(1, 2, 2.5, 5, 10)))

    def frame(self, ax: Axes, letter: str) -> None:
        """Draw its outline with a letter."""
        width, height = self.right - self.left, self.top - self.bottom
        look: dict[str, Any] = {"edgecolor": PALETTE[1], "linewidth": 1.1, "zorder": 4}
        ax.add_patch(Rectangle((self.left, self.bottom), width, height, fill=False, **look))
        ax.annotate(
            letter, (self.right, self.top), xytext=(2, 1), textcoords="offset points",
            fontweight="bold", color=PALETTE[1], zorder=5,
        )  # fmt: skip

    def within(self, other: Zoom) -> bool:
        """Whether it is a part of another one."""
        across = other.left <= self.left < self.right <= other.right
        return self is not other and across and other.bottom <= self.bottom < self.top <= other.top

    def __str__(self) -> str:
        """As it is written on the command line."""
        numbers = ",".join(f"{side:g}" for side in self[:4])
        return f"{self.name}:{numbers}" if self.name else numbers


def read_zoom(text: str) -> Zoom:
    """A rectangle as it is written on the command line."""
    name, _, sides = text.rpartition(":")
    try:
        left, right, bottom, top = map(float, sides.split(","))
    except ValueError:
        left = right = bottom = top = np.nan
    if not (left < right and bottom < top and np.isfinite([left, right, bottom, top]).all()):
        raise ValueError(f"expected LEFT,RIGHT,BOTTOM,TOP in units of the axes, found {text!r}")
    return Zoom(left, right, bottom, top, name)


def coordinate_of(zooms: Sequence[Zoom], names: Sequence[str]) -> str:
    """The free coordinate, of those named, that rectangles belong to."""
    only = names[0] if len(names) == 1 else ""
    asked = {zoom.name or only for zoom in zooms}
    if len(asked) == 1 and asked <= set(names):
        return asked.pop()
    wanted, written = listed(list(names), "or"), listed([str(zoom) for zoom in zooms], "and")
    raise ValueError(f"expected rectangles of one free coordinate, {wanted}; found {written}")


SIZES = ((60, 4.0), (600, 2.4), (3000, 1.5), (20_000, 0.9), (np.inf, 0.5))
FAINT = ((3000, 1.0), (20_000, 0.5), (np.inf, 0.3))
"""Size and opacity of dots up to so many points: what is dense looks dense."""


@styled
def section_figure(data: xr.Dataset, zooms: Sequence[Zoom] = ()) -> Figure | None:
    """One panel for each free coordinate; None for data without points.

    `zooms`: rectangles that are drawn once more below, two in a row; with any of them, only the
    free coordinates that they belong to are drawn.
    """
    found = [free.name for free in free_coordinates(data)]
    if not found or not data.sizes["crossing"]:
        return None
    if zooms:
        return _zoomed(data, coordinate_of(zooms, found), zooms)
    return diagram_each(found, lambda ax, name, of: _draw(ax, data, name, of), name_of(data))


def _zoomed(data: xr.Dataset, name: str, zooms: Sequence[Zoom]) -> Figure:
    """A panel with all points, and the rectangles below it."""
    pairs = [[k, k + 1 if k < len(zooms) else -1] for k in range(1, len(zooms) + 1, 2)]
    result, (main, *others) = mosaic([[0, 0], *pairs], [WHOLE, *[PAIRED] * len(pairs)])
    _draw(main, data, name, name_of(data))
    for ax, letter, zoom in zip(others, ascii_uppercase, zooms, strict=False):
        _draw(ax, data, name, zoom=zoom)
        for panel, whole in ((main, None), *zip(others, zooms, strict=True)):
            if whole is None or zoom.within(whole):
                zoom.frame(panel, letter)
        ax.set_title(letter)
    return result


@chart
def section(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """Points of `linkages.poincare`: of the free coordinate named, or the first.

    `name`: The free coordinate.
    """
    return _draw(axes_for(ax), data, name, name_of(data))


def _draw(
    ax: Axes, data: xr.Dataset, name: str | None, heading: str = "", zoom: Zoom | None = None
) -> Axes:
    """Draw the points of one free coordinate."""
    coordinate = free_coordinate(data, name)
    x, y = shown_pair(ax, data, coordinate, coordinate.pair)
    if zoom is not None:
        x, y = zoom.inside(x, y)
    ax.plot(
        x, y, "o", color=PALETTE[0], markersize=stepped(SIZES, len(x)), markeredgewidth=0,
        alpha=stepped(FAINT, len(x)), zorder=3, rasterized=len(x) > FAINT[0][0],
    )  # fmt: skip
    if zoom is None:
        for along, values in (("x", x), ("y", y)):  # points that coincide are one
            show_steady(ax, values, along, least=1.0)
    else:
        zoom.limit(ax)
    count = f"{len(x):,} point{'' if len(x) == 1 else 's'}"
    set_title(ax, title(heading, coordinate.name), count)
    return ax


@styled
def impact_map_figure(data: xr.Dataset) -> Figure | None:
    """Rates over phases and directions over phases; rates over directions without a period."""
    phase, rate, direction = TOUCHES
    pairs = [(phase, rate), (phase, direction)] if phase in data else [(direction, rate)]
    shown = [pair for pair in pairs if {*pair} <= set(data.data_vars)]
    if not shown or not data.sizes["crossing"]:
        return None
    free = Free("touch", str(data["touch"].values[0]))
    result, axes = diagrams(len(shown))
    for ax, pair in zip(axes, shown, strict=True):
        x, y = shown_pair(ax, data, free, pair)
        size = stepped(SIZES, len(x))
        ax.plot(x, y, "o", color=PALETTE[0], markersize=size, markeredgewidth=0, zorder=3)
        if pair[0] == phase:
            ax.set_xlim(0.0, 1.0)
        if pair[1] == rate and np.nanmin(y) >= 0.0:
            ax.set_ylim(bottom=0.0)
    set_title(axes[-1], "", f"{data.sizes['crossing']} touches")
    set_title(axes[0], title(name_of(data), free.name))
    return result


HEIGHT = 3.0
SETTLING = 0.1  # part of the run at the beginning that may lie outside the picture
FLAT = 40.0  # largest exponent over others from which on its axis is logarithmic away from zero
LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
NONE = "all Lyapunov exponents are −∞: the motion has merged with its neighbours"
"""What is written where there is nothing to draw."""


@chart
def exponents(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """How the exponents of `linkages.lyapunov` settle over time.

    A band about the last value of each has twice its standard error on either side.
    """
    ax = axes_for(ax, HEIGHT)
    time, history, errors = (np.asarray(data[name]) for name in ("time", "history", "error"))
    scale = time_axis(ax, time)
    ax.axhline(0.0, color=BLACK, linewidth=0.9, zorder=2)
    entries: dict[str, Artist] = {}
    for index, (values, error) in enumerate(zip(history.T, errors, strict=True)):
        look, last = line_style(index), float(values[-1])
        band = last - BAND * error, last + BAND * error
        ax.axhspan(*band, color=look["color"], alpha=0.15, linewidth=0)
        (line,) = ax.plot(time * scale.factor, values, **look)
        shown, by = to_error(last, float(error))
        number = str(index + 1).translate(LOWERED)
        entries[f"λ{number} = {shown} ± {by} 1/s".replace("-", "−")] = line
    _limits(ax, history, errors)
    ax.set_ylabel("running estimate of the Lyapunov exponent [1/s]")
    legend_above(ax, entries, name_of(data))
    if not entries:
        ax.text(0.5, 0.75, NONE, ha="center", va="center", transform=ax.transAxes)
    return ax


def _limits(ax: Axes, history: np.ndarray, errors: np.ndarray) -> None:
    """Show what exponents do once they settle; the first of them may be much larger."""
    late = history[int(SETTLING * len(history)) :]
    last = history[-1]
    low = min(late.min(initial=0.0), (last - BAND * errors).min(initial=0.0))
    high = max(late.max(initial=0.0), (last + BAND * errors).max(initial=0.0))
    margin = 0.06 * (high - low) or 1.0
    sizes = np.sort(np.abs(last))
    small = sizes[(sizes > 0.0) & (sizes < sizes.max(initial=0.0) / FLAT)]
    if small.size:  # else those whose signs decide would lie on zero
        ax.set_yscale("symlog", linthresh=2.0 * float(small.max()), linscale=2.0)
        ax.yaxis.set_major_formatter(lambda value, _: f"{value:g}".replace("-", "−"))
        low, high, margin = 1.5 * low, 1.5 * high, 2.0 * float(small.max())
    ax.set_ylim(low - margin, high + margin)


SPECTRUM_HEIGHT = 2.4
MOST_LINES = 40
DECADES = 12.0  # what lies this far below the highest peak is not shown
STRETCHES = 400  # medians of so many stretches draw the floor


@styled
def spectrum_figure(spectra: Mapping[str, PowerSpectrum], heading: str = "") -> Figure | None:
    """One panel for each observed quantity; None if there are none."""
    if not spectra:
        return None
    result, axes = panels(len(spectra), 1, SPECTRUM_HEIGHT)
    for ax, (name, spectrum) in zip(axes, spectra.items(), strict=True):
        draw_spectrum(ax, spectrum, title(heading, name))
    return result


def draw_spectrum(ax: Axes, spectrum: PowerSpectrum, heading: str = "") -> Axes:
    """Draw power over frequency in decibels below its peak, with the strongest lines marked."""
    frequencies, density = spectrum.frequencies[1:], spectrum.density[1:]
    peak = float(density.max()) or 1.0
    least = 10.0**-DECADES
    level = 10 * np.log10(np.maximum(density / peak, least))
    ax.plot(frequencies, level, color=PALETTE[0], linewidth=0.6, label="power")
    floor = 10 * np.log10(np.maximum(spectrum.floor[1:] / peak, least))
    parts = np.array_split(np.arange(len(floor)), min(STRETCHES, len(floor)))
    middles = [[np.mean(frequencies[part]), np.median(floor[part])] for part in parts]
    look: dict[str, Any] = {"color": BLACK, "linewidth": 0.8, "label": "floor between lines"}
    ax.plot(*np.transpose(middles), **look)
    lines = spectrum.lines[:MOST_LINES]
    if len(lines):
        at = np.clip(np.round(lines / spectrum.resolution).astype(int) - 1, 0, len(level) - 1)
        count, look = len(spectrum.lines), {"color": PALETTE[1], "markersize": 3.5}
        words = f"{count} line{'' if count == 1 else 's'}"
        if count > MOST_LINES:
            words = f"the strongest {MOST_LINES} of {words}"
        ax.plot(lines, level[at] + 3.0, "v", markeredgewidth=0, label=words, **look)
    shown = frequencies[level > -10 * DECADES + 20]
    high = float(shown.max()) if len(shown) else float(frequencies[-1])
    ax.set_xlim(0.0, high)
    ax.set_ylim(max(-10 * DECADES, float(level[frequencies <= high].min())) - 4.0, 12.0)
    ax.set_xlabel("frequency [Hz]")
    ax.set_ylabel("power relative to the peak [dB]")
    legend_above(ax, labelled(ax.lines), heading)
    return ax


CONTACT_HEIGHT = 2.3
LOST = "#F3D9C4"


@styled
def contact_figure(force: xr.DataArray, heading: str = "") -> Figure | None:
    """One panel for each clearance; None without clearances or samples."""
    if force.size == 0:
        return None
    names = [str(name) for name in force["clearance"].values]
    result, axes = panels(len(names), 1, CONTACT_HEIGHT)
    for ax, name in zip(axes, names, strict=True):
        draw_contact(ax, force.sel(clearance=name), title(heading, name))
    return result


def draw_contact(ax: Axes, force: xr.DataArray, heading: str = "") -> Axes:
    """Draw the force in a clearance; shaded where it is negative: a pin cannot pull at its hole."""
    time, values = np.asarray(force["time"], dtype=float), np.asarray(force, dtype=float)
    scales = time_axis(ax, time), scale_of(values, "N")
    spans = lost_spans(time, values)
    for begin, end in spans:
        ends = begin * scales[0].factor, end * scales[0].factor
        ax.axvspan(*ends, color=LOST, linewidth=0, zorder=0)
    ax.axhline(0.0, color=BLACK, linewidth=0.8, zorder=2)
    draw_curve(ax, time, values, scales, color=PALETTE[0])
    ax.set_ylabel(scales[1].label("force"))
    text = "contact throughout"
    if spans:
        share = sum(end - begin for begin, end in spans) / (time[-1] - time[0])
        text = f"shaded: no contact, {100 * share:.2g} % of the time shown"
    set_title(ax, heading, text)
    return ax


PERIODS = 4  # periods over which forces in clearances are shown


def chaos_figures(report: ChaosReport) -> dict[str, Figure]:
    """Name → figure, as far as the report has something to show."""
    result: dict[str, Figure | None] = {
        "chaos_section": section_figure(report.section),
        "chaos_exponents": figure_of(exponents(report.exponents)),
        "chaos_spectrum": spectrum_figure(report.spectra, report.name),
    }
    if report.force is not None:
        result["chaos_contact"] = contact_figure(shown_forces(report), report.name)
    return {name: figure for name, figure in result.items() if figure is not None}


def shown_forces(report: ChaosReport) -> xr.DataArray:
    """Forces over a few periods: where contact is lost first, else the last ones."""
    assert report.force is not None
    time = np.asarray(report.force["time"], dtype=float)
    taken = np.asarray(report.section["time"], dtype=float)
    period = float(np.median(np.diff(taken))) if len(taken) > 1 else float(np.ptp(time))
    losses = [item.first_loss for item in report.contact if item.first_loss is not None]
    length = PERIODS * period
    begin = min(losses) - 0.5 * period if losses else time[-1] - length
    begin = max(time[0], min(begin, time[-1] - length))
    return report.force.isel(time=(time >= begin) & (time <= begin + length))
