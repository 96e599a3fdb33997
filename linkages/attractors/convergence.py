"""Whether a sequence of section points converges to a cycle, by measured contraction."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.periods import apart

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

WINDOW = 8
"""Fewest points over which contraction is measured: pairs of complex multipliers swing within."""

NEAR = 1e4
"""Units by which a point may differ from the one a cycle before, for the cycle to be tried."""

SPLIT = 4.0
"""Units by which points of a cycle differ that are the same: each is up to one from its limit."""

SHRINKING = 0.98
"""Contraction in a window of differences that vanish in the end."""

STEADY = 0.999
"""Contraction in a window above which the limit is not extrapolated: noise would decide."""


@dataclass(frozen=True)
class Recurrence:
    """A cycle that section points converge to."""

    count: int  # points of a cycle, the fewest that repeat
    left: float  # distance of the last point from its limit, in units


def distances(points: Floats, others: Floats, angles: Mask, unit: Floats) -> Floats:
    """Largest difference of any entry in units, shape (n,); of angles modulo 2π."""
    return np.asarray(np.abs(apart(points, others, angles) / unit).max(axis=1))


def remaining(step: float, before: float, parts: float) -> float:
    """Distance to the limit of a geometric sequence: the sum of all steps to come.

    `step`, `before`: the last step of the sequence, and an earlier one.
    `parts`: how many steps lie between the two.
    """
    if step == 0.0:
        return 0.0
    if step >= STEADY * before:
        return math.inf
    ratio = (step / before) ** (1.0 / parts)
    return step * ratio / (1.0 - ratio)


def recurrence(
    points: Floats, angles: Mask, unit: Floats, *, noise: float, longest: int
) -> Recurrence | None:
    """The shortest cycle that points converge to, if its limit is less than a unit away.

    With z after n points, the steps |z(n) − z(n − k)| of k points shrink by a measured factor; what
    is left of them follows from the geometric series. Slow convergence is thus not mistaken for a
    cycle of k points, nor a splitting that is small but stays.

    `points`: in the order of the motion, shape (n, d).
    `angles`: which entries repeat modulo 2π, shape (d,).
    `unit`: difference of entries that counts as none, shape (d,).
    `noise`: steps in units that errors of integration cause.
    `longest`: most points of a cycle.
    """
    total = len(points)
    back = distances(points[-2::-1], points[-1:], angles, unit)
    for count in range(1, min(longest, total - 1) + 1):
        window = count * math.ceil(WINDOW / count)
        if total < 2 * window + count:
            return None
        if back[count - 1] > NEAR:
            continue
        last = points[-2 * window - count :]
        steps = distances(last[count:], last[:-count], angles, unit)
        step, before = float(steps[window:].max()), float(steps[:window].max())
        left = step if step <= noise else remaining(step, before, window / count)
        if left <= 1.0:
            fewest = _fewest(points, count, angles, unit)
            return None if fewest is None else Recurrence(fewest, left)
    return None


def _fewest(points: Floats, count: int, angles: Mask, unit: Floats) -> int | None:
    """The shortest cycle that one of `count` points is; None while it still shrinks to one.

    A cycle whose multipliers are a pair seems further away than several turns of it do.
    """
    window = count * math.ceil(WINDOW / count)
    for part in range(1, count):
        if count % part:
            continue
        last = points[-2 * window - part :]
        split = distances(last[part:], last[:-part], angles, unit)
        now, before = float(split[window:].max()), float(split[:window].max())
        if now <= SPLIT:
            return part
        if now <= SHRINKING * before:
            return None
    return count
