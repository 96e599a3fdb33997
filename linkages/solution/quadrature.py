"""Integrals over time of quantities that may jump, and the work of drives and loads."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.scalars import Scalar
from linkages.solution.driven_limits import looks
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.motion import Piece

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

PRECISION = 1e-9
"""Estimated error that is allowed, as a part of the integral of the absolute value.

It is that of the rule with fewer nodes: what is smooth is integrated to some 1e-12."""

_ROUND_OFF = 1e-14
_DEEPEST, _ALL, _ROOM = 44, 3, 128
"""How often an interval is halved at most, how often all of them are, and how many intervals more
than twice as many as at first may be open later."""

_DEEP, _AT_POLE = 20, 1e-4
"""Beside a pole an integral does not decrease when its interval is halved: where it is not resolved
after so many halvings, at least this part of the mean over intervals is left."""

# Nodes on [−1, 1] from the outermost one inwards, weights of the rule with 13 nodes and degree 19,
# and of that with seven of them and degree 9: Gander, Gautschi, Adaptive quadrature – revisited,
# BIT 40 (2000) 84–101. Both weights are positive at the ends and sums of both differ everywhere
# between: a jump anywhere in an interval changes them by at least 0.79 of the error of the first.
_HALF = np.array([
    [1.0, 0.0158271919734801830871699867333055, 11.0 / 210.0],
    [0.942882415695479719056351758431857, 0.0942738402188500455312825050771082, 0.0],
    [math.sqrt(2.0 / 3.0), 0.155071987336585396253635979802103, 72.0 / 245.0],
    [0.641853342345781305781235541329032, 0.188821573960182454420005339372972, 0.0],
    [1.0 / math.sqrt(5.0), 0.199773405226858526792068022066488, 125.0 / 294.0],
    [0.236383199662149880282223773492053, 0.224926465333339527016017687996395, 0.0],
])  # fmt: skip
_MIDDLE = np.array([[0.0, 0.242611071901407733799640957903256, 16.0 / 35.0]])
_NODES, _FINE, _COARSE = np.concatenate([_HALF * [-1, 1, 1], _MIDDLE, _HALF[::-1]]).T


def integrals(
    function: Callable[[Whole, Floats], Floats], begin: Floats, end: Floats, group: Whole
) -> Floats:
    """Integrals of functions over intervals, which are halved where a function is not smooth.

    A jump within an interval is located to round-off by this. Where noise leaves too many intervals
    after some halvings, the last result counts. `function` takes the index of the interval and the
    time, shape (n,) each; `group` is the motion of each interval, over which errors are compared
    with the integral of the absolute value. The result, shape (intervals,), is nan at a pole, near
    which that integral has no bound. It does not depend on other motions.
    """
    result = np.zeros(len(begin))
    if not len(begin):
        return result
    which, low, high = np.arange(len(begin)), begin, end
    count = np.bincount(group)
    allowed = np.zeros(len(begin))
    for depth in range(_DEEPEST):
        half, middle = 0.5 * (high - low), 0.5 * (low + high)
        times = middle[:, None] + half[:, None] * _NODES
        values = function(np.repeat(which, len(_NODES)), times.ravel()).reshape(times.shape)
        # sums along rows: their bits do not depend on how many rows there are
        fine, coarse, size = (
            (each * weights).sum(axis=1) * half
            for each, weights in ((values, _FINE), (values, _COARSE), (np.abs(values), _FINE))
        )
        size = np.abs(size)
        if not depth:
            allowed = PRECISION * (np.bincount(group, size) / count)[group]
        failed = np.abs(fine - coarse) > np.maximum(allowed[which], _ROUND_OFF * size)
        narrow = (low == middle) | (middle == high) | (depth + 1 == _DEEPEST)
        many = np.bincount(group[which[failed]], minlength=len(count))
        noisy = (many > 2 * count + _ROOM) & (depth >= _ALL)
        open_ = failed & ~narrow & ~noisy[group[which]]
        if depth >= _DEEP:
            poles = failed & ~open_ & (size * PRECISION > _AT_POLE * allowed[which])
            fine[poles] = np.nan
        np.add.at(result, which[~open_], fine[~open_])
        if not open_.any():
            break
        which = np.tile(which[open_], 2)
        low, high = (
            np.concatenate([low[open_], middle[open_]]),
            np.concatenate([middle[open_], high[open_]]),
        )
    return result


_CHUNK = 8192
_QUADRATURE_ANGLE = math.radians(30.0)


def with_work(pieces: list[Piece], fastest: float, most: float) -> list[Piece]:
    """Work of drives and loads since t = 0 in all pieces; `fastest` is that of `with_turns`."""
    end = float(pieces[-1].time[-1]) if len(pieces[-1].time) else 0.0
    looks(end, fastest, _QUADRATURE_ANGLE, most)
    done, last = 0.0, 0.0
    result = []
    for piece in pieces:
        if piece.samples is None:
            work = done + _work(piece, last, fastest)
        else:
            start = piece.part(slice(0, 1))
            (across,) = integral_across(piece, evaluate_nodes(piece, [_power(piece)]))
            work = done + _work(start, last, fastest) + across
        if len(work):
            done, last = float(work[-1]), float(piece.time[-1])
        result.append(replace(piece, work=work))
    return result


def _power(piece: Piece) -> Scalar:
    model = piece.system.model
    return model.driven_power + model.load_power


def integral_across(piece: Piece, rates: Floats) -> Floats:
    """Integrals from the first to every time of a passage of interpolated rates, (rows, times)."""
    points, weights = np.polynomial.legendre.leggauss(len(piece.time))
    half = 0.5 * np.diff(piece.time)[:, None]
    places = (piece.time[:-1, None] + half) + half * points
    between = replace(piece, samples=places.ravel()).interpolated(rates)
    parts = (between.reshape(len(rates), *places.shape) @ weights) * half[:, 0]
    return np.cumsum(np.insert(parts, 0, 0.0, axis=1), axis=1)


def _work(piece: Piece, begun: float, fastest: float) -> Floats:
    """Work since `begun`, also of what jumps."""
    power = _power(piece)
    edges = np.concatenate([[begun], piece.time])
    longest = float(np.abs(np.diff(edges)).max(initial=0.0))
    parts = max(1, math.ceil(longest * fastest / _QUADRATURE_ANGLE))
    sample = np.repeat(np.arange(len(piece.time)), parts)
    part = np.tile(np.arange(parts), len(piece.time))
    begin, step = edges[sample], np.diff(edges)[sample] / parts

    def of(interval: Whole, times: Floats) -> Floats:
        modes = {block: where[sample[interval]] for block, where in piece.flipped.items()}
        result = [
            piece.system.evaluate(
                [power], times[some], flipped={block: row[some] for block, row in modes.items()}
            )[0]
            for some in (slice(k, k + _CHUNK) for k in range(0, len(times), _CHUNK))
        ]
        return np.concatenate(result)

    own = begin + part * step
    result = integrals(of, own, own + step, np.zeros(len(own), dtype=int))
    return np.cumsum(result.reshape(-1, parts).sum(axis=1))
