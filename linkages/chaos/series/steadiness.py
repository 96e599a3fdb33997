"""Whether section points keep their statistics, as those of an attractor or a torus do."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.chaos.series.averages import mean_error
from linkages.chaos.series.embedding import embed

Floats = NDArray[np.float64]

FEWEST = 32
"""Two halves, each long enough for an error."""


def steadiness(points: ArrayLike, *, angles: ArrayLike | None = None) -> tuple[float, float]:
    """How far averages over the first half of the points differ from those over the second.

    Averages of entries and of their squares, with weights that vanish at both ends. Along
    quasi-periodic motions they converge faster than any power of 1/n [1]_, so that a slow
    approach to another motion shows long before it ends; along chaotic motions they differ by
    their standard errors.

    Parameters
    ----------
    points
        Shape (n, d), n ≥ 32.
    angles
        Which entries are angles, shape (d,).

    Returns
    -------
    The largest difference in standard deviations of the points, and the largest in standard
    errors of means.

    Raises
    ------
    ValueError
        For fewer points.

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
