"""Indicators of chaos: power spectrum, 0–1 test, FLI, GALI and correlation dimension."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.chaos.exponents import TangentSystem, start_tangents
from linkages.chaos.tori import embed

Floats = NDArray[np.float64]

ROUND_OFF = 1e-14
"""GALI below this says no more: tangents are parallel to double precision."""

REGULAR_POWER, CHAOTIC_POWER = 2.5, 8.0
"""Powers of time below which growth is that of regular motions, and above which that of chaos."""


class Verdict(StrEnum):
    """What an indicator says about a motion."""

    REGULAR = "regular"
    CHAOTIC = "chaotic"
    UNDECIDED = "undecided"


@dataclass(frozen=True, eq=False)
class Indicators:
    """Fast Lyapunov indicator and generalised alignment index over time.

    FLI says of every kind of system whether tangents grow exponentially, GALI only of those that
    conserve energy: with friction tangents also become parallel along regular motions. `classify`
    judges FLI, or minus the logarithm of GALI down to `ROUND_OFF`.

    `gali`: volume spanned by the k tangents of unit length, shape (n,); `ROUND_OFF` once it has
    reached that, for from then on it is that of round-off. 1 for a single tangent.
    """

    times: Floats  # ends of intervals since the start, shape (n,), in seconds or steps
    fli: Floats  # ln of the largest stretching of any tangent so far, shape (n,)
    gali: Floats


def fast_indicators(
    system: TangentSystem,
    *,
    intervals: int,
    interval: float,
    count: int = 2,
) -> Indicators:
    """FLI and GALI_k along a motion, from k tangents that are only brought back to length one.

    `intervals`, `interval`: how often, and after which time in seconds or steps, values are taken.
    `count`: number k of tangents: one is enough for FLI, GALI needs two. On an N-dimensional torus
    GALI_k stays constant for k ≤ N.

    References
    ----------
    .. [1] C. Froeschlé, E. Lega, R. Gonczi, Celest. Mech. Dyn. Astron. 67 (1997) 41.
    .. [2] Ch. Skokos, T. C. Bountis, Ch. Antonopoulos, Physica D 231 (2007) 30.
    """
    if intervals < 4 or not interval > 0 or count < 1:
        raise ValueError("intervals must be at least 4, interval > 0 and count at least 1")
    start_tangents(system, count)
    start = system.time
    parts = list(system.grow(intervals, interval, orthogonal=False))
    rates, tangents = (
        np.concatenate([getattr(p, n) for p in parts]) for n in ("rates", "tangents")
    )
    longest = np.cumsum(interval * rates, axis=0).max(axis=1)
    volumes = np.prod(np.linalg.svd(tangents, compute_uv=False), axis=1)
    parallel = np.logical_or.accumulate(volumes <= ROUND_OFF)
    return Indicators(
        times=np.concatenate([part.times for part in parts]) - start,
        fli=np.maximum.accumulate(np.maximum(longest, 0.0)),
        gali=np.where(parallel, ROUND_OFF, volumes),
    )


def last_power(times: Floats, logarithm: Floats) -> float:
    """The power of time that grows as much as a logarithm tells while time last doubled."""
    middle = int(np.searchsorted(times, 0.5 * times[-1]))
    return float(logarithm[-1] - logarithm[middle]) / math.log(2.0)


def classify(times: Floats, logarithm: Floats) -> Verdict:
    """Whether a logarithm grows like that of a power of time or like time itself.

    Along regular motions tangents grow, and volumes of tangents shrink, at most like a power p of
    time: the logarithm rises by p ln 2 while time doubles. Tangents grow with p = 1, volumes
    shrink with p ≤ 2 for k ≤ N + 1. Along chaotic motions the rise is λT/2 and passes any
    threshold.

    `times`, `logarithm`: shape (n,) each; times count from the start.
    Returns: regular if the last doubling of time brings less than 2.5 ln 2, chaotic if it brings
    more than 8 ln 2; undecided between: run longer.
    """
    power = last_power(times, logarithm)
    if power > CHAOTIC_POWER:
        return Verdict.CHAOTIC
    return Verdict.REGULAR if power < REGULAR_POWER else Verdict.UNDECIDED


FEWEST_POINTS = 500
FEWEST_PAIRS = 200
"""Pairs below which a correlation sum is too noisy (7 %) for a local slope."""

LARGEST_SUM = 0.03
"""Correlation sums above this feel the edges of the set."""

SAME = 1e-7
"""Distance, in units of the extent of the set, within which points are the same one."""

SHORTEST = 4.0
"""Ratio of radii that a scaling region must span."""

FLATNESS = 0.1
"""How far local slopes may be from their mean in the scaling region: this part of it, or this if
the mean is less than 1."""

_BINS = 8  # radii per octave
_WINDOW = _BINS  # local slopes are fitted over an octave


@dataclass(frozen=True, eq=False)
class CorrelationDimension:
    """Correlation dimension with its scaling region.

    `value`, `error`: mean of the local slopes of the scaling region. The error adds, in squares,
    their standard deviation (slopes of fractals oscillate) and how far a straight line through them
    is from the mean at the smallest radius (slopes have not reached their limit).
    `radii`, `sums`: radii, in standard deviations of the points, and the part of pairs within them.
    """

    value: float
    error: float
    radii: Floats
    sums: Floats
    region: tuple[float, float]  # the first and the last radius of the scaling region
    doubt: str = ""  # why the value cannot be trusted; empty if it can


def correlation_dimension(
    points: ArrayLike,
    *,
    angles: ArrayLike | None = None,
    theiler: int = 1,
) -> CorrelationDimension:
    """Correlation dimension by Grassberger and Procaccia [1]_, over the longest plateau.

    `points`: shape (n, d), n ≥ 500: section points, or samples of a motion in its state space.
    Takes n²/2 distances: 10 000 points some seconds.
    `theiler`: pairs closer than this in the sequence do not count [2]_: take the correlation time
    of samples of a flow, 1 for section points.

    References
    ----------
    .. [1] P. Grassberger, I. Procaccia, Physica D 9 (1983) 189.
    .. [2] J. Theiler, Phys. Rev. A 34 (1986) 2427.
    """
    embedded = embed(points, angles)
    if not 1 <= theiler <= len(embedded) - FEWEST_POINTS + 1:
        raise ValueError(
            f"{len(embedded)} points with theiler = {theiler}: at least {FEWEST_POINTS} points "
            "beyond the window are needed, and a window of at least 1"
        )
    radii, pairs = _pair_counts(embedded, theiler)
    sums = pairs / pairs[-1]
    usable = (pairs >= FEWEST_PAIRS) & (sums <= LARGEST_SUM)
    if sums[0] > LARGEST_SUM:
        text = f"One pair out of {1 / sums[0]:.3g} coincides: the points are finitely many."
        return CorrelationDimension(0.0, 0.0, radii, sums, (float(radii[0]), float(radii[0])), text)
    return _plateau(radii, sums, usable)


def _pair_counts(points: Floats, theiler: int) -> tuple[Floats, Floats]:
    """Radii, `_BINS` to an octave, and the pairs within each; by lag, without a matrix of them."""
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    if extent == 0:
        return np.array([0.0, 1.0]), np.array([1.0, 1.0])
    lowest = _BINS * np.log2(SAME * extent)
    number = int(np.ceil(_BINS * np.log2(1 / SAME))) + 2
    counts = np.zeros(number, dtype=np.int64)
    columns = np.ascontiguousarray(points.T)
    tiny = (SAME * extent) ** 2
    for lag in range(theiler, len(points)):
        square = np.zeros(len(points) - lag)
        for column in columns:
            difference = column[lag:] - column[:-lag]
            square += difference * difference
        np.maximum(square, tiny, out=square)
        bins = (0.5 * _BINS * np.log2(square) - lowest).astype(np.int64)
        counts += np.bincount(bins, minlength=number)
    radii = np.exp2((lowest + 1 + np.arange(number)) / _BINS)
    return radii, np.cumsum(counts).astype(float)


def _plateau(radii: Floats, sums: Floats, usable: NDArray[np.bool_]) -> CorrelationDimension:
    """The longest run of local slopes close to their mean; of equal ones the flattest."""
    x, y = np.log(radii[usable]), np.log(sums[usable])
    if len(x) < _WINDOW + 2:
        text = "Too few radii with enough pairs: take more points."
        low, high = (float(radii[usable][0]), float(radii[usable][-1])) if len(x) else (0.0, 0.0)
        return CorrelationDimension(0.0, 0.0, radii, sums, (low, high), text)
    centred = np.arange(_WINDOW + 1) - 0.5 * _WINDOW
    weights = centred / (centred @ centred * (x[1] - x[0]))
    slopes = np.convolve(y, weights[::-1], mode="valid")
    best = (1, -np.inf, 0, 1)
    for first in range(len(slopes)):
        for last in range(first + 1, len(slopes)):
            part = slopes[first : last + 1]
            mean = part.mean()
            if np.abs(part - mean).max() <= FLATNESS * max(1.0, mean):
                best = max(best, (last - first, -float(part.std()), first, last))
    first, last = best[2], best[3]
    part = slopes[first : last + 1]
    region = (float(np.exp(x[first])), float(np.exp(x[last + _WINDOW])))
    doubt = ""
    if region[1] < SHORTEST * region[0]:
        doubt = (
            f"Local slopes are level from radius {region[0]:.3g} to {region[1]:.3g} only: "
            "take more points, or a state space of higher dimension."
        )
    trend = np.polyfit(x[first : last + 1], part, 1)[0] * 0.5 * (x[last] - x[first])
    error = float(np.hypot(part.std(), trend))
    return CorrelationDimension(float(part.mean()), error, radii, sums, region, doubt)


LOBE = 4
"""Half the width of a line in bins: the main lobe of the Blackman–Harris window."""

DYNAMIC_RANGE = 1e-8
"""Peaks below this part of the highest one may be side lobes of the window (-92 dB)."""

_NEIGHBOURS, _CLOSE = 40, 10
_FALSE_ALARM = 1e-3


@dataclass(frozen=True, eq=False)
class PowerSpectrum:
    """One-sided power spectrum of a series about its mean, and its lines.

    `frequencies`, `density`: in Hz and in (unit of the series)²/Hz, shape (n,).
    """

    frequencies: Floats
    density: Floats
    floor: Floats  # local floor, shape (n,), as `density`
    lines: Floats  # frequencies of lines in Hz, the strongest first, shape (m,)
    powers: Floats  # mean square that each carries, shape (m,)

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

    `series`: shape (n,), n ≥ 256; of an angle that rotates, take sine or cosine.
    `interval`: seconds between samples; for a section 1, and frequencies are per section.

    References
    ----------
    .. [1] F. J. Harris, Proc. IEEE 66 (1978) 51.
    """
    values = np.asarray(series, dtype=float)
    if values.ndim != 1 or len(values) < 256 or not np.isfinite(values).all():
        raise ValueError("series must be at least 256 finite numbers in one dimension")
    if not interval > 0:
        raise ValueError("interval must be > 0")
    from scipy.signal import periodogram  # takes a third of a second to load

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
    from scipy.ndimage import median_filter

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
    """Result of the 0–1 test."""

    values: Floats  # growth rate for each frequency, shape (frequencies,), each from -1 to 1

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

    `series`: section points of one observed quantity, shape (n,), in any unit; of an angle take
    sine or cosine. In finely sampled series chaos looks regular.

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
    from scipy.signal import correlate

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
