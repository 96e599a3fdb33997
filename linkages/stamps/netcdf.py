"""NetCDF 4: an attribute for each name."""

from __future__ import annotations

import io
import json
from typing import Any, BinaryIO


def put(content: bytes, text: str) -> bytes:
    """Write the entries of a JSON object as attributes."""
    import h5netcdf

    memory = io.BytesIO(content)
    with h5netcdf.File(memory, "a") as file:
        file.attrs.update(json.loads(text))
    return memory.getvalue()


MOST = 64 * 1024**2
"""Bytes that are read of a file to find its attributes; of data there may be more."""


def taken(file: BinaryIO) -> str | None:
    """All attributes that are texts, as a JSON object; nothing else of the file is read."""
    import h5py

    limited = _Limited(file)
    try:
        with h5py.File(limited, "r") as opened:
            single = [n for n in opened.attrs if opened.attrs.get_id(n).shape == ()]
            texts = {name: opened.attrs[name] for name in single}
            found = {name: text for name, text in texts.items() if isinstance(text, str)}
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, MemoryError):
        # damaged, or another kind
        if limited.left < 0:
            raise ValueError("attributes that are too large") from None
        return None
    return json.dumps(found, ensure_ascii=False)


class _Limited:
    """An open file of which no more than `MOST` bytes are read."""

    def __init__(self, file: BinaryIO) -> None:
        self._file, self.left = file, MOST

    def readinto(self, buffer: memoryview) -> int:
        """Read as io.RawIOBase does."""
        self.left -= len(buffer)
        if self.left < 0:
            raise OSError("more is read than attributes need")
        return self._file.readinto(buffer)  # type: ignore[attr-defined]

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)
