"""YAML text to plain values with positions; nothing in the text is executed or interpreted.

Every scalar stays the text that was written: ``on``, ``no`` and ``1e-3`` mean something else to
YAML 1.1 than to the writer of a mechanism.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import yaml

from linkages.errors import Problem
from linkages.reading.paths import Path, dotted
from linkages.reading.wording import shown

MAX_NODES = 200_000
MAX_COPIES = 20_000
MAX_DEPTH = 32
_NULLS = frozenset({"", "~", "null", "Null", "NULL"})
_TOO_DEEP = "exceeded maximum nesting depth"

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True)
class Plain:
    """Plain values (dict, list, str, None) of one YAML document.

    Parameters
    ----------
    content
        The values; None for an empty document.
    positions
        (line, column), counted from 1, of each key and each list entry.
    problems
        Everything wrong with the text; where there are any, `content` is not to be used.
    """

    content: Any
    positions: dict[Path, tuple[int, int]]
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

    positions: dict[Path, tuple[int, int]] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    _met: set[int] = field(default_factory=set)
    _open: set[int] = field(default_factory=set)
    _copies: int = 0

    def value(self, node: yaml.Node, path: Path) -> Any:
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

    def _mapping(self, node: yaml.Node, path: Path, first: bool) -> dict[str, Any]:
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

    def _report(self, message: str, path: Path, mark: Any) -> None:
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
