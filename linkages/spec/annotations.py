"""What the annotations of a model say: its fields, alternatives, entries of lists and rules."""

from __future__ import annotations

import types
from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, Union, get_args, get_origin

from linkages.spec.quantities import FieldType

LISTS = (tuple, list)
_FIELDS = "__pydantic_fields__"


@cache
def fields(model: type) -> dict[str, Any]:
    """Return the annotations of a pydantic dataclass by key, with their metadata."""
    found = {}
    variables = getattr(get_origin(model), "__parameters__", ())
    values = dict(zip(variables, get_args(model), strict=True))
    for name, info in infos_of(model).items():
        annotation = _filled(info.annotation, values)
        annotated = Annotated[(annotation, *info.metadata)] if info.metadata else None
        found[name] = annotated or annotation
    return found


def infos_of(model: Any) -> dict[str, Any]:
    """Return pydantic's information by key as the file writes it; a class may be a generic one."""
    infos = getattr(get_origin(model) or model, _FIELDS, {})
    return {info.alias or name: info for name, info in infos.items()}


def written_fields(instance: object) -> dict[str, Any] | None:
    """Return the values of a pydantic dataclass by key, without defaults; None for others."""
    infos = getattr(type(instance), _FIELDS, None)
    if infos is None:
        return None
    values = {name: (info, getattr(instance, name)) for name, info in infos.items()}
    return {
        info.alias or name: value
        for name, (info, value) in values.items()
        if value != info.get_default(call_default_factory=True)
    }


def alternatives(annotation: Any) -> list[Any]:
    """Return the alternatives of a union, without None; the annotation itself if it is none."""
    rule = rule_of(annotation)
    if rule is not None:
        return [annotation, *rule.models]
    return [
        arm
        for part in _parts(annotation)
        if part is not type(None)
        for arm in (alternatives(part) if part is not annotation else [part])
    ]


def optional(annotation: Any) -> bool:
    """Tell whether nothing may stand in the place."""
    return type(None) in _parts(annotation)


def entries_of(annotation: Any) -> list[Any]:
    """Return the annotations of the entries of a list; two of them where any number may stand."""
    arguments = get_args(annotation)
    return [arguments[0]] * 2 if open_ended(annotation) else list(arguments)


def open_ended(annotation: Any) -> bool:
    """Tell whether a list may have any number of entries."""
    return get_origin(annotation) is list or get_args(annotation)[-1] is Ellipsis


def stripped(annotation: Any) -> Any:
    """Return an annotation without its metadata."""
    return get_args(annotation)[0] if get_origin(annotation) is Annotated else annotation


def rule_of(annotation: Any) -> FieldType | None:
    """Return the rule that reads the value, if there is one."""
    metadata = get_args(annotation)[1:] if get_origin(annotation) is Annotated else ()
    return next((entry for entry in metadata if isinstance(entry, FieldType)), None)


def _parts(annotation: Any) -> tuple[Any, ...]:
    plain = stripped(annotation)
    if rule_of(annotation) is None and get_origin(plain) in (Union, types.UnionType):
        return get_args(plain)
    return (annotation,)


def _filled(annotation: Any, values: Mapping[Any, Any]) -> Any:
    """Return an annotation with the type variables of a generic class replaced."""
    if annotation in values:
        return values[annotation]
    variables = getattr(annotation, "__parameters__", ())
    return annotation[tuple(values[v] for v in variables)] if variables else annotation
