"""Definition files as plain mappings in which each value has a position in the text.

Every scalar stays the text that was written: ``on``, ``no`` and ``1e-3`` mean something else to
YAML 1.1 than to the writer of a mechanism.
"""

from __future__ import annotations

import codecs
import csv
import logging
import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import yaml

from linkages.errors import InputError, Problem
from linkages.reading.paths import KeyPath, dotted, value_at
from linkages.reading.wording import shown, suggestion
from linkages.stamps import FORMATS, stamped

if TYPE_CHECKING:
    from linkages.stamps import Origin

# What YAML 1.2 calls printable; everything else (control characters, lone surrogates) is refused
# here, with a place, rather than by the YAML scanner without one.
_NOT_TEXT = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def decode(data: str | bytes, source: str) -> str:
    """Return the text of a UTF-8 file, without its byte order mark."""
    text = data.removeprefix("\ufeff") if isinstance(data, str) else _from_utf8(data, source)
    if bad := _NOT_TEXT.search(text):
        before = text[: bad.start()]
        code = ord(bad.group())
        result = f"byte 0x{code:02x}" if code < 0x80 else f"character U+{code:04X}"
        offset = len(before.encode(errors="surrogatepass"))
        if isinstance(data, bytes) and data.startswith(codecs.BOM_UTF8):
            offset += len(codecs.BOM_UTF8)
        raise InputError(source, [_not_text(result, offset, before)])
    return text


def csv_rows(text: str, source: str) -> list[tuple[int, list[str]]]:
    """Line numbers, from 1, and cells of a table, without empty lines and those that begin with #.

    Cells are separated by semicolons or tabs if the first line has any, otherwise by commas.
    """
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    first = lines[0][1] if lines else ""
    separator = next((mark for mark in ";\t" if mark in first), ",")
    rows = []
    for number, line in lines:
        try:
            rows.append((number, next(csv.reader([line], delimiter=separator))))
        except csv.Error:  # the one error of a single line
            message = f"a cell is longer than {csv.field_size_limit()} characters"
            raise InputError(source, [Problem(message=message, line=number, column=1)]) from None
    return rows


def _from_utf8(data: bytes, source: str) -> str:
    try:
        return data.decode("utf-8").removeprefix("\ufeff")
    except UnicodeDecodeError as error:
        before = data[: error.start].decode("utf-8")
        result = f"byte 0x{data[error.start]:02x}"
        raise InputError(source, [_not_text(result, error.start, before)]) from None


def _not_text(found: str, offset: int, before: str) -> Problem:
    message = f"{found} at byte offset {offset} is not text; expected a YAML file in UTF-8"
    line = len(re.findall("\r\n|\r|\n", before)) + 1
    column = len(re.split("[\r\n]", before)[-1].removeprefix("\ufeff")) + 1
    return Problem(message=message, line=line, column=column)


_SUFFIX = ".yaml"
_PACKAGE = Path(__file__).resolve().parent.parent


def shipped() -> dict[str, Path]:
    """Return the mechanisms shipped with the package by name, in alphabetical order."""
    return {path.stem: path for path in sorted(_folder().glob(f"*{_SUFFIX}"))}


def find(file: str | Path) -> Path:
    """Return the definition file meant by a path or by the name of a shipped mechanism.

    Raises InputError there is no such file and no such mechanism; names the nearest one.
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
        return [str(item) for item in sorted(path.parent.glob(f"*{_SUFFIX}"))]
    except (OSError, ValueError):
        return []


MAX_NODES = 400_000
MAX_COPIES = 20_000
MAX_DEPTH = 32
_NULLS = frozenset({"", "~", "null", "Null", "NULL"})
_TOO_DEEP = "exceeded maximum nesting depth"

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True)
class Plain:
    """Plain values (dict, list, str, None) of one YAML document."""

    content: Any  # the values; None for an empty document
    # (line, column), counted from 1, of each key and each list entry
    positions: dict[KeyPath, tuple[int, int]]
    # Everything wrong with the text; where there are any, `content` is not to be used
    problems: tuple[Problem, ...]


class _RefusedError(Exception):
    def __init__(self, message: str, mark: Any = None) -> None:
        super().__init__(message)
        self.problem = _problem(message, mark)


def is_null(text: str) -> bool:
    """Whether an unquoted scalar says that there is nothing."""
    return text in _NULLS


def plain(text: str) -> Plain:
    """Read one YAML document into plain values."""
    builder = _Builder()
    content = None
    try:
        builder.problems.extend(_stream_problems(text))
        node = yaml.compose(text, Loader=_Loader)
        if node is not None:
            content = builder.value(node, ())
    except _RefusedError as refused:
        builder.problems.append(refused.problem)
    except yaml.YAMLError as error:
        builder.problems.append(_syntax_problem(error))
    return Plain(content, builder.positions, tuple(builder.problems))


def _stream_problems(text: str) -> Iterator[Problem]:
    """Yield tags; refuse what must not reach the composer, which recurses and keeps every node."""
    documents = depth = nodes = 0
    for event in yaml.parse(text, Loader=_Loader):
        nodes += isinstance(event, yaml.NodeEvent)
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        documents += isinstance(event, yaml.DocumentStartEvent)
        if depth > MAX_DEPTH:
            raise _RefusedError(f"nested more than {MAX_DEPTH} deep", event.start_mark)
        if nodes > MAX_NODES:
            raise _RefusedError(f"more than {MAX_NODES} keys and values", event.start_mark)
        if documents > 1:
            message = "a second document starts here; expected one mechanism per file"
            raise _RefusedError(message, event.start_mark)
        tag = getattr(event, "tag", None)
        if tag is not None:
            message = f"tag {shown(_as_written(tag))} is not allowed; expected a plain value"
            yield _problem(message, event.start_mark)


@dataclass
class _Builder:
    """Walks the node graph; aliases are written out, so that no two places share a container."""

    positions: dict[KeyPath, tuple[int, int]] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    _met: set[int] = field(default_factory=set)
    _open: set[int] = field(default_factory=set)
    _copies: int = 0

    def value(self, node: yaml.Node, path: KeyPath) -> Any:
        self.positions.setdefault(path, _position(node.start_mark))
        identity = id(node)
        first = identity not in self._met
        if identity in self._open:
            self._report("this alias contains itself", path, node.start_mark)
            return None
        self._copies += not first
        if self._copies > MAX_COPIES:
            message = f"aliases expand to more than {MAX_COPIES} values"
            raise _RefusedError(message, node.start_mark)
        if len(path) > MAX_DEPTH:
            raise _RefusedError(f"aliases nest more than {MAX_DEPTH} deep", node.start_mark)
        self._met.add(identity)
        if isinstance(node, yaml.ScalarNode):
            return None if not node.style and is_null(node.value) else node.value
        self._open.add(identity)
        if isinstance(node, yaml.SequenceNode):
            content: Any = [self.value(item, (*path, i)) for i, item in enumerate(node.value)]
        else:
            content = self._mapping(node, path, first)
        self._open.discard(identity)
        return content

    def _mapping(self, node: yaml.Node, path: KeyPath, first: bool) -> dict[str, Any]:
        content: dict[str, Any] = {}
        lines: dict[str, int] = {}
        for key_node, value_node in node.value:
            problem = _key_problem(key_node, lines)
            if problem is not None:
                if first:
                    self._report(problem, path, key_node.start_mark)
                continue
            key = key_node.value
            lines[key] = key_node.start_mark.line + 1
            self.positions[(*path, key)] = _position(key_node.start_mark)
            content[key] = self.value(value_node, (*path, key))
        return content

    def _report(self, message: str, path: KeyPath, mark: Any) -> None:
        self.problems.append(_problem(message, mark, dotted(path)))


def _key_problem(node: yaml.Node, lines: dict[str, int]) -> str | None:
    if not isinstance(node, yaml.ScalarNode):
        return "a list or mapping cannot be a key; expected a word followed by ': '"
    if node.value == "<<" and not node.style:
        return "the merge key '<<' is not supported; write the keys out"
    if not node.value:
        return "a key is missing before ':'"
    if node.value in lines:
        return f"duplicate key {shown(node.value)}, first given in line {lines[node.value]}"
    return None


def _syntax_problem(error: yaml.YAMLError) -> Problem:
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    what = " ".join(str(getattr(error, "problem", None) or error).split())[:200]
    if what == _TOO_DEEP:  # libyaml looks at this first
        return _problem(f"nested more than {MAX_DEPTH} deep", mark)
    context, start = getattr(error, "context", None), getattr(error, "context_mark", None)
    if context and start:
        what += f" ({context} that starts in line {start.line + 1})"
    return _problem(f"not valid YAML: {what}", mark)


def _problem(message: str, mark: Any, path: str = "") -> Problem:
    line, column = _position(mark) if mark is not None else (None, None)
    return Problem(message=message, path=path, line=line, column=column)


def _position(mark: Any) -> tuple[int, int]:
    return mark.line + 1, mark.column + 1


def _as_written(tag: str) -> str:
    return tag.replace("tag:yaml.org,2002:", "!!", 1)


LOGGER = logging.getLogger(__name__)
MAX_BYTES = 10_000_000
_EXPECTED = "expected a mapping with keys such as joints, bars, drives"


@dataclass(frozen=True)
class Document:
    """Plain content of a definition file with the position of everything in it."""

    source: str  # the file, as messages name it
    # Mappings, lists, texts and None as written; numbers only where Python code set them
    content: dict[str, Any]
    # (line, column) of the key of each mapping entry and of each list entry, counted from 1
    positions: Mapping[KeyPath, tuple[int, int]]
    # For each path whose value is not the file's, the assignment it comes from
    overridden: Mapping[KeyPath, str] = field(default_factory=dict)
    # Where the file stands; None for a text that is no file. Files of tables are below it
    folder: FilePath | None = field(default=None, compare=False)
    # Of a definition that stands in results: `changes` of the one that they were computed from
    changed: tuple[str, ...] = field(default=(), compare=False)
    # Another folder below which files of tables may be
    tables: FilePath | None = field(default=None, compare=False)

    @property
    def changes(self) -> tuple[str, ...]:
        """Assignments that make this out of its file, each once."""
        own = dict.fromkeys(self.overridden.values())
        again = {text.partition("=")[0] for text in own}
        kept = (text for text in self.changed if text.partition("=")[0] not in again)
        return (*kept, *own)

    def value(self, path: KeyPath) -> Any:
        """Return what stands at a path, or None where nothing does."""
        return value_at(self.content, path)

    def locate(self, path: KeyPath) -> tuple[int, int] | None:
        """Return (line, column) of the value, or of the nearest enclosing one that has a place.

        None where the value was set from outside the file.
        """
        for enclosing in _outwards(path):
            if enclosing in self.overridden:
                return None
            if enclosing in self.positions:
                return self.positions[enclosing]
        return None

    def problem(self, path: KeyPath, message: str) -> Problem:
        """Return a problem at a path, with its position or with the assignment that set it."""
        for enclosing in _outwards(path):
            if origin := self.overridden.get(enclosing):
                return Problem(message=f"{message} (from set {origin})", path=dotted(path))
        line, column = self.locate(path) or (None, None)
        return Problem(message=message, path=dotted(path), line=line, column=column)


def _outwards(path: KeyPath) -> Iterator[KeyPath]:
    return (path[:length] for length in range(len(path), -1, -1))


def read(path: FilePath) -> Document:
    """Read a definition file, or the definition that a file of results was computed from."""
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
    result = stamped(path)
    if result is not None:
        return result
    if path.suffix.lower() not in FORMATS or path.suffix.lower() == ".json":
        return None
    message = "has no definition in it; expected a YAML file, or results that linkages wrote"
    raise InputError(str(path), [Problem(message=message)])


def parse(text: str | bytes, source: str) -> Document:
    """Read the text of a definition file."""
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
