"""DXF: comments before the first section, which have the group code 999."""

from __future__ import annotations

import json
import re

LONGEST = 200
"""Characters of the text in a comment; programs take 255 and more in a line."""

_LINE = re.compile(rb"^ *999\r?\nlinkages-origin (.*?)\r?\n", re.MULTILINE)


def put(content: bytes, text: str) -> bytes:
    """The drawing with a text, a JSON object, in comments of ASCII alone."""
    plain = json.dumps(json.loads(text))
    parts = [plain[start : start + LONGEST] for start in range(0, len(plain), LONGEST)]
    comments = "".join(f"999\nlinkages-origin {part}\n" for part in parts)
    return comments.encode("ascii") + _LINE.sub(b"", content)


def taken(content: bytes) -> str | None:
    """The text in the comments."""
    parts = _LINE.findall(content)
    return b"".join(parts).decode("ascii", errors="replace") if parts else None
