"""What notebooks show of objects: functions of packages above that of the object."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

RENDERERS: dict[str, Callable[[Any], str]] = {}
"""Name of a class → function that returns HTML; `linkages` itself fills it."""


def html_of(thing: Any) -> str:
    """The HTML that notebooks show of an object."""
    return RENDERERS[type(thing).__name__](thing)
