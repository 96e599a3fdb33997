"""What a mechanism was defined by, entry by entry."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.reading.paths import dotted

MARK = "●"
"""Stands before what differs from the file."""

_LONGEST = 160


def input_rows(mechanism: Mechanism) -> list[list[str]]:
    """A row for each entry of the definition: its path, marked where it differs, and its values."""
    changed = [text.partition("=")[0].strip() for text in mechanism.changes]
    rows = []
    for path, value in _entries(mechanism.definition.content):
        name = dotted(path)
        own = any(_same(name, text) or _same(text, name) for text in changed)
        rows.append([f"{MARK} {name}" if own else name, _shown(value)])
    return rows


def _entries(content: Mapping[str, Any]) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    for section, value in content.items():
        if section == "name":
            continue
        if isinstance(value, dict) and any(isinstance(v, dict | list) for v in value.values()):
            yield from (((section, name), entry) for name, entry in value.items())
        elif isinstance(value, list) and any(isinstance(entry, dict) for entry in value):
            yield from (((section, index), entry) for index, entry in enumerate(value))
        else:
            yield (section,), value


def _same(inner: str, outer: str) -> bool:
    """Whether one path is another one, or within it."""
    return inner == outer or inner.startswith((f"{outer}.", f"{outer}["))


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        text = ", ".join(f"{key} {_shown(entry)}" for key, entry in value.items())
    elif isinstance(value, list):
        text = f"[{', '.join(_shown(entry) for entry in value)}]"
    else:
        text = "" if value is None else str(value)
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"
