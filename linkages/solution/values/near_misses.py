"""Where a gap almost closes, and opens again untouched: neighbours of the motion touch there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.solution.moving.evaluation import evaluate_nodes
from linkages.solution.moving.motion import Motion
from linkages.solution.values.episodes import FREE, Episodes, Nodes

Floats = NDArray[np.float64]


def nearest_miss(motion: Motion, nodes: Nodes, found: Episodes) -> tuple[float, float] | None:
    """The least gap that opens again, and its time; None where there is none.

    It is in m, or in rad of a stop that twists, and lies between two samples in free flight, across
    which the rate of the indentation changes its sign, on the cubic through both with their rates.
    """
    least: tuple[float, float] | None = None
    jumps = np.sort(np.concatenate([found.begin, *_impacts(motion)]))
    for piece in motion.pieces:
        if len(piece.time) < 2:
            continue
        depth, rate = evaluate_nodes(piece, [nodes.gap.indentation, nodes.speed])
        time, step = piece.time[:-1], np.diff(piece.time)
        forward = np.sign(step)
        free = found.state(piece.time) == FREE
        apart = free[:-1] & free[1:] & ~_between(piece.time, jumps)
        turns = apart & (forward * rate[:-1] > 0.0) & (forward * rate[1:] < 0.0)
        for k in np.flatnonzero(turns):
            top, at = _top(depth[k], step[k] * rate[k], depth[k + 1], step[k] * rate[k + 1])
            if least is None or -top < least[0]:
                least = max(-top, 0.0), float(time[k] + at * step[k])
    return least


def _impacts(motion: Motion) -> list[Floats]:
    """Times at which rates jump, those of other contacts as well."""
    walls = motion.pieces[0].system.model.walls
    changes = (motion.changes.get(contact.touch) for contact in walls.contacts)
    return [changed.time for changed in changes if changed is not None]


def _between(time: Floats, jumps: Floats) -> NDArray[np.bool_]:
    """Whether something happens between each two samples."""
    low, high = np.minimum(time[:-1], time[1:]), np.maximum(time[:-1], time[1:])
    first, last = (np.searchsorted(jumps, ends) for ends in (low, high))
    return np.asarray(last > first)


def _top(start: float, rise: float, end: float, fall: float) -> tuple[float, float]:
    """Greatest value on [0, 1] of the cubic with these values and slopes at 0 and 1, and where."""
    change = end - start
    c2, c3 = 3.0 * change - 2.0 * rise - fall, rise + fall - 2.0 * change
    roots = np.roots([3.0 * c3, 2.0 * c2, rise])
    real = roots[np.isreal(roots)].real
    places = [0.0, *real[(real > 0.0) & (real < 1.0)], 1.0]
    values = [start + x * (rise + x * (c2 + x * c3)) for x in places]
    best = int(np.argmax(values))
    return float(values[best]), float(places[best])
