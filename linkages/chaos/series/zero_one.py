"""The 0–1 test for chaos: regular or chaotic from one observed series, without tangents."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import correlate

Floats = NDArray[np.float64]

FEWEST = 200
"""Samples below which the asymptotic growth rate is not seen."""

_OVERSAMPLED = 0.5


@dataclass(frozen=True, eq=False)
class ZeroOne:
    """Result of the 0–1 test.

    Parameters
    ----------
    values
        Growth rate for each frequency, shape (frequencies,), each from -1 to 1.
    lag
        Of how many samples one was used.
    samples
        How many samples were used.
    """

    values: Floats
    lag: int
    samples: int

    @property
    def growth(self) -> float:
        """K, the median: near 0 for regular, near 1 for chaotic motion."""
        return float(np.median(self.values))

    @property
    def spread(self) -> float:
        """Half the distance between the quartiles of the values."""
        low, high = np.percentile(self.values, [25, 75])
        return 0.5 * float(high - low)


def zero_one(
    series: ArrayLike,
    *,
    frequencies: int = 100,
    lag: int | None = None,
    damping: float = 0.0,
    seed: int = 0,
) -> ZeroOne:
    """The 0–1 test by the correlation method, with the oscillating term taken away [1]_.

    Parameters
    ----------
    series
        Equidistant samples or section points of one observed quantity, shape (n,), in any unit.
        Of an angle take sine or cosine.
    frequencies
        Number of random frequencies c, uniform in (π/5, 4π/5).
    lag
        Use one of so many samples; by default `sampling_lag`, since in an oversampled series
        chaos looks regular.
    damping
        Factor of the damping term of [2]_, 2.5 there: makes weak noise and slow modulation count
        as regular, at the price of weak chaos.
    seed
        Of the random frequencies.

    Raises
    ------
    ValueError
        If samples are not finite, constant, or fewer than 200 after decimation.

    References
    ----------
    .. [1] G. A. Gottwald, I. Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129.
    .. [2] J. H. P. Dawes, M. C. Freeland, "The '0–1 test for chaos' and strange nonchaotic
       attractors", University of Bath 2008.
    """
    whole = np.asarray(series, dtype=float)
    if whole.ndim != 1 or not np.isfinite(whole).all():
        raise ValueError("series must be finite numbers in one dimension")
    lag = sampling_lag(whole) if lag is None else lag
    used = whole[::lag]
    if len(used) < FEWEST:
        raise ValueError(
            f"{len(used)} samples remain when one of {lag} is used, {FEWEST} are needed: "
            "observe for longer"
        )
    if np.ptp(used) <= 1e-12 * np.abs(used).max():
        raise ValueError("the series is constant; there is nothing to test")
    chosen = np.random.default_rng(seed).uniform(np.pi / 5, 4 * np.pi / 5, frequencies)
    values = np.array([_growth(used, c, damping) for c in chosen])
    return ZeroOne(values=values, lag=lag, samples=len(used))


def _growth(series: Floats, c: float, damping: float) -> float:
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
    displacement += damping * mean * np.sin(np.sqrt(2) * n)
    if np.ptp(displacement) == 0:
        return 0.0
    return float(np.corrcoef(n, displacement)[0, 1])


def sampling_lag(series: ArrayLike, longest: int | None = None) -> int:
    """How many samples apart a series should be taken.

    1 if neighbouring samples correlate by less than one half, as points of a section mostly do.
    Otherwise the first minimum of the mutual information between samples so far apart [1]_, or the
    first zero of the correlation if that comes first.

    Parameters
    ----------
    series
        Shape (n,).
    longest
        Largest lag, n // 20 by default; also the answer where neither is found.

    References
    ----------
    .. [1] A. M. Fraser, H. L. Swinney, Phys. Rev. A 33 (1986) 1134.
    """
    values = np.asarray(series, dtype=float)
    values = values - values.mean()
    longest = max(1, len(values) // 20 if longest is None else longest)
    power = float(values @ values)
    if power == 0 or values[1:] @ values[:-1] < _OVERSAMPLED * power:
        return 1
    bins = max(8, min(32, round((len(values) / 5) ** 0.5)))
    known: list[float] = []
    for lag in range(1, longest + 1):
        if values[lag:] @ values[:-lag] <= 0:
            return lag
        known.append(_mutual_information(values[:-lag], values[lag:], bins))
        least = int(np.argmin(known)) + 1
        if lag >= least + max(2, least // 2):  # so far from a minimum it is no ripple of counting
            return least
    return longest


def _mutual_information(first: Floats, second: Floats, bins: int) -> float:
    joint = np.histogram2d(first, second, bins=bins)[0] / len(first)
    alone = joint.sum(axis=1)[:, None] * joint.sum(axis=0)
    filled = joint > 0
    return float(np.sum(joint[filled] * np.log(joint[filled] / alone[filled])))
