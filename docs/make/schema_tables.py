"""The JSON Schema of definition files as Markdown tables; `conf.py` puts them into schema.md."""

from __future__ import annotations

from typing import Any

from linkages.components.mechanisms.registry import SECTIONS, definition_schema

Schema = dict[str, Any]
HEAD = "| key | form | default | meaning |\n|---|---|---|---|\n"
EXPECTED = " Expected: "


def tables() -> str:
    """A section for each section of the file, with a table for each kind of entry; an index."""
    schema = definition_schema()
    links = " · ".join(f"[{name}](#{name.replace('_', '-')})" for name in [*SECTIONS, "law"])
    parts = [f"Sections: {links}. [Index of keys](#index-of-keys).\n"]
    places: dict[str, dict[str, None]] = {}
    for name, section in SECTIONS.items():
        about = schema["properties"][name]
        parts.append(f"## {name}\n")
        if section.field is not None:
            parts.append(f"{about['description'].split('.')[0]}. Example: `{section.example}`\n")
            entry = about.get("additionalProperties", about)
            parts.append(f"Form of an entry: {form_of(entry)}.\n")
            continue
        parts.append(f"{_form(section.form)} Example: `{section.example}`\n")
        for model in section.models:
            found = schema["definitions"][model.__name__]
            required = found.get("required", [])
            rows = [_row(f"`{k}`", v, k in required) for k, v in found["properties"].items()]
            parts.append(f"**{model.__name__}.** {_cell(found['description'])}\n")
            parts.append(HEAD + "".join(rows))
            for key in found["properties"]:
                places.setdefault(key, {})[f"[{name}](#{name.replace('_', '-')})"] = None
    index = [f"| `{key}` | {', '.join(places[key])} |\n" for key in sorted(places)]
    return "\n".join(
        [*parts, _laws(schema), "## Index of keys\n", "| key | in |\n|---|---|\n" + "".join(index)]
    )


def _form(form: str) -> str:
    words = {"mapping": "Names with their entries.", "list": "A list.", "value": "A mapping."}
    return words[form]


def _row(key: str, value: Schema, required: bool) -> str:
    meaning = value.get("description", "").partition(EXPECTED)[0]
    default = "required" if required else _default(value)
    return f"| {key} | {_cell(form_of(value))} | {default} | {_cell(meaning)} |\n"


def _default(value: Schema) -> str:
    found = value.get("default", "")
    if isinstance(found, bool):
        return f"`{str(found).lower()}`"
    return f"{found:g}" if isinstance(found, float) else f"`{found}`" if found != "" else ""


def form_of(value: Schema) -> str:
    """What may stand in a place, in words."""
    if "anyOf" in value:
        arms = [arm for arm in value["anyOf"] if arm.get("type") != "null"]
        plain = [arm for arm in arms if "properties" not in arm] or arms  # laws have their tables
        return " or ".join(dict.fromkeys(form_of(arm) for arm in plain))
    if "enum" in value:
        return ", ".join(f"`{word}`" for word in value["enum"] if isinstance(word, str))
    kinds = value.get("type", [])
    if "boolean" in kinds:
        return "`true` or `false`"
    if "array" in kinds:
        count, each = "two" if value.get("minItems") == 2 else "a list", form_of(value["items"])
        return f"{count} names" if each == "a name" else f"{count}, each {each}"
    if "properties" in value:
        return "a mapping"
    if "object" in kinds:
        return f"names with {form_of(value['additionalProperties'])}"
    about = value.get("description", "")
    words = about.partition(EXPECTED)[2].rstrip(".") or about
    return words.replace(", or with a unit", "") if "maxLength" not in value else "a name"


def _laws(schema: Schema) -> str:
    """Tables of the named laws, as a drive of a bar takes them."""
    arms = schema["definitions"]["Drive"]["properties"]["law"]["anyOf"]
    laws = [arm for arm in arms if "properties" in arm]
    parts = ["## law\n", "Where a law may stand. Here are the quantities of an angle.\n"]
    for law in laws:
        (key, inner), *others = law["properties"].items()
        found = law if others else inner
        required = found.get("required", ())
        rows = [_row(f"`{k}`", v, k in required) for k, v in found["properties"].items()]
        parts.append(f"**{key}.** {_cell(found['description'])}\n")
        parts.append(HEAD + "".join(rows))
    return "\n".join(parts)


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("*", "\\*")
