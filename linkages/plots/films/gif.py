"""Animated GIFs of drawings: one palette for all frames, and of each frame only what changed."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

Frame = NDArray[np.uint8]
Palette = NDArray[np.uint8]

COLOURS = 32
SEEN = 6
"""Pixels that a shade needs in the sampled frames to count."""

FASTEST = 50.0
"""Frames per second; browsers show frames of less than 0.02 s much longer than that."""

_SHADES = 1 << 15  # five bits of red, green and blue


def shades(frame: Frame) -> NDArray[np.intp]:
    """Red, green and blue in five bits each, as one number for each pixel.

    Parameters
    ----------
    frame
        Shape (height, width, 3 or 4).
    """
    # one table look-up for each pixel needs an index, and 15 bits hold more than eyes see
    red, green, blue = (frame[..., channel].astype(np.intp) >> 3 for channel in range(3))
    return (red << 10) | (green << 5) | blue


def palette_of(frames: Sequence[Frame], colours: int = COLOURS) -> Palette:
    """Colours that show frames well, shape (n, 3): frequent ones, and those far from the others.

    The most frequent colour comes first and is exact.
    """
    counts, sums = np.zeros(_SHADES), np.zeros((3, _SHADES))
    for frame in frames:
        found = shades(frame).ravel()
        counts += np.bincount(found, minlength=_SHADES)
        for channel in range(3):
            values = frame[..., channel].ravel()
            sums[channel] += np.bincount(found, weights=values, minlength=_SHADES)
    common = int(counts.argmax())
    kept = counts >= min(SEEN, counts[common])
    means = (sums[:, kept] / counts[kept]).T
    weights = np.sqrt(counts[kept])
    chosen = [int(np.flatnonzero(kept).tolist().index(common))]
    apart = np.full(len(means), np.inf)
    while len(chosen) < min(colours, len(means)):
        apart = np.minimum(apart, np.sum((means - means[chosen[-1]]) ** 2, axis=1))
        chosen.append(int(np.argmax(weights * apart)))
    return np.round(means[chosen]).astype(np.uint8)


def nearest_colours(palette: Palette) -> NDArray[np.uint8]:
    """The index of the palette's nearest colour for every number that `shades` gives."""
    every = np.arange(_SHADES)
    centres = np.stack([(every >> 10) & 31, (every >> 5) & 31, every & 31]) * (255.0 / 31.0)
    distances = np.zeros((len(palette), _SHADES))
    for channel in range(3):
        distances += (palette[:, channel, None] - centres[channel]) ** 2
    return distances.argmin(axis=0).astype(np.uint8)


class GifFile:
    """A GIF that repeats for ever, written frame by frame.

    Parameters
    ----------
    path
        Where to write.
    palette
        From `palette_of`, at most 255 colours.
    fps
        Frames per second, at most `FASTEST`. Times are rounded to 0.01 s without adding up.
    """

    def __init__(self, path: Path, palette: Palette, fps: float) -> None:
        self._file = path.open("wb")
        self._palette = palette
        self._table = nearest_colours(palette)
        self._clear = len(palette)  # the index that stands for: as before
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
        indices = self._table[shades(frame)]
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
        table = self._palette.tobytes().ljust(3 << bits, b"\0")
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
