"""Work of drives and loads along a motion that is not integrated."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.graph.scalars import Scalar
from linkages.solution.moving.evaluation import evaluate_nodes
from linkages.solution.moving.limits import looks
from linkages.solution.moving.motion import Piece
from linkages.solution.moving.quadrature import integrals

_CHUNK = 8192
_QUADRATURE_ANGLE = math.radians(30.0)

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]


def with_work(pieces: list[Piece], fastest: float, most: float) -> list[Piece]:
    """Work of drives and loads since t = 0 at the times of all pieces.

    Parameters
    ----------
    pieces
        Of one motion, in their order.
    fastest
        Highest speed of a drive in rad/s (or in sizes of the mechanism per second).
    most
        Number of places that may be looked at.

    Raises
    ------
    ValueError
        If that is not enough.
    """
    end = float(pieces[-1].time[-1]) if len(pieces[-1].time) else 0.0
    looks(end, fastest, _QUADRATURE_ANGLE, most)
    done, last = 0.0, 0.0
    result = []
    for piece in pieces:
        if piece.samples is None:
            work = done + _work(piece, last, fastest)
        else:
            start = piece.part(slice(0, 1))
            work = done + _work(start, last, fastest) + _work_across(piece)
        if len(work):
            done, last = float(work[-1]), float(piece.time[-1])
        result.append(replace(piece, work=work))
    return result


def _power(piece: Piece) -> Scalar:
    model = piece.system.model
    return model.driven_power + model.load_power


def _work_across(piece: Piece) -> Floats:
    """Work within a passage."""
    (work,) = integral_across(piece, evaluate_nodes(piece, [_power(piece)]))
    return work


def integral_across(piece: Piece, rates: Floats) -> Floats:
    """Integrals from the first to every time of a passage, shape (rows, times).

    The rates, of that shape, are interpolated: in the middle they cannot be computed.
    """
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
        found = [
            piece.system.evaluate(
                [power], times[some], flipped={block: row[some] for block, row in modes.items()}
            )[0]
            for some in (slice(k, k + _CHUNK) for k in range(0, len(times), _CHUNK))
        ]
        return np.concatenate(found)

    own = begin + part * step
    found = integrals(of, own, own + step, np.zeros(len(own), dtype=int))
    return np.cumsum(found.reshape(-1, parts).sum(axis=1))
