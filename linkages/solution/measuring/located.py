"""Largest values of series, located between their samples by looking there."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

ALIKE = 1e-9
"""Part by which peaks must differ to be told apart: the first of those alike is given."""

_PARTS = 16
"""Parts on each side of a place that are looked at; each look is so many times as close."""

_FEWEST, _LOOKS = 4, 9
"""Looks at a smooth peak, which is then found to round-off, and at one with a kink."""

_SETTLED = 1e-12
"""Part of the size of a series by which a look must raise its peak for another one to follow."""


class Extremes(NamedTuple):
    """Largest values and where they are, in samples from the first one, shape (motions,) each."""

    value: Floats
    place: Floats


def largest_between(samples: Floats, between: Callable[[Whole, Floats], Floats]) -> Extremes:
    """The largest value of every row, between samples where there is more.

    Parameters
    ----------
    samples
        Shape (rows, samples). A row that is not finite has no largest value.
    between
        Rows and places in them, shape (n,) each → values there.
    """
    finite = np.asarray(np.isfinite(samples).all(axis=1))
    values = samples if finite.all() else np.where(finite[:, None], samples, 0.0)
    best = np.argmax(values, axis=1)
    top, bottom = values[np.arange(len(values)), best], values.min(axis=1)
    rows, starts = _candidates(values, best)
    kept = (finite & (bottom < top))[rows]
    rows, starts = rows[kept], starts[kept]
    place = best.astype(float)
    if len(rows):
        sizes = np.maximum(top, -bottom)
        heights, places = _looked_at(values, sizes, rows, starts.astype(float), between)
        top, place = _first_of_highest(top, place, rows, heights, places)
    return Extremes(np.where(finite, top, np.nan), place)


def _candidates(values: Floats, best: Whole) -> tuple[Whole, Whole]:
    """Rows and samples beside which the largest value may lie: as far as the bend there allows.

    Without a bend there is no more than the sample: of a series that rests, the first is enough.
    """
    count = values.shape[1]
    if count < 3:
        return np.zeros(0, dtype=int), np.zeros(0, dtype=int)
    higher = np.ones_like(values, dtype=bool)
    higher[:, 1:] &= values[:, 1:] >= values[:, :-1]
    higher[:, :-1] &= values[:, :-1] >= values[:, 1:]
    rows, starts = np.nonzero(higher)
    inner = np.clip(starts, 1, count - 2)
    with np.errstate(over="ignore"):  # beside an infinite bend every peak is looked at
        bend = 2 * values[rows, inner] - values[rows, inner - 1] - values[rows, inner + 1]
        # an inner peak exceeds its sample by an eighth of that, one beside an end by up to a half
        most = values[rows, starts] + 0.5 * np.abs(bend)
    found = (most >= values[rows, best[rows]]) & ((bend != 0.0) | (starts == best[rows]))
    return rows[found], starts[found]


def _looked_at(
    values: Floats,
    sizes: Floats,
    rows: Whole,
    places: Floats,
    between: Callable[[Whole, Floats], Floats],
) -> tuple[Floats, Floats]:
    """Peaks beside samples, closer and closer: heights and places, shape (peaks,)."""
    last = values.shape[1] - 1.0
    heights = values[rows, places.astype(int)].copy()
    size = sizes[rows]
    reach, parts = 1.0, np.arange(-_PARTS, _PARTS + 1) / _PARTS
    open_ = np.arange(len(rows))
    for look in range(_LOOKS):
        around = np.clip(places[open_, None] + reach * parts, 0.0, last)
        which = np.repeat(rows[open_], len(parts))
        found = np.broadcast_to(between(which, around.ravel()), which.shape)
        found = found.reshape(around.shape)
        found = np.where(np.isfinite(found), found, -np.inf)
        at = np.argmax(found, axis=1)
        each = np.arange(len(open_))
        before = heights[open_].copy()
        raised = found[each, at] > before
        heights[open_] = np.where(raised, found[each, at], before)
        places[open_] = np.where(raised, around[each, at], places[open_])
        reach /= _PARTS
        settled = heights[open_] - before <= _SETTLED * size[open_]
        open_ = open_[~settled] if look + 1 >= _FEWEST else open_
        if not len(open_):
            break
    return heights, places


def _first_of_highest(
    top: Floats, place: Floats, rows: Whole, heights: Floats, places: Floats
) -> tuple[Floats, Floats]:
    """Of all peaks of a row the first of those that are as high as the highest."""
    highest = top.copy()
    np.maximum.at(highest, rows, heights)
    alike = heights >= highest[rows] - ALIKE * np.abs(highest[rows])
    first = np.full(len(top), np.inf)
    np.minimum.at(first, rows[alike], places[alike])
    return highest, np.where(np.isfinite(first), first, place)
