"""Attractors out of the ends of many motions: matched by their points, and numbered."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.attractors.settling import Kind
from linkages.chaos.periods import apart
from linkages.sweeps.engine import Arrays, Code

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]

SAME = 20.0
"""Tolerances by which the ends of motions differ that tend to one attractor."""

MANY = 24
"""Cycles or states at rest with equally many points from which on they are one family."""

ALIKE = 3.0
"""Distances of neighbours within sets of points that lie on one attractor but do not repeat."""

LINKED = 0.25
"""Part of the range by which an attractor moves from a parameter's value to the next, at most."""

DIGITS = 1e-3
"""Part of the range to which coordinates are rounded for the order of attractors."""

MOST_NUMBERS = 2**22
"""Numbers that are compared at once."""

NOWHERE = -1
"""Label of what could not be computed."""


@dataclass(frozen=True, eq=False)
class Attractor:
    """What motions tend to.

    `kind`, `period`, `section`, `turns`, `touches`: as `Settled` has them.
    """

    kind: Kind
    period: float
    section: int
    turns: Floats
    touches: Floats
    points: Floats  # shape (k, x); of a family those of its member that was met most closely
    place: int  # the start that came closest
    node: int  # its parameters
    # Whether it is one of many side by side: states at rest with dry friction, for example
    family: bool = False

    @classmethod
    def of(cls, found: Mapping[str, Any], place: int, node: int) -> Attractor:
        """That of a motion, from what `Settled` has of it."""
        return cls(
            kind=Kind(int(found["kind"])),
            period=float(found["period"]),
            section=int(found["section"]),
            turns=found["turns"],
            touches=found["touches"],
            points=found["points"],
            place=place,
            node=node,
        )


@dataclass(frozen=True, eq=False)
class Matched:
    """Attractors with the starts that tend to them."""

    # In the order of their numbers; the last one is that of undecided motions, if there are any
    attractors: tuple[Attractor, ...]
    # Number of the attractor of every start, shape (starts,); −1 where nothing was computed
    labels: Integers


def ranges(found: Arrays, angles: Mask) -> Floats:
    """Largest range of each entry of states over all motions, shape (x,); 1 where it is zero."""
    reach = found["reach"][found["outcome"] == Code.COMPUTED]
    result = np.max(reach, axis=0, initial=0.0) if len(reach) else np.zeros(len(angles))
    return np.where(result > 0.0, result, 1.0)


def farthest(points: Floats, others: Floats, angles: Mask, scale: Floats) -> Floats:
    """Hausdorff distance of a set of points from others in parts of ranges, shape (m,).

    `points`: shape (k, x).
    `others`: sets of points, shape (m, l, x).
    """
    each = points.size * others.shape[1]
    result = []
    for part in np.array_split(others, 1 + len(others) * each // MOST_NUMBERS):
        between = _between(points, part, angles, scale)
        result.append(np.maximum(between.min(2).max(axis=1), between.min(1).max(axis=1)))
    return np.concatenate(result)


def _between(points: Floats, others: Floats, angles: Mask, scale: Floats) -> Floats:
    """Distances of all points from all others, shape (m, k, l)."""
    shape = len(others), len(points), others.shape[1]
    full = (*shape, points.shape[1])
    one, other = (
        np.broadcast_to(each, full).reshape(-1, full[-1])
        for each in (points[None, :, None], others[:, None])
    )
    different = apart(one, other, angles)
    return np.asarray(np.abs(different / scale).max(axis=1).reshape(shape))


def clustered(found: Arrays, nodes: Integers, angles: Mask, settled: float) -> Matched:
    """Attractors of starts with the same parameters each, by the distance of their points.

    The result depends on the ends of the motions alone, not on their order: those that came closest
    to their attractor are taken first.

    `found`: answers of `Starts`.
    `nodes`: number of the parameters of each start.
    `angles`: which entries of states repeat after a turn.
    `settled`: part of its range by which a motion is away from its attractor at most.
    """
    scale = ranges(found, angles)
    labels = np.full(len(nodes), NOWHERE, dtype=np.int64)
    attractors: list[Attractor] = []
    computed = found["outcome"] == Code.COMPUTED
    groups = np.column_stack([nodes, found["kind"], found["count"], found["section"]])
    groups[found["kind"] >= Kind.QUASI_PERIODIC, 2] = 0  # as many points as are kept
    groups[~computed | (found["kind"] == Kind.UNDECIDED)] = NOWHERE
    order = np.lexsort((*found["points"][:, 0].T[::-1], np.nan_to_num(found["left"])))
    kinds, which = np.unique(groups, axis=0, return_inverse=True)
    which = which.ravel()  # a column in NumPy 2.0
    for number, (node, kind, *_) in enumerate(kinds.tolist()):
        if node == NOWHERE:
            continue
        left = order[which[order] == number]
        begun = len(attractors)
        while len(left):
            first = int(left[0])
            same = _same(found, first, left, angles, scale, settled)
            labels[left[same]] = len(attractors)
            attractors.append(_attractor(found, first, node))
            left = left[~same]
        if len(attractors) - begun > MANY and kind < Kind.QUASI_PERIODIC:
            labels[labels >= begun] = begun
            attractors[begun:] = [replace(attractors[begun], family=True)]
    return Matched(tuple(attractors), labels)


def _same(
    found: Arrays, first: int, others: Integers, angles: Mask, scale: Floats, settled: float
) -> Mask:
    """Which of some motions end on the attractor of the first of them."""
    count = int(found["count"][first])
    points = found["points"][first, :count]
    if found["kind"][first] < Kind.QUASI_PERIODIC:
        away = farthest(points, found["points"][others, :count], angles, scale)
        return np.asarray(away <= SAME * settled)
    own = _neighbours(points, angles, scale)
    result = []
    for other in others:
        set_ = found["points"][other, : int(found["count"][other])]
        between = _between(points, set_[None], angles, scale)[0]
        usual = max(own, _neighbours(set_, angles, scale))
        across = max(np.median(between.min(axis=1)), np.median(between.min(axis=0)))
        result.append(other == first or across <= ALIKE * usual)
    return np.array(result)


def _neighbours(points: Floats, angles: Mask, scale: Floats) -> float:
    """Median distance of points from the nearest other one of their set."""
    between = _between(points, points[None], angles, scale)[0]
    np.fill_diagonal(between, np.inf)
    return float(np.median(between.min(axis=1)))


def _attractor(found: Arrays, place: int, node: int) -> Attractor:
    own = {name: array[place] for name, array in found.items()}
    return Attractor.of(own | {"points": own["points"][: int(own["count"])]}, place, node)


def linked(
    attractors: Sequence[Attractor],
    neighbours: Sequence[tuple[int, int]],
    angles: Mask,
    scale: Floats,
) -> Integers:
    """Number of the family of each attractor: those that follow each other over parameters.

    Attractors at neighbouring values belong together if either is the nearest to the other of all
    with the same kind and number of points, and less than a quarter of the range away.

    `neighbours`: pairs of numbers of parameters.
    """
    own: dict[int, list[int]] = {}
    for index, each in enumerate(attractors):
        own.setdefault(each.node, []).append(index)
    parents = [*range(len(attractors))]

    def root(index: int) -> int:
        while parents[index] != index:
            index = parents[index]
        return index

    for one, other in neighbours:
        here, there = own.get(one, []), own.get(other, [])
        away = np.array(
            [[distance(attractors[a], attractors[b], angles, scale) for b in there] for a in here]
        )
        if not away.size:
            continue
        for row, index in enumerate(here):
            column = int(away[row].argmin())
            if away[row, column] <= LINKED and int(away[:, column].argmin()) == row:
                low, high = sorted((root(index), root(there[column])))
                parents[high] = low
    return np.unique([root(index) for index in range(len(parents))], return_inverse=True)[1]


def distance(one: Attractor, other: Attractor, angles: Mask, scale: Floats) -> float:
    """Distance of two attractors in parts of ranges; infinite if they are of different kinds."""
    keys = [
        (each.kind, each.section, np.abs(each.turns).tolist(), np.nan_to_num(each.touches).tolist())
        for each in (one, other)
    ]
    alike = keys[0] == keys[1]
    if not alike or (one.kind < Kind.QUASI_PERIODIC and len(one.points) != len(other.points)):
        return np.inf
    return float(farthest(one.points, other.points[None], angles, scale)[0])


def ordered(attractors: Sequence[Attractor], scale: Floats) -> list[int]:
    """Places of attractors by kind, number of points, period, and coordinates of their points."""

    def key(index: int) -> tuple[float, ...]:
        each = attractors[index]
        rounded = sorted(np.round(each.points / (DIGITS * scale)).tolist())
        period = 0.0 if np.isnan(each.period) else float(f"{each.period:.4g}")
        count = len(each.points) if each.kind < Kind.QUASI_PERIODIC else 0
        return (each.kind, count, period, each.node, *rounded[0], *each.points[0].tolist())

    return sorted(range(len(attractors)), key=key)


def numbered(families: Integers, order: Sequence[int]) -> Integers:
    """Numbers of families in the order in which their first members come."""
    numbers = np.full(1 + int(families.max(initial=-1)), NOWHERE, dtype=np.int64)
    for index in order:
        if numbers[families[index]] == NOWHERE:
            numbers[families[index]] = int(numbers.max()) + 1
    return np.asarray(numbers[families])


def with_undecided(matched: Matched, found: Arrays, unstable: Mapping[int, bool]) -> Matched:
    """The same without attractors that are unstable, and undecided motions as the last one.

    Motions that stop before their attractor is known are undecided as well.

    `unstable`: number of an attractor → whether motions beside it leave it.
    """
    kept = [index for index in range(len(matched.attractors)) if not unstable.get(index, False)]
    numbers = np.full(len(matched.attractors) + 1, NOWHERE, dtype=np.int64)
    numbers[kept] = np.arange(len(kept))
    labels = numbers[matched.labels]
    begun = ~np.isin(found["outcome"], (Code.INVALID, Code.NOT_ASSEMBLED, Code.MISSING))
    open_ = (labels == NOWHERE) & begun
    attractors = [matched.attractors[index] for index in kept]
    if open_.any():
        labels[open_] = len(attractors)
        place = int(np.flatnonzero(open_)[0])
        attractors.append(replace(_attractor(found, place, NOWHERE), kind=Kind.UNDECIDED))
    return Matched(tuple(attractors), labels)
