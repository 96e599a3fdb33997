"""How many samples show every oscillation of a motion."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

PER_SWING = 40.0
"""Samples per oscillation with which its peak is at most 0.3 % above the highest sample."""

MOST_SAMPLES = 100_000
"""Of a motion that measures look at; one with more would take seconds."""

STEADY = 1e-6
"""Of the largest magnitude: what changes less between samples does not move."""


def turning_points(values: NDArray[np.float64]) -> int:
    """How often a series changes between rising and falling; round-off does not count."""
    finite = values[np.isfinite(values)]
    if len(finite) < 3:
        return 0
    steps = np.diff(finite)
    slopes = np.sign(steps[np.abs(steps) > STEADY * np.abs(finite).max()])
    return int(np.count_nonzero(slopes[1:] * slopes[:-1] < 0))


def swings(series: Iterable[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Samples per oscillation of each element of series; infinite where it does not turn twice.

    Parameters
    ----------
    series
        Shape (samples, …) each.
    """
    found = []
    for values in series:
        for column in values.reshape(len(values), -1).T if values.size else ():
            turns = turning_points(column)
            found.append(2.0 * len(values) / turns if turns > 1 else np.inf)
    return np.array(found)


def samples_per_swing(series: Iterable[NDArray[np.float64]]) -> float:
    """Samples per oscillation of the element that oscillates most, like `swings`."""
    return float(np.min(swings(series), initial=np.inf))
