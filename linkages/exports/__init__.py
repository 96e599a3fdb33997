"""Formats that mechanisms are exported to: those that files here list in `EXPORTS`.

Modules here import what they need when they run, so that ``--help`` answers at once.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkages.discovery import modules_of, plugged
from linkages.errors import InputError
from linkages.options.option import OptionError
from linkages.reading.wording import suggestion

if TYPE_CHECKING:
    from linkages.components.mechanisms.mechanism import Mechanism
    from linkages.kernel.system import System
    from linkages.options.run import SimulationOptions
    from linkages.solution.solution import Solution

GROUP = "linkages.exports"
"""Entry points that name formats, and the folder of those of this package."""


@dataclass(frozen=True)
class Subject:
    """What is exported: a mechanism, assembled or moved only if a format asks for it."""

    mechanism: Mechanism  # as it was read
    name: str  # what files are called, without ending
    given: Solution | None = None  # its motion, if there is one already
    # Of its motion otherwise, as `linkages.simulate` takes them
    options: Mapping[str, Any] = field(default_factory=dict)
    # Sentences on what a format changes, which it adds
    notes: list[str] = field(default_factory=list)

    @cached_property
    def system(self) -> System:
        """The mechanism, assembled at its initial state."""
        if self.given is not None:
            return self.given.system
        from linkages.kernel.system import System

        return System(self.mechanism)

    @cached_property
    def simulation(self) -> SimulationOptions:
        """How the motion is computed if nothing else is said."""
        from linkages.options.run import SimulationOptions
        from linkages.solution.run_options import options_of

        return options_of(SimulationOptions, self.mechanism, self.options)

    @cached_property
    def solution(self) -> Solution:
        """The motion that is given, or the one that the definition asks for."""
        if self.given is not None:
            return self.given
        from linkages.solution.simulate import simulate

        return simulate(self.mechanism, **self.options)


Export = Callable[..., Mapping[str, str | bytes]]
"""A function of a `Subject` and of options by keyword: name → content of each file.

Its name is that of the format; its docstring says what is written."""


def exports() -> dict[str, Export]:
    """All formats by name."""
    own = [function for module in modules_of(GROUP) for function in module.EXPORTS]
    own.sort(key=lambda function: function.__name__)
    return {made.__name__: made for made in (*own, *(made for _, made in plugged(GROUP)))}


def files_of(subject: Subject, to: str, options: Mapping[str, Any]) -> Mapping[str, str | bytes]:
    """Name → content of each file of a format.

    Raises OptionError for an unknown format, or an option that it does not have; it is a
    ValueError.
    """
    known = exports()
    if to not in known:
        near = suggestion(to, known) or f"; expected one of: {', '.join(known)}"
        raise OptionError("to", f"unknown format {to!r}{near}")
    own = list(inspect.signature(known[to]).parameters)[1:]
    for name in options:
        if name not in own:
            has = f"it has: {', '.join(own)}" if own else "it has none"
            raise OptionError(name, f"format {to!r} has no option {name!r}; {has}")
    return known[to](subject, **options)


def written(files: Mapping[str, str | bytes], folder: Path) -> list[Path]:
    """Write files into a folder, each whole or not at all; returns where they are."""
    from linkages.reading.output_files import replaced

    for name, content in files.items():
        with replaced(folder / name) as temporary:
            data = content.encode("utf-8") if isinstance(content, str) else content
            temporary.write_bytes(data)
    return [folder / name for name in files]


def export(
    what: Mechanism | Solution,
    to: str,
    folder: str | Path = ".",
    *,
    name: str | None = None,
    **options: Any,
) -> list[Path]:
    """Write a mechanism, or one with its motion, for another program.

    Parameters
    ----------
    what
        A mechanism, or a solution: its motion is then taken for what shows motions.
    to
        The format, such as ``"svg"`` or ``"dxf"``.
    folder
        Made if it does not exist.
    name
        What files are called, without ending; default: the name of the mechanism, in small letters
        with hyphens.
    **options
        Of the format.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    ValueError
        For an unknown format, or an option that it does not have; nothing is written then.
    FileExistsError
        If a file of such a name says nothing of its origin: another program's, or somebody's own.
    """
    from linkages.solution.files import origin_of
    from linkages.solution.solution import Solution
    from linkages.stamps import FORMATS, stamp

    mechanism, given = (what.mechanism, what) if isinstance(what, Solution) else (what, None)
    stem = name or re.sub(r"[^a-z0-9]+", "-", mechanism.name.lower()).strip("-") or "mechanism"
    files = files_of(Subject(mechanism, stem, given), to, options)
    for path in (Path(folder) / file for file in files):
        if path.suffix in FORMATS and path.exists() and not _ours(path):
            raise FileExistsError(
                f"{path}: is there, and does not say that linkages wrote it; expected another "
                "'name' or 'folder', or its removal"
            )
    paths = written(files, Path(folder))
    for path in paths:
        stamp(path, origin_of(mechanism, {"to": to, **options}))
    return paths


def _ours(path: Path) -> bool:
    """Whether a file says that this package wrote it."""
    from linkages.stamps import stamped

    try:
        return stamped(path) is not None
    except InputError:  # it is damaged, or too large
        return False
