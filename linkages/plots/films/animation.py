"""Animations as GIF, WebP or MP4."""

from __future__ import annotations

import shutil
import struct
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import GifImagePlugin, Image

from linkages.interrupts import interrupts_kept
from linkages.plots.films.film import FPS, Film, paced, scenes
from linkages.plots.films.force_arrows import LOADS
from linkages.plots.films.force_arrows import loads as acting
from linkages.plots.films.force_arrows import reactions as supporting
from linkages.plots.films.stage import Stage
from linkages.reading.output_files import replaced
from linkages.solution.files import origin_of
from linkages.solution.series import REACTION, TIME, find_series, requested, system_series
from linkages.solution.solution import Solution
from linkages.stamps import stamp

Frame = NDArray[np.uint8]

COLOURS = 48  # of a GIF: few compress well, and pictures have few
FASTEST = 50.0  # frames per second; browsers show frames of less than 0.02 s much longer than that


def palette_of(frames: Sequence[Frame], colours: int = COLOURS) -> Image.Image:
    """An image whose palette shows frames well: frequent colours, and those far from the others."""
    whole = Image.fromarray(np.ascontiguousarray(np.vstack([f[..., :3] for f in frames])))
    return whole.quantize(colours, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)


def write_gif(path: Path, frames: Iterable[Frame], palette: Image.Image, fps: float) -> None:
    """Write a GIF that repeats for ever, frame by frame: nothing but changes, and none kept.

    `frames`: shape (height, width, 3 or 4) each, all of one size.
    `palette`: from `palette_of`, at most 255 colours.
    `fps`: frames per second, at most `FASTEST`. Times are rounded to 0.01 s without adding up.
    """
    colours = bytes(palette.getpalette() or [])[: 3 * (1 + int(np.asarray(palette).max()))]
    same = len(colours) // 3  # the index that stands for: as before
    before: NDArray[np.uint8] | None = None
    with path.open("wb") as file:
        for done, frame in enumerate(frames):
            shown = Image.fromarray(np.ascontiguousarray(frame[..., :3]))
            indices = np.asarray(shown.quantize(palette=palette, dither=Image.Dither.NONE))
            ends = [round(100 * count / fps) for count in (done, done + 1)]
            options = {"duration": 10 * (ends[1] - ends[0]), "disposal": 1}
            rows, columns, part = slice(0, None), slice(0, None), indices
            if before is None:
                height, width = indices.shape
                bits = max(1, same.bit_length())
                sizes = width, height, 0xF0 | (bits - 1), 0, 0
                file.write(struct.pack("<6sHHBBB", b"GIF89a", *sizes))
                file.write(colours.ljust(3 << bits, b"\0") + b"!\xff\x0bNETSCAPE2.0\x03\x01\0\0\0")
            else:
                changed = indices != before
                rows, columns = _span(changed.any(axis=1)), _span(changed.any(axis=0))
                part = np.where(changed, indices, np.uint8(same))[rows, columns]
                options["transparency"] = same
            image = Image.fromarray(np.ascontiguousarray(part))
            for data in GifImagePlugin.getdata(image, (columns.start, rows.start), **options):
                file.write(data)
            before = indices
        file.write(b";")


def _span(taken: NDArray[np.bool_]) -> slice:
    """From the first to the last that is taken; one if none is, for a frame cannot be empty."""
    places = np.flatnonzero(taken)
    return slice(int(places[0]), int(places[-1]) + 1) if len(places) else slice(0, 1)


QUALITY = "18"  # constant rate factor of H.264: lines stay sharp


def find_ffmpeg() -> str:
    """The path of ffmpeg."""
    result = shutil.which("ffmpeg")
    if result is None:
        raise ValueError(
            "MP4 needs the program ffmpeg, which was not found; install it "
            "(apt install ffmpeg, brew install ffmpeg, winget install ffmpeg) or write a GIF"
        )
    return result


def write_mp4(path: Path, frames: Iterable[Frame], size: tuple[int, int], fps: float) -> None:
    """Write a video of frames of shape (height, width, 4).

    `size`: width and height in pixels, both even.
    Raises OSError if ffmpeg fails; says why.
    """
    command = [
        find_ffmpeg(), "-y", "-loglevel", "error",
        "-f", "rawvideo", "-pix_fmt", "rgba", "-s", f"{size[0]}x{size[1]}", "-r", f"{fps:.9g}",
        "-i", "-", "-an", "-c:v", "libx264", "-crf", QUALITY, "-pix_fmt", "yuv420p",
        "-movflags", "+faststart", str(path),
    ]  # fmt: skip
    with tempfile.TemporaryFile() as messages:
        # apart from the terminal: Ctrl-C is ours to handle
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=messages,
            start_new_session=True,
        )  # fmt: skip
        assert process.stdin is not None
        broken = False
        try:
            for frame in frames:
                process.stdin.write(np.ascontiguousarray(frame).data)
            process.stdin.flush()
        except BrokenPipeError:
            broken = True
        except BaseException:
            process.kill()
            raise
        finally:
            with suppress(BrokenPipeError):
                process.stdin.close()
            process.wait()
        if broken or process.returncode:
            messages.seek(0)
            lines = messages.read().decode(errors="replace").strip().splitlines()
            raise OSError(f"ffmpeg failed: {lines[-1] if lines else 'it gave no reason'}")


METHOD, WEBP_QUALITY = 2, 20
"""How hard the encoder tries: more takes four times as long for a seventh less; nothing is lost."""


class _Frames(Image.Image):
    """Frames as one image of many: Pillow asks for them one after the other, and keeps none."""

    def __init__(self, frames: Iterator[Frame], count: int) -> None:
        super().__init__()
        self._frames = frames
        self.n_frames = count
        self._take()

    def _take(self) -> None:
        shown = Image.fromarray(np.ascontiguousarray(next(self._frames)[..., :3]))
        self.im, self._mode, self._size = shown.im, shown.mode, shown.size

    def tell(self) -> int:
        """Pillow returns to where it was."""
        return 0

    def seek(self, frame: int) -> None:
        """Take the next frame; the first one is there already."""
        if self._next == frame:
            self._take()
            self._next += 1

    _next = 1


def write_webp(path: Path, frames: Iterator[Frame], count: int, fps: float) -> None:
    """Write frames, without loss, as a WebP that repeats for ever.

    `frames`: shape (height, width, 3 or 4) each, all of one size.
    """
    ends = np.round(1000.0 * np.arange(count + 1) / fps).astype(int)
    image = _Frames(frames, count)
    durations = np.diff(ends).tolist()
    how = {"lossless": True, "quality": WEBP_QUALITY, "method": METHOD}
    how |= {"kmin": count, "kmax": count + 1, "duration": durations, "loop": 0}
    image.save(path, "WEBP", save_all=True, **how)


FORMATS = ("gif", "webp", "mp4")
LOOKS = 8  # frames from which the palette of a GIF is made
LARGEST = 4096  # pixels of a side


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
    also += LOADS if loads else ()
    also += requested(solution.system, [REACTION]) if reactions else ()
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
            if format_ == "webp":
                write_webp(temporary, frames(), film.frames, film.fps)
            elif format_ == "mp4":
                write_mp4(temporary, frames(), stage.size, film.fps)
            else:
                palette = stage_palette(stage, shown.places, shown.near)
                write_gif(temporary, frames(), palette, film.fps)
            origin = origin_of(solution.mechanism, solution.options)
            stamp(temporary, {"verb": "animate", **origin})
    return film


def check_arguments(
    format: str,  # noqa: A002
    fps: float,
    size: tuple[int, int] | None,
    dpi: float | None,
) -> str:
    """What can be said before a motion is known; returns the format."""
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


def stage_palette(stage: Stage, places: Sequence[int], near: Sequence[int]) -> Image.Image:
    """The palette of some of the pictures that a film shows."""
    looks = np.unique(np.linspace(0, len(places) - 1, LOOKS).round().astype(int))
    return palette_of([stage.picture(places[look], near[look]).copy() for look in looks])
