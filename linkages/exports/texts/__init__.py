"""Parts of programs that are the same for all mechanisms, in their own languages."""

from __future__ import annotations

from functools import cache
from importlib.resources import files


@cache
def fixed_text(name: str) -> str:
    """The text of a file of this folder."""
    return (files(__name__) / name).read_text(encoding="utf-8")
