"""MP4 videos, encoded by ffmpeg."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from contextlib import suppress
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

Frame = NDArray[np.uint8]

QUALITY = "18"
"""Constant rate factor of H.264: lines stay sharp."""


def find_ffmpeg() -> str:
    """The path of ffmpeg.

    Raises
    ------
    ValueError
        If it is not installed.
    """
    found = shutil.which("ffmpeg")
    if found is None:
        raise ValueError(
            "MP4 needs the program ffmpeg, which was not found; install it "
            "(apt install ffmpeg, brew install ffmpeg, winget install ffmpeg) or write a GIF"
        )
    return found


class VideoFile:
    """A video, written frame by frame.

    Parameters
    ----------
    path
        Where to write; ends in ``.mp4``.
    size
        Width and height in pixels, both even.
    fps
        Frames per second.

    Raises
    ------
    ValueError
        If ffmpeg is not installed.
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

        Raises
        ------
        OSError
            If ffmpeg has ended; says why.
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
