"""The data that frames of a film show: a motion at the times of its frames, and traces between."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.plots.films.film import Film
from linkages.solution.values.requests import requested

if TYPE_CHECKING:
    import xarray as xr

    from linkages.solution.solution import Solution

SHOWN = (
    "joint_position", "bar_angle", "slider_position", "clearance_force", "clearance_angle",
    "clearance_offset", "offset_position",
)  # fmt: skip
"""What a picture needs, and what says how fast it moves; nothing else is computed."""

TRACED = 2000
"""Times that a trace has at least, besides those of the frames: it is a smooth line."""

MOST_EVALUATIONS = 20_000_000
"""A motion that took more is not computed again: that would take seconds."""

SAME = 1e-6
"""Of the time between frames: times no farther apart are one."""


class Scenes(NamedTuple):
    """What frames show.

    Attributes
    ----------
    data
        A motion.
    places, near
        Which sample each frame shows, and its enlarged clearances.
    """

    data: xr.Dataset
    places: list[int]
    near: list[int]


def scenes(solution: Solution, film: Film, also: Collection[str] = ()) -> Scenes:
    """A motion at the times of a film, from its integrator's own interpolation.

    Data that were interrupted, or would take many seconds to compute again, are shown at the
    samples that are nearest.

    Parameters
    ----------
    solution
        Up to the end of the film.
    film
        What is shown.
    also
        Variables besides those that pictures need.
    """
    near = film if film.near is None else film.near
    between = np.linspace(film.times[0], film.times[-1], TRACED)
    if _computed_again(solution):
        data = _at(solution, np.concatenate([film.times, near.times, between]), film, also)
    else:
        data = _kept(solution.data, film, near)
    time = data["time"]
    return Scenes(data, film.samples(time).tolist(), near.samples(time).tolist())


def _computed_again(solution: Solution) -> bool:
    long = solution.motion.cost.get("evaluations", 0) > MOST_EVALUATIONS
    return not (solution.motion.interrupted or long) and "joint_position" in solution.data


def _at(
    solution: Solution, times: NDArray[np.float64], film: Film, also: Collection[str]
) -> xr.Dataset:
    """The same motion at other times; it starts where it started."""
    from linkages.solution.simulate import simulate

    given = solution.options
    for name in ("end", "samples", "times", "events"):
        given.pop(name, None)
    possible = requested(solution.system, "all")
    given["outputs"] = [name for name in dict.fromkeys([*SHOWN, *also]) if name in possible]
    first = float(solution.data["time"][0])
    way = np.sign(film.step)
    wanted = np.unique(way * np.concatenate([[first], times]))
    apart = np.diff(wanted) > SAME * abs(film.step if film.near is None else film.near.step)
    wanted = way * wanted[np.concatenate([[True], apart])]
    data = simulate(solution.mechanism, times=wanted, **given, throw=False).data
    return data.isel(time=slice(1, None)) if abs(film.start - first) > 0 else data


def _kept(data: xr.Dataset, film: Film, near: Film) -> xr.Dataset:
    """Samples of frames, and between them what traces need to be smooth."""
    time = data["time"]
    samples = film.samples(time)
    first, last = int(samples[0]), int(samples[-1])
    between = np.linspace(first, last, min(last - first + 1, 2 * TRACED)).round().astype(np.intp)
    return data.isel(time=np.union1d(np.union1d(samples, near.samples(time)), between))
