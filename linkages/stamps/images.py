"""PNG: a chunk of international text (PNG specification, third edition, 11.3.3.4)."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

KEYWORD = b"linkages"
_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_HEAD = KEYWORD + b"\0" + b"\0\0" + b"\0" + b"\0"  # not compressed, no language, no translation


def put_png(content: bytes, text: str) -> bytes:
    """The picture with a text, after its header."""
    first, *others = _chunks(content)
    kept = [chunk for chunk in others if not _own(chunk)]
    return _SIGNATURE + b"".join([first, _chunk(b"iTXt", _HEAD + text.encode()), *kept])


def taken_png(content: bytes) -> str | None:
    """The text in a picture."""
    if not content.startswith(_SIGNATURE):
        return None
    found = (chunk for chunk in _chunks(content) if _own(chunk))
    return next((chunk[8 + len(_HEAD) : -4].decode() for chunk in found), None)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _chunks(content: bytes) -> Iterator[bytes]:
    place = len(_SIGNATURE)
    while place + 12 <= len(content):
        end = place + 12 + struct.unpack_from(">I", content, place)[0]
        yield content[place:end]
        place = end


def _own(chunk: bytes) -> bool:
    return chunk[4:8] == b"iTXt" and chunk[8:].startswith(_HEAD)
