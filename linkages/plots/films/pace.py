"""How fast a film may be: how often what moves swings between two of its frames."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from math import ceil, copysign, floor, log10
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from linkages.kernel.outputs import VARIABLES
from linkages.plots.films.film import FPS, LONGEST, Film, film_of
from linkages.solution.resolved import turning_points

if TYPE_CHECKING:
    import xarray as xr

    from linkages.solution.solution import Solution

MOST = 0.25
"""Swings between two frames beyond which they can no longer be followed."""

FEWEST_FRAMES = 12
"""Frames that a swing should have."""

SMOOTH_FRAMES = 24
"""Frames that a swing of an enlarged clearance has where it has a pace of its own."""

COMFORTABLE = 10.0
"""Seconds of a film that is suggested."""

LONGEST_ASKED = 60.0
"""Seconds of a film whose part of the motion is asked for, but not its pace."""


class Pace(NamedTuple):
    """How often something swings, or turns round, between two frames."""

    name: str
    rate: float
    turns: bool

    def between(self, film: Film) -> str:
        """How often it does between frames, and in a second of the motion, in words."""
        what = "turns" if self.turns else "swings"
        return f"{self.name} {self.rate:.2g} {what} ({self.rate / abs(film.step):.3g} per second)"


def paced(
    solution: Solution,
    *,
    start: float = 0.0,
    duration: float | None = None,
    slow: float | None = None,
    fps: float = FPS,
) -> Film:
    """Cut a motion into frames that show what moves fastest, unless a pace is asked for.

    Where a clearance swings too fast for the frames of the whole motion, its enlarged picture gets
    a slower pace. Where something else does, the film is slower, and shorter unless its duration
    is asked for.

    Parameters
    ----------
    solution
        Up to the end of the film.
    start, duration, slow, fps
        As `film_of` takes them.

    Raises
    ------
    ValueError
        For numbers that make no film.
    """
    last = float(solution.data["time"][-1])
    film = film_of(last, start=start, duration=duration, slow=slow, fps=fps)
    if slow is not None:
        return film
    rate = _greatest(pace for pace in paces(solution, film) if not _enlarged(solution, pace))
    if rate > MOST:
        slow = _rounded(film.slow * rate * FEWEST_FRAMES, ceil)
        shown = film.frames * abs(film.step)
        if duration is None:
            shown = min(shown, _rounded(LONGEST / slow, floor))
        if shown * slow <= LONGEST_ASKED:
            film = film_of(last, start=start, duration=shown, slow=slow, fps=fps)
    rate = _greatest(pace for pace in paces(solution, film) if _enlarged(solution, pace))
    if rate <= MOST:
        return film
    step = 1.0 / (_rounded(film.slow * rate * SMOOTH_FRAMES, ceil) * fps)
    return replace(film, near=replace(film, step=copysign(step, film.step)))


def paces(solution: Solution, film: Film) -> list[Pace]:
    """How often free and driven coordinates swing or turn, as far as the solution has them.

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
    return [pace for name in names for pace in _paces(shown, name, abs(film.step), moved)]


def _paces(data: xr.Dataset, variable: str, step: float, moved: set[str]) -> list[Pace]:
    (dimension,) = VARIABLES[variable].dims
    lasting = float(np.ptp(data["time"].to_numpy())) if data.sizes["time"] else 0.0
    found = []
    for name in data[dimension].values:
        values = np.asarray(data[variable].sel({dimension: name}), dtype=float)
        if name not in moved or not lasting:
            continue
        swings = turning_points(values) / 2
        turns = abs(values[-1] - values[0]) / (2 * np.pi) if VARIABLES[variable].angle else 0.0
        found.append(Pace(str(name), max(swings, turns) * step / lasting, turns > swings))
    return found


def fastest(solution: Solution, film: Film) -> Pace | None:
    """What swings or turns most often between the frames that show it."""
    enlarged = film if film.near is None else film.near
    found = [pace for pace in paces(solution, film) if not _enlarged(solution, pace)]
    found += [pace for pace in paces(solution, enlarged) if _enlarged(solution, pace)]
    return max(found, key=lambda pace: pace.rate, default=None)


def too_fast(solution: Solution, film: Film) -> str:
    """A note on what swings or turns too often between frames to be seen; empty if nothing does."""
    pace = fastest(solution, film)
    if pace is None or pace.rate <= MOST:
        return ""
    slow = _rounded(film.slow * pace.rate * FEWEST_FRAMES, ceil)
    left = abs(float(solution.data["time"][-1]) - film.start)
    part = left * slow > COMFORTABLE
    much = _rounded(COMFORTABLE / slow, floor) if part else left
    return (
        f"{pace.name} {'turns' if pace.turns else 'swings'} {pace.rate:.2g} times between frames, "
        f"which show it at random places; --slow {slow:g} shows it"
        f"{f', with --duration {much:g}' * part} in {slow * much:.2g} s"
    )


def _enlarged(solution: Solution, pace: Pace) -> bool:
    """Whether it is a coordinate of a clearance, which is seen enlarged only."""
    names = (clearance.name for clearance in solution.mechanism.clearances)
    return any(pace.name == name or pace.name.startswith(f"{name}.") for name in names)


def _greatest(found: Iterable[Pace]) -> float:
    return max((pace.rate for pace in found), default=0.0)


def _rounded(value: float, way: Callable[[float], int]) -> float:
    """One significant digit, up or down; round-off does not count."""
    unit = 10.0 ** floor(log10(value))
    return float(way(round(value / unit, 9)) * unit)
