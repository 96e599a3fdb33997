"""Power spectra with their lines marked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.plots.style import BLACK, PALETTE, TOP, fitted, legend_above, panels, styled

if TYPE_CHECKING:
    from linkages.chaos.series.spectrum import PowerSpectrum

HEIGHT, LEGEND = 2.4, 0.3
MOST_LINES = 40
DECADES = 12.0
"""What lies this far below the highest peak is not shown."""

STRETCHES = 400
"""Medians of so many stretches draw the floor."""


@styled
def figure(spectra: Mapping[str, PowerSpectrum], heading: str = "") -> Figure | None:
    """One panel for each observed quantity; None if there are none."""
    if not spectra:
        return None
    result, axes = panels(len(spectra), 1, HEIGHT, TOP + LEGEND)
    for ax, (name, spectrum) in zip(axes, spectra.items(), strict=True):
        draw(ax, spectrum, f"{heading}: {name}" if heading else name)
    return result


def draw(ax: Axes, spectrum: PowerSpectrum, heading: str = "") -> Axes:
    """Draw power over frequency in decibels below its peak, with the strongest lines marked.

    Parameters
    ----------
    ax
        Where to draw.
    spectrum
        From `linkages.chaos.series.spectrum.power_spectrum`.
    heading
        Stands over the legend.
    """
    frequencies, density = spectrum.frequencies[1:], spectrum.density[1:]
    peak = float(density.max()) or 1.0
    least = 10.0**-DECADES
    level = 10 * np.log10(np.maximum(density / peak, least))
    ax.plot(frequencies, level, color=PALETTE[0], linewidth=0.6, label="power")
    floor = 10 * np.log10(np.maximum(spectrum.floor[1:] / peak, least))
    parts = np.array_split(np.arange(len(floor)), min(STRETCHES, len(floor)))
    ax.plot(
        [np.mean(frequencies[part]) for part in parts],
        [np.median(floor[part]) for part in parts],
        color=BLACK,
        linewidth=0.8,
        label="floor between lines",
    )
    lines = spectrum.lines[:MOST_LINES]
    if len(lines):
        at = np.clip(np.round(lines / spectrum.resolution).astype(int) - 1, 0, len(level) - 1)
        ax.plot(
            lines,
            level[at] + 3.0,
            "v",
            color=PALETTE[1],
            markersize=3.5,
            markeredgewidth=0,
            label=_count(len(spectrum.lines)),
        )
    shown = frequencies[level > -10 * DECADES + 20]
    high = float(shown.max()) if len(shown) else float(frequencies[-1])
    ax.set_xlim(0.0, high)
    ax.set_ylim(max(-10 * DECADES, float(level[frequencies <= high].min())) - 4.0, 12.0)
    ax.set_xlabel("frequency [Hz]")
    ax.set_ylabel("power relative to the peak [dB]")
    ax.legend(**legend_above(fitted(heading, ax.bbox.width / ax.figure.dpi)), ncols=3)
    return ax


def _count(lines: int) -> str:
    if lines > MOST_LINES:
        return f"the strongest {MOST_LINES} of {lines} lines"
    return f"{lines} line{'' if lines == 1 else 's'}"
