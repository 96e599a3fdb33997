"""Whether a film is slow enough to show what moves fastest in it."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil, floor, log10
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from linkages.kernel.outputs import VARIABLES
from linkages.plots.films.film import Film
from linkages.solution.resolved import turning_points

if TYPE_CHECKING:
    import xarray as xr

    from linkages.solution.solution import Solution

MOST = 0.25
"""Swings between two frames beyond which they can no longer be followed."""

FEWEST_FRAMES = 12
"""Frames that a swing should have."""

COMFORTABLE = 10.0
"""Seconds of a film that is suggested."""


class Pace(NamedTuple):
    """How often something swings, or turns round, between two frames."""

    name: str
    rate: float
    turns: bool


def fastest(solution: Solution, film: Film) -> Pace | None:
    """What moves fastest of the free and driven coordinates, as far as the solution has them.

    Parameters
    ----------
    solution
        Samples need not be dense: those that show every swing are computed.
    film
        Which part of it is shown.
    """
    names = [
        name for name, found in VARIABLES.items() if found.coordinate and name in solution.data
    ]
    data = solution.dense(names)
    first, last = sorted((film.start, film.start + film.frames * film.step))
    shown = data.isel(time=(data["time"] >= first) & (data["time"] <= last))
    moved = {*solution.system.topology.free, *solution.system.topology.driven}
    paces = [pace for name in names for pace in _paces(shown, name, film.frames, moved)]
    return max(paces, key=lambda pace: pace.rate, default=None)


def _paces(data: xr.Dataset, variable: str, frames: int, moved: set[str]) -> list[Pace]:
    (dimension,) = VARIABLES[variable].dims
    found = []
    for name in data[dimension].values:
        values = np.asarray(data[variable].sel({dimension: name}), dtype=float)
        if name not in moved or len(values) < 2:
            continue
        swings = turning_points(values) / 2
        turns = abs(values[-1] - values[0]) / (2 * np.pi) if VARIABLES[variable].angle else 0.0
        found.append(Pace(str(name), max(swings, turns) / frames, turns > swings))
    return found


def too_fast(solution: Solution, film: Film) -> str:
    """A note on what swings or turns too often between frames to be seen; empty if nothing does."""
    pace = fastest(solution, film)
    if pace is None or pace.rate <= MOST:
        return ""
    slow = _rounded(film.slow * pace.rate * FEWEST_FRAMES, ceil)
    much = _rounded(COMFORTABLE / slow, floor)
    return (
        f"{pace.name} {'turns' if pace.turns else 'swings'} {pace.rate:.2g} times between frames, "
        f"which show it at random places; --slow {slow:g} shows it, with --duration {much:g} "
        f"in {slow * much:.2g} s"
    )


def _rounded(value: float, way: Callable[[float], int]) -> float:
    """One significant digit, up or down; round-off does not count."""
    unit = 10.0 ** floor(log10(value))
    return float(way(round(value / unit, 9)) * unit)
