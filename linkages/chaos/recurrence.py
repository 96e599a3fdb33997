"""What a motion settles to, from its section points alone: a cycle, or chaos.

Lengths are in units of the error that a step of the integration may have, so that the same limits
hold for all mechanisms and tolerances.

References
----------
.. [1] M. T. Rosenstein, J. J. Collins, C. J. De Luca, Physica D 65 (1993) 117: exponents from
   nearest neighbours of a small data set.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.tori import embed

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

NOISE, CLOSE, SAME = 1e2, 1e3, 1e4
"""Distances: of points on a cycle, as errors make them; from a cycle that has been reached; of
points that are taken as one.

Errors are 0.1 to 100, and some thousand where an orbit is sensitive within its period. Chaotic
motions have extents of 1e8 and more, and come that near to an unstable cycle in one of some 1e5
passes at most."""

WINDOW = 4
"""Fewest points over which a contraction is measured."""

REPEATS = 4
"""How many times as long as a cycle its motion must have been seen."""

CYCLES, STEADY, LEAST = 8, 3.0, 1.0
"""Number of repetitions over which a motion has only errors and does not drift; the most that they
may differ in units of the largest difference between two in turn, and in any case."""


@dataclass(frozen=True)
class Cycle:
    """A cycle that was reached."""

    count: int  # its number of points
    # Factor by which the distance from it shrinks in one repetition; nan if only errors are left
    contraction: float


def find_cycle(points: Floats, angles: Mask, unit: Floats) -> Cycle | None:
    """The shortest cycle that a motion has reached; None if that is not decided yet.

    The largest distances |z[i] − z[i − k]| over a stretch, and over the stretch before it, yield
    the factor r of their contraction in k points. What is left of the way to the cycle is then at
    most the sum d·r + d·r² + … of a geometric series. A slow approach is thus no cycle, however
    close two points in turn are. Where only errors of the integration are left, points must not
    drift. A cycle whose points are as good as those of a shorter one is that one.

    `points`: section points, shape (n, d).
    `angles`: which entries are angles, shape (d,); they repeat modulo 2π.
    `unit`: error that a step may have, shape (d,).
    """
    seen = _Lags(points, angles, unit)
    for count in (np.flatnonzero(seen.back[: seen.longest] <= SAME) + 1).tolist():
        if not seen.measures(count):
            break
        now, factor = seen.contraction(count)
        if not _approached(now, factor):
            factor = math.nan
            if not _repeated(now, seen.back[count - 1 :: count]):
                continue
        parts = (part for part in range(1, count) if count % part == 0)
        own = next((part for part in parts if seen.apart(part, count) <= SAME), count)
        return Cycle(own, factor ** (own / count))
    return None


STRETCHES, EVEN, ALIKE, NEAR = 6, 0.1, 0.75, 0.01
"""Parts of a motion, of which the last three show a steady approach; the part by which the
logarithm of the contraction from one to the next may change; the part of it that distances in a
shorter cycle have to shrink; and the largest remaining distance, as a part of the extent of all
points."""


def approached_cycle(points: Floats, angles: Mask, unit: Floats) -> Cycle | None:
    """The cycle that a motion approaches at a steady rate but has not reached; None if it does not.

    Distances between points shrink exponentially over the last half of the motion. Those from the
    points of a shorter cycle must not, or it is the shorter one that is approached.

    `points`, `angles`, `unit`: as `find_cycle` takes them.
    """
    seen = _Lags(points, angles, unit)
    if len(points) < STRETCHES * WINDOW:
        return None
    count = int(seen.back[: seen.longest].argmin()) + 1
    width = count * max(1, len(points) // (STRETCHES * count))
    if len(points) < count + 3 * width:
        return None
    later, earlier = seen.shrinks(count, width), seen.shrinks(count, width, width)
    if not (min(later, earlier) > 0.0 and abs(later - earlier) <= EVEN * earlier):
        return None
    now, factor = seen.apart(count, width), math.exp(-later * count / width)
    if now * factor > NEAR * seen.back.max() * (1.0 - factor):
        return None
    parts = (part for part in range(1, count) if count % part == 0)
    alike = (part for part in parts if seen.shrinks(part, width) > ALIKE * later)
    own = next(alike, count)
    return Cycle(own, factor ** (own / count) if now > NOISE else math.nan)


def points_left(points: Floats, angles: Mask, unit: Floats) -> float:
    """How many more points `find_cycle` needs if contraction goes on as it does; perhaps infinite.

    `points`, `angles`, `unit`: as `find_cycle` takes them.
    """
    seen = _Lags(points, angles, unit)
    count = int(seen.back[: seen.longest].argmin()) + 1
    if not seen.measures(count):
        return math.inf
    now, factor = seen.contraction(count)
    if not 0.0 < factor < 1.0:
        return math.inf
    far = max(now * max(1.0, factor / (1.0 - factor)) / CLOSE, 1.0)
    return count * math.ceil(math.log(far) / -math.log(factor))


class _Lags:
    """Distances between points of a motion so many points apart, in units."""

    def __init__(self, points: Floats, angles: Mask, unit: Floats) -> None:
        self._points = points / unit
        self._angles, self._turn = angles, 2 * np.pi / unit[angles]
        self.back = self._distances(self._points[-2::-1], self._points[-1])
        self.longest = len(points) // REPEATS

    def _distances(self, points: Floats, others: Floats) -> Floats:
        """Largest difference of any entry, shape (n,); nan where an entry is no finite number."""
        result = np.abs(points - others)
        if len(self._turn):
            within = result[:, self._angles] % self._turn
            result[:, self._angles] = np.minimum(within, self._turn - within)
        return np.asarray(result.max(axis=1))

    def apart(self, lag: int, last: int, before: int = 0) -> float:
        """Largest distance from the point a lag before, over some of the last points."""
        end = len(self._points) - before
        own = slice(end - last, end), slice(end - last - lag, end - lag)
        return float(self._distances(*(self._points[part] for part in own)).max())

    def measures(self, lag: int) -> bool:
        """Whether there are enough points for `contraction`."""
        return len(self._points) >= lag + 2 * max(lag, WINDOW)

    def shrinks(self, lag: int, width: int, before: int = 0) -> float:
        """Logarithm of the ratio of largest distances in the stretch before and in this one."""
        now, then = (self.apart(lag, width, before + add) for add in (0, width))
        return math.log(then / now) if now > 0.0 and then > 0.0 else 0.0

    def contraction(self, lag: int) -> tuple[float, float]:
        """The largest distance over the last stretch, and the factor of its growth in one lag."""
        width = max(lag, WINDOW)
        now, before = self.apart(lag, width), self.apart(lag, width, width)
        return now, (now / before) ** (lag / width) if before > 0.0 else 0.0


def _approached(now: float, factor: float) -> bool:
    """Whether what is left of the way to a cycle is short, by the last step and its contraction."""
    return factor < 1.0 and now <= CLOSE and now * factor <= CLOSE * (1.0 - factor)


def _repeated(now: float, back: Floats) -> bool:
    """Whether a motion has only errors left, and does not drift from one repetition to the next."""
    most = max(STEADY * now, LEAST)
    return now <= SAME and len(back) >= CYCLES and float(back[:CYCLES].max()) <= most


FEWEST = 40
"""Points that tell whether a motion is chaotic."""

TRANSIENT = 1 / 3
"""Part of the points that are not looked at for that."""

FURTHEST = 16
"""Points over which neighbours are followed."""

GROWN, ERRORS, HALF = 1.0, 4.0, 0.5
"""Mean logarithm of the growth of distances between neighbours of a chaotic motion: the least, also
in units of its standard error, and that in either half of the motion."""


def separates(points: Floats, angles: Mask) -> bool:
    """Whether nearest neighbours among the points of a motion come apart, as in chaos [1]_.

    Along a torus they stay as near as they are, on average, and along an approach to a cycle they
    come nearer. No answer is reason for doubt: long transients may be chaotic as well.

    `points`, `angles`: as `find_cycle` takes them.
    """
    if len(points) < FEWEST or not np.isfinite(points).all():
        return False
    places = embed(points[int(TRANSIENT * len(points)) :], angles)
    apart = np.abs(places[:, None] - places[None]).max(axis=2)
    least = np.finfo(float).eps * max(float(apart.max()), np.finfo(float).tiny)
    further = min(FURTHEST, len(places) // 4)
    first = np.arange(len(places) - further)
    own = apart[: len(first), : len(first)].copy()
    np.fill_diagonal(own, np.inf)
    second = own.argmin(axis=1)
    later = np.arange(1, further + 1)[:, None]
    followed = np.maximum(apart[first + later, second + later], least)
    growth = np.log(followed / np.maximum(own[first, second], least))
    most = growth[growth.mean(axis=1).argmax()]
    halves = np.array_split(most, 2)
    error = float(most.std(ddof=1)) / math.sqrt(len(most))
    grown = float(most.mean()) > max(GROWN, ERRORS * error)
    return grown and min(float(half.mean()) for half in halves) > HALF
