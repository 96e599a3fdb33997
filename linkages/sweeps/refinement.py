"""Grids that are computed only where neighbours differ."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Integers = NDArray[np.intp]
Mask = NDArray[np.bool_]

_SIDES: tuple[Literal["left", "right"], ...] = ("left", "right")


def refined(
    shape: tuple[int, int], step: int, labels: Callable[[Integers], Sequence[int]]
) -> Integers:
    """Compute a grid coarsely, then again in cells whose corners differ, down to single points.

    Every `step`-th row and column (a power of two) and the last ones are first. A cell with two
    different corners has all of them computed, so that the border of a region is followed also
    where coarser cells have missed it. What touches no corner of a coarse cell is missed. `labels`
    computes points, given by increasing indices of the flattened grid. Returns the index of the
    point whose result each point has, shape (rows · columns,).
    """
    source = np.full(shape, -1, dtype=np.intp)
    label = np.zeros(shape, dtype=np.int64)
    places = np.arange(source.size, dtype=np.intp).reshape(shape)

    def compute(wanted: Mask) -> bool:
        new = places[wanted & (source != places)]
        if new.size:
            label.flat[new] = labels(new)
            source.flat[new] = new
        return bool(new.size)

    rows, columns = (_lines(count, step) for count in shape)
    compute(_within(shape, rows, columns))
    while True:
        different = _different(label[np.ix_(rows, columns)])
        while compute(_within(shape, rows, columns) & _cells(shape, rows, columns, different)):
            different = _different(label[np.ix_(rows, columns)])
        if step == 1:
            return source.ravel()
        step //= 2
        finer = [_lines(count, step) for count in shape]
        new = _within(shape, *finer) & (source < 0)
        inside = _cells(shape, rows, columns, different)
        at = np.ix_(_before(rows, shape[0]), _before(columns, shape[1]))
        label[new & ~inside], source[new & ~inside] = (
            array[at][new & ~inside] for array in (label, source)
        )
        compute(new & inside)
        rows, columns = finer


def _lines(count: int, step: int) -> Integers:
    """Rows or columns of a coarser grid, from the first to the last; two at least."""
    return np.append(np.arange(0, max(count - 1, 1), step), count - 1)


def _within(shape: tuple[int, int], rows: Integers, columns: Integers) -> Mask:
    """Points of a coarser grid."""
    result = np.zeros(shape, dtype=bool)
    result[np.ix_(rows, columns)] = True
    return result


def _different(corners: NDArray[np.int64]) -> Mask:
    """Cells between rows and columns whose corners are not all alike."""
    first = corners[:-1, :-1]
    others = corners[1:, :-1], corners[:-1, 1:], corners[1:, 1:]
    return np.asarray(np.logical_or.reduce([other != first for other in others]))


def _cells(shape: tuple[int, int], rows: Integers, columns: Integers, cells: Mask) -> Mask:
    """Points within some cells, or on their borders."""
    result = np.zeros(shape, dtype=bool)
    for down in _touching(rows, shape[0]):
        for across in _touching(columns, shape[1]):
            result |= cells[np.ix_(down, across)]
    return result


def _touching(lines: Integers, count: int) -> list[Integers]:
    """The two cells that each row or column is in; they are the same one within a cell."""
    sides = [np.searchsorted(lines, np.arange(count), side=side) - 1 for side in _SIDES]
    return [np.clip(found, 0, len(lines) - 2) for found in sides]


def _before(lines: Integers, count: int) -> Integers:
    """The last line of a coarser grid that is not behind each line, shape (count,)."""
    return lines[np.searchsorted(lines, np.arange(count), side="right") - 1]
