"""Programs and models: a comment at their end, in which nothing ends it."""

from __future__ import annotations

import json
import re

_MARK = "linkages-origin: "
_HARMFUL = re.compile(r"[*\-<>?]")
"""In texts of JSON alone, so that other ways to write them mean the same: ends of comments of C and
XML, and the beginning of a trigraph."""


def _comment(begin: str, end: str) -> re.Pattern[str]:
    return re.compile(rf"^{re.escape(begin + _MARK)}(.*){re.escape(end)}\n", re.MULTILINE)


def _put(content: bytes, text: str, begin: str, end: str) -> bytes:
    rest = _comment(begin, end).sub("", content.decode())
    plain = json.dumps(json.loads(text))  # ASCII: nothing else ends a line in any language
    harmless = _HARMFUL.sub(lambda found: f"\\u{ord(found[0]):04x}", plain)
    return f"{rest.rstrip()}\n{begin}{_MARK}{harmless}{end}\n".encode()


def _taken(content: bytes, begin: str, end: str) -> str | None:
    found = _comment(begin, end).search(content.decode(errors="replace"))
    return None if found is None else found[1]


def put_braces(content: bytes, text: str) -> bytes:
    """The program in C or JavaScript with a text."""
    return _put(content, text, "/* ", " */")


def taken_braces(content: bytes) -> str | None:
    """The text in a program in C or JavaScript."""
    return _taken(content, "/* ", " */")


def put_python(content: bytes, text: str) -> bytes:
    """The module of Python with a text."""
    return _put(content, text, "# ", "")


def taken_python(content: bytes) -> str | None:
    """The text in a module of Python."""
    return _taken(content, "# ", "")


def put_xml(content: bytes, text: str) -> bytes:
    """The model with a text."""
    return _put(content, text, "<!-- ", " -->")


def taken_xml(content: bytes) -> str | None:
    """The text in a model."""
    return _taken(content, "<!-- ", " -->")
