"""Models of definition entries: their fields, documentation and JSON Schema.

It is necessary, not sufficient: it accepts all that the loader accepts, and refuses what can be
told from the shape of one entry. Draft 7, which editors know best.
"""

from __future__ import annotations

import inspect
import re
import types
from collections.abc import Collection, Mapping
from functools import cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from linkages.spec.quantities import FieldType, NameRule

LISTS = (tuple, list)
_FIELDS = "__pydantic_fields__"


@cache
def fields(model: type) -> dict[str, Any]:
    """Return the annotations of a pydantic dataclass by key, with their metadata."""
    result = {}
    variables = getattr(get_origin(model), "__parameters__", ())
    values = dict(zip(variables, get_args(model), strict=True))
    for name, info in infos_of(model).items():
        annotation = _filled(info.annotation, values)
        annotated = Annotated[(annotation, *info.metadata)] if info.metadata else None
        result[name] = annotated or annotation
    return result


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


@cache
def naming(model: Any) -> dict[str, tuple[tuple[NameRule, ...], bool]]:
    """Key → rules of the names there that others declare, and whether they are a list.

    There is one rule for each entry of a list, and one for all where any number may stand.
    """
    result = {}
    for key, annotation in fields(model).items():
        for arm in alternatives(annotation):
            several = get_origin(arm) in LISTS
            entries = entries_of(arm) if several else [arm]
            rules = [rule_of(e) for e in (entries[:1] if several and open_ended(arm) else entries)]
            names = tuple(rule for rule in rules if isinstance(rule, NameRule) and rule.of)
            if names:
                result[key] = names, several
    return result


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


PARAMETERS = "\n\nParameters\n----------\n"
"""Begins the section of a docstring that describes fields."""

_PARAMETERS = re.compile(r"\nParameters\n-+\n(.*?)(?=\n\n\w|\Z)", re.DOTALL)
_FIELD = re.compile(r"^(\w[\w, ]*)\n((?:[ ]+.*\n?|\n)+)", re.MULTILINE)


def summary(model: Any) -> str:
    """Return the first sentence of the docstring of a class, which may be a generic one."""
    return _line(_docstring(model).partition("\n\n")[0])


@cache
def field_texts(model: Any) -> dict[str, str]:
    """Return what docstrings say of each field, by its name in Python: of the class, or a base.

    Of a function, what its docstring says of its parameters.
    """
    texts: dict[str, str] = {}
    documented = [model] if inspect.isfunction(model) else reversed(_class(model).__mro__)
    for kind in documented:
        text = kind.__doc__ if kind is model else vars(kind).get("__doc__")
        texts |= documented_fields(inspect.cleandoc(text or ""))
    return texts


def documented_fields(text: str) -> dict[str, str]:
    """Return what one docstring says of each field."""
    texts: dict[str, str] = {}
    result = _PARAMETERS.search(text)
    for names, entry in [] if result is None else _FIELD.findall(result[1]):
        texts |= dict.fromkeys(names.split(", "), _line(entry))
    return texts


def _line(text: str) -> str:
    return " ".join(text.replace("``", "`").split())


def _docstring(model: Any) -> str:
    return inspect.cleandoc(_class(model).__doc__ or "")


def _class(model: Any) -> type:
    result: type = get_origin(model) or model
    return result


Schema = dict[str, Any]

# All that pydantic takes for true or false, in capitals or not; YAML reads the first pair itself.
_TRUTHS = ("true", "false", "yes", "no", "on", "off", "y", "n", "t", "f", "1", "0")
_TRUTH = "^({})$".format(
    "|".join("".join(f"[{letter}{letter.upper()}]" for letter in word) for word in _TRUTHS)
)


def model_schema(model: Any, without: Collection[str] = ()) -> Schema:
    """Return the schema of the mapping that a model describes."""
    infos = {key: info for key, info in infos_of(model).items() if key not in without}
    own, texts = _own_names(model), field_texts(model)
    properties = {
        key: _property(fields(model)[key], info, texts.get(own[key], ""))
        for key, info in infos.items()
    }
    required = [key for key, info in infos.items() if info.is_required()]
    return {
        "description": summary(model),
        "type": "object",
        "properties": properties,
        **({"required": required} if required else {}),
        "additionalProperties": False,
    }


def value_schema(annotation: Any) -> Schema:
    """Return the schema of a value with an annotation."""
    result = any_of([_alternative(arm) for arm in alternatives(annotation)])
    return or_nothing(result) if optional(annotation) else result


def any_of(schemas: list[Schema]) -> Schema:
    """Return the schema of a value that fits one of several."""
    return schemas[0] if len(schemas) == 1 else {"anyOf": schemas}


def or_nothing(schema: Schema) -> Schema:
    """Return the schema of a value that may also be left empty."""
    if "anyOf" in schema:
        return {**schema, "anyOf": [*schema["anyOf"], {"type": "null"}]}
    if "type" not in schema:
        return {"anyOf": [schema, {"type": "null"}]}
    kinds = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
    return {**schema, "type": [*kinds, "null"]}


def _property(annotation: Any, info: Any, text: str) -> Schema:
    result = value_schema(annotation)
    about = result.get("description", "")
    if "properties" in result:  # a mapping has its own description
        result["description"] = text or about
    else:
        result["description"] = f"{text} Expected: {about}." if about else text
    if isinstance(info.default, bool | int | float | str):
        result["default"] = info.default
    return result


def _alternative(annotation: Any) -> Schema:
    rule, bare = rule_of(annotation), stripped(annotation)
    if isinstance(rule, NameRule):
        return rule.json_schema()
    if rule is not None:
        result: Schema = {"description": rule.expected(), **rule.json_schema()}
        if rule.models:  # they are alternatives of their own
            result["type"] = [kind for kind in result["type"] if kind != "object"]
        return result
    if get_origin(bare) is Literal:
        return {"enum": list(get_args(bare))}
    if get_origin(bare) in LISTS:
        entries = entries_of(bare)
        count = {} if open_ended(bare) else {"minItems": len(entries), "maxItems": len(entries)}
        first, *others = map(value_schema, entries)
        assert all(other == first for other in others)
        return {"type": "array", "items": first, **count}
    if get_origin(bare) is dict:
        key, value = get_args(bare)
        return mapping_schema(value_schema(key), value_schema(value))
    if infos_of(bare):
        return model_schema(bare)
    if bare is bool:
        kinds = ["boolean", "string", "integer"]
        return {"type": kinds, "pattern": _TRUTH, "minimum": 0, "maximum": 1}
    raise TypeError(f"no schema for {annotation}")


def mapping_schema(key: Schema, value: Schema) -> Schema:
    """Return the schema of a mapping of names to values; all keys of JSON are text."""
    names = {name: part for name, part in key.items() if name not in ("type", "description")}
    return {"type": "object", "propertyNames": names, "additionalProperties": value}


def _own_names(model: Any) -> dict[str, str]:
    """Key in the file → name of the field in Python."""
    origin = get_origin(model) or model
    return {info.alias or name: name for name, info in origin.__pydantic_fields__.items()}
