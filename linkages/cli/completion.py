"""What a shell offers after a key: definition files here, and mechanisms of the library."""

from __future__ import annotations

import os
from pathlib import Path

SUFFIXES = (".yaml", ".yml")


def complete_file(incomplete: str) -> list[str]:
    """Definition files and folders that begin as given, then shipped mechanisms."""
    from linkages.reading.locate import shipped

    return [*_paths(incomplete), *(name for name in shipped() if name.startswith(incomplete))]


def _paths(incomplete: str) -> list[str]:
    folder, begun = os.path.split(incomplete)
    try:
        entries = sorted(Path(folder or ".").expanduser().iterdir())
    except OSError:
        return []
    return [
        os.path.join(folder, entry.name) + (os.sep if entry.is_dir() else "")
        for entry in entries
        if entry.name.startswith(begun)
        and (entry.name.startswith(".") <= begun.startswith("."))
        and (entry.is_dir() or entry.suffix in SUFFIXES)
    ]
