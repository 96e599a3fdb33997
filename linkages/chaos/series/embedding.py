"""Points of a state space as points of a Euclidean space, angles as points of circles."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def embed(points: ArrayLike, angles: ArrayLike | None = None) -> Floats:
    """Put cosine and sine for every angle, and divide every entry by its standard deviation.

    So entries of different units count alike (cosine and sine of one angle by a common one); no
    dimension depends on it.

    Parameters
    ----------
    points
        Shape (n, d), or (n,) for one entry.
    angles
        Which entries are angles in radians, shape (d,); none by default.

    Returns
    -------
    Shape (n, d + number of angles): entries that are no angles first.

    Raises
    ------
    ValueError
        If points are not finite, or angles do not fit them.
    """
    whole, mask = checked_points(points, angles)
    groups = [[column] for column in whole.T[~mask]]
    groups += [[np.cos(column), np.sin(column)] for column in whole.T[mask]]
    columns = []
    for group in groups:
        deviation = np.sqrt(sum(float(column.var()) for column in group))
        columns += [column / deviation if deviation > 0 else column for column in group]
    return np.column_stack(columns)


def checked_points(points: ArrayLike, angles: ArrayLike | None) -> tuple[Floats, NDArray[np.bool_]]:
    """Points of shape (n, d) and the mask of angles of shape (d,)."""
    whole = np.asarray(points, dtype=float)
    if whole.ndim == 1:
        whole = whole[:, None]
    if whole.ndim != 2 or not whole.size or not np.isfinite(whole).all():
        raise ValueError("points must be finite numbers of shape (n, d)")
    mask = np.zeros(whole.shape[1], dtype=bool) if angles is None else np.array(angles, dtype=bool)
    if mask.shape != (whole.shape[1],):
        raise ValueError(f"angles must be one entry for each of {whole.shape[1]} columns")
    return whole, mask
