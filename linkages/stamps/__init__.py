"""What result files store of their origin: the definition as computed, options, command.

Each format has a place for text that other programs ignore. A result file is a definition file as
well: `stamped` reads what `stamp` has written, validated by `Origin`.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from linkages.errors import InputError, Problem
from linkages.stamps.stamp_formats import (
    put_braces,
    put_dxf,
    put_gif,
    put_html,
    put_json,
    put_mp4,
    put_netcdf,
    put_pdf,
    put_png,
    put_python,
    put_svg,
    put_webp,
    put_xml,
    taken_braces,
    taken_dxf,
    taken_gif,
    taken_html,
    taken_json,
    taken_mp4,
    taken_netcdf,
    taken_pdf,
    taken_png,
    taken_python,
    taken_svg,
    taken_webp,
    taken_xml,
)

if TYPE_CHECKING:
    from linkages.stamps.stamp_formats import Origin

MAX_BYTES = 256 * 1024**2
"""Largest result file that is read as a whole; of NetCDF files, only attributes are read."""

MAX_PARSED = 32 * 1024**2
"""Longest JSON text that is parsed: as objects it takes up to forty times as much memory."""


@dataclass(frozen=True)
class Format:
    """How a kind of file holds a text."""

    # Content and a text → the content with that text, in the place of an earlier one
    put: Callable[[bytes, str], bytes]
    # Content → the text in it; None if there is none. ValueError, IndexError or struct.error if it
    # is damaged
    taken: Callable[[Any], str | None]
    # Whether `taken` needs the content as bytes; otherwise it gets the open file
    whole: bool = True


FORMATS = {
    ".nc": Format(put_netcdf, taken_netcdf, whole=False),
    ".png": Format(put_png, taken_png),
    ".svg": Format(put_svg, taken_svg),
    ".pdf": Format(put_pdf, taken_pdf),
    ".html": Format(put_html, taken_html),
    ".json": Format(put_json, taken_json),
    ".dxf": Format(put_dxf, taken_dxf),
    ".gif": Format(put_gif, taken_gif),
    ".webp": Format(put_webp, taken_webp),
    ".mp4": Format(put_mp4, taken_mp4),
    **dict.fromkeys((".c", ".h", ".js"), Format(put_braces, taken_braces)),
    ".py": Format(put_python, taken_python),
    ".xml": Format(put_xml, taken_xml),
}
"""Ending → how such files hold texts. Tables have none: what is beside them says it."""


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
    return None if text is None else origin_in(text, str(path))


def origin_in(text: str, source: str) -> Origin | None:
    """The validated origin in a JSON text; None if it has no definition."""
    from linkages.stamps.stamp_formats import read_origin

    return read_origin(text, source)


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
