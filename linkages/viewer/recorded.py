"""A motion as the page stores it: frames and series."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.errors import InputError
from linkages.exports.writers.source_code import javascript_module
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.run_options import samples_per_swing
from linkages.solution.series import REACTIONS, STATE, TIME, available, data_series, requested
from linkages.solution.simulate import simulate
from linkages.solution.solution import Solution, labelled

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


Place = tuple[int, int]
"""Where an array begins among all numbers, and how many it has."""


class Packed:
    """Arrays one behind the other; `assets/unpack.js` reads their text."""

    def __init__(self) -> None:
        self._arrays: list[NDArray[np.float32]] = []
        self._count = 0

    def add(self, values: ArrayLike) -> Place:
        """Append an array, rounded to 32 bits; return its place."""
        with np.errstate(over="ignore"):  # what is beyond the range of 32 bits is infinite
            array = np.asarray(values, dtype=np.float64).ravel().astype(np.float32)
        self._arrays.append(array)
        place = (self._count, len(array))
        self._count += len(array)
        return place

    def add_exact(self, values: Sequence[float] | NDArray[np.float64]) -> tuple[Place, Place]:
        """Append an array as two: rounded, and what rounding took away."""
        exact = np.asarray(values, dtype=np.float64)
        rounded = exact.astype(np.float32)
        return self.add(rounded), self.add(exact - rounded)

    def text(self) -> str:
        """All of it, about half as long as plain base 64.

        Neighbours are alike, so what is compressed are differences of bit patterns, first all of
        their lowest bytes, then the next ones.
        """
        whole = np.concatenate([np.zeros(0, np.float32), *self._arrays]).view(np.uint32)
        steps = np.diff(whole, prepend=np.uint32(0))
        planes = steps.astype("<u4").view(np.uint8).reshape(-1, 4).T
        return deflated(planes.tobytes())


def deflated(data: bytes) -> str:
    """Bytes as compressed text, which `assets/unpack.js` reads."""
    return base64.b64encode(zlib.compress(data, 9)).decode("ascii")


PLACES = "joint_position"


def ideal_of(system: System) -> System | None:
    """The mechanism without clearances; None where there are none, or it cannot move alike."""
    if not system.mechanism.clearance_names:
        return None
    try:
        return System(system.mechanism.ideal())
    except InputError:  # without clearances it has no mobility left, or too much
        return None


def ideal_module(system: System, options: RunOptions) -> str:
    """Its module of JavaScript, with what deviations are measured against; empty for none."""
    ideal = ideal_of(system)
    if ideal is None:
        return ""
    compared = [VARIABLES[name].compared for name in available(system)]
    return javascript_module(ideal, options, [PLACES, *filter(None, compared)])


def recorded(data: xr.Dataset, system: System, packed: Packed) -> dict[str, Any]:
    """Frames of a motion.

    Returns
    -------
    ``time``, exactly, in two parts; ``series``, each with its values at the frames and, where
    those do not show it, its least and largest value of every ``stretch`` of frames; ``ghost``:
    joints of the same mechanism without clearances, where it has any; ``samples`` before frames
    were chosen.
    """
    frames = chosen(data)
    time = np.asarray(data["time"], dtype=float)
    series = []
    for name, found in data_series(data).items():
        if name == TIME or VARIABLES[found.variable].flags:
            continue
        values = np.asarray(found.of(data), dtype=float)
        between = bounds(values, frames)
        series.append(
            {
                "name": name,
                "values": packed.add(values[frames]),
                "bounds": None if between is None
                else {"stretch": between[0], "sides": [packed.add(side) for side in between[1:]]},
            }
        )  # fmt: skip
    return {
        "time": packed.add_exact(time[frames]),
        "samples": len(time),
        "series": series,
        "ghost": _ghost(time[frames], system, packed),
    }


def _ghost(time: np.ndarray[Any, Any], system: System, packed: Packed) -> Any:
    """The same motion without clearances; None where there are none, or it cannot move alike."""
    ideal = ideal_of(system)
    if ideal is None or ideal.topology.free:
        return None
    own = time[np.unique(np.linspace(0, len(time) - 1, FEWEST).round().astype(int))]
    moved = simulate(ideal.mechanism, times=own, outputs=[PLACES], throw=False)
    if not moved.completed:
        return None
    places = moved.data[PLACES].transpose("joint", "axis", "time")
    joints = {
        str(name): [packed.add(x), packed.add(y)]
        for name, (x, y) in zip(places["joint"].values, np.asarray(places), strict=True)
    }
    return {"time": packed.add_exact(own), "joints": joints}
