"""Raw mappings to validated objects, with every problem at its place in the file."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any, TypeVar, cast

from pydantic import TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from linkages.errors import Problem
from linkages.reading.document import Document
from linkages.reading.paths import Path, leads, value_at
from linkages.reading.wording import nearest, shown, suggestion
from linkages.spec.expectation import annotation_at, example, expectation, keys, literals

Model = TypeVar("Model")
_UNKNOWN_KEY = ("unexpected_keyword_argument", "extra_forbidden")
_DECIMALS = re.compile(r"\d+( *[^\W\d].*)?")
_WHOLE = re.compile(r"[-+]?\d+")
_POINT = "; decimals are written with a point, as in 0.5, not 0,5"
_OWN_WORDS = ("value_error", "assertion_error")
# What pydantic finds wrong with the shape of a value; the annotation says it better.
_SHAPE = (
    "tuple_type", "list_type", "dict_type", "dataclass_type", "string_type", "bool_type",
    "bool_parsing", "literal_error", "too_long", "too_short",
)  # fmt: skip


@dataclass(frozen=True)
class _Fault:
    path: Path
    message: str
    union: Path | None
    custom: bool

    @property
    def rank(self) -> tuple[int, bool]:
        """The deeper a fault lies, the closer its alternative is to what was meant."""
        return len(self.path), self.custom


def validated(
    model: type[Model],
    raw: object,
    document: Document,
    path: Path,
    problems: list[Problem],
    **given: object,
) -> Model | None:
    """Return the validated object, or None after adding what is wrong to `problems`.

    Parameters
    ----------
    model
        A pydantic dataclass that forbids extra keys.
    raw
        The mapping of the definition file.
    document, path
        Where the mapping stands.
    problems
        Gets one entry for each thing that is wrong.
    given
        Fields that do not stand in the mapping, such as a name that is the key of the entry.
    """
    if not isinstance(raw, dict):
        message = f"expected a mapping such as {example(model, without=given)}, found {shown(raw)}"
        problems.append(document.problem(path, message))
        return None
    taken = [key for key in raw if key in given]
    for key in taken:
        message = _unknown_key(key, model, given)
        problems.append(document.problem((*path, key), message))
    values = {**raw, **given}
    try:
        instance: Model = _adapter(cast(Any, model)).validate_python(values)
    except ValidationError as error:
        problems.extend(problems_from(error, document, path, model, raw=values, given=given))
        return None
    return None if taken else instance


def problems_from(
    error: ValidationError,
    document: Document,
    prefix: Path,
    model: type,
    *,
    raw: object,
    given: Collection[str] = (),
) -> list[Problem]:
    """Translate what pydantic found into problems at their places in the file.

    Parameters
    ----------
    error
        From validating `raw` as `model`.
    document, prefix
        Where the mapping stands.
    model
        The pydantic dataclass.
    raw
        What was validated: it tells the steps of a path from the marks that pydantic adds.
    given
        Keys of `raw` that do not stand in the file, and so are not among the expected ones.
    """
    faults = [_fault(details, model, raw, given) for details in error.errors(include_url=False)]
    kept = dict.fromkeys((fault.path, fault.message) for fault in _most_telling(faults))
    return [
        document.problem(_in_document(document, prefix, path), message) for path, message in kept
    ]


@cache
def _adapter(model: Any) -> TypeAdapter[Any]:
    return TypeAdapter(model)


def _fault(details: ErrorDetails, model: type, raw: object, given: Collection[str]) -> _Fault:
    location = details["loc"]
    missing = location[-1] if details["type"] == "missing" else None
    path, union = _steps(location if missing is None else location[:-1], raw)
    if missing is not None:
        message = _missing(missing, model, path, value_at(raw, path))
    elif details["type"] in _UNKNOWN_KEY:
        parent = path[:-1]
        owner = annotation_at(model, parent)
        message = _unknown_key(str(path[-1]), owner, () if parent else given)
    else:
        message = _wrong_value(details, annotation_at(model, path), path == union)
    return _Fault(path, message, union, details["type"] == "linkages")


def _steps(location: Iterable[str | int], raw: object) -> tuple[Path, Path | None]:
    """Return the part of a location that leads through the raw values.

    Also returns the path of the first union, whose alternatives pydantic names in between.
    """
    path: Path = ()
    union = None
    for step in location:
        if leads(raw, step):
            raw = value_at(raw, (step,))
            path = (*path, step)
        elif union is None:
            union = path
    return path, union


def _most_telling(faults: list[_Fault]) -> list[_Fault]:
    """Of what the alternatives of one union complain about, keep the most specific."""
    best: dict[Path, tuple[int, bool]] = {}
    for fault in faults:
        if fault.union is not None:
            best[fault.union] = max(best.get(fault.union, fault.rank), fault.rank)
    return [f for f in faults if f.union is None or f.rank == best[f.union]]


def _in_document(document: Document, prefix: Path, path: Path) -> Path:
    """Return the path without steps that lead nowhere in the file: given fields, wrappings."""
    written = document.value(prefix)
    return prefix + (path if written is None else _steps(path, written)[0])


def _missing(key: str | int, model: type, path: Path, found: object) -> str:
    if isinstance(key, int):
        words = expectation(annotation_at(model, path)) or "a longer list"
        return f"expected {words}, found {shown(found)}"
    hint = expectation(annotation_at(model, (*path, key)))
    return f"missing key {key!r}" + (f": expected {hint}" if hint else "")


def _unknown_key(key: str, model: Any, given: Collection[str]) -> str:
    if _DECIMALS.fullmatch(key):  # {length: 30,5 mm}
        return f"unknown key {shown(key)}{_POINT}"
    known = [name for name in keys(model) if name not in given]
    start = f"unknown key {shown(key)}"
    if remedy := getattr(model, "misplaced", {}).get(key):
        return f"{start}: {remedy}"
    if near := nearest(key, known):
        return f"{start}; did you mean {near!r}?"
    return f"{start}; expected {'one of: ' if len(known) > 1 else ''}{', '.join(known)}"


def _commas(details: ErrorDetails) -> str:
    """What to say of a list with too many entries, for YAML splits [30,5 mm, 0] at each comma."""
    found = [str(entry) for entry in details["input"]] if details["type"] == "too_long" else []
    pairs = pairwise(found)
    return _POINT if any(_WHOLE.fullmatch(a) and _DECIMALS.fullmatch(b) for a, b in pairs) else ""


def _wrong_value(details: ErrorDetails, annotation: Any, in_union: bool) -> str:
    context = details.get("ctx", {})
    found = shown(details["input"])
    if details["type"] in _OWN_WORDS:
        return str(context["error"])
    words = expectation(annotation) if annotation is not None else None
    if words and (in_union or details["type"] in _SHAPE):
        near = suggestion(str(details["input"]), literals(annotation))
        return f"expected {words}, found {context.get('found', found)}{near}{_commas(details)}"
    if details["type"] == "linkages" or not details["msg"].startswith("Input should be "):
        return details["msg"]
    return f"expected {details['msg'].removeprefix('Input should be ')}, found {found}"
