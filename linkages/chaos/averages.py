"""Standard errors of the means of correlated series."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.chaos.tori import embed

Floats = NDArray[np.float64]

FEWEST_BLOCKS = 8

KUIPER = np.sqrt(2 / np.pi)
"""Standard error of a sum of independent numbers, in units of the mean range of partial sums."""

TWO_SIGMA = 0.97725
"""Where a normal distribution is two standard deviations above its mean."""

SETTLES = 1 / 3
"""Range of the partial sums of the later half, in units of the whole, below which a series settles:
for independent numbers it is about 0.7, and below this in one case out of 100."""

LEFT = 1.5
"""What is left of such a series, in units of how far the mean is from that of its later half: sums
like ln(cn) leave ln(cn)/(ln(cn) - 1.4), 1.5 for cn of 60 and more, and transients leave 1."""

BOUNDED = 0.25
"""Error by the longest blocks, in units of that by the shortest, below which sums are bounded."""

ALIKE = 1e-4
"""Difference of means, relative to the largest entry, that four printed digits hide."""


def mean_error(series: ArrayLike) -> tuple[Floats, NDArray[np.bool_]]:
    """Standard errors of means, for chaotic, periodic and settling series alike.

    The largest of three estimates, each of them right for another kind of series:

    - Batch means, for sums that diffuse (chaos). Neighbours are merged again and again into blocks
      of length B = 1, 2, 4, …; block means have the standard error s(B). The first B with
      B³ > 2 n (s(B)/s(1))⁴ is long against the correlation, yet leaves enough blocks [1]_ [2]_; in
      anticorrelated series s(B) falls, and its inverse ratio takes that place. Few blocks are made
      up for, so that two errors are a confidence of 95 % (Student).
    - The range of the partial sums of the series less its mean, times √(2/π)/n. For independent
      numbers that is the standard error as well [3]_; where the sums are bounded (periodic growth,
      tori) the mean is wrong by their range/n at most, which batches of a multiple of the period
      do not see.
    - How far the mean is from that of the later half, times `LEFT`, where the range falls
      (`SETTLES`): after a transient, and where sums grow like ln n (regular motions that conserve
      energy), the mean is wrong by about that.

    For diffusing sums the largest of three is too large by a tenth.

    `series`: shape (n,) or (n, m), one series in each column; n ≥ 16.
    Returns: errors, shape (m,), and whether they can be trusted, shape (m,): not where s(B) rises
    to the end. The correlation is as long as the series then, and the largest s(B) is taken.

    References
    ----------
    .. [1] H. Flyvbjerg, H. G. Petersen, J. Chem. Phys. 91 (1989) 461.
    .. [2] R. M. Lee, G. J. Conduit, N. Nemec, P. López Ríos, N. D. Drummond, Phys. Rev. E 83
       (2011) 066706, after U. Wolff, Comput. Phys. Commun. 156 (2004) 143.
    .. [3] N. H. Kuiper, Proc. K. Ned. Akad. Wet. A 63 (1960) 38: the range has the mean √(πn/2) σ.
    """
    whole = _columns(series)
    if len(whole) < 2 * FEWEST_BLOCKS:
        raise ValueError(f"an error needs at least {2 * FEWEST_BLOCKS} intervals, not {len(whole)}")
    diffusing, trusted = _batch_error(whole)
    later = whole[len(whole) // 2 :]
    ranges = _range_of_sums(whole)
    settling = LEFT * np.abs(whole.mean(axis=0) - later.mean(axis=0))
    settling = np.where(_range_of_sums(later) < SETTLES * ranges, settling, 0.0)
    bounded = KUIPER * ranges / len(whole)
    return np.maximum(diffusing, np.maximum(bounded, settling)), trusted


def slow_error(series: ArrayLike, length: float) -> Floats:
    """How far means of rates of growth are from those of all time where they fall like 1/t.

    Tangents of (nearly) double multipliers grow like t + s times an exponential, so that rates are
    wrong by 1/(t + s), which may hardly change within a series. Means over its halves, h each, then
    differ by D = ln((s + h)²/(s (s + 2 h)))/h, and that of the whole is wrong by
    ln(1 + 2 h/s)/(2 h) = arcosh(exp(D h/2))/h.

    `series`: rates of growth, shape (n,) or (n, m), n ≥ 16.
    `length`: of the time between two of them, in units of the inverse of rates.
    Returns: shape (m,); 0 where the later half does not go on like this: where it varies like the
    whole (`SETTLES`), and where its s is more than twice as large as that of the whole, less h.
    """
    whole = _columns(series)
    later = whole[len(whole) // 2 :]
    (error, since), (_, after) = (_of_slow(part, length) for part in (whole, later))
    smooth = _range_of_sums(later) < SETTLES * _range_of_sums(whole)
    return np.where(smooth & (after < 2.0 * (since + length * len(later))), error, 0.0)


def _of_slow(part: Floats, length: float) -> tuple[Floats, Floats]:
    """The error of a mean, and s, if rates fall like 1/(t + s)."""
    first, later = np.array_split(part, 2)
    span = length * len(part) / 2
    grown = np.abs(first.mean(axis=0) - later.mean(axis=0)) * span
    root = np.sqrt(-np.expm1(-grown))
    with np.errstate(divide="ignore"):
        return (grown / 2 + np.log1p(root)) / span, span * (1.0 / root - 1.0)


def _columns(series: ArrayLike) -> Floats:
    whole = np.asarray(series, dtype=float)
    return whole[:, None] if whole.ndim == 1 else whole


def _range_of_sums(part: Floats) -> Floats:
    """Range of the partial sums of a series less its mean; the first and the last one are zero."""
    sums = np.cumsum(part - part.mean(axis=0), axis=0)
    return np.maximum(sums.max(axis=0), 0.0) - np.minimum(sums.min(axis=0), 0.0)


def _batch_error(whole: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Errors by batch means (0 where sums are bounded), and whether they can be trusted."""
    blocks, counts, spreads = whole, [], []
    while len(blocks) >= FEWEST_BLOCKS:
        counts.append(len(blocks))
        spreads.append(blocks.std(axis=0, ddof=1))
        blocks = _merged(blocks)
    errors = np.array(spreads) / np.sqrt(counts)[:, None]
    cubes = 8.0 ** np.arange(len(counts))[:, None]  # of the lengths of blocks, 1, 2, 4, …
    lower, higher = np.minimum(errors[0], errors), np.maximum(errors[0], errors)
    long = cubes * lower**4 >= 2 * len(whole) * higher**4
    few = _student(tuple(counts))
    chosen = np.take_along_axis(few[:, None] * errors, long.argmax(axis=0)[None], axis=0)[0]
    result, falls = long.any(axis=0), errors[-1] < errors[0]
    rest = np.where(falls, 0.0, few[-1] * errors.max(axis=0))
    bounded = errors[-1] < BOUNDED * errors[0]
    return np.where(bounded, 0.0, np.where(result, chosen, rest)), result | falls


@lru_cache(maxsize=64)
def _student(counts: tuple[int, ...]) -> Floats:
    """Factors that make up for few blocks: of two standard errors, as if there were many."""
    from scipy.special import stdtrit  # takes a tenth of a second to load

    return np.asarray(stdtrit(np.array(counts) - 1, TWO_SIGMA)) / 2


def _merged(blocks: Floats) -> Floats:
    even = len(blocks) // 2 * 2
    return 0.5 * (blocks[:even:2] + blocks[1:even:2])


def drift(series: ArrayLike, parts: int = 4) -> Floats:
    """Spread of the means of equal parts of a series in units of their standard error.

    For a stationary series it is the range of `parts` normal numbers: above 5 for four of them in
    one case out of 400. For a periodic one it is below 3, since the error of a part counts that
    its sum is bounded. A motion that sticks for a while near regular ones, or has not reached its
    attractor yet, gives more: the error is the median of those of the parts, so that the part that
    differs does not excuse itself.

    Returns: shape (m,), one entry for each column; 0 where parts are alike to four digits of the
    largest entry of the column.
    """
    whole = _columns(series)
    pieces = np.array_split(whole, parts)
    spread = np.ptp([piece.mean(axis=0) for piece in pieces], axis=0)
    error = np.median([mean_error(piece)[0] for piece in pieces], axis=0)
    alike = spread <= ALIKE * np.abs(whole).max(axis=0)
    return np.where(alike, 0.0, spread / np.maximum(error, np.finfo(float).tiny))


FEWEST = 32
"""Two halves, each long enough for an error."""


def steadiness(points: ArrayLike, *, angles: ArrayLike | None = None) -> tuple[float, float]:
    """How far averages over the first half of the points differ from those over the second.

    Averages of entries and of their squares, with weights that vanish at both ends. Along
    quasi-periodic motions they converge faster than any power of 1/n [1]_, so that a slow
    approach to another motion shows long before it ends; along chaotic motions they differ by
    their standard errors.

    `points`: shape (n, d), n ≥ 32.
    `angles`: which entries are angles, shape (d,).
    Returns: the largest difference in standard deviations of the points, and the largest in
    standard errors of means.

    References
    ----------
    .. [1] S. Das, Y. Saiki, E. Sander, J. A. Yorke, Nonlinearity 30 (2017) 4111.
    """
    embedded = embed(points, angles)
    if len(embedded) < FEWEST:
        raise ValueError(f"{len(embedded)} points; at least {FEWEST} are needed")
    centred = embedded - embedded.mean(axis=0)
    observed = np.concatenate([centred, centred**2], axis=1)
    first, second = np.array_split(observed, 2)
    apart = np.abs(_average(first) - _average(second))
    error = np.hypot(mean_error(first)[0], mean_error(second)[0])
    return float(apart.max()), float((apart / np.maximum(error, np.finfo(float).tiny)).max())


def _average(rows: Floats) -> Floats:
    """Weighted mean of rows."""
    place = (np.arange(len(rows)) + 0.5) / len(rows)
    weights = np.exp(-1 / (place * (1 - place)))
    return np.asarray(weights @ rows / weights.sum())
