"""A definition as text with gaps for its numbers."""

from __future__ import annotations

import re
from copy import deepcopy
from dataclasses import replace
from typing import Any

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.sensitivity.numbers import written
from linkages.reading.paths import split
from linkages.reading.writing import as_yaml


def template(mechanism: Mechanism) -> list[Any]:
    """The definition as YAML, in parts.

    Returns
    -------
    Texts, and between them ``{"path", "text"}`` of the numbers that the definition writes and that
    have an effect; all texts together are the definition as it is.
    """
    definition = mechanism.definition
    content = {"name": mechanism.name, **deepcopy(dict(definition.content))}
    content["name"] = mechanism.name
    kept: list[tuple[str, Any]] = []
    for number in written(mechanism):
        steps = split(number.path) or ()
        text = definition.value(steps)
        if isinstance(text, str | int | float) and _put(content, steps, f"number{len(kept)}gap"):
            kept.append((number.path, text))
    parts: list[Any] = []
    for place, text in enumerate(re.split(r"number(\d+)gap", _yaml(mechanism, content))):
        if place % 2:
            path, own = kept[int(text)]
            parts.append({"path": path, "text": own if isinstance(own, str) else repr(own)})
        else:
            parts.append(text)
    return parts


def _put(content: Any, steps: tuple[str | int, ...], value: str) -> bool:
    """Replace what stands at a path; whether there is such a place."""
    if not steps or not isinstance(content, dict | list):
        return False
    place: Any = steps[0]
    if len(steps) > 1:
        return _put(content[place], steps[1:], value)
    content[place] = value
    return True


def _yaml(mechanism: Mechanism, content: dict[str, Any]) -> str:
    return as_yaml(replace(mechanism.definition, content=content))
