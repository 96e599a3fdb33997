"""Which samples of a motion a page carries: enough to follow what swings fastest in it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.solution.resolved import samples_per_swing
from linkages.solution.solution import Solution, labelled
from linkages.solution.values.requests import REACTIONS, STATE, available, requested

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

BESIDE = (
    "joint_position", "bar_angle", "slider_position", "clearance_force", "clearance_angle",
    "clearance_offset", "clearance_state", "joint_reaction", "pin_reaction", "load_force",
    "load_torque", "spring_force", "torsional_spring_torque", "transmission_angle",
    "kinetic_energy", "potential_energy", "shaking_force", "shaking_moment",
)  # fmt: skip
"""Outputs that a page has besides the usual ones: what it draws, and what people ask for."""

PER_SWING = 10
"""Frames with which a swing can be followed."""

FEWEST, MOST = 600, 3000
NUMBERS = 156_000
"""All numbers of a page together, about: it stays at a few hundred kilobytes."""

ASIDE = 0.03
"""Of its range: what a series may do between two frames without its least and largest there."""

BANDS = 400
"""Stretches for which a page has the least and the largest value, at most: as many as pixels."""


def wanted(system: System, outputs: Iterable[str] | None = None) -> list[str]:
    """The outputs that a page shows: those asked for or the usual ones, and what it needs."""
    own = available(system)
    return list(
        dict.fromkeys([*requested(system, outputs), *(name for name in BESIDE if name in own)])
    )


def dense(solution: Solution) -> xr.Dataset:
    """Data of a solution with all that a page shows, at samples that show every swing."""
    given = [str(name) for name in solution.data.data_vars]
    names = wanted(solution.system, given)
    known = {*given, *REACTIONS, STATE}
    shown = [name for name in names if name in known or not VARIABLES[name].whole]
    close = solution.closely
    found = labelled(solution.system, close.motion, {name: close.values(name) for name in shown})
    return found.assign_attrs(solution.data.attrs)


def chosen(data: xr.Dataset) -> NDArray[np.intp]:
    """Indices of the samples that become frames, the first and the last among them."""
    samples = data.sizes["time"]
    series = sum(int(np.prod(array.shape[1:])) for array in data.data_vars.values())
    moving = [a for name, a in data.data_vars.items() if VARIABLES[str(name)].coordinate]
    swing = samples_per_swing(np.asarray(array, dtype=float) for array in moving)
    needed = PER_SWING * samples / swing if np.isfinite(swing) else 0.0
    most = int(np.clip(NUMBERS / max(series, 1), FEWEST, MOST))
    count = min(samples, most, max(FEWEST, int(np.ceil(needed))))
    return np.unique(np.linspace(0, samples - 1, count).round().astype(np.intp))


def bounds(values: Array, frames: NDArray[np.intp]) -> tuple[int, Array, Array] | None:
    """Least and largest value of stretches of so many frames, which is returned first.

    None where frames alone show the series, as they do mostly: nothing between two of them is
    aside of both by more than `ASIDE` of the range.
    """
    if len(frames) == len(values) or not np.isfinite(values).all():
        return None
    low, high = _between(values, frames)
    first, second = values[frames[:-1]], values[frames[1:]]
    aside = np.maximum(np.minimum(first, second) - low, high - np.maximum(first, second))
    if aside.max() <= ASIDE * np.ptp(values):
        return None
    stretch = -(-len(frames) // BANDS)
    return stretch, *_between(values, frames[[*range(0, len(frames) - 1, stretch), -1]])


def _between(values: Array, ends: NDArray[np.intp]) -> tuple[Array, Array]:
    """Least and largest value from each sample to the next one, both included."""
    last = values[ends[1:]]
    low = np.minimum(np.minimum.reduceat(values, ends[:-1]), last)
    return low, np.maximum(np.maximum.reduceat(values, ends[:-1]), last)
