"""The 0–1 test for chaos: regular or chaotic from one observed series, without tangents."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import correlate

Floats = NDArray[np.float64]

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
    frequencies
        Number of random frequencies c, uniform in (π/5, 4π/5).
    seed
        Of the random frequencies.

    Raises
    ------
    ValueError
        If samples are not finite, constant, or fewer than 200.

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
