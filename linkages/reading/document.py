"""A definition file as a plain mapping that knows where each value stands in the text."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from linkages.errors import InputError, Problem
from linkages.reading.decoding import decode
from linkages.reading.nodes import plain
from linkages.reading.paths import Path, dotted, value_at
from linkages.reading.wording import shown
from linkages.stamps import FORMATS, stamped

if TYPE_CHECKING:
    from linkages.stamps.origins import Origin

LOGGER = logging.getLogger(__name__)
MAX_BYTES = 10_000_000
_EXPECTED = "expected a mapping with keys such as joints, bars, drives"


@dataclass(frozen=True)
class Document:
    """Plain content of a definition file with the position of everything in it.

    Parameters
    ----------
    source
        The file, as messages name it.
    content
        Mappings, lists, texts and None as written; numbers only where Python code set them.
    positions
        (line, column) of the key of each mapping entry and of each list entry, counted from 1.
    overridden
        For each path whose value is not the file's, the assignment it comes from.
    folder
        Where the file stands; None for a text that is no file. Files of tables are below it.
    changed
        Of a definition that stands in results: `changes` of the one that they were computed from.
    tables
        Another folder below which files of tables may be.
    """

    source: str
    content: dict[str, Any]
    positions: Mapping[Path, tuple[int, int]]
    overridden: Mapping[Path, str] = field(default_factory=dict)
    folder: FilePath | None = field(default=None, compare=False)
    changed: tuple[str, ...] = field(default=(), compare=False)
    tables: FilePath | None = field(default=None, compare=False)

    @property
    def changes(self) -> tuple[str, ...]:
        """Assignments that make this out of its file, each once."""
        own = dict.fromkeys(self.overridden.values())
        again = {text.partition("=")[0] for text in own}
        kept = (text for text in self.changed if text.partition("=")[0] not in again)
        return (*kept, *own)

    def value(self, path: Path) -> Any:
        """Return what stands at a path, or None where nothing does."""
        return value_at(self.content, path)

    def locate(self, path: Path) -> tuple[int, int] | None:
        """Return (line, column) of the value, or of the nearest enclosing one that has a place.

        None where the value was set from outside the file.
        """
        for enclosing in _outwards(path):
            if enclosing in self.overridden:
                return None
            if enclosing in self.positions:
                return self.positions[enclosing]
        return None

    def problem(self, path: Path, message: str) -> Problem:
        """Return a problem at a path, with its position or with the assignment that set it."""
        for enclosing in _outwards(path):
            if origin := self.overridden.get(enclosing):
                return Problem(message=f"{message} (from set {origin})", path=dotted(path))
        line, column = self.locate(path) or (None, None)
        return Problem(message=message, path=dotted(path), line=line, column=column)


def _outwards(path: Path) -> Iterator[Path]:
    return (path[:length] for length in range(len(path), -1, -1))


def read(path: FilePath) -> Document:
    """Read a definition file, or the definition that a file of results was computed from.

    Raises
    ------
    InputError
        The file cannot be read, or `parse` refuses its text.
    """
    source = str(path)
    LOGGER.info("reading %s", path)
    try:
        with open(path, "rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        reason = _reason(error)
        raise InputError(source, [Problem(message=reason)]) from error
    except ValueError as error:
        raise InputError(source, [Problem(message=f"not a file name: {error}")]) from error
    if recorded := _recorded(path):
        return replace(parse(recorded.definition, source), changed=tuple(recorded.changes))
    if len(data) > MAX_BYTES:
        message = f"larger than {MAX_BYTES // 10**6} MB; expected the definition of a mechanism"
        raise InputError(source, [Problem(message=message)])
    return replace(parse(data, source), folder=path.parent)


def _recorded(path: FilePath) -> Origin | None:
    """What results were computed from; None for a definition file."""
    found = stamped(path)
    if found is not None:
        return found
    if path.suffix.lower() not in FORMATS or path.suffix.lower() == ".json":
        return None
    message = "has no definition in it; expected a YAML file, or results that linkages wrote"
    raise InputError(str(path), [Problem(message=message)])


def parse(text: str | bytes, source: str) -> Document:
    """Read the text of a definition file.

    Raises
    ------
    InputError
        Lists everything that is wrong with the text as YAML: syntax, duplicate keys, tags.
    """
    result = plain(decode(text, source))
    if result.problems:
        raise InputError(source, result.problems)
    if not result.positions:
        raise InputError(source, [Problem(message=f"the file is empty; {_EXPECTED}")])
    if not isinstance(result.content, dict):
        line, column = result.positions[()]
        message = f"{_EXPECTED}, found {shown(result.content)}"
        raise InputError(source, [Problem(message=message, line=line, column=column)])
    return Document(source, result.content, result.positions)


def _reason(error: OSError) -> str:
    if isinstance(error, IsADirectoryError):
        return "is a directory; expected a YAML file"
    if isinstance(error, FileNotFoundError):
        return "no such file"
    if isinstance(error, PermissionError):
        return "cannot be read: permission denied"
    return f"cannot be read: {error.strerror or error}"
