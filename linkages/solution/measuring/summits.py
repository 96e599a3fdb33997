"""All local maxima of a series of one motion, located between its samples."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.solution.measuring.located import largest_between
from linkages.solution.measuring.reduced import Source, series_values
from linkages.spec.formulas import Node
from linkages.spec.measures import Measure

Floats = NDArray[np.float64]

_REACH = 2
"""Samples on each side of a maximum among samples within which it is located."""


class Summits(NamedTuple):
    """Times and values of local maxima in the order of time, shape (maxima,) each."""

    time: Floats
    value: Floats


def summits(measure: Measure, node: Node, source: Source, sign: float = 1.0) -> Summits:
    """Local maxima of a series of one motion, ends included.

    Parameters
    ----------
    measure, node
        The measure, and the part of its tree that changes with time.
    source
        One motion.
    sign
        −1 for the maxima of the negative.
    """
    (values,) = sign * series_values(measure, node, source)
    last = len(values) - 1
    higher = np.ones(len(values), dtype=bool)
    higher[1:] &= values[1:] >= values[:-1]
    higher[:-1] &= values[:-1] >= values[1:]
    tops = np.flatnonzero(higher & np.isfinite(values))
    if last < 2 * _REACH:
        return Summits(source.time[tops], values[tops])
    first = np.clip(tops - _REACH, 0, last - 2 * _REACH)
    windows = values[first[:, None] + np.arange(2 * _REACH + 1)]

    def between(which: NDArray[np.int64], places: Floats) -> Floats:
        within = np.clip(first[which] + places, 0.0, last)
        return sign * series_values(measure, node, source, np.zeros_like(which), within)

    found = largest_between(windows, between)
    times = np.interp(first + found.place, np.arange(last + 1), source.time)
    kept = np.unique(times, return_index=True)[1]
    return Summits(times[kept], found.value[kept])
