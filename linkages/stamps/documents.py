"""SVG, HTML, JSON and PDF: an element, an entry, a key of the document information."""

from __future__ import annotations

import json
import re
from html import escape, unescape
from typing import Any

KEY = "origin"
_SVG = re.compile(r'<metadata id="linkages-origin">(.*?)</metadata>\n?', re.DOTALL)
_HTML = re.compile(
    r'<script type="application/json" id="linkages-origin">(.*?)</script>\n?', re.DOTALL
)
_PDF = re.compile(rb"/linkages <([0-9A-Fa-f]+)>")
_TRAILER = re.compile(rb"trailer\s*<<(.*?)>>\s*startxref\s+(\d+)\s+%%EOF\s*$", re.DOTALL)


def put_svg(content: bytes, text: str) -> bytes:
    """The drawing with a text, as metadata of it all."""
    rest = _SVG.sub("", content.decode())
    element = f'<metadata id="linkages-origin">{escape(text, quote=False)}</metadata>\n'
    return _after(rest, re.compile(r"<svg\b[^>]*>\n?"), element).encode()


def taken_svg(content: bytes) -> str | None:
    """The text in a drawing."""
    found = _SVG.search(content.decode(errors="replace"))
    return None if found is None else unescape(found[1])


def put_html(content: bytes, text: str) -> bytes:
    """The page with a text, as data at the end of its head: its encoding is said before."""
    rest = _HTML.sub("", content.decode())
    harmless = text.replace("<", "\\u003c")  # nothing in it ends the element
    element = f'<script type="application/json" id="linkages-origin">{harmless}</script>\n'
    return _after(rest, re.compile(r"<head>.*?(?=</head>)", re.DOTALL), element).encode()


def taken_html(content: bytes) -> str | None:
    """The text in a page."""
    found = _HTML.search(content.decode(errors="replace"))
    return None if found is None else found[1]


def put_json(content: bytes, text: str) -> bytes:
    """The object with the text's own object under one more key."""
    found = json.loads(content) | {KEY: json.loads(text)}
    return (json.dumps(found, indent=2, ensure_ascii=False) + "\n").encode()


def taken_json(content: bytes) -> str | None:
    """The object under that key."""
    try:
        found: Any = json.loads(content)
    except ValueError:  # JSON or not, it may be a definition file
        return None
    own = found.get(KEY) if isinstance(found, dict) else None
    return json.dumps(own, ensure_ascii=False) if isinstance(own, dict) else None


def put_pdf(content: bytes, text: str) -> bytes:
    """The document with a text in its information, as an update at its end (ISO 32000-1, 7.5.6).

    Raises
    ------
    ValueError
        If its last section of cross references is no table, which those of Matplotlib are.
    """
    found = _TRAILER.search(content)
    entries = {} if found is None else {
        key: re.search(rb"/%b\s+(\d+)" % key, found[1]) for key in (b"Size", b"Root", b"Info")
    }  # fmt: skip
    if found is None or None in entries.values():
        raise ValueError("expected a PDF document with a table of cross references")
    size, root, info = (int(match[1]) for match in entries.values() if match is not None)
    own = b"\n%d 0 obj\n<< /linkages <FEFF%b> >>\nendobj\n" % (
        info,
        text.encode("utf-16-be").hex().encode(),
    )
    table = b"xref\n%d 1\n%010d 00000 n \n" % (info, len(content) + 1)
    trailer = b"trailer\n<< /Size %d /Root %d 0 R /Info %d 0 R /Prev %d >>\n" % (
        size,
        root,
        info,
        int(found[2]),
    )
    place = len(content) + len(own)
    return content + own + table + trailer + b"startxref\n%d\n%%%%EOF\n" % place


def taken_pdf(content: bytes) -> str | None:
    """The text in the information of a document, the last one."""
    found = _PDF.findall(content)
    return bytes.fromhex(found[-1].decode()).decode("utf-16") if found else None


def _after(text: str, mark: re.Pattern[str], element: str) -> str:
    """A text with an element after the first place of a mark."""
    found = mark.search(text)
    if found is None:
        raise ValueError(f"expected a document with {mark.pattern}")
    return text[: found.end()] + element + text[found.end() :]
