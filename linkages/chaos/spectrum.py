"""Power spectrum, and the 0–1 test for chaos."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import median_filter
from scipy.signal import correlate, periodogram

Floats = NDArray[np.float64]

LOBE = 4
"""Half the width of a line in bins: the main lobe of the Blackman–Harris window."""

DYNAMIC_RANGE = 1e-8
"""Peaks below this part of the highest one may be side lobes of the window (-92 dB)."""

_NEIGHBOURS, _CLOSE = 40, 10
_FALSE_ALARM = 1e-3


@dataclass(frozen=True, eq=False)
class PowerSpectrum:
    """One-sided power spectrum of a series about its mean, and its lines.

    Parameters
    ----------
    frequencies, density
        In Hz and in (unit of the series)²/Hz, shape (n,).
    floor
        Local floor, shape (n,), as `density`.
    lines
        Frequencies of lines in Hz, the strongest first, shape (m,).
    powers
        Mean square that each carries, shape (m,).
    """

    frequencies: Floats
    density: Floats
    floor: Floats
    lines: Floats
    powers: Floats

    @property
    def resolution(self) -> float:
        """Distance of bins in Hz; lines closer than 9 bins may be taken for one."""
        return float(self.frequencies[1])

    @property
    def line_share(self) -> float:
        """Part of the mean square that lines carry: 1 for regular motions, less with chaos."""
        total = float(self.density.sum()) * self.resolution
        return min(1.0, float(self.powers.sum()) / total) if total > 0 else 1.0


def power_spectrum(series: ArrayLike, interval: float) -> PowerSpectrum:
    """Spectrum of equidistant samples by one periodogram with a Blackman–Harris window.

    A line is a peak as narrow as the window allows that rises over the local floor by more than
    noise would once in 1000 spectra. The floor is the median of 72 bins around the peak or of the
    12 closest ones, if that is higher; bins of the peak itself do not count. So a chaotic band
    gives no line if the record is long enough for it to be 20 bins wide.

    Parameters
    ----------
    series
        Shape (n,), n ≥ 256; of an angle that rotates, take sine or cosine.
    interval
        Seconds between samples; for a section 1, and frequencies are per section.

    References
    ----------
    .. [1] F. J. Harris, Proc. IEEE 66 (1978) 51.
    """
    values = np.asarray(series, dtype=float)
    if values.ndim != 1 or len(values) < 256 or not np.isfinite(values).all():
        raise ValueError("series must be at least 256 finite numbers in one dimension")
    if not interval > 0:
        raise ValueError("interval must be > 0")
    frequencies, density = periodogram(
        values, fs=1 / interval, window="blackmanharris", detrend="constant"
    )
    density[0] = 0.0
    floor = _floor(density)
    peaks = _peaks(density, floor)
    lines = np.array([_refined(density, peak) for peak in peaks]) * frequencies[1]
    powers = np.array([_carried(density, floor, peak) for peak in peaks]) * frequencies[1]
    order = np.argsort(-powers)
    return PowerSpectrum(
        frequencies=frequencies,
        density=density,
        floor=floor,
        lines=lines[order] if len(peaks) else np.empty(0),
        powers=powers[order] if len(peaks) else np.empty(0),
    )


def _floor(density: Floats) -> Floats:
    """Median of the bins around each bin, its own lobe aside, over a wide and a close range."""
    return np.maximum(_around(density, _NEIGHBOURS), _around(density, _CLOSE))


def _around(density: Floats, reach: int) -> Floats:
    footprint = np.ones(2 * reach + 1, dtype=bool)
    footprint[reach - LOBE : reach + LOBE + 1] = False
    return median_filter(density, footprint=footprint, mode="reflect")


def _peaks(density: Floats, floor: Floats) -> list[int]:
    """Bins of lines: highest within a lobe, and over the floor beyond what noise does.

    Powers of noise are exponentially distributed with mean floor / ln 2; of n of them one exceeds
    ln(n / p) means with probability p.
    """
    over = np.log(len(density) / _FALSE_ALARM) / np.log(2)
    least = np.maximum(over * floor, DYNAMIC_RANGE * density.max())
    candidates = np.flatnonzero(density > least)
    kept = []
    for peak in candidates:
        low, high = max(0, peak - LOBE), peak + LOBE + 1
        if peak > 1 and density[peak] == density[low:high].max():
            kept.append(int(peak))
    return kept


def _refined(density: Floats, peak: int) -> float:
    """Place of a maximum in bins, by a parabola through the logarithms of three."""
    if not 0 < peak < len(density) - 1 or not density[peak - 1 : peak + 2].all():
        return float(peak)
    left, middle, right = np.log(density[peak - 1 : peak + 2])
    curvature = left - 2 * middle + right
    return peak + 0.5 * (left - right) / curvature if curvature < 0 else float(peak)


def _carried(density: Floats, floor: Floats, peak: int) -> float:
    lobe = slice(max(0, peak - LOBE), peak + LOBE + 1)
    return float(np.maximum(density[lobe] - floor[lobe] / np.log(2), 0.0).sum())


FEWEST = 200
"""Samples below which the asymptotic growth rate is not seen."""


@dataclass(frozen=True, eq=False)
class ZeroOne:
    """Result of the 0–1 test.

    Parameters
    ----------
    values
        Growth rate for each frequency, shape (frequencies,), each from -1 to 1.
    """

    values: Floats

    @property
    def growth(self) -> float:
        """K, the median: near 0 for regular, near 1 for chaotic motion."""
        return float(np.median(self.values))

    @property
    def spread(self) -> float:
        """Half the distance between the quartiles of the values."""
        low, high = np.percentile(self.values, [25, 75])
        return 0.5 * float(high - low)


def zero_one(series: ArrayLike, *, frequencies: int = 100, seed: int = 0) -> ZeroOne:
    """The 0–1 test by the correlation method, with the oscillating term taken away [1]_.

    Parameters
    ----------
    series
        Section points of one observed quantity, shape (n,), in any unit; of an angle take sine or
        cosine. In finely sampled series chaos looks regular.

    References
    ----------
    .. [1] G. A. Gottwald, I. Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129.
    """
    whole = np.asarray(series, dtype=float)
    if whole.ndim != 1 or not np.isfinite(whole).all():
        raise ValueError("series must be finite numbers in one dimension")
    if len(whole) < FEWEST:
        raise ValueError(f"{len(whole)} samples; {FEWEST} are needed: observe for longer")
    if np.ptp(whole) <= 1e-12 * np.abs(whole).max():
        raise ValueError("the series is constant; there is nothing to test")
    chosen = np.random.default_rng(seed).uniform(np.pi / 5, 4 * np.pi / 5, frequencies)
    return ZeroOne(np.array([_growth(whole, c) for c in chosen]))


def _growth(series: Floats, c: float) -> float:
    """Correlation of the corrected mean square displacement with time."""
    count = len(series)
    most = count // 10
    walk = np.cumsum(series * np.exp(1j * c * np.arange(1, count + 1)))
    walk -= walk.mean()
    head = walk[: count - most]
    square = np.cumsum(np.concatenate([[0.0], np.abs(walk) ** 2]))
    moved = square[len(head) + 1 : len(head) + most + 1] - square[1 : most + 1]
    product = correlate(walk, head, mode="valid", method="fft").real[1:]
    displacement = (moved + square[len(head)] - 2 * product) / len(head)
    n = np.arange(1, most + 1)
    mean = series.mean() ** 2
    displacement -= mean * (1 - np.cos(n * c)) / (1 - np.cos(c))
    if np.ptp(displacement) == 0:
        return 0.0
    return float(np.corrcoef(n, displacement)[0, 1])
