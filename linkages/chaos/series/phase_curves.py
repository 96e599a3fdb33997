"""Whether section points are a smooth function of a phase, as on tori that two drives impose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.chaos.series.embedding import embed

Floats = NDArray[np.float64]

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

    Parameters
    ----------
    points, turns
        The points are a smooth function of their number modulo `points` and of the phase modulo
        `turns`; 0 each if they are none.
    error
        Largest difference of a point from the curve through its neighbours, in ranges of entries;
        the least of all numbers that are tried.
    covered
        Part of a turn in which phases lie.
    """

    points: int
    turns: int
    error: float
    covered: float

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

    Parameters
    ----------
    points
        Section points after the transient, shape (n, d).
    phases
        Those of another drive at these points, in turns that go on, shape (n,).
    angles
        Which entries are angles, shape (d,).

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
    found = 0.0
    for first in range(points):
        branch, place = scaled[first::points], turns[first::points] % period / period
        order = np.argsort(place)
        branch, place = branch[order], place[order]
        kept = np.diff(place, prepend=place[-1] - 1.0) > ALIKE
        again = branch - branch[kept][np.cumsum(kept) - 1] if kept.any() else branch[:0]
        found = max(found, float(np.abs(again).max(initial=0.0)))
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
        found = max(found, float(np.abs(between - branch).max(initial=0.0)))
    return found
