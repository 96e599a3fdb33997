"""The JSON Schema of definition files, from the components that their sections are read as."""

from __future__ import annotations

from typing import Any

from linkages.components.contributed.component import Component
from linkages.components.mechanisms.registry import SECTIONS, Known
from linkages.spec.docstrings import summary
from linkages.spec.json_schema import any_of, mapping_schema, model_schema, or_nothing, value_schema
from linkages.spec.quantities import Name

Schema = dict[str, Any]

FILE_NAME = "linkages.schema.json"
"""The schema as a file; shipped beside the mechanisms, written beside what `new` makes."""

TITLE = "Definition of a planar linkage"


def definition_schema() -> Schema:
    """Return the JSON Schema (draft 7) of a definition file."""
    models = [
        model for section in SECTIONS.values() if not section.field for model in section.models
    ]
    name = {
        "description": "Title of reports and figures, on one line; default: the file's name.",
        "type": ["string", "number", "boolean", "null"],
    }
    sections = {key: _section(section) for key, section in SECTIONS.items()}
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": TITLE,
        "description": "Numbers are in SI; or text: arithmetic with pi, or a number with a unit, "
        "perhaps with a tolerance (140 ± 0.05 mm, 140 +0.1/-0.05 mm).",
        "type": "object",
        "properties": {"name": name, **sections},
        "additionalProperties": False,
        "definitions": {model.__name__: model_schema(model, _without(model)) for model in models},
    }


def _without(model: type[Component]) -> tuple[str, ...]:
    return SECTIONS[model.section].given


def _section(section: Known) -> Schema:
    entry = _entry(section)
    if section.form == "mapping":
        found = or_nothing(mapping_schema(value_schema(Name), entry))
        form, example = "Names with their entries, such as", section.example
    elif section.form == "list":
        found = or_nothing({"type": "array", "items": entry})
        form, example = "A list, such as", f"[{section.example}]"
    else:
        found, form, example = entry, "Such as", section.example
    summaries = " ".join(summary(model) for model in section.models)
    return {**found, "description": f"{summaries} {form} {example}"}


def _entry(section: Known) -> Schema:
    """An entry: a mapping that a component describes, or the one field that is written alone."""
    if section.field is None:
        return any_of([{"$ref": f"#/definitions/{m.__name__}"} for m in section.models])
    models = [model_schema(model, section.given) for model in section.models]
    return any_of([model["properties"][section.field] for model in models])
