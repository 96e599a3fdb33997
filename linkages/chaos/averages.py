"""Standard errors of the means of correlated series."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

FEWEST_BLOCKS = 8


def mean_error(series: ArrayLike) -> tuple[Floats, NDArray[np.bool_]]:
    """Standard errors of means by batch means with automatic block length.

    Neighbours are merged again and again into blocks of length B = 1, 2, 4, …; block means have
    the standard error s(B). The first B with B³ > 2 n (s(B)/s(1))⁴ is long against the
    correlation, yet leaves enough blocks [1]_ [2]_. In anticorrelated series, such as growth
    along a flow, s(B) falls; then its inverse ratio takes that place. If it falls for ever (the
    sum of the series is bounded) the longest blocks, at least 8, give an error that is too large
    rather than too small.

    Parameters
    ----------
    series
        Shape (n,) or (n, m), one series in each column; n ≥ 16.

    Returns
    -------
    Errors, shape (m,), and whether they can be trusted, shape (m,): not where s(B) rises to the
    end. The correlation is as long as the series then, and the largest s(B) is given.

    Raises
    ------
    ValueError
        If the series is shorter than 16.

    References
    ----------
    .. [1] H. Flyvbjerg, H. G. Petersen, J. Chem. Phys. 91 (1989) 461.
    .. [2] R. M. Lee, G. J. Conduit, N. Nemec, P. López Ríos, N. D. Drummond, Phys. Rev. E 83
       (2011) 066706, after U. Wolff, Comput. Phys. Commun. 156 (2004) 143.
    """
    blocks = np.asarray(series, dtype=float)
    if blocks.ndim == 1:
        blocks = blocks[:, None]
    count = len(blocks)
    if count < 2 * FEWEST_BLOCKS:
        raise ValueError(f"an error needs at least {2 * FEWEST_BLOCKS} intervals, not {count}")
    errors: list[Floats] = []
    length = 1
    found = np.zeros(blocks.shape[1], dtype=bool)
    chosen = np.zeros(blocks.shape[1])
    while len(blocks) >= FEWEST_BLOCKS:
        errors.append(blocks.std(axis=0, ddof=1) / np.sqrt(len(blocks)))
        lower, higher = np.minimum(errors[0], errors[-1]), np.maximum(errors[0], errors[-1])
        long = length**3 * lower**4 >= 2 * count * higher**4
        chosen = np.where(~found & long, errors[-1], chosen)
        found |= long
        blocks, length = _merged(blocks), 2 * length
    bounded = errors[-1] < errors[0]
    rest = np.where(bounded, errors[-1], np.max(errors, axis=0))
    return np.where(found, chosen, rest), found | bounded


def _merged(blocks: Floats) -> Floats:
    even = len(blocks) // 2 * 2
    return 0.5 * (blocks[:even:2] + blocks[1:even:2])


def drift(series: ArrayLike, parts: int = 4) -> Floats:
    """Spread of the means of equal parts of a series in units of their standard error.

    For a stationary series it is the range of `parts` normal numbers: above 5 for four of them in
    one case out of 400. A motion that sticks for a while near regular ones, or has not reached its
    attractor yet, gives more.

    Returns
    -------
    Shape (m,), one entry for each column; 0 where parts are alike to nine digits of the largest
    entry of the series.

    Raises
    ------
    ValueError
        If the parts are shorter than 16.
    """
    whole = np.asarray(series, dtype=float)
    if whole.ndim == 1:
        whole = whole[:, None]
    pieces = np.array_split(whole, parts)
    means = np.array([piece.mean(axis=0) for piece in pieces])
    errors = np.array([mean_error(piece)[0] for piece in pieces])
    spread = means.max(axis=0) - means.min(axis=0)
    error = np.sqrt(np.mean(errors**2, axis=0))
    alike = spread <= 1e-9 * max(np.abs(whole).max(), np.finfo(float).tiny)
    return np.where(alike, 0.0, spread / np.where(error > 0, error, np.finfo(float).tiny))
