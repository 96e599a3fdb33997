"""Whether section points lie on closed curves, as those of quasi-periodic motions do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.spatial.distance import pdist, squareform

from linkages.chaos.series.embedding import embed

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

FEWEST = 60
"""Points that each curve must have."""

COVERED = 0.95
"""Part of the points that must lie along the one path that spans them."""

CLOSING = 5.0
"""Gap between the ends of that path, in units of its longest edge."""

ORDERED = 0.95
"""Part of neighbours whose images must be neighbours again."""

_ISLAND = 15.0
_MOST = 3000


@dataclass(frozen=True)
class ClosedCurves:
    """What the arrangement of section points says.

    Parameters
    ----------
    count
        Number of closed curves, visited one after the other; 0 if there are none.
    reason
        Why points do not lie on closed curves; empty if they do.
    """

    count: int
    reason: str = ""


def closed_curves(points: ArrayLike, *, angles: ArrayLike | None = None) -> ClosedCurves:
    """Decide whether a motion is quasi-periodic with two frequencies.

    The criterion, on standardised points with angles on circles:

    1. The minimum spanning tree, cut at edges 15 times as long as the median where that leaves
       each part at least 60 points, consists of paths: the longest path through each part meets
       95 % of its points. Points that fill a surface or a fractal give branches.
    2. The ends of each path are no further apart than five times its longest edge.
    3. With m curves, the m-th iterate keeps the order of points along its curve, which motions on
       circles do and chaotic ones do not: images of 95 % of neighbours are neighbours or have one
       point between them.

    Parameters
    ----------
    points
        Section points after the transient in the whole state space, shape (n, d), n ≥ 60, the
        first 3000 of which are used. A periodic motion has too few different ones: ask
        `find_period` first.
    angles
        Which entries are angles, shape (d,).

    Raises
    ------
    ValueError
        For fewer points.
    """
    embedded = embed(points, angles)[:_MOST]
    if len(embedded) < FEWEST:
        raise ValueError(f"{len(embedded)} section points; at least {FEWEST} are needed")
    distances = squareform(pdist(embedded))
    np.fill_diagonal(distances, np.inf)
    if np.median(distances.min(axis=1)) < 1e-9:
        return ClosedCurves(0, "Points repeat: the motion is periodic.")
    np.fill_diagonal(distances, 0.0)
    tree = minimum_spanning_tree(distances).toarray()
    tree = tree + tree.T
    whole = _arranged(tree, np.zeros(len(tree), dtype=np.int64), distances)
    if whole.count:
        return whole
    islands = np.where(tree > _ISLAND * np.median(tree[tree > 0]), 0.0, tree)
    number, labels = connected_components(islands, directed=False)
    if number == 1 or np.bincount(labels).min() < FEWEST:
        return whole
    return _arranged(islands, labels.astype(np.int64), distances)


def _arranged(tree: Floats, labels: Integers, distances: Floats) -> ClosedCurves:
    """Whether every part of a forest is a closed curve on which the motion turns."""
    number = int(labels.max()) + 1
    for label in range(number):
        path = _longest_path(tree, int(np.flatnonzero(labels == label)[0]))
        members = int((labels == label).sum())
        if len(path) < COVERED * members:
            share = len(path) / members
            return ClosedCurves(0, f"Points branch: a path meets {share:.0%} of them.")
        longest = distances[path[:-1], path[1:]].max()
        gap = distances[path[0], path[-1]] / longest
        if gap > CLOSING:
            return ClosedCurves(0, f"The ends of a curve are {gap:.0f} gaps apart.")
        order = _order_kept(path, number, len(tree))
        if order < ORDERED:
            return ClosedCurves(0, f"The motion keeps the order of {order:.0%} of points.")
    return ClosedCurves(number)


def _longest_path(tree: Floats, start: int) -> Integers:
    """Points along the longest path of the tree that a point belongs to, by number of edges."""
    end = start
    for _ in range(2):
        root = end
        order, before = breadth_first_order(tree, root, directed=False)
        depth = np.zeros(len(tree), dtype=np.int64)
        for node in order[1:]:
            depth[node] = depth[before[node]] + 1
        end = int(order[np.argmax(depth[order])])
    path = [end]
    while path[-1] != root:
        path.append(int(before[path[-1]]))
    return np.array(path)


def _order_kept(path: Integers, step: int, total: int) -> float:
    """Part of neighbours whose images are neighbours."""
    place = np.full(total, -1)
    place[path] = np.arange(len(path))
    known = path[path + step < total]
    known = known[place[np.minimum(known + step, total - 1)] >= 0]
    image = place[known + step]
    forward = np.remainder(np.diff(image, append=image[:1]), len(path))
    backward = len(path) - forward
    return max(float(np.mean(forward <= 2)), float(np.mean(backward <= 2)))
