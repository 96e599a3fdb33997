"""Which file is meant: a path, or the name of a mechanism shipped with the package."""

from __future__ import annotations

import os
from pathlib import Path

from linkages.errors import InputError, Problem
from linkages.reading.wording import suggestion

_SUFFIX = ".yaml"
_PACKAGE = Path(__file__).resolve().parent.parent


def shipped() -> dict[str, Path]:
    """Return the mechanisms shipped with the package by name, in alphabetical order."""
    return {path.stem: path for path in sorted(_folder().glob(f"*{_SUFFIX}"))}


def find(file: str | Path) -> Path:
    """Return the definition file meant by a path or by the name of a shipped mechanism.

    Raises
    ------
    InputError
        There is no such file and no such mechanism; names the nearest one.
    """
    path, text = Path(file), str(file)
    if os.path.exists(path) and not os.path.isdir(path):
        return path
    mechanisms = shipped()
    by_name = mechanisms.get(text.removesuffix(_SUFFIX))
    if by_name is not None:
        return by_name
    if os.path.isdir(path):
        message = "is a directory; expected a YAML file or the name of a shipped mechanism"
    else:
        near = suggestion(path.name.removesuffix(_SUFFIX), [*mechanisms, *_neighbours(path)])
        message = (
            "no such file, and no mechanism of that name is shipped"
            f"{near or ';'} `python -m linkages list` shows all that are"
        )
    raise InputError(text, [Problem(message=message)])


def _folder() -> Path:
    """Return the folder of mechanisms: inside an installed wheel, beside a source checkout."""
    installed = _PACKAGE / "mechanisms"
    return installed if installed.is_dir() else _PACKAGE.parent / "mechanisms"


def _neighbours(path: Path) -> list[str]:
    """Return the definition files that stand where the missing one was looked for."""
    try:
        return [str(found) for found in sorted(path.parent.glob(f"*{_SUFFIX}"))]
    except (OSError, ValueError):
        return []
