"""Power spectrum: lines over a local floor, and the share of power that they carry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import median_filter
from scipy.signal import periodogram

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

    Raises
    ------
    ValueError
        For fewer samples, or samples that are not finite.

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
