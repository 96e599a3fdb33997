"""All local maxima of a series of one motion, located between its samples."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.solution.measuring.located import largest_between

Floats = NDArray[np.float64]


class Summits(NamedTuple):
    """Local maxima in the order of time, in samples from the first one, shape (maxima,) each."""

    place: Floats
    value: Floats


def summits(values: Floats, between: Callable[[Floats], Floats]) -> Summits:
    """Local maxima of a series, ends included.

    Parameters
    ----------
    values
        At the samples, shape (samples,).
    between
        Places in samples from the first one → values there.
    """
    last = len(values) - 1
    higher = np.isfinite(values)
    higher[1:] &= values[1:] >= values[:-1]
    higher[:-1] &= values[:-1] >= values[1:]
    tops = np.flatnonzero(higher)
    if last < 2 or not len(tops):
        return Summits(tops.astype(float), values[tops])
    first = np.clip(tops - 1, 0, last - 2)
    windows = values[first[:, None] + np.arange(3)]
    found = largest_between(windows, lambda which, places: between(first[which] + places))
    known = np.isfinite(found.value)
    places, kept = np.unique(np.where(known, first + found.place, tops), return_index=True)
    return Summits(places, np.where(known, found.value, values[tops])[kept])
