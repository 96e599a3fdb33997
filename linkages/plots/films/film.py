"""Samples of a solution that an animation shows, and at which speed."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from math import ceil, copysign, floor, log10
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.kernel.outputs import VARIABLES
from linkages.solution.run_options import turning_points
from linkages.solution.series import requested

if TYPE_CHECKING:
    import xarray as xr

    from linkages.solution.solution import Solution

FPS = 25.0
SLOWEST = 0.01  # frames per second; a GIF cannot show a frame for much longer
SHORTEST, LONGEST = 4.0, 12.0  # seconds that an animation lasts whose pace nobody asked for
MOST_FRAMES = 20_000


@dataclass(frozen=True)
class Film:
    """Part of a motion, cut into frames.

    Parameters
    ----------
    start
        Simulated time of the first frame in seconds.
    step
        Simulated time between frames in seconds.
    frames
        How many there are.
    fps
        Frames per second of the film.
    near
        What enlarged clearances show meanwhile, where they are slower than the mechanism.
    """

    start: float
    step: float
    frames: int
    fps: float
    near: Film | None = None

    @property
    def slow(self) -> float:
        """Seconds of the film per second of the motion."""
        return 1.0 / (self.fps * abs(self.step))

    @property
    def seconds(self) -> float:
        """How long the film lasts."""
        return self.frames / self.fps

    @property
    def times(self) -> NDArray[np.float64]:
        """Simulated times of the frames, shape (frames,)."""
        return np.asarray(self.start + self.step * np.arange(self.frames), dtype=float)

    @property
    def pace(self) -> str:
        """How fast the motion is shown, in words."""
        if abs(self.slow - 1.0) < 5e-4:
            return "real time"
        if self.slow > 1.0:
            return f"slowed down {self.slow:.4g}×"
        return f"sped up {1.0 / self.slow:.4g}×"

    def samples(self, time: ArrayLike) -> NDArray[np.intp]:
        """The sample nearest to each frame, shape (frames,).

        `time`: of samples in seconds; they rise, or fall in a motion that goes back in time.
        """
        forward = np.sign(self.step) * np.asarray(time, dtype=float)
        wanted = np.sign(self.step) * self.times
        after = np.clip(np.searchsorted(forward, wanted), 1, max(1, len(forward) - 1))
        before = after - 1
        after = np.minimum(after, len(forward) - 1)
        nearer = wanted - forward[before] <= forward[after] - wanted
        return np.asarray(np.where(nearer, before, after), dtype=np.intp)


def film_of(
    last: float,
    *,
    start: float = 0.0,
    duration: float | None = None,
    slow: float | None = None,
    fps: float = FPS,
) -> Film:
    """Cut a motion from 0 to `last` into frames; its very end is left out, so that turns repeat.

    `last`: where the motion ends, in seconds; negative for one that goes back in time.
    `start`, `duration`: which part of it to show, in seconds of the motion; all that follows if no
    duration is said.
    `slow`: seconds of the film per second of the motion; if not given, 1, or what makes the film
    last from `SHORTEST` to `LONGEST`, roughly.
    """
    if duration is not None and not 0 < duration < np.inf:
        raise ValueError(f"duration must be > 0 s, found {duration:g}")
    left = abs(last) - abs(start)
    if not np.isfinite(start) or left <= 0 or start * last < 0:
        raise ValueError(f"start must be a time from 0 to before {last:g} s, found {start:g}")
    shown = left if duration is None else duration
    if shown > left * (1 + 1e-9):
        raise ValueError(f"duration reaches beyond the end of the motion at {last:g} s: {shown:g}")
    slow = natural_pace(shown) if slow is None else slow
    if not 0 < slow < np.inf:
        raise ValueError(f"slow must be > 0, found {slow:g}")
    if not SLOWEST <= fps < np.inf:
        raise ValueError(f"fps must be at least {SLOWEST:g}, found {fps:g}")
    count = shown * slow * fps
    if count > MOST_FRAMES:
        raise ValueError(
            f"{count:.6g} frames are more than {MOST_FRAMES}; show less, faster, or fewer a second"
        )
    frames = max(1, round(count))
    return Film(start, float(np.copysign(1.0 / (slow * fps), last)), frames, fps)


def natural_pace(duration: float) -> float:
    """How much to slow a motion down so that it can be followed: 1, 2, 5, 10, …, or a half, ….

    `duration`: of the motion, in seconds.
    """
    if SHORTEST <= duration <= LONGEST:
        return 1.0
    wanted = (SHORTEST if duration < SHORTEST else LONGEST) / duration
    power = 10.0 ** np.floor(np.log10(wanted) + 1e-9)
    steps = (1.0, 2.0, 5.0, 10.0)
    if wanted > 1.0:
        return float(next(s for s in steps if s * power >= wanted * (1 - 1e-9)) * power)
    return float(next(s for s in reversed(steps) if s * power <= wanted * (1 + 1e-9)) * power)


SHOWN = (
    "joint_position", "bar_angle", "slider_position", "clearance_force", "clearance_angle",
    "clearance_offset", "offset_position",
)  # fmt: skip
"""What a picture needs, and what says how fast it moves; nothing else is computed."""

TRACED = 2000  # times that a trace has at least, besides those of the frames: it is a smooth line
MOST_EVALUATIONS = 20_000_000
"""A motion that took more is not computed again: that would take seconds."""

SAME = 1e-6  # of the time between frames: times no farther apart are one


class Scenes(NamedTuple):
    """What frames show."""

    data: xr.Dataset  # a motion
    places: list[int]  # which sample each frame shows
    near: list[int]  # the same of its enlarged clearances


def scenes(solution: Solution, film: Film, also: Collection[str] = ()) -> Scenes:
    """A motion at the times of a film, from its integrator's own interpolation.

    Data that were interrupted, or would take many seconds to compute again, are shown at the
    samples that are nearest.
    """
    near = film if film.near is None else film.near
    between = np.linspace(film.times[0], film.times[-1], TRACED)
    long = solution.motion.cost.get("evaluations", 0) > MOST_EVALUATIONS
    if not (solution.motion.interrupted or long) and "joint_position" in solution.data:
        data = _at(solution, np.concatenate([film.times, near.times, between]), film, also)
    else:
        data = _kept(solution.data, film, near)
    time = data["time"]
    return Scenes(data, film.samples(time).tolist(), near.samples(time).tolist())


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


MOST = 0.25  # swings between two frames beyond which they can no longer be followed
FEWEST_FRAMES = 12  # frames that a swing should have
SMOOTH_FRAMES = 24
"""Frames that a swing of an enlarged clearance has where it has a pace of its own."""

COMFORTABLE = 10.0  # seconds of a film that is suggested
LONGEST_ASKED = 60.0  # seconds of a film whose part of the motion is asked for, but not its pace


class Pace(NamedTuple):
    """How often something swings, or turns round, between two frames."""

    name: str
    rate: float
    turns: bool
    enlarged: bool  # whether it is a coordinate of a clearance, which is seen enlarged only

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
    """
    last = float(solution.data["time"][-1])
    film = film_of(last, start=start, duration=duration, slow=slow, fps=fps)
    if slow is not None:
        return film
    rate = max((pace.rate for pace in paces(solution, film) if not pace.enlarged), default=0.0)
    if rate > MOST:
        slow = _rounded(film.slow * rate * FEWEST_FRAMES, ceil)
        shown = film.frames * abs(film.step)
        if duration is None:
            shown = min(shown, _rounded(LONGEST / slow, floor))
        if shown * slow <= LONGEST_ASKED:
            film = film_of(last, start=start, duration=shown, slow=slow, fps=fps)
    rate = max((pace.rate for pace in paces(solution, film) if pace.enlarged), default=0.0)
    if rate <= MOST:
        return film
    step = 1.0 / (_rounded(film.slow * rate * SMOOTH_FRAMES, ceil) * fps)
    return replace(film, near=replace(film, step=copysign(step, film.step)))


def paces(solution: Solution, film: Film) -> list[Pace]:
    """How often free and driven coordinates swing or turn, as far as the solution has them."""
    names = [name for name, item in VARIABLES.items() if item.coordinate and name in solution.data]
    data = solution.dense(names)
    first, last = sorted((film.start, film.start + film.frames * film.step))
    shown = data.isel(time=(data["time"] >= first) & (data["time"] <= last))
    lasting = float(np.ptp(shown["time"].to_numpy())) if shown.sizes["time"] else 0.0
    moved = {*solution.system.topology.free, *solution.system.topology.driven}
    clearances = {clearance.name for clearance in solution.mechanism.clearances}
    result = []
    for variable in names if lasting else ():
        (dimension,) = VARIABLES[variable].dims
        for name in (name for name in map(str, shown[dimension].values) if name in moved):
            values = np.asarray(shown[variable].sel({dimension: name}), dtype=float)
            swings = turning_points(values) / 2
            whole = abs(values[-1] - values[0]) / (2 * np.pi) if VARIABLES[variable].angle else 0.0
            rate, enlarged = max(swings, whole) * abs(film.step) / lasting, name.split(".")[0]
            result.append(Pace(name, rate, whole > swings, enlarged in clearances))
    return result


def fastest(solution: Solution, film: Film) -> Pace | None:
    """What swings or turns most often between the frames that show it."""
    enlarged = film if film.near is None else film.near
    result = [pace for pace in paces(solution, film) if not pace.enlarged]
    result += [pace for pace in paces(solution, enlarged) if pace.enlarged]
    return max(result, key=lambda pace: pace.rate, default=None)


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


def _rounded(value: float, way: Callable[[float], int]) -> float:
    """One significant digit, up or down; round-off does not count."""
    unit = 10.0 ** floor(log10(value))
    return float(way(round(value / unit, 9)) * unit)
