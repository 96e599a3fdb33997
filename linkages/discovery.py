"""What is found by itself: modules of a folder, entry points, and the HTML that notebooks show."""

from __future__ import annotations

import pkgutil
import warnings
from collections.abc import Callable
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from types import ModuleType
from typing import Any


@cache
def modules_of(package: str) -> tuple[ModuleType, ...]:
    """All modules of a package, without those of its subpackages, in alphabetical order."""
    paths = import_module(package).__path__
    names = sorted(item.name for item in pkgutil.iter_modules(paths) if not item.ispkg)
    return tuple(import_module(f"{package}.{name}") for name in names)


@cache
def plugged(group: str) -> tuple[tuple[str, Any], ...]:
    """Entry points of other packages: name and what it names.

    One that cannot be loaded is left out, with a warning: it must not take everything else along.
    """
    result = []
    for entry in sorted(entry_points(group=group), key=lambda entry: entry.name):
        try:
            result.append((entry.name, entry.load()))
        except Exception as error:  # whatever a foreign module does when it is imported
            warnings.warn(f"entry point {group}: {entry.value}: {error}", stacklevel=2)
    return tuple(result)


RENDERERS: dict[str, Callable[[Any], str]] = {}
"""Name of a class → function that returns HTML; `linkages` itself fills it."""


def html_of(thing: Any) -> str:
    """The HTML that notebooks show of an object."""
    return RENDERERS[type(thing).__name__](thing)
