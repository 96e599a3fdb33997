"""Animated WebP in full colour, encoded by Pillow."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Frame = NDArray[np.uint8]

METHOD, QUALITY = 2, 20
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

    Parameters
    ----------
    path
        Where to write.
    frames
        Shape (height, width, 3 or 4) each, all of one size.
    count
        How many there are.
    fps
        Frames per second. Times are rounded to 1 ms without adding up.
    """
    ends = np.round(1000.0 * np.arange(count + 1) / fps).astype(int)
    image = _Frames(frames, count)
    durations = np.diff(ends).tolist()
    how = {"lossless": True, "quality": QUALITY, "method": METHOD, "kmin": count, "kmax": count + 1}
    image.save(path, "WEBP", save_all=True, duration=durations, loop=0, **how)
