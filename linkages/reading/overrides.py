"""Values set from outside the file (``--set clearances.r1.size=0.1e-3``), one or many at once."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NoReturn, TypeAlias

import yaml

from linkages.errors import InputError, Problem
from linkages.reading.document import MAX_DEPTH, Document, decode, is_null, plain
from linkages.reading.paths import KeyPath, dotted, split, value_at
from linkages.reading.wording import nearest, shown

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats: TypeAlias = NDArray[np.float64]


class UndecidedError(ValueError):
    """What is asked of a column has no answer that all of its values share."""


class Column:
    """Values of one number, each treated as it would be alone, the same in all bits.

    Arithmetic is NumPy's. Comparisons are answered where all values agree. Whatever takes a column
    for a single number is refused with `UndecidedError` or `TypeError`: nothing is lost in silence.

    `values`: shape (n,).
    """

    __array_ufunc__ = None
    __hash__ = object.__hash__

    def __init__(self, values: Floats) -> None:
        self.values = values

    def _with(self, operation: Callable[..., Floats], *operands: Any) -> Any:
        if not all(isinstance(each, Column | int | float) for each in operands):
            return NotImplemented
        return Column(operation(*map(values_of, operands)))

    def __add__(self, other: Any) -> Any:
        return self._with(operator.add, self, other)

    def __radd__(self, other: Any) -> Any:
        return self._with(operator.add, other, self)

    def __sub__(self, other: Any) -> Any:
        return self._with(operator.sub, self, other)

    def __rsub__(self, other: Any) -> Any:
        return self._with(operator.sub, other, self)

    def __mul__(self, other: Any) -> Any:
        return self._with(operator.mul, self, other)

    def __rmul__(self, other: Any) -> Any:
        return self._with(operator.mul, other, self)

    def __truediv__(self, other: Any) -> Any:
        return self._with(operator.truediv, self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return self._with(operator.truediv, other, self)

    def __neg__(self) -> Column:
        return Column(-self.values)

    def __abs__(self) -> Column:
        return Column(abs(self.values))

    def __round__(self) -> Column:
        return Column(self.values.round())

    def _decided(self, other: Any, comparison: Callable[..., Any]) -> Any:
        if not isinstance(other, Column | int | float):
            return NotImplemented
        result = comparison(self.values, values_of(other))
        if result.any() and not result.all():
            raise UndecidedError("true of some values and not of others")
        return bool(result.all())

    def __lt__(self, other: Any) -> Any:
        return self._decided(other, operator.lt)

    def __le__(self, other: Any) -> Any:
        return self._decided(other, operator.le)

    def __gt__(self, other: Any) -> Any:
        return self._decided(other, operator.gt)

    def __ge__(self, other: Any) -> Any:
        return self._decided(other, operator.ge)

    def __eq__(self, other: object) -> Any:
        return self._decided(other, operator.eq)

    def __ne__(self, other: object) -> Any:
        return self._decided(other, operator.ne)

    def __bool__(self) -> bool:
        return bool(self != 0.0)

    def __float__(self) -> NoReturn:
        raise UndecidedError("a column is no single number")

    def __array__(self, *_: Any, **__: Any) -> NoReturn:
        raise UndecidedError("a column is no array of numbers")


def values_of(number: Any) -> Any:
    """The values of a column; any other number itself."""
    return number.values if isinstance(number, Column) else number


NEXT = re.compile(r",(?=\s*[A-Za-z_][^,={}()]*=)")
"""A comma before another assignment; commas within a value are followed by no equals sign."""


class _RefusedError(Exception):
    """Why one assignment cannot be made."""


def parse_assignment(text: str) -> tuple[str, str]:
    """Split ``"path=value"`` at the first equals sign."""
    path, equals, value = text.partition("=")
    if not equals or split(path.strip()) is None:
        message = f"expected path=value, such as clearances.r1.size=1e-4, found {shown(text)}"
        raise InputError("--set", [Problem(message=message)])
    return path.strip(), value.strip()


def apply(document: Document, overrides: Mapping[str, object]) -> Document:
    """Return the document with values replaced or added; the given one is left as it is.

    `overrides`: value by dotted path. Text is read as it would be after ``key:`` in the file;
    numbers are SI; quantities of pint carry their unit; lists, mappings and arrays are taken as
    they are. Missing mappings on the way are created; whether the result makes sense is for
    validation to say.
    """
    if not isinstance(overrides, Mapping):
        expected = 'expected a mapping of paths to values, such as {"clearances.r1.size": 1e-4}'
        raise TypeError(f"{expected}, found {overrides!r}")
    problems = []
    assigned = [split(str(text)) or () for text in overrides]
    for text, value in overrides.items():
        try:
            _check_new(document.content, split(str(text)) or (), assigned)
            document = _assigned(document, str(text), _written(value))
        except _RefusedError as reason:
            message = f"{reason} (from set {_assignment(text, value)})"
            problems.append(Problem(message=message, path=str(text)))
    if problems:
        raise InputError(document.source, problems)
    return document


def _assigned(document: Document, text: str, value: object) -> Document:
    steps = split(text)
    if steps is None:
        raise _RefusedError("expected a path such as clearances.r1.size or loads[0].force")
    raw = _from_text(value) if isinstance(value, str) else _raw(value, 0)
    path, created = _resolved(document.content, steps)
    content = _replaced(document.content, path, raw)
    origin = _assignment(text, value)
    overridden = {p: o for p, o in document.overridden.items() if not _within(p, path)}
    new = {path[:length]: origin for length in range(created, len(path) + 1)}
    positions = {p: at for p, at in document.positions.items() if not _within(p, path)}
    return replace(document, content=content, positions=positions, overridden=overridden | new)


def _check_new(content: Any, steps: KeyPath, assigned: list[KeyPath]) -> None:
    """Refuse to make a new entry for one value where an entry of nearly the same name exists."""
    for length in range(1, len(steps) - 1):
        parent, name = value_at(content, steps[:length]), steps[length]
        if not isinstance(parent, dict) or not isinstance(name, str) or name in parent:
            continue
        entry = steps[: length + 1]
        alone = sum(other[: length + 1] == entry for other in assigned) == 1
        if alone and (near := nearest(name, parent)):
            raise _RefusedError(f"unknown name {name!r}; did you mean {near!r}?")
        return


def _resolved(content: Any, steps: KeyPath) -> tuple[KeyPath, int]:
    """Follow the steps; return them with list indices as int, and how many of them exist.

    The last step counts as not existing: its value is what gets replaced.
    """
    path: list[str | int] = []
    exists = len(steps)
    node = content
    for number, step in enumerate(steps, start=1):
        if isinstance(node, list):
            step = _index(node, step, tuple(path))
            node = node[step]
        elif isinstance(node, dict) or node is None:
            if isinstance(step, int):
                result = shown(node)
                raise _RefusedError(f"{dotted(tuple(path))} is {result}; [{step}] needs a list")
            if node is None or step not in node:
                exists = min(exists, number)
            node = node.get(step) if node is not None else None
        else:
            raise _RefusedError(f"{dotted(tuple(path))} is {shown(node)}; {step!r} needs a mapping")
        path.append(step)
    return tuple(path), exists


def _index(node: list[Any], step: str | int, path: KeyPath) -> int:
    if isinstance(step, str) and not (step.isascii() and step.isdigit()):
        raise _RefusedError(f"{dotted(path)} is a list; expected an index, found {shown(step)}")
    if len(str(step)) > 9 or int(step) >= len(node):
        count = f"{len(node)} entr{'y' if len(node) == 1 else 'ies'}"
        raise _RefusedError(f"index {str(step)[:12]} is out of range: {dotted(path)} has {count}")
    return int(step)


def _replaced(node: Any, path: KeyPath, value: Any) -> Any:
    """Copy the containers along the path only; everything else is shared and never changed."""
    if not path:
        return value
    step, rest = path[0], path[1:]
    if isinstance(step, int):
        entries = list(node)
        entries[step] = _replaced(entries[step], rest, value)
        return entries
    mapping = dict(node or {})
    mapping[step] = _replaced(mapping.get(step), rest, value)
    return mapping


def _from_text(text: str) -> Any:
    """Read the text as the file would be read after ``key:``."""
    if "\n" in text or "\r" in text:
        raise _RefusedError("expected a value on one line")
    try:
        result = plain(f"value: {decode(text, '--set')}")
    except InputError as error:
        raise _RefusedError(error.problems[0].message) from None
    if result.problems:
        raise _RefusedError("; ".join(problem.message for problem in result.problems))
    return result.content["value"]


def _written(value: Any) -> Any:
    """A quantity of pint as a file would have it: its number, then its unit."""
    if not (hasattr(value, "magnitude") and hasattr(value, "units")):
        return value
    magnitude = value.magnitude
    if hasattr(magnitude, "tolist"):
        magnitude = magnitude.tolist()
    if isinstance(magnitude, list):
        return [_written(value[index]) for index in range(len(magnitude))]
    return f"{magnitude!r} {value.units:C}".removesuffix(" dimensionless").strip()


def _raw(value: Any, depth: int) -> Any:
    """Return a Python value in the terms of a document; arrays become lists."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if value is None or isinstance(value, str | int | float | Column):
        return value
    if depth > MAX_DEPTH:
        raise _RefusedError(f"the value is nested more than {MAX_DEPTH} deep")
    if isinstance(value, list | tuple):
        return [_raw(entry, depth + 1) for entry in value]
    if isinstance(value, Mapping):
        return {str(key): _raw(entry, depth + 1) for key, entry in value.items()}
    kind = type(value).__name__
    raise _RefusedError(f"expected a number, text, list or mapping, found a value of type {kind}")


def _assignment(path: object, value: object) -> str:
    if isinstance(value, str):
        return f"{path}={value if len(value) <= 60 and value.isprintable() else shown(value)}"
    text = repr(value.tolist() if hasattr(value, "tolist") else value)
    return f"{path}={' '.join(text[:60].split())}{'…' if len(text) > 60 else ''}"


def _within(path: KeyPath, ancestor: KeyPath) -> bool:
    return path[: len(ancestor)] == ancestor


_TEXT = "tag:yaml.org,2002:str"


class _Dumper(yaml.SafeDumper):
    """Writes all scalars without tags, for the reader takes them for texts, and without anchors."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012

    def ignore_aliases(self, data: Any) -> bool:  # noqa: ARG002
        """What stands at two places is written twice."""
        return True


def _text(dumper: _Dumper, value: str) -> yaml.Node:
    quoted = is_null(value) or value == "<<"  # mean something else without quotes
    return dumper.represent_scalar(_TEXT, value, style="'" if quoted else None)


def _number(dumper: _Dumper, value: object) -> yaml.Node:
    """Values that Python code put in; `repr` has all digits."""
    return dumper.represent_scalar(_TEXT, "null" if value is None else repr(value))


_Dumper.add_representer(str, _text)
for _kind in (int, float, bool, type(None)):
    _Dumper.add_representer(_kind, _number)


def as_yaml(document: Document) -> str:
    """The definition with all values put in, as YAML that is read as the same content.

    Comments are lost.
    """
    return yaml.dump(
        document.content,
        Dumper=_Dumper,
        default_flow_style=None,  # innermost lists and mappings on one line
        sort_keys=False,
        allow_unicode=True,
        width=100,
    )
