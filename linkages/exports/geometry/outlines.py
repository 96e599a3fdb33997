"""Outlines of straight lines and arcs, as drawing programs know them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.plots.mechanism.bodies import convex_hull

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Outline:
    """A closed line, counter-clockwise.

    Parameters
    ----------
    corners
        Shape (n, 2).
    bulges
        Of the side that begins at each corner, shape (n,): the tangent of a quarter of the angle
        of its arc; 0 for a straight side.
    """

    corners: Array
    bulges: Array


def rounded(points: ArrayLike, radius: float) -> Outline:
    """What encloses discs of a radius about all points: a stadium, or a plate with round corners.

    Raises
    ------
    ValueError
        For a single point, which has no outline of this kind.
    """
    hull = convex_hull(np.asarray(points, dtype=float))
    if len(hull) < 2:
        raise ValueError("expected two points or more that differ")
    if len(hull) == 2 and np.subtract(*hull[::-1])[0] < 0.0:
        hull = hull[::-1]
    ways = np.roll(hull, -1, axis=0) - hull
    ways /= np.hypot(*ways.T)[:, None]
    outward = radius * np.column_stack((ways[:, 1], -ways[:, 0]))
    before = np.roll(ways, 1, axis=0)
    turns = np.arctan2(
        before[:, 0] * ways[:, 1] - before[:, 1] * ways[:, 0], (before * ways).sum(axis=1)
    )
    corners = np.stack((hull + np.roll(outward, 1, axis=0), hull + outward), axis=1)
    bulges = np.column_stack((np.tan(np.abs(turns) / 4.0), np.zeros(len(hull))))
    return Outline(corners.reshape(-1, 2), bulges.ravel())


def thinned(path: ArrayLike, apart: float) -> Array:
    """Points of a path, first and last among them, between which lines are no farther from others.

    Parameters
    ----------
    path
        Shape (n, 2).
    apart
        Farthest distance of a point that is left out from the line that goes by.

    References
    ----------
    .. [1] D. H. Douglas, T. K. Peucker, "Algorithms for the reduction of the number of points
       required to represent a digitized line or its caricature", Cartographica 10 (1973) 112-122.
    """
    points = np.asarray(path, dtype=float)
    kept, spans = {0, len(points) - 1}, [(0, len(points) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        away = _distances(points[first + 1 : last], points[first], points[last])
        farthest = first + 1 + int(np.argmax(away))
        if away.max() > apart:
            kept.add(farthest)
            spans += [(first, farthest), (farthest, last)]
    return points[sorted(kept)]


def _distances(points: Array, start: Array, end: Array) -> Array:
    """From a segment, shape (n,)."""
    way = end - start
    square = float(way @ way)
    share = np.clip((points - start) @ way / square, 0.0, 1.0) if square else np.zeros(len(points))
    return np.asarray(np.hypot(*(points - start - share[:, None] * way).T))


def rectangle(centre: ArrayLike, angle: float, length: float, height: float) -> Outline:
    """A rectangle about a point, with its length in a direction."""
    along = 0.5 * length * np.array([np.cos(angle), np.sin(angle)])
    across = 0.5 * height * np.array([-np.sin(angle), np.cos(angle)])
    corners = np.asarray(centre) + np.array(
        [-along - across, along - across, along + across, -along + across]
    )
    return Outline(corners, np.zeros(4))
