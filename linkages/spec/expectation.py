"""What a field of a definition expects, in words, derived from the annotations of its model."""

from __future__ import annotations

import typing
from collections.abc import Collection
from typing import Any, Literal, get_args, get_origin

from linkages.reading.paths import Path
from linkages.reading.wording import listed
from linkages.spec.annotations import (
    LISTS,
    alternatives,
    entries_of,
    fields,
    infos_of,
    open_ended,
    rule_of,
    stripped,
)
from linkages.spec.laws import LawRule
from linkages.spec.quantities import NameRule, Quantity

_COUNTS = {1: "one", 2: "two", 3: "three", 4: "four"}


def annotation_at(annotation: Any, path: Path) -> Any:
    """Return the annotation that a path leads to, or None where it leads nowhere."""
    if not path:
        return annotation
    for arm in alternatives(annotation):
        step, rest = path[0], path[1:]
        inner = _entered(stripped(arm), step)
        found = annotation_at(inner, rest) if inner is not None else None
        if found is not None:
            return found
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
        names = [key for key in own if required[key].is_required()] or own[:2]
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
