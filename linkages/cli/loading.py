"""From command-line arguments to a mechanism."""

from __future__ import annotations

from collections.abc import Sequence

from linkages.components.definition import load
from linkages.components.mechanism import Mechanism
from linkages.errors import InputError, Problem
from linkages.reading.overrides import parse_assignment


def mechanism_from(file: str, assignments: Sequence[str]) -> Mechanism:
    """Read a definition file with the values of ``--set`` put in.

    Raises
    ------
    InputError
        For anything wrong in the file or the assignments.
    """
    overrides: dict[str, object] = {}
    problems: list[Problem] = []
    for assignment in assignments:
        try:
            path, value = parse_assignment(assignment)
        except InputError as error:
            problems += error.problems
        else:
            overrides[path] = value
    if problems:
        raise InputError("--set", problems)
    return load(file, set=overrides)
