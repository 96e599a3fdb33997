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

_CHUNK = 8192
_QUADRATURE_ANGLE = math.radians(30.0)
_REFINEMENTS = 7

Floats = NDArray[np.float64]


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
    """Work since `begun`: Gauss–Legendre quadrature, refined until it settles."""
    power = _power(piece)
    points, weights = np.polynomial.legendre.leggauss(8)
    edges = np.concatenate([[begun], piece.time])
    longest = float(np.abs(np.diff(edges)).max(initial=0.0))
    parts = max(1, math.ceil(longest * fastest / _QUADRATURE_ANGLE))
    result = np.zeros(len(edges) - 1)
    for refinement in range(_REFINEMENTS):
        pieces = _integrals(piece, power, edges, parts * 2**refinement, points, weights)
        previous, result = result, np.cumsum(pieces)
        scale = np.abs(pieces).sum()
        if refinement and np.abs(result - previous).max(initial=0.0) <= 1e-13 * scale:
            break
    return result


def _integrals(
    piece: Piece, power: Scalar, edges: Floats, parts: int, points: Floats, weights: Floats
) -> Floats:
    """Integral of the power over every interval, each cut into equal parts."""
    lengths = np.diff(edges) / parts
    result = np.zeros(len(lengths))
    for start in range(0, len(lengths) * parts, _CHUNK):
        interval, part = np.divmod(
            np.arange(start, min(start + _CHUNK, result.size * parts)), parts
        )
        half = 0.5 * lengths[interval]
        places = (edges[interval] + (2 * part + 1) * half)[:, None] + half[:, None] * points
        modes = {b: np.repeat(w[interval], len(points)) for b, w in piece.flipped.items()}
        values = piece.system.evaluate([power], places.ravel(), flipped=modes)
        np.add.at(result, interval, values.reshape(places.shape) @ weights * half)
    return result
