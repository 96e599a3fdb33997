"""Indicators of chaos: FLI, GALI and correlation dimension."""

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

    Parameters
    ----------
    times
        Ends of intervals since the start, shape (n,), in seconds or steps.
    fli
        ln of the largest stretching of any tangent so far, shape (n,).
    gali
        Volume spanned by the k tangents of unit length, shape (n,); `ROUND_OFF` once it has
        reached that, for from then on it is that of round-off. 1 for a single tangent.
    """

    times: Floats
    fli: Floats
    gali: Floats


def fast_indicators(
    system: TangentSystem,
    *,
    intervals: int,
    interval: float,
    count: int = 2,
) -> Indicators:
    """FLI and GALI_k along a motion, from k tangents that are only brought back to length one.

    Parameters
    ----------
    intervals, interval
        How often, and after which time in seconds or steps, values are taken.
    count
        Number k of tangents: one is enough for FLI, GALI needs two. On an N-dimensional torus
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

    Parameters
    ----------
    times, logarithm
        Shape (n,) each; times count from the start.

    Returns
    -------
    Regular if the last doubling of time brings less than 2.5 ln 2, chaotic if it brings more than
    8 ln 2; undecided between: run longer.
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

    Parameters
    ----------
    value, error
        Mean of the local slopes of the scaling region. The error adds, in squares, their standard
        deviation (slopes of fractals oscillate) and how far a straight line through them is from
        the mean at the smallest radius (slopes have not reached their limit).
    radii, sums
        Radii, in standard deviations of the points, and the part of pairs within them.
    region
        The first and the last radius of the scaling region.
    doubt
        Why the value cannot be trusted; empty if it can.
    """

    value: float
    error: float
    radii: Floats
    sums: Floats
    region: tuple[float, float]
    doubt: str = ""


def correlation_dimension(
    points: ArrayLike,
    *,
    angles: ArrayLike | None = None,
    theiler: int = 1,
) -> CorrelationDimension:
    """Correlation dimension by Grassberger and Procaccia [1]_, over the longest plateau.

    Parameters
    ----------
    points
        Shape (n, d), n ≥ 500: section points, or samples of a motion in its state space. Takes
        n²/2 distances: 10 000 points some seconds.
    theiler
        Pairs closer than this in the sequence do not count [2]_: take the correlation time of
        samples of a flow, 1 for section points.

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
