"""Closed curves and tori of section points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def embed(points: ArrayLike, angles: ArrayLike | None = None) -> Floats:
    """Put cosine and sine for every angle, and divide every entry by its standard deviation.

    So entries of different units count alike (cosine and sine of one angle by a common one); no
    dimension depends on it.

    `points`: shape (n, d), or (n,) for one entry.
    `angles`: which entries are angles in radians, shape (d,); none by default.
    Returns: shape (n, d + number of angles): entries that are no angles first.
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
    """What the arrangement of section points says."""

    count: int  # number of closed curves, visited one after the other; 0 if there are none
    reason: str = ""  # why points do not lie on closed curves; empty if they do


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

    `points`: section points after the transient in the whole state space, shape (n, d), n ≥ 60, the
    first 3000 of which are used. A periodic motion has too few different ones: ask `find_period`
    first.
    `angles`: which entries are angles, shape (d,).
    """
    embedded = embed(points, angles)[:_MOST]
    if len(embedded) < FEWEST:
        raise ValueError(f"{len(embedded)} section points; at least {FEWEST} are needed")
    from scipy.sparse.csgraph import connected_components, minimum_spanning_tree
    from scipy.spatial.distance import pdist, squareform

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
    from scipy.sparse.csgraph import breadth_first_order

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


SMOOTH = 1e-2
"""Part of its range by which every point may differ from the curve through its neighbours."""

BETTER, RESOLVED = 10.0, 1e-6
"""Times the least difference that the fewest branches may have, and one that needs no more."""

LARGEST_GAP = 0.05
"""Part of a turn between neighbouring phases from which on they do not cover the turn."""

MOST_BRANCHES = 4
"""Points and turns after which a curve may close, multiplied."""

ALIKE = 1e-6
"""Part of a turn below which phases are the same."""

_NEIGHBOURS = np.array([-3, -2, -1, 1, 2, 3])


@dataclass(frozen=True)
class PhaseCurve:
    """How section points depend on a phase that is known.

    `points`, `turns`: the points are a smooth function of their number modulo `points` and of the
    phase modulo `turns`; 0 each if they are none.
    """

    points: int
    turns: int
    # Largest difference of a point from the curve through its neighbours, in ranges of entries; the
    # least of all numbers that are tried
    error: float
    covered: float  # part of a turn in which phases lie

    @property
    def smooth(self) -> bool:
        """Whether there is such a function."""
        return self.points > 0

    @property
    def whole(self) -> bool:
        """Whether phases cover the turn."""
        return self.covered > 1.0 - LARGEST_GAP


def phase_curve(
    points: ArrayLike, phases: ArrayLike, *, angles: ArrayLike | None = None
) -> PhaseCurve:
    """Decide whether points lie on closed curves that a phase runs along.

    Every point is compared with the polynomial through its six neighbours in phase. Along smooth
    curves the difference falls fast with the number of points; on a strange nonchaotic attractor,
    which is discontinuous in the phase [1]_, it remains of the order of the range.

    `points`: section points after the transient, shape (n, d).
    `phases`: those of another drive at these points, in turns that go on, shape (n,).
    `angles`: which entries are angles, shape (d,).

    References
    ----------
    .. [1] A. S. Pikovsky, U. Feudel, Chaos 5 (1995) 253: phase sensitivity.
    """
    embedded, turns = embed(points, angles), np.asarray(phases, dtype=float)
    ranges = np.ptp(embedded, axis=0)
    scaled = embedded[:, ranges > 0] / ranges[ranges > 0]
    covered = 1.0 - _largest_gap(np.sort(turns % 1.0))
    tried = [
        (points_apart, number // points_apart)
        for number in range(1, MOST_BRANCHES + 1)
        for points_apart in range(1, number + 1)
        if number % points_apart == 0
    ]
    errors = [_error(scaled, turns, *branches) for branches in tried]
    least = min(errors)
    if least > SMOOTH:
        return PhaseCurve(0, 0, least, covered)
    # more branches fit a curve of fewer as well, but hardly better
    index = next(i for i, error in enumerate(errors) if error <= max(BETTER * least, RESOLVED))
    return PhaseCurve(*tried[index], errors[index], covered)


def _largest_gap(phases: Floats) -> float:
    """Between neighbours on the circle of one turn."""
    return float(np.diff(phases, append=phases[:1] + 1.0).max())


def _error(scaled: Floats, turns: Floats, points: int, period: int) -> float:
    """Largest difference from the curve through neighbours, of all branches."""
    result = 0.0
    for first in range(points):
        branch, place = scaled[first::points], turns[first::points] % period / period
        order = np.argsort(place)
        branch, place = branch[order], place[order]
        kept = np.diff(place, prepend=place[-1] - 1.0) > ALIKE
        again = branch - branch[kept][np.cumsum(kept) - 1] if kept.any() else branch[:0]
        result = max(result, float(np.abs(again).max(initial=0.0)))
        branch, place = branch[kept], place[kept]
        if len(place) <= len(_NEIGHBOURS) or _largest_gap(place) > LARGEST_GAP:
            return np.inf
        near = (np.arange(len(place))[:, None] + _NEIGHBOURS) % len(place)
        away = (place[near] - place[:, None] + 0.5) % 1.0 - 0.5
        weights = np.ones_like(away)
        for one in range(len(_NEIGHBOURS)):
            others = np.delete(away, one, axis=1)
            weights[:, one] = np.prod(others / (others - away[:, one, None]), axis=1)
        between = np.einsum("pn,pnd->pd", weights, branch[near])
        result = max(result, float(np.abs(between - branch).max(initial=0.0)))
    return result
