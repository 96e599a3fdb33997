"""Which samples of a solution an animation shows, and how fast."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

FPS = 25.0
SLOWEST = 0.01
"""Frames per second; a GIF cannot show a frame for much longer."""

SHORTEST, LONGEST = 4.0, 12.0
"""Seconds that an animation lasts whose pace nobody asked for."""

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

        Parameters
        ----------
        time
            Sample times in seconds; they rise, or fall in a motion that goes back in time.
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

    Parameters
    ----------
    last
        Where the motion ends, in seconds; negative for one that goes back in time.
    start, duration
        Which part of it to show, in seconds of the motion; all that follows if no duration is said.
    slow
        Seconds of the film per second of the motion; if not given, 1, or what makes the film last
        from `SHORTEST` to `LONGEST`, roughly.
    fps
        Frames per second of the film.

    Raises
    ------
    ValueError
        For numbers that make no film.
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

    Parameters
    ----------
    duration
        Of the motion, in seconds.
    """
    if SHORTEST <= duration <= LONGEST:
        return 1.0
    wanted = (SHORTEST if duration < SHORTEST else LONGEST) / duration
    power = 10.0 ** np.floor(np.log10(wanted) + 1e-9)
    steps = (1.0, 2.0, 5.0, 10.0)
    if wanted > 1.0:
        return float(next(s for s in steps if s * power >= wanted * (1 - 1e-9)) * power)
    return float(next(s for s in reversed(steps) if s * power <= wanted * (1 + 1e-9)) * power)
