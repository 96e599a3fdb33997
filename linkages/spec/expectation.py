"""What a field of a definition expects, in words, derived from the annotations of its model."""

from __future__ import annotations

import types
import typing
from collections.abc import Collection, Mapping
from functools import cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from linkages.reading.paths import Path
from linkages.reading.wording import listed
from linkages.spec.laws import LawRule
from linkages.spec.quantities import FieldType, NameRule, Quantity

_COUNTS = {1: "one", 2: "two", 3: "three", 4: "four"}
_FIELDS = "__pydantic_fields__"
_LISTS = (tuple, list)


@cache
def fields(model: type) -> dict[str, Any]:
    """Return the annotations of a pydantic dataclass by key, with their metadata."""
    found = {}
    variables = getattr(get_origin(model), "__parameters__", ())
    values = dict(zip(variables, get_args(model), strict=True))
    for name, info in _infos(model).items():
        annotation = _filled(info.annotation, values)
        annotated = Annotated[(annotation, *info.metadata)] if info.metadata else None
        found[name] = annotated or annotation
    return found


def _infos(model: Any) -> dict[str, Any]:
    """Return pydantic's information by key as the file writes it; a class may be a generic one."""
    infos = getattr(get_origin(model) or model, _FIELDS, {})
    return {info.alias or name: info for name, info in infos.items()}


def _filled(annotation: Any, values: Mapping[Any, Any]) -> Any:
    """Return an annotation with the type variables of a generic class replaced."""
    if annotation in values:
        return values[annotation]
    variables = getattr(annotation, "__parameters__", ())
    return annotation[tuple(values[v] for v in variables)] if variables else annotation


def annotation_at(annotation: Any, path: Path) -> Any:
    """Return the annotation that a path leads to, or None where it leads nowhere."""
    if not path:
        return annotation
    for arm in _arms(annotation):
        step, rest = path[0], path[1:]
        inner = _entered(_bare(arm), step)
        found = annotation_at(inner, rest) if inner is not None else None
        if found is not None:
            return found
    return None


def expectation(annotation: Any) -> str | None:
    """Return for example ``"a list of two names, such as [A, B]"``; None where nothing is known."""
    if rule := _rule(annotation):
        return rule.expected()
    arms = _arms(annotation)
    if len(arms) > 1:
        words = [words for arm in arms if (words := expectation(arm))]
        return " or ".join(words) or None
    bare = _bare(arms[0])
    if get_origin(bare) is Literal:
        return listed(repr(word) for word in get_args(bare))
    if get_origin(bare) in _LISTS:
        return _list_expectation(bare)
    if _infos(bare):
        return f"a mapping such as {example(bare)}"
    if get_origin(bare) is dict or bare is dict:
        return "a mapping"
    return {bool: "true or false", str: "text"}.get(bare)


def example(annotation: Any, number: int = 0, without: Collection[str] = ()) -> str:
    """Return a value as it could stand in a file.

    `number` varies it within a list; keys in `without` do not stand in the file.
    """
    annotation = _arms(annotation)[0]
    rule, bare = _rule(annotation), _bare(annotation)
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
    if get_origin(bare) in _LISTS:
        entries = _entries(bare)[:4]
        return f"[{', '.join(example(entry, i) for i, entry in enumerate(entries))}]"
    if required := _infos(bare):
        own = [key for key in required if key not in without]
        names = [key for key in own if required[key].is_required()] or own[:2]
        inside = fields(bare)
        return f"{{{', '.join(f'{key}: {example(inside[key])}' for key in names)}}}"
    return "…"


def keys(annotation: Any) -> list[str]:
    """Return the keys of the mapping that an annotation stands for."""
    models: list[Any] = [_bare(arm) for arm in _arms(annotation)]
    return [key for model in models if _infos(model) for key in fields(model)]


def literals(annotation: Any) -> list[str]:
    """Return the words that may stand literally."""
    bare = [_bare(arm) for arm in _arms(annotation)]
    return [str(word) for arm in bare if get_origin(arm) is Literal for word in get_args(arm)]


def _list_expectation(annotation: Any) -> str:
    entries = _entries(annotation)
    rules = [_rule(entry) for entry in entries]
    kind = "entries"
    if all(isinstance(rule, NameRule) for rule in rules):
        kind = "names"
    elif all(isinstance(rule, Quantity | LawRule) for rule in rules):
        spoken = typing.cast(Quantity | LawRule, rules[0]).dimension.spoken
        kind = f"numbers ({spoken}, or with units)" if spoken else "numbers"
    open_ended = get_origin(annotation) is list or get_args(annotation)[-1] is Ellipsis
    count = "" if open_ended else f"{_COUNTS.get(len(entries), len(entries))} "
    return f"a list of {count}{kind}, such as {example(annotation)}"


def _entries(annotation: Any) -> list[Any]:
    """Return the annotations of the entries of a list; two of them where any number may stand."""
    arguments = get_args(annotation)
    if get_origin(annotation) is list or arguments[-1] is Ellipsis:
        return [arguments[0]] * 2
    return list(arguments)


def _entered(annotation: Any, step: str | int) -> Any:
    """Return the annotation one step further in, or None."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if isinstance(step, str) and _infos(annotation):
        return fields(annotation).get(step)
    if origin is dict and isinstance(step, str):
        return arguments[1]
    if origin in _LISTS and isinstance(step, int):
        if origin is list or arguments[-1] is Ellipsis:
            return arguments[0]
        return arguments[step] if step < len(arguments) else None
    return None


def _arms(annotation: Any) -> list[Any]:
    """Return the alternatives of a union, without None; the annotation itself if it is none."""
    rule = _rule(annotation)
    if rule is not None:
        return [annotation, *rule.models]
    bare = _bare(annotation)
    if get_origin(bare) in (Union, types.UnionType):
        return [arm for part in get_args(bare) if part is not type(None) for arm in _arms(part)]
    return [annotation]


def _bare(annotation: Any) -> Any:
    return get_args(annotation)[0] if get_origin(annotation) is Annotated else annotation


def _rule(annotation: Any) -> FieldType | None:
    metadata = get_args(annotation)[1:] if get_origin(annotation) is Annotated else ()
    return next((entry for entry in metadata if isinstance(entry, FieldType)), None)
