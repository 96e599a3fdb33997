"""Animations of solutions, as GIF, WebP or MP4."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from linkages.interrupts import interrupts_kept
from linkages.plots.films.film import FPS, Film
from linkages.plots.films.gif import FASTEST, Frame, GifFile, palette_of
from linkages.plots.films.loads import LOADS
from linkages.plots.films.loads import loads as acting
from linkages.plots.films.loads import reactions as supporting
from linkages.plots.films.pace import paced
from linkages.plots.films.scenes import Scenes, scenes
from linkages.plots.films.stage import Stage
from linkages.plots.films.video import VideoFile, find_ffmpeg
from linkages.plots.films.webp import write_webp
from linkages.reading.replacing import replaced
from linkages.solution.origin import origin_of
from linkages.solution.solution import Solution
from linkages.solution.values.requests import REACTION, requested
from linkages.solution.values.series import TIME, find_series, system_series
from linkages.stamps import stamp

FORMATS = ("gif", "webp", "mp4")
LOOKS = 8
"""Frames from which the palette of a GIF is made."""

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
    dpi: float | None = None,
    names: bool = False,
    plot: Sequence[str] = (),
    loads: bool = False,
    reactions: Sequence[str] = (),
    bare: bool = False,
    watch: Callable[[float], None] | None = None,
) -> Film:
    """Write an animation of a motion: the mechanism, traces of its joints, enlarged clearances.

    Frames show the motion at their times, however the solution was sampled.

    Parameters
    ----------
    solution
        With ``joint_position`` among its outputs; cut short or not.
    path
        Ends in ``.gif``, ``.webp`` or ``.mp4``; the latter needs the program ffmpeg. A file of that
        name is replaced when the new one is complete.
    start, duration
        Which part of the motion to show, in seconds of the motion; default: all of it, or as much
        as can be followed within 12 s.
    slow
        Seconds of the film per second of the motion: 10 is slow motion, 0.5 is twice as fast.
        Default: what makes the film last between 4 and 12 s, and slower where a free or driven
        coordinate swings so fast that frames would show it at random places. Clearances that
        swing faster than the mechanism moves have a pace of their own.
    fps
        Frames per second of the film; a GIF has at most 50.
    size
        Width and height in pixels; default: as the mechanism needs, about 790 to 1240 pixels wide.
    dpi
        Pixels per inch: size of texts and symbols; default: they grow with `size`.
    names
        Write the names of joints beside them.
    plot
        Series such as ``"crank.effort"``, each drawn over time in a strip with a cursor.
    loads
        Draw forces and torques from outside as arrows, as large as they are at the time; the scale
        stays the same, and is written below.
    reactions
        Joints whose reactions are drawn, to the same scale.
    bare
        Show mechanism and clearances alone, without axes and texts, and without the room for these.
    watch
        Called after every frame with the fraction done.

    Returns
    -------
    Film
        What is shown: ``start`` and ``step`` in seconds of the motion, ``frames``, ``fps``,
        ``slow``, ``seconds``, and ``near``, the same of clearances that have their own pace.

    Raises
    ------
    ValueError
        For arguments that make no sense, and for MP4 without ffmpeg; nothing is written then.
    """
    path = Path(path)
    format_ = check_arguments(path.suffix.removeprefix(".").lower(), fps, size, dpi)
    samples = solution.data.sizes["time"]
    if samples < 2:
        raise ValueError(f"an animation needs two samples or more, found {samples}")
    film = paced(solution, start=start, duration=duration, slow=slow, fps=fps)
    known = system_series(solution.system)
    drawn = [find_series(known, name) for name in plot]
    also = [series.variable for series in drawn if series.variable != TIME]
    also += [
        *(LOADS if loads else ()),
        *(requested(solution.system, [REACTION]) if reactions else ()),
    ]
    shown = scenes(solution, film, also)
    pushes = acting(shown.data, solution.system) if loads else []
    pushes += supporting(shown.data, reactions)
    with interrupts_kept() as ask:
        stage = Stage(
            shown.data, solution.mechanism, film, size, dpi, names=names,
            strips=[(series.name, series.of(shown.data)) for series in drawn], pushes=pushes,
            bare=bare,
        )  # fmt: skip

        def frames() -> Iterator[Frame]:
            for done, (place, near) in enumerate(zip(shown.places, shown.near, strict=True), 1):
                yield stage.picture(place, near)
                if watch is not None:
                    watch(done / film.frames)
                ask()

        with replaced(path) as temporary:
            _write(temporary, format_, stage, shown, film, frames())
            origin = origin_of(solution.mechanism, solution.options)
            stamp(temporary, {"verb": "animate", **origin})
    return film


def check_arguments(
    format: str,  # noqa: A002
    fps: float,
    size: tuple[int, int] | None,
    dpi: float | None,
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
    elif format == "gif" and fps > FASTEST:
        raise ValueError(f"a GIF shows at most {FASTEST:g} frames per second, found {fps:g}")
    if dpi is not None and not 20 <= dpi <= 1000:
        raise ValueError(f"dpi must be from 20 to 1000, found {dpi:g}")
    if size is not None and not all(2 <= side <= LARGEST for side in size):
        raise ValueError(f"size must be from 2 to {LARGEST} pixels, found {size[0]}x{size[1]}")
    return format


def _write(
    path: Path, form: str, stage: Stage, shown: Scenes, film: Film, frames: Iterator[Frame]
) -> None:
    """Write frames in a format; all are taken, also the last one's end."""
    if form == "webp":
        write_webp(path, frames, film.frames, film.fps)
        return
    with _opened(path, form, stage, shown, film) as file:
        for frame in frames:
            file.add(frame)


def _opened(path: Path, form: str, stage: Stage, shown: Scenes, film: Film) -> GifFile | VideoFile:
    if form == "mp4":
        return VideoFile(path, stage.size, film.fps)
    looks = np.unique(np.linspace(0, film.frames - 1, LOOKS).round().astype(int))
    seen = [stage.picture(shown.places[look], shown.near[look]).copy() for look in looks]
    return GifFile(path, palette_of(seen), film.fps)
