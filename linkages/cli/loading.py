"""From command-line arguments to a mechanism and to a folder for results."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any, TypeVar

from linkages.analyses import options_of_analysis
from linkages.components.mechanisms.definition import load
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError, Problem
from linkages.options.asked import asked_in
from linkages.reading.locate import shipped
from linkages.reading.overrides import parse_assignment
from linkages.stamps import FORMATS, stamped

Given = TypeVar("Given")
Found = TypeVar("Found")


def mechanism_from(
    file: str, assignments: Sequence[str], tables_from: Path | None = None
) -> Mechanism:
    """Read a definition file with the values of ``--set`` put in.

    Raises
    ------
    InputError
        For anything wrong in the file or the assignments.
    """
    return load(file, set=overrides("--set", assignments), tables_from=tables_from)


INTEGRATION = ("method", "rtol", "atol", "step", "change_points")
"""Options that files of results say for every command."""


def results_in(file: str) -> str:
    """Of a folder of results, the file to compute from: that of `simulate`, or the only one.

    A store of a sweep is what it is: `sweep --status` describes it.
    """
    folder = Path(file)
    if not folder.is_dir() or file in shipped() or (folder / "manifest.json").is_file():
        return file
    found = sorted(folder.glob("*.nc"))
    wanted = [path for path in found if path.stem == "simulate"] or found
    return str(wanted[0]) if len(wanted) == 1 else file


def arguments_in(file: str, verb: str, assigned: Collection[str]) -> dict[str, Any]:
    """What a file of results was computed with, as far as a command takes it over.

    Parameters
    ----------
    file
        As on the command line; a definition file says nothing.
    verb
        The command.
    assigned
        Paths of ``--set``: what they say takes the place of what the file was computed with.
    """
    path = Path(file)
    origin = stamped(path) if path.suffix.lower() in FORMATS and path.is_file() else None
    if origin is None:
        return {}
    found = asked_in(origin.arguments, file, options_of_analysis(verb))
    if isinstance(outputs := found.get("outputs"), list):  # those that were computed
        found["outputs"] = None if origin.command else ",".join(outputs)
    same = origin.verb in (verb, None)
    return {
        name: value
        for name, value in found.items()
        if (same or name in INTEGRATION) and not {"simulate", f"simulate.{name}"} & set(assigned)
    }


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
