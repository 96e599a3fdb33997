"""Raw mappings to validated objects; all problems are reported at once with their positions."""

from __future__ import annotations

import re
import typing
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any, Literal, TypeVar, cast, get_args, get_origin

from pydantic import TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from linkages.errors import Problem
from linkages.reading.document import Document
from linkages.reading.paths import KeyPath, leads, value_at
from linkages.reading.wording import listed, nearest, shown, suggestion
from linkages.spec.law_fields import LawRule
from linkages.spec.models import (
    LISTS,
    alternatives,
    entries_of,
    fields,
    infos_of,
    open_ended,
    rule_of,
    stripped,
)
from linkages.spec.quantities import NameRule, Quantity

_COUNTS = {1: "one", 2: "two", 3: "three", 4: "four"}


def annotation_at(annotation: Any, path: KeyPath) -> Any:
    """Return the annotation that a path leads to, or None where it leads nowhere."""
    if not path:
        return annotation
    for arm in alternatives(annotation):
        step, rest = path[0], path[1:]
        inner = _entered(stripped(arm), step)
        result = annotation_at(inner, rest) if inner is not None else None
        if result is not None:
            return result
    return None


def expectation(annotation: Any) -> str | None:
    """Return for example ``"a list of two names, such as [A, B]"``; None where nothing is known."""
    if rule := rule_of(annotation):
        return rule.expected()
    arms = alternatives(annotation)
    if len(arms) > 1:
        words = [words for arm in arms if (words := expectation(arm))]
        return " or ".join(words) or None
    bare = stripped(arms[0])
    if get_origin(bare) is Literal:
        return listed(repr(word) for word in get_args(bare))
    if get_origin(bare) in LISTS:
        return _list_expectation(bare)
    if infos_of(bare):
        return f"a mapping such as {example(bare)}"
    if get_origin(bare) is dict or bare is dict:
        return "a mapping"
    return {bool: "true or false", str: "text"}.get(bare)


def example(annotation: Any, number: int = 0, without: Collection[str] = ()) -> str:
    """Return a value as it could stand in a file.

    `number` varies it within a list; keys in `without` do not stand in the file.
    """
    annotation = alternatives(annotation)[0]
    rule, bare = rule_of(annotation), stripped(annotation)
    if isinstance(rule, NameRule):
        return "ABCDEF"[number % 6]
    if rule is not None:
        return (
            f"{0.3 + number / 10:.1f}"
            if isinstance(rule, Quantity | LawRule)
            else str(100 + number)
        )
    if get_origin(bare) is Literal:
        return str(get_args(bare)[0])
    if get_origin(bare) in LISTS:
        entries = entries_of(bare)[:4]
        return f"[{', '.join(example(entry, i) for i, entry in enumerate(entries))}]"
    if required := infos_of(bare):
        own = [key for key in required if key not in without]
        names = [key for key in own if required[key].is_required()] or own[:1]
        inside = fields(bare)
        return f"{{{', '.join(f'{key}: {example(inside[key])}' for key in names)}}}"
    return "…"


def keys(annotation: Any) -> list[str]:
    """Return the keys of the mapping that an annotation stands for."""
    models: list[Any] = [stripped(arm) for arm in alternatives(annotation)]
    return [key for model in models if infos_of(model) for key in fields(model)]


def literals(annotation: Any) -> list[str]:
    """Return the words that may stand literally."""
    bare = [stripped(arm) for arm in alternatives(annotation)]
    return [str(word) for arm in bare if get_origin(arm) is Literal for word in get_args(arm)]


def _list_expectation(annotation: Any) -> str:
    entries = entries_of(annotation)
    rules = [rule_of(entry) for entry in entries]
    kind = "entries"
    if all(isinstance(rule, NameRule) for rule in rules):
        kind = "names"
    elif all(isinstance(rule, Quantity | LawRule) for rule in rules):
        spoken = typing.cast(Quantity | LawRule, rules[0]).dimension.spoken
        kind = f"numbers ({spoken}, or with units)" if spoken else "numbers"
    count = "" if open_ended(annotation) else f"{_COUNTS.get(len(entries), len(entries))} "
    return f"a list of {count}{kind}, such as {example(annotation)}"


def _entered(annotation: Any, step: str | int) -> Any:
    """Return the annotation one step further in, or None."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if isinstance(step, str) and infos_of(annotation):
        return fields(annotation).get(step)
    if origin is dict and isinstance(step, str):
        return arguments[1]
    if origin in LISTS and isinstance(step, int):
        if open_ended(annotation):
            return arguments[0]
        return arguments[step] if step < len(arguments) else None
    return None


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
    path: KeyPath
    message: str
    union: KeyPath | None
    custom: bool

    @property
    def rank(self) -> tuple[int, bool]:
        """The deeper a fault lies, the closer its alternative is to what was meant."""
        return len(self.path), self.custom


def validated(
    model: type[Model],
    raw: object,
    document: Document,
    path: KeyPath,
    problems: list[Problem],
    **given: object,
) -> Model | None:
    """Return the validated object, or None after adding what is wrong to `problems`."""
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
    prefix: KeyPath,
    model: type,
    *,
    raw: object,
    given: Collection[str] = (),
) -> list[Problem]:
    """Translate what pydantic found into problems at their places in the file."""
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


def _steps(location: Iterable[str | int], raw: object) -> tuple[KeyPath, KeyPath | None]:
    """Return the part of a location that leads through the raw values.

    Also returns the path of the first union, whose alternatives pydantic names in between.
    """
    path: KeyPath = ()
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
    best: dict[KeyPath, tuple[int, bool]] = {}
    for fault in faults:
        if fault.union is not None:
            best[fault.union] = max(best.get(fault.union, fault.rank), fault.rank)
    return [f for f in faults if f.union is None or f.rank == best[f.union]]


def _in_document(document: Document, prefix: KeyPath, path: KeyPath) -> KeyPath:
    """Return the path without steps that lead nowhere in the file: given fields, wrappings."""
    written = document.value(prefix)
    return prefix + (path if written is None else _steps(path, written)[0])


def _missing(key: str | int, model: type, path: KeyPath, found: object) -> str:
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
    result = [str(entry) for entry in details["input"]] if details["type"] == "too_long" else []
    pairs = pairwise(result)
    return _POINT if any(_WHOLE.fullmatch(a) and _DECIMALS.fullmatch(b) for a, b in pairs) else ""


def _wrong_value(details: ErrorDetails, annotation: Any, in_union: bool) -> str:
    context = details.get("ctx", {})
    result = shown(details["input"])
    if details["type"] in _OWN_WORDS:
        return str(context["error"])
    words = expectation(annotation) if annotation is not None else None
    if words and (in_union or details["type"] in _SHAPE):
        near = suggestion(str(details["input"]), literals(annotation))
        return f"expected {words}, found {context.get('found', result)}{near}{_commas(details)}"
    if details["type"] == "linkages" or not details["msg"].startswith("Input should be "):
        return details["msg"]
    return f"expected {details['msg'].removeprefix('Input should be ')}, found {result}"
