"""From command-line arguments to a mechanism and to a folder for results."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from linkages.components.mechanisms.definition import load
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError, Problem
from linkages.reading.overrides import parse_assignment

Given = TypeVar("Given")
Found = TypeVar("Found")


def mechanism_from(file: str, assignments: Sequence[str]) -> Mechanism:
    """Read a definition file with the values of ``--set`` put in.

    Raises
    ------
    InputError
        For anything wrong in the file or the assignments.
    """
    return load(file, set=overrides("--set", assignments))


def overrides(option: str, assignments: Sequence[str]) -> dict[str, object]:
    """Path → value of assignments that an option has."""
    return dict(each_read(option, assignments, parse_assignment))


def each_read(option: str, values: Sequence[Given], read: Callable[[Given], Found]) -> list[Found]:
    """What the values of an option are read as.

    Raises
    ------
    InputError
        Lists all that cannot be read.
    """
    found: list[Found] = []
    problems: list[Problem] = []
    for value in values:
        try:
            found.append(read(value))
        except InputError as error:
            problems += error.problems
        except ValueError as error:
            problems.append(Problem(message=str(error)))
    if problems:
        raise InputError(option, problems)
    return found


def require_folder(folder: Path) -> None:
    """Results are computed only if they can be written.

    Raises
    ------
    InputError
        If a folder cannot be made or written to.
    """
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not existing.is_dir():
        message = f"expected a folder for results, found a file: {existing}"
    elif not os.access(existing, os.W_OK | os.X_OK):
        message = f"expected a folder for results; {existing} cannot be written to"
    else:
        return
    raise InputError(str(folder), [Problem(message=message)])
