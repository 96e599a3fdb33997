"""Samples that are dense enough to show every swing of a motion."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray as xr

    from linkages.solution.solution import Solution

PER_SWING = 40.0
"""Samples of a swing with which its top is at most 0.3 % above the highest sample."""

MOST_SAMPLES = 100_000
MOST_EVALUATIONS = 20_000_000
"""A motion that took more is not computed again: that would take seconds."""

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


def per_swing(data: xr.Dataset, names: Sequence[str]) -> float:
    """Samples per swing of the series that swings most; infinite where none turns twice.

    Parameters
    ----------
    data
        Its first dimension is time.
    names
        Of variables.
    """
    most = 0
    for name in names:
        values = np.asarray(data[name], dtype=float)
        if values.size:
            most = max([most, *map(turning_points, values.reshape(len(values), -1).T)])
    return np.inf if most < 2 else 2.0 * data.sizes["time"] / most


def resolved(solution: Solution, names: Sequence[str], also: Sequence[str] = ()) -> xr.Dataset:
    """Variables of a solution at samples that show every swing.

    Parameters
    ----------
    solution
        Its own data are returned if they show every swing already, and where the motion was
        interrupted, is too long to be computed again, or was sampled at times of one's own.
    names
        Of outputs.
    also
        Of further outputs, whose swings do not matter.
    """
    from linkages.solution.simulate import simulate

    data, given = solution.data, solution.options
    long = solution.motion.cost.get("evaluations", 0) > MOST_EVALUATIONS
    if solution.motion.interrupted or long or not names or "samples" not in given:
        return data
    while (factor := _factor(solution, data, names)) > 1:
        count = (given["samples"] - 1) * factor + 1
        if count > MOST_SAMPLES:
            break
        given |= {"samples": count, "outputs": [*names, *also]}
        data = simulate(solution.mechanism, **given, throw=False).data
    return data.assign_attrs(solution.data.attrs)


def _factor(solution: Solution, data: xr.Dataset, names: Sequence[str]) -> int:
    """How many times denser samples should be: by the swings that they show, and by its steps.

    An adaptive method takes several steps per swing, so that samples which are closer than its
    steps pass over none.
    """
    found = per_swing(data, names)
    factor = ceil(PER_SWING / found) if np.isfinite(found) else 1
    if solution.settings.run.step is None:
        factor = max(factor, ceil(solution.motion.cost.get("steps", 0) / data.sizes["time"]))
    return factor
