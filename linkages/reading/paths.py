"""Dotted paths such as ``loads[0].force``: written from steps, and split into steps."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Any

KeyPath = tuple[str | int, ...]
"""Steps from the top of a definition file: keys of mappings, indices of lists."""

_PLAIN_KEY = re.compile(r"[\w -]{1,64}")
_SEGMENT = re.compile(r"(?P<key>[^\[\].]+)?(?P<indices>(?:\[[0-9]{1,9}\])*)")


def dotted(path: KeyPath) -> str:
    """Return the path as messages show it, for example ``"loads[0].force"``.

    A key that would break the line or the dots is quoted, and shortened where it is long.
    """
    text = ""
    for step in path:
        if isinstance(step, int):
            text += f"[{step}]"
            continue
        key = step if _PLAIN_KEY.fullmatch(step) else repr(step[:64])
        text += f".{key}" if text else key
    return text


@lru_cache(maxsize=4096)
def split(text: str) -> KeyPath | None:
    """Split a dotted path into steps; None where it is not one.

    ``loads[0]`` gives an index (int); ``loads.0`` gives the text ``"0"``, which is an index or a
    key depending on what it meets.
    """
    steps: list[str | int] = []
    for number, segment in enumerate(text.split(".")):
        match = _SEGMENT.fullmatch(segment.strip())
        if match is None or (match["key"] is None and (number == 0 or not match["indices"])):
            return None
        if match["key"] is not None:
            steps.append(match["key"].strip())
        steps.extend(int(index) for index in re.findall(r"[0-9]+", match["indices"]))
    return tuple(steps) if all(step != "" for step in steps) else None


def leads(container: object, step: str | int) -> bool:
    """Tell whether a step leads into a mapping or a list."""
    if isinstance(container, dict):
        return step in container
    return isinstance(container, list | tuple) and isinstance(step, int) and step < len(container)


def value_at(container: Any, path: KeyPath) -> Any:
    """Return what a path leads to, or None where it leads nowhere."""
    for step in path:
        if not leads(container, step):
            return None
        container = container[step]
    return container
