"""Animations as GIF, WebP or MP4."""

from __future__ import annotations

import shutil
import struct
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from linkages.interrupts import interrupts_kept
from linkages.plots.films.film import FPS, Film, Scenes, paced, scenes
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


class GifFile:
    """A GIF that repeats for ever, written frame by frame: nothing but changes, and none kept.

    `path`: where to write.
    `palette`: from `palette_of`, at most 255 colours.
    `fps`: frames per second, at most `FASTEST`. Times are rounded to 0.01 s without adding up.
    """

    def __init__(self, path: Path, palette: Image.Image, fps: float) -> None:
        self._file = path.open("wb")
        self._palette = palette
        colours = palette.getpalette() or []
        self._table = bytes(colours[: 3 * (1 + int(np.asarray(palette).max()))])
        self._clear = len(self._table) // 3  # the index that stands for: as before
        self._fps = fps
        self._written = 0
        self._shown: NDArray[np.uint8] | None = None

    def __enter__(self) -> GifFile:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is None:
            self._file.write(b";")
        self._file.close()

    def add(self, frame: Frame) -> None:
        """Append a frame, shape (height, width, 3 or 4); all of one size."""
        shown = Image.fromarray(np.ascontiguousarray(frame[..., :3]))
        plain = shown.quantize(palette=self._palette, dither=Image.Dither.NONE)
        indices = np.asarray(plain)
        if self._shown is None:
            self._file.write(self._header(*indices.shape))
            self._write(indices, (0, 0), None)
        else:
            changed = indices != self._shown
            rows, columns = _span(changed.any(axis=1)), _span(changed.any(axis=0))
            part = np.where(changed, indices, np.uint8(self._clear))[rows, columns]
            self._write(part, (columns.start, rows.start), self._clear)
        self._shown = indices
        self._written += 1

    def _header(self, height: int, width: int) -> bytes:
        bits = max(1, int(self._clear).bit_length())
        table = self._table.ljust(3 << bits, b"\0")
        screen = struct.pack("<6sHHBBB", b"GIF89a", width, height, 0xF0 | (bits - 1), 0, 0)
        return screen + table + b"!\xff\x0bNETSCAPE2.0\x03\x01\0\0\0"

    def _write(self, part: Frame, offset: tuple[int, int], clear: int | None) -> None:
        from PIL import GifImagePlugin, Image

        begin, end = self._written / self._fps, (self._written + 1) / self._fps
        options = {"duration": 10 * (round(100 * end) - round(100 * begin)), "disposal": 1}
        if clear is not None:
            options["transparency"] = clear
        image = Image.fromarray(np.ascontiguousarray(part))
        for data in GifImagePlugin.getdata(image, offset, **options):
            self._file.write(data)


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


class VideoFile:
    """A video, written frame by frame.

    `path`: where to write; ends in ``.mp4``.
    `size`: width and height in pixels, both even.
    `fps`: frames per second.
    Raises ValueError if ffmpeg is not installed.
    """

    def __init__(self, path: Path, size: tuple[int, int], fps: float) -> None:
        command = [
            find_ffmpeg(), "-y", "-loglevel", "error",
            "-f", "rawvideo", "-pix_fmt", "rgba", "-s", f"{size[0]}x{size[1]}", "-r", f"{fps:.9g}",
            "-i", "-", "-an", "-c:v", "libx264", "-crf", QUALITY, "-pix_fmt", "yuv420p",
            "-movflags", "+faststart", str(path),
        ]  # fmt: skip
        self._messages = tempfile.TemporaryFile()  # noqa: SIM115 — closed on leaving
        # apart from the terminal: Ctrl-C is ours to handle
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=self._messages,
            start_new_session=True,
        )

    def __enter__(self) -> VideoFile:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is not None:
            self._process.kill()
        self._finish()
        said = self._said()
        self._messages.close()
        if kind is None and self._process.returncode:
            raise OSError(f"ffmpeg failed: {said}")

    def add(self, frame: Frame) -> None:
        """Append a frame, shape (height, width, 4).

        Raises OSError if ffmpeg has ended; says why.
        """
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(np.ascontiguousarray(frame).data)
        except BrokenPipeError:
            self._process.wait()
            raise OSError(f"ffmpeg failed: {self._said()}") from None

    def _finish(self) -> None:
        assert self._process.stdin is not None
        with suppress(BrokenPipeError):  # its exit code says that it failed
            self._process.stdin.close()
        self._process.wait()

    def _said(self) -> str:
        self._messages.seek(0)
        lines = self._messages.read().decode(errors="replace").strip().splitlines()
        return lines[-1] if lines else "it gave no reason"


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


def _write(
    path: Path, form: str, stage: Stage, shown: Scenes, film: Film, frames: Iterator[Frame]
) -> None:
    """Write frames in a format; all are taken, also the last one's end."""
    if form == "webp":
        write_webp(path, frames, film.frames, film.fps)
        return
    file: GifFile | VideoFile
    if form == "mp4":
        file = VideoFile(path, stage.size, film.fps)
    else:
        file = GifFile(path, stage_palette(stage, shown.places, shown.near), film.fps)
    with file:
        for frame in frames:
            file.add(frame)


def stage_palette(stage: Stage, places: Sequence[int], near: Sequence[int]) -> Image.Image:
    """The palette of some of the pictures that a film shows."""
    looks = np.unique(np.linspace(0, len(places) - 1, LOOKS).round().astype(int))
    return palette_of([stage.picture(places[look], near[look]).copy() for look in looks])
