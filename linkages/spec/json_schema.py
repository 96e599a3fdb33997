"""The JSON Schema of a model: what an editor can check and complete of a definition file.

It is necessary, not sufficient: it accepts all that the loader accepts, and refuses what can be
told from the shape of one entry. Draft 7, which editors know best.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, Literal, get_args, get_origin

from linkages.spec.annotations import (
    LISTS,
    alternatives,
    entries_of,
    fields,
    infos_of,
    open_ended,
    optional,
    rule_of,
    stripped,
)
from linkages.spec.docstrings import field_texts, summary
from linkages.spec.quantities import NameRule

Schema = dict[str, Any]

# All that pydantic takes for true or false, in capitals or not; YAML reads the first pair itself.
_TRUTHS = ("true", "false", "yes", "no", "on", "off", "y", "n", "t", "f", "1", "0")
_TRUTH = "^({})$".format(
    "|".join("".join(f"[{letter}{letter.upper()}]" for letter in word) for word in _TRUTHS)
)


def model_schema(model: Any, without: Collection[str] = ()) -> Schema:
    """Return the schema of the mapping that a model describes.

    Parameters
    ----------
    model
        A pydantic dataclass that forbids extra keys.
    without
        Fields that do not stand in the mapping, such as a name that is the key of the entry.
    """
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
    found = any_of([_alternative(arm) for arm in alternatives(annotation)])
    return or_nothing(found) if optional(annotation) else found


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
    found = value_schema(annotation)
    about = found.get("description", "")
    if "properties" in found:  # a mapping has its own description
        found["description"] = text or about
    else:
        found["description"] = f"{text} Expected: {about}." if about else text
    if isinstance(info.default, bool | int | float | str):
        found["default"] = info.default
    return found


def _alternative(annotation: Any) -> Schema:
    rule, bare = rule_of(annotation), stripped(annotation)
    if isinstance(rule, NameRule):
        return rule.json_schema()
    if rule is not None:
        found: Schema = {"description": rule.expected(), **rule.json_schema()}
        if rule.models:  # they are alternatives of their own
            found["type"] = [kind for kind in found["type"] if kind != "object"]
        return found
    if get_origin(bare) is Literal:
        return {"enum": list(get_args(bare))}
    if get_origin(bare) in LISTS:
        entries = entries_of(bare)
        count = {} if open_ended(bare) else {"minItems": len(entries), "maxItems": len(entries)}
        assert all(entry == entries[0] for entry in entries)
        return {"type": "array", "items": value_schema(entries[0]), **count}
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
