"""Animations of solutions, as GIF or MP4."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.interrupts import interrupts_kept
from linkages.plots.films.film import FPS, Film, film_of
from linkages.plots.films.gif import FASTEST, GifFile, palette_of
from linkages.plots.films.stage import Stage
from linkages.plots.films.video import VideoFile, find_ffmpeg
from linkages.reading.replacing import replaced
from linkages.solution.solution import Solution

if TYPE_CHECKING:
    import xarray as xr

FORMATS = ("gif", "mp4")
DPI = 80.0
LOOKS = 8
"""Frames from which the palette of a GIF is made."""

TRACED = 4000
"""Samples that a trace has at most, besides those of the frames."""

LARGEST = 4096
"""Pixels of a side."""


def animate(
    solution: Solution,
    path: str | Path,
    *,
    start: float = 0.0,
    duration: float | None = None,
    slow: float | None = None,
    fps: float = FPS,
    size: tuple[int, int] | None = None,
    dpi: float = DPI,
    watch: Callable[[float], None] | None = None,
) -> Film:
    """Write an animation of a motion: the mechanism, traces of its joints, enlarged clearances.

    Every frame shows the sample that is nearest to its time, so samples should be as dense as
    frames; `simulate(mechanism, samples=2001)` is dense enough for most.

    Parameters
    ----------
    solution
        With ``joint_position`` among its outputs; cut short or not.
    path
        Ends in ``.gif`` or ``.mp4``; the latter needs the program ffmpeg. A file of that name is
        replaced when the new one is complete.
    start, duration
        Which part of the motion to show, in seconds of the motion; default: all of it.
    slow
        Seconds of the film per second of the motion: 10 is slow motion, 0.5 is twice as fast.
        Default: 1, or whatever makes the film last between 4 and 12 s.
    fps
        Frames per second of the film; a GIF has at most 50.
    size
        Width and height in pixels; default: as the mechanism needs, about 530 to 720 pixels wide.
    dpi
        Pixels per inch: size of texts and symbols.
    watch
        Called after every frame with the fraction done.

    Returns
    -------
    Film
        What is shown: ``start`` and ``step`` in seconds of the motion, ``frames``, ``fps``,
        ``slow``, ``seconds``.

    Raises
    ------
    ValueError
        For arguments that make no sense, and for MP4 without ffmpeg; nothing is written then.
    """
    path = Path(path)
    format_ = check_arguments(path.suffix.removeprefix(".").lower(), fps, size, dpi)
    time = np.asarray(solution.data["time"], dtype=float)
    if len(time) < 2:
        raise ValueError(f"an animation needs two samples or more, found {len(time)}")
    film = film_of(float(time[-1]), start=start, duration=duration, slow=slow, fps=fps)
    window, indices = shown_part(solution.data, film.samples(time))
    with interrupts_kept() as ask:
        stage = Stage(window, solution.mechanism, film, size, dpi)
        with (
            replaced(path) as temporary,
            _opened(temporary, format_, stage, film, indices) as file,
        ):
            for done, index in enumerate(indices, start=1):
                file.add(stage.picture(index))
                if watch is not None:
                    watch(done / len(indices))
                ask()
    return film


def shown_part(data: xr.Dataset, samples: NDArray[np.intp]) -> tuple[xr.Dataset, list[int]]:
    """Data of a film: the samples of its frames, and between them what traces need to be smooth.

    Parameters
    ----------
    data
        All samples.
    samples
        Those of the frames, in their order.

    Returns
    -------
    The data, and the places of the frames' samples in them.
    """
    first, last = int(samples[0]), int(samples[-1])
    between = np.linspace(first, last, min(last - first + 1, TRACED)).round().astype(np.intp)
    kept = np.union1d(samples, between)
    return data.isel(time=kept), [int(place) for place in np.searchsorted(kept, samples)]


def check_arguments(
    format: str,  # noqa: A002
    fps: float,
    size: tuple[int, int] | None,
    dpi: float,
) -> str:
    """What can be said before a motion is known; returns the format.

    Raises
    ------
    ValueError
        For arguments that make no sense, and for MP4 without ffmpeg.
    """
    if format not in FORMATS:
        raise ValueError(f"unknown format {format!r}; expected one of: {', '.join(FORMATS)}")
    if format == "mp4":
        find_ffmpeg()
    elif fps > FASTEST:
        raise ValueError(f"a GIF shows at most {FASTEST:g} frames per second, found {fps:g}")
    if not 20 <= dpi <= 1000:
        raise ValueError(f"dpi must be from 20 to 1000, found {dpi:g}")
    if size is not None and not all(2 <= side <= LARGEST for side in size):
        raise ValueError(f"size must be from 2 to {LARGEST} pixels, found {size[0]}x{size[1]}")
    return format


def _opened(
    path: Path, format_: str, stage: Stage, film: Film, indices: list[int]
) -> GifFile | VideoFile:
    if format_ == "mp4":
        return VideoFile(path, stage.size, film.fps)
    looks = np.unique(np.linspace(0, len(indices) - 1, LOOKS).round().astype(int))
    frames = [stage.picture(indices[look]).copy() for look in looks]
    return GifFile(path, palette_of(frames), film.fps)
