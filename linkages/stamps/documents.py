"""SVG, HTML, JSON and PDF: an element, an entry, a key of the document information."""

from __future__ import annotations

import json
import logging
import re
from html import escape, unescape
from io import BytesIO
from typing import Any

KEY = "origin"
_SVG = re.compile(r'<metadata id="linkages-origin">(.*?)</metadata>\n?', re.DOTALL)
_HTML = re.compile(
    r'<script type="application/json" id="linkages-origin">(.*?)</script>\n?', re.DOTALL
)
_PDF = "/linkages"


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
    except (ValueError, RecursionError):  # JSON or not, it may be a definition file
        return None
    own = found.get(KEY) if isinstance(found, dict) else None
    return json.dumps(own, ensure_ascii=False) if isinstance(own, dict) else None


def put_pdf(content: bytes, text: str) -> bytes:
    """The document with a text in its information."""
    from pypdf import PdfWriter

    writer, file = PdfWriter(clone_from=BytesIO(content)), BytesIO()
    writer.add_metadata({_PDF: text})
    writer.write(file)
    return file.getvalue()


def taken_pdf(content: bytes) -> str | None:
    """The text in the information of a document; None if it is no document as well."""
    from pypdf import PdfReader

    log = logging.getLogger("pypdf")
    before, nowhere = log.propagate, logging.NullHandler()
    log.addHandler(nowhere)
    log.propagate = False  # its modules report to the user what is reported here
    try:
        information: Any = PdfReader(BytesIO(content)).metadata or {}
        found = information.get(_PDF)
        return None if found is None else str(found)
    except Exception:  # a damaged document makes it raise whatever comes
        return None
    finally:
        log.propagate = before
        log.removeHandler(nowhere)


def _after(text: str, mark: re.Pattern[str], element: str) -> str:
    """A text with an element after the first place of a mark."""
    found = mark.search(text)
    if found is None:
        raise ValueError(f"expected a document with {mark.pattern}")
    return text[: found.end()] + element + text[found.end() :]
