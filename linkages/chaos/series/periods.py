"""After how many section points a motion repeats."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.chaos.series.embedding import checked_points

Floats = NDArray[np.float64]

REPEATS = 3
"""How often a period must be seen."""


@dataclass(frozen=True, eq=False)
class Period:
    """The period of a sequence of section points.

    Parameters
    ----------
    count
        Section points until the motion repeats; None if it does not within what was seen.
    deviation
        Largest difference of points so far apart, in units of the tolerance; where there is no
        period, the least that any number reaches.
    cycle
        The points of one period, in the order of the motion, shape (count, d); last of all.
    """

    count: int | None
    deviation: float
    cycle: Floats


def find_period(
    points: ArrayLike,
    *,
    angles: ArrayLike | None = None,
    tolerance: ArrayLike = 1e-4,
    longest: int | None = None,
) -> Period:
    """Smallest m for which every point is repeated m points later, and at the end.

    The last points count for all: where neighbours are alike, but drift (in laminar phases of
    intermittency), nothing repeats.

    Parameters
    ----------
    points
        Section points after the transient, shape (n, d).
    angles
        Which entries are angles, shape (d,); they repeat modulo 2π.
    tolerance
        Largest difference that counts as a repetition, in the units of the entries: one number or
        shape (d,). Near a bifurcation two points of a cycle may be closer than this.
    longest
        Largest m; n // 3 by default, so that it is seen three times.

    Raises
    ------
    ValueError
        If points are not finite, or too few for `longest`.
    """
    whole, mask = checked_points(points, angles)
    most = len(whole) // REPEATS if longest is None else longest
    if not 1 <= most <= len(whole) // REPEATS:
        raise ValueError(
            f"{len(whole)} points show periods from 1 to {len(whole) // REPEATS}, not {most}"
        )
    scale = np.broadcast_to(np.asarray(tolerance, dtype=float), whole.shape[1:])
    if not (scale > 0).all():
        raise ValueError("tolerance must be > 0")
    least = np.inf
    for count in range(1, most + 1):
        deviation = float(differences(whole[count:], whole[:-count], mask, scale).max())
        cycle = whole[-count:]
        if deviation <= 1.0:
            again = cycle[(np.arange(len(whole)) - len(whole)) % count]
            deviation = float(differences(whole, again, mask, scale).max())
        if deviation <= 1.0:
            return Period(count, deviation, cycle.copy())
        least = min(least, deviation)
    return Period(None, least, np.empty((0, whole.shape[1])))


def differences(
    points: Floats, others: Floats, angles: NDArray[np.bool_], tolerance: Floats
) -> Floats:
    """Largest difference of any entry of points, in tolerances, shape (n,); of angles modulo 2π."""
    # what overflows is further apart than any tolerance: infinite, or nan where that is, too
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        found = apart(points, others, angles)
        away = found != 0.0  # what is equal is within a tolerance of zero as well
        found = np.divide(np.abs(found), tolerance, out=np.zeros_like(found), where=away)
    return np.asarray(np.max(np.where(np.isnan(found), np.inf, found), axis=1))


def apart(points: Floats, others: Floats, angles: NDArray[np.bool_]) -> Floats:
    """Differences of the entries of points, shape (n, d); of angles from −π to π."""
    found = points - others
    found[:, angles] = np.remainder(found[:, angles] + np.pi, 2 * np.pi) - np.pi
    return found
