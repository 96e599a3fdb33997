"""GIF, WebP and MP4: a comment, a chunk and a box of their own."""

from __future__ import annotations

import struct
from collections.abc import Iterator

_MARK = b"linkages:"
_CHUNK = b"LNKG"
_BOX = bytes.fromhex("5a1d0c5e8f0b4c6e9b9e3d6a7c2f4e10")
"""A UUID that says what is in a box."""
_TRAILER = b";"


def put_gif(content: bytes, text: str) -> bytes:
    """The film with a text as its last comment (GIF 89a, 24)."""
    begin = content.rfind(b"!\xfe" + bytes([len(_MARK)]) + _MARK)
    rest = content[:begin] if begin >= 0 else content.removesuffix(_TRAILER)
    data = text.encode()
    blocks = [_MARK, *(data[i : i + 255] for i in range(0, len(data), 255))]
    comment = b"".join(bytes([len(block)]) + block for block in blocks)
    return rest + b"!\xfe" + comment + b"\0" + _TRAILER


def taken_gif(content: bytes) -> str | None:
    """The text in a film."""
    begin = content.rfind(b"!\xfe" + bytes([len(_MARK)]) + _MARK)
    if begin < 0:
        return None
    place, found = begin + 3 + len(_MARK), bytearray()
    while length := content[place]:
        found += content[place + 1 : place + 1 + length]
        place += 1 + length
    return found.decode()


def put_webp(content: bytes, text: str) -> bytes:
    """The film with a text in a chunk of its own at the end (WebP container specification)."""
    chunks = [*(chunk for chunk in _riff(content) if chunk[0] != _CHUNK), (_CHUNK, text.encode())]
    body = b"WEBP" + b"".join(
        name + struct.pack("<I", len(own)) + own + b"\0" * (len(own) % 2) for name, own in chunks
    )
    return b"RIFF" + struct.pack("<I", len(body)) + body


def taken_webp(content: bytes) -> str | None:
    """The text in a film."""
    return next((own.decode() for name, own in _riff(content) if name == _CHUNK), None)


def _riff(content: bytes) -> Iterator[tuple[bytes, bytes]]:
    place = 12
    while place + 8 <= len(content):
        (length,) = struct.unpack_from("<I", content, place + 4)
        yield content[place : place + 4], content[place + 8 : place + 8 + length]
        place += 8 + length + length % 2


def put_mp4(content: bytes, text: str) -> bytes:
    """The film with a text in a box of its own at the end (ISO/IEC 14496-12, 11.1)."""
    rest = b"".join(box for box in _boxes(content) if not _own(box))
    data = b"uuid" + _BOX + text.encode()
    return rest + struct.pack(">I", 4 + len(data)) + data


def taken_mp4(content: bytes) -> str | None:
    """The text in a film."""
    return next((box[24:].decode() for box in _boxes(content) if _own(box)), None)


def _boxes(content: bytes) -> Iterator[bytes]:
    place = 0
    while place + 8 <= len(content):
        (length,) = struct.unpack_from(">I", content, place)
        if length == 1:  # a length of 64 bits follows
            (length,) = struct.unpack_from(">Q", content, place + 8)
        end = place + length if length >= 8 else len(content)
        yield content[place:end]
        place = end


def _own(box: bytes) -> bool:
    return box[4:8] == b"uuid" and box[8:24] == _BOX
