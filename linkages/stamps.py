"""What result files store of their origin: the definition as computed, options, command.

Each format, from SVG to films, has a place for text that other programs ignore. A result file is a
definition file as well: `stamped` reads what `stamp` has written, validated by `Origin`.
"""

from __future__ import annotations

import io
import json
import logging
import re
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from html import escape, unescape
from io import BytesIO
from pathlib import Path
from typing import Annotated, Any, BinaryIO

from pydantic import BaseModel, ConfigDict, Field, Json, JsonValue, ValidationError

from linkages.errors import InputError, Problem

KEY = "origin"

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


_SVG = re.compile(r'<metadata id="linkages-origin">(.*?)</metadata>\n?', re.DOTALL)
_HTML = re.compile(
    r'<script type="application/json" id="linkages-origin">(.*?)</script>\n?', re.DOTALL
)
_PDF = "/linkages"


def _put_svg(content: bytes, text: str) -> bytes:
    """The drawing with a text, as metadata of it all."""
    rest = _SVG.sub("", content.decode())
    element = f'<metadata id="linkages-origin">{escape(text, quote=False)}</metadata>\n'
    return _after(rest, re.compile(r"<svg\b[^>]*>\n?"), element).encode()


def _taken_svg(content: bytes) -> str | None:
    result = _SVG.search(content.decode(errors="replace"))
    return None if result is None else unescape(result[1])


def _put_html(content: bytes, text: str) -> bytes:
    """The page with a text, as data at the end of its head: its encoding is said before."""
    rest = _HTML.sub("", content.decode())
    harmless = text.replace("<", "\\u003c")  # nothing in it ends the element
    element = f'<script type="application/json" id="linkages-origin">{harmless}</script>\n'
    return _after(rest, re.compile(r"<head>.*?(?=</head>)", re.DOTALL), element).encode()


def _taken_html(content: bytes) -> str | None:
    result = _HTML.search(content.decode(errors="replace"))
    return None if result is None else result[1]


def _put_json(content: bytes, text: str) -> bytes:
    """The object with the text's own object under one more key."""
    result = json.loads(content) | {KEY: json.loads(text)}
    return (json.dumps(result, indent=2, ensure_ascii=False) + "\n").encode()


def _taken_json(content: bytes) -> str | None:
    try:
        result: Any = json.loads(content)
    except (ValueError, RecursionError):  # JSON or not, it may be a definition file
        return None
    own = result.get(KEY) if isinstance(result, dict) else None
    return json.dumps(own, ensure_ascii=False) if isinstance(own, dict) else None


def _put_pdf(content: bytes, text: str) -> bytes:
    """The document with a text in its information."""
    from pypdf import PdfWriter

    writer, file = PdfWriter(clone_from=BytesIO(content)), BytesIO()
    writer.add_metadata({_PDF: text})
    writer.write(file)
    return file.getvalue()


def _taken_pdf(content: bytes) -> str | None:
    """The text in the information of a document; None if it is no document as well."""
    from pypdf import PdfReader

    log = logging.getLogger("pypdf")
    before, nowhere = log.propagate, logging.NullHandler()
    log.addHandler(nowhere)
    log.propagate = False  # its modules report to the user what is reported here
    try:
        information: Any = PdfReader(BytesIO(content)).metadata or {}
        result = information.get(_PDF)
        return None if result is None else str(result)
    except Exception:  # a damaged document makes it raise whatever comes
        return None
    finally:
        log.propagate = before
        log.removeHandler(nowhere)


def _after(text: str, mark: re.Pattern[str], element: str) -> str:
    """A text with an element after the first place of a mark."""
    result = mark.search(text)
    if result is None:
        raise ValueError(f"expected a document with {mark.pattern}")
    return text[: result.end()] + element + text[result.end() :]


LONGEST_COMMENT = 200
"""Characters of the text in a comment; programs take 255 and more in a line."""

_LINE = re.compile(rb"^ *999\r?\nlinkages-origin (.*?)\r?\n", re.MULTILINE)


def _put_dxf(content: bytes, text: str) -> bytes:
    """The drawing with a text, a JSON object, in comments of ASCII alone."""
    plain = json.dumps(json.loads(text))
    parts = [
        plain[start : start + LONGEST_COMMENT] for start in range(0, len(plain), LONGEST_COMMENT)
    ]
    comments = "".join(f"999\nlinkages-origin {part}\n" for part in parts)
    return comments.encode("ascii") + _LINE.sub(b"", content)


def _taken_dxf(content: bytes) -> str | None:
    parts = _LINE.findall(content)
    return b"".join(parts).decode("ascii", errors="replace") if parts else None


_FILM_MARK = b"linkages:"
_CHUNK = b"LNKG"
_BOX = bytes.fromhex("5a1d0c5e8f0b4c6e9b9e3d6a7c2f4e10")
"""A UUID that says what is in a box."""
_TRAILER = b";"


def _put_gif(content: bytes, text: str) -> bytes:
    """The film with a text as its last comment (GIF 89a, 24)."""
    begin = content.rfind(b"!\xfe" + bytes([len(_FILM_MARK)]) + _FILM_MARK)
    rest = content[:begin] if begin >= 0 else content.removesuffix(_TRAILER)
    data = text.encode()
    blocks = [_FILM_MARK, *(data[i : i + 255] for i in range(0, len(data), 255))]
    comment = b"".join(bytes([len(block)]) + block for block in blocks)
    return rest + b"!\xfe" + comment + b"\0" + _TRAILER


def _taken_gif(content: bytes) -> str | None:
    begin = content.rfind(b"!\xfe" + bytes([len(_FILM_MARK)]) + _FILM_MARK)
    if begin < 0:
        return None
    place, result = begin + 3 + len(_FILM_MARK), bytearray()
    while length := content[place]:
        result += content[place + 1 : place + 1 + length]
        place += 1 + length
    return result.decode()


def _put_webp(content: bytes, text: str) -> bytes:
    """The film with a text in a chunk of its own at the end (WebP container specification)."""
    chunks = [*(chunk for chunk in _riff(content) if chunk[0] != _CHUNK), (_CHUNK, text.encode())]
    body = b"WEBP" + b"".join(
        name + struct.pack("<I", len(own)) + own + b"\0" * (len(own) % 2) for name, own in chunks
    )
    return b"RIFF" + struct.pack("<I", len(body)) + body


def _taken_webp(content: bytes) -> str | None:
    return next((own.decode() for name, own in _riff(content) if name == _CHUNK), None)


def _riff(content: bytes) -> Iterator[tuple[bytes, bytes]]:
    place = 12
    while place + 8 <= len(content):
        (length,) = struct.unpack_from("<I", content, place + 4)
        yield content[place : place + 4], content[place + 8 : place + 8 + length]
        place += 8 + length + length % 2


def _put_mp4(content: bytes, text: str) -> bytes:
    """The film with a text in a box of its own at the end (ISO/IEC 14496-12, 11.1)."""
    rest = b"".join(box for box in _boxes(content) if not _is_own_box(box))
    data = b"uuid" + _BOX + text.encode()
    return rest + struct.pack(">I", 4 + len(data)) + data


def _taken_mp4(content: bytes) -> str | None:
    return next((box[24:].decode() for box in _boxes(content) if _is_own_box(box)), None)


def _boxes(content: bytes) -> Iterator[bytes]:
    place = 0
    while place + 8 <= len(content):
        (length,) = struct.unpack_from(">I", content, place)
        if length == 1:  # a length of 64 bits follows
            (length,) = struct.unpack_from(">Q", content, place + 8)
        end = place + length if length >= 8 else len(content)
        yield content[place:end]
        place = end


def _is_own_box(box: bytes) -> bool:
    return box[4:8] == b"uuid" and box[8:24] == _BOX


KEYWORD = b"linkages"
_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_HEAD = KEYWORD + b"\0" + b"\0\0" + b"\0" + b"\0"  # not compressed, no language, no translation


def _put_png(content: bytes, text: str) -> bytes:
    """The picture with a text, after its header."""
    first, *others = _chunks(content)
    kept = [chunk for chunk in others if not _is_own_chunk(chunk)]
    return _SIGNATURE + b"".join([first, _chunk(b"iTXt", _HEAD + text.encode()), *kept])


def _taken_png(content: bytes) -> str | None:
    if not content.startswith(_SIGNATURE):
        return None
    result = (chunk for chunk in _chunks(content) if _is_own_chunk(chunk))
    return next((chunk[8 + len(_HEAD) : -4].decode() for chunk in result), None)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _chunks(content: bytes) -> Iterator[bytes]:
    place = len(_SIGNATURE)
    while place + 12 <= len(content):
        end = place + 12 + struct.unpack_from(">I", content, place)[0]
        yield content[place:end]
        place = end


def _is_own_chunk(chunk: bytes) -> bool:
    return chunk[4:8] == b"iTXt" and chunk[8:].startswith(_HEAD)


def _put_netcdf(content: bytes, text: str) -> bytes:
    """Write the entries of a JSON object as attributes."""
    import h5netcdf

    memory = io.BytesIO(content)
    with h5netcdf.File(memory, "a") as file:
        file.attrs.update(json.loads(text))
    return memory.getvalue()


MOST = 64 * 1024**2
"""Bytes that are read of a file to find its attributes; of data there may be more."""


def _taken_netcdf(file: BinaryIO) -> str | None:
    """All attributes that are texts, as a JSON object; nothing else of the file is read."""
    import h5py

    limited = _Limited(file)
    try:
        with h5py.File(limited, "r") as opened:
            single = [n for n in opened.attrs if opened.attrs.get_id(n).shape == ()]
            texts = {name: opened.attrs[name] for name in single}
            result = {name: text for name, text in texts.items() if isinstance(text, str)}
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, MemoryError):
        # damaged, or another kind
        if limited.left < 0:
            raise ValueError("attributes that are too large") from None
        return None
    return json.dumps(result, ensure_ascii=False)


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


_MARK = "linkages-origin: "
_HARMFUL = re.compile(r"[*\-<>?]")
"""In texts of JSON alone, so that other ways to write them mean the same: ends of comments of C and
XML, and the beginning of a trigraph."""


def _comments(begin: str, end: str) -> Format:
    """A program or model with a text in a comment of one line at its end."""
    comment = re.compile(rf"^{re.escape(begin + _MARK)}(.*){re.escape(end)}\n", re.MULTILINE)

    def put(content: bytes, text: str) -> bytes:
        rest = comment.sub("", content.decode())
        plain = json.dumps(json.loads(text))  # ASCII: nothing else ends a line in any language
        harmless = _HARMFUL.sub(lambda found: f"\\u{ord(found[0]):04x}", plain)
        return f"{rest.rstrip()}\n{begin}{_MARK}{harmless}{end}\n".encode()

    def taken(content: bytes) -> str | None:
        result = comment.search(content.decode(errors="replace"))
        return None if result is None else result[1]

    return Format(put, taken)


_IN_UNIT = "extra/linkages/origin.json"
"""Where units of the Functional Mock-up Interface hold data of tools."""


def _put_fmu(content: bytes, text: str) -> bytes:
    """The archive with a text in a file of its own."""
    memory = BytesIO()
    with zipfile.ZipFile(BytesIO(content)) as before, zipfile.ZipFile(memory, "w") as after:
        for entry in before.infolist():
            if entry.filename != _IN_UNIT:
                after.writestr(entry, before.read(entry))
        own = zipfile.ZipInfo(_IN_UNIT)
        own.external_attr = 0o644 << 16
        after.writestr(own, text, zipfile.ZIP_DEFLATED)
    return memory.getvalue()


def _taken_fmu(content: bytes) -> str | None:
    try:
        with zipfile.ZipFile(BytesIO(content)) as archive:
            if _IN_UNIT not in archive.namelist():
                return None
            with archive.open(_IN_UNIT) as file:
                return file.read(MAX_PARSED + 1).decode()  # a small archive may unfold to more
    except Exception:  # a damaged archive makes it raise whatever comes
        raise ValueError("expected an archive") from None


FORMATS = {
    ".nc": Format(_put_netcdf, _taken_netcdf, whole=False),
    ".png": Format(_put_png, _taken_png),
    ".svg": Format(_put_svg, _taken_svg),
    ".pdf": Format(_put_pdf, _taken_pdf),
    ".html": Format(_put_html, _taken_html),
    ".json": Format(_put_json, _taken_json),
    ".dxf": Format(_put_dxf, _taken_dxf),
    ".gif": Format(_put_gif, _taken_gif),
    ".webp": Format(_put_webp, _taken_webp),
    ".mp4": Format(_put_mp4, _taken_mp4),
    ".fmu": Format(_put_fmu, _taken_fmu),
    **dict.fromkeys((".c", ".h", ".js"), _comments("/* ", " */")),
    ".py": _comments("# ", ""),
    ".xml": _comments("<!-- ", " -->"),
}
"""Ending → how such files hold texts. Tables have none: what is beside them says it."""


LONGEST = 10_000_000
"""Characters of a definition; of everything else, a tenth."""

_Text = Annotated[str, Field(max_length=LONGEST // 10)]
_Texts = Annotated[list[_Text], Field(max_length=100_000)]
_Object = Annotated[dict[str, JsonValue], Field(max_length=1_000)]

_EXPECTED = {
    "arguments": "a JSON object",
    "options": "a JSON object",
    "changes": "a JSON list of texts",
    "notes": "a JSON list of texts",
    "definition": f"a text of at most {LONGEST // 10**6} million characters",
}


class Origin(BaseModel):
    """What results were computed from. Entries of other names are left out.

    `definition` has all values put in, `changes` are the assignments to its file. `options` and, of
    these, the given `arguments` describe the computation; `asked_in` of `linkages.options.option`
    selects what a new one takes over. `command` was typed, `complete` is ``yes`` at its end.
    """

    model_config = ConfigDict(frozen=True, strict=True, extra="ignore")

    definition: Annotated[str, Field(max_length=LONGEST)]
    changes: Json[_Texts] = Field(default_factory=list)
    options: Json[_Object] = Field(default_factory=dict)
    arguments: Json[_Object] = Field(default_factory=dict)
    verb: _Text | None = None
    analysis: _Text | None = None
    command: _Text = ""
    version: _Text = ""
    notes: Json[_Texts] = Field(default_factory=list)
    complete: _Text = "yes"


class _Any(BaseModel):
    """Whether there is an origin at all."""

    definition: JsonValue = None


def read_origin(text: str, source: str) -> Origin | None:
    """Validate a JSON text; None without a definition; InputError names wrong entries."""
    try:
        if _Any.model_validate_json(text).definition is None:
            return None
        return Origin.model_validate_json(text)
    except ValidationError as error:
        names = dict.fromkeys(str(item["loc"][0]) if item["loc"] else "" for item in error.errors())
        problems = [
            Problem(path=f"origin.{name}" if name else "origin", message=_message(name))
            for name in names
        ]
        raise InputError(source, problems) from None


def _message(name: str) -> str:
    expected = _EXPECTED.get(name, "a text") if name else "a JSON object of texts"
    return f"expected {expected}; the file is damaged, or linkages did not write it"


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
