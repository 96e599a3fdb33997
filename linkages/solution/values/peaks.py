"""Largest values of a series, located between its samples."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.solvers.coefficients.collocation import cardinals

ROUND_OFF = 1e-9
"""Part of the scale of a series below which its values are round-off, and have no peaks."""

_TRUSTED = 0.01
"""Part of a peak up to which polynomials must agree on it; else the largest sample is given."""

_ALIKE = 1e-7
"""Part by which peaks must differ to be told apart: the first of those alike is given."""

_PLACES = np.linspace(-1.0, 1.0, 41)
"""Where a peak is looked for, in samples from the largest one nearby."""

_FIVE, _BEFORE, _BEHIND = (-2, -1, 0, 1, 2), (-2, -1, 0, 1), (-1, 0, 1, 2)
"""Samples that a polynomial goes through; the two shorter rows say how well it is determined."""

Floats = NDArray[np.float64]


class Peak(NamedTuple):
    """A largest absolute value.

    `value` and `time` (in samples) are those of the peak; `missed` is by what part of the value the
    motion may exceed it, because samples do not resolve the peak.
    """

    value: float
    time: float
    missed: float


def even(time: Floats) -> bool:
    """Whether samples are equally spaced, so that polynomials through them locate peaks."""
    steps = np.abs(np.diff(time))
    spread = steps.max(initial=0.0) - steps.min(initial=np.inf)
    return bool(spread <= 1e-6 * steps.max(initial=0.0))  # times are read from texts as well


def largest(series: Floats, scale: float) -> Peak:
    """The largest absolute value of a series, between samples where they resolve it.

    A polynomial of degree 4 through the five samples around a peak locates it; those of degree 3
    through four of them say how far that can be trusted.

    Parameters
    ----------
    series
        Shape (samples,), equally spaced.
    scale
        Size of values that are not round-off; infinite for series that are not smooth.
    """
    sizes = np.abs(series)
    index = int(np.argmax(sizes))
    sampled = Peak(float(series[index]), float(index), 0.0)
    if not ROUND_OFF * scale < sizes[index] < np.inf:
        return sampled
    bound = _bound(series, index)
    peaks = _tops(sizes)
    if not peaks.size:
        return sampled._replace(missed=bound)
    places, heights = _through(series, peaks, _FIVE)
    missed = np.max(
        [np.abs(_through(series, peaks, stencil)[1] - heights) for stencil in (_BEFORE, _BEHIND)],
        axis=0,
    )
    best = int(np.argmax(heights >= heights.max() * (1 - _ALIKE)))  # the first of those alike
    # the largest sample may be an end, or the peak; one or two samples do not resolve a peak
    higher = heights[best] > sizes[index] * (1 + _ALIKE)
    if not higher or missed[best] > _TRUSTED * heights[best]:
        return sampled._replace(missed=min(1.2 * bound, _excess(heights + missed, sizes[index])))
    sign = np.sign(series[peaks[best]])
    value, time = float(sign * heights[best]), float(peaks[best] + places[best])
    return Peak(value, time, min(bound, _excess(heights + missed, heights[best])))


def _excess(most: Floats, found: float) -> float:
    return max(0.0, float(most.max() / found - 1.0))


def _bound(series: Floats, index: int) -> float:
    """Part by which a motion may exceed the largest of its samples.

    A peak half way between two samples that are h apart is h²|f″|/8 above both. Of m peaks that are
    as high, one is likely to be m times as close to a sample.
    """
    if not 0 < index < len(series) - 1:
        return 0.0
    bend = series[index - 1] - 2 * series[index] + series[index + 1]
    single = float(abs(bend / (8 * series[index])))
    sizes = np.abs(series)
    inner = sizes[1:-1]
    peaks = (inner >= sizes[:-2]) & (inner > sizes[2:]) & (inner >= (1 - single) * sizes[index])
    return single / max(1, int(peaks.sum())) ** 2


def _tops(sizes: Floats) -> NDArray[np.int64]:
    """Samples that are larger than their neighbours, if a peak near them may be the largest."""
    if len(sizes) < 5:
        return np.zeros(0, dtype=np.int64)
    inner = sizes[2:-2]
    tops = (inner >= sizes[1:-3]) & (inner > sizes[3:-1])
    bends = 2 * inner - sizes[1:-3] - sizes[3:-1]
    reach = inner + np.where(tops, 0.5 * bends, 0.0)
    return np.flatnonzero(tops & (reach >= sizes.max())) + 2


def _through(
    series: Floats, peaks: NDArray[np.int64], stencil: tuple[int, ...]
) -> tuple[Floats, Floats]:
    """Where polynomials through samples beside peaks are largest, and how large, (peaks,) each."""
    nodes = np.array(stencil, dtype=float)
    samples = series[peaks[:, None] + np.array(stencil)] * np.sign(series[peaks])[:, None]
    values = samples @ cardinals(nodes, _PLACES).T
    at = np.clip(np.argmax(values, axis=1), 1, len(_PLACES) - 2)
    before, here, after = (values[np.arange(len(peaks)), at + k] for k in (-1, 0, 1))
    bend = before - 2 * here + after
    moved = np.where(bend < 0, 0.5 * (before - after) / np.where(bend < 0, bend, 1.0), 0.0)
    moved = np.clip(moved, -1.0, 1.0)
    return _PLACES[at] + moved * (_PLACES[1] - _PLACES[0]), here - 0.25 * (before - after) * moved
