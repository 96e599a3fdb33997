"""What result files store of their origin: the definition as computed, options, command.

Each format has a place for text that other programs ignore. A result file is a definition file as
well: `stamped` reads what `stamp` has written, validated by `Origin`.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import BinaryIO

from linkages.errors import InputError, Problem
from linkages.stamps.stamp_formats import FORMATS, MAX_PARSED, Origin, read_origin

MAX_BYTES = 256 * 1024**2
"""Largest result file that is read as a whole; of NetCDF files, only attributes are read."""


def stamp(path: Path, origin: Mapping[str, str]) -> bool:
    """Write into a file what it was computed from."""
    result = FORMATS.get(path.suffix.lower())
    if result is None:
        return False
    path.write_bytes(result.put(path.read_bytes(), json.dumps(dict(origin), ensure_ascii=False)))
    return True


def stamped(path: Path) -> Origin | None:
    """What a result file was computed from; None if it does not contain that."""
    result = FORMATS.get(path.suffix.lower())
    if result is None:
        return None
    try:
        with path.open("rb") as file:
            text = result.taken(_content(file, path) if result.whole else file)
    except (ValueError, IndexError, struct.error):
        message = "is damaged; expected results that linkages wrote"
        raise InputError(str(path), [Problem(message=message)]) from None
    if text is not None and len(text) > MAX_PARSED:
        raise _too_large(path, MAX_PARSED)
    return None if text is None else read_origin(text, str(path))


def _content(file: BinaryIO, path: Path) -> bytes:
    """All of a file, unless it is too large."""
    most = MAX_PARSED if path.suffix.lower() == ".json" else MAX_BYTES
    if path.stat().st_size <= most:
        content = file.read(most + 1)  # it may grow, and some files have no size
        if len(content) <= most:
            return content
    raise _too_large(path, most)


def _too_large(path: Path, most: int) -> InputError:
    message = f"larger than {most // 1024**2} MiB; expected results that linkages wrote"
    return InputError(str(path), [Problem(message=message)])
