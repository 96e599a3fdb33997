"""The SI unit of a number in a definition file, by its path."""

from __future__ import annotations

from typing import Any

from linkages.components.registry import SECTIONS, Section
from linkages.reading.document import Document
from linkages.reading.paths import Path, split, value_at
from linkages.spec.annotations import alternatives, entries_of, fields, rule_of
from linkages.spec.quantities import Quantity


def unit_at(document: Document, path: str) -> str:
    """SI unit of what stands at a path, as text.

    Parameters
    ----------
    document
        The definition that the path leads into.
    path
        Such as ``"clearances.r1.size"``.

    Returns
    -------
    Empty for a pure number, where a law of time may stand, and where the path leads nowhere.
    """
    steps = split(path) or ()
    section = SECTIONS.get(str(steps[0])) if steps else None
    if section is None:
        return ""
    depth = 1 if section.form == "value" else 2
    entry = value_at(document.content, steps[:depth])
    model = section.choose(entry)
    if section.for_sliders and steps[1:2] in _sliders(document):
        model = section.for_sliders  # keys do not always tell
    found = _units(section, model, steps[depth:])
    return found.pop().replace("**", "^").replace("*", " ") if len(found) == 1 else ""


def _sliders(document: Document) -> list[Path]:
    return [(name,) for name in document.content.get("sliders") or ()]


def _units(section: Section, model: Any, rest: Path) -> set[str]:
    keys = fields(model)
    if section.field is not None and (not rest or rest[0] not in keys):
        return _of(keys[section.field], rest)
    return _of(keys[rest[0]], rest[1:]) if rest and rest[0] in keys else set()


def _of(annotation: Any, rest: Path) -> set[str]:
    """Units of the numbers that an annotation allows at the end of a path."""
    found: set[str] = set()
    for arm in alternatives(annotation):
        rule = rule_of(arm)
        if isinstance(rule, Quantity) and not rest:
            found.add(rule.dimension.unit)
        elif rest and isinstance(rest[0], int) and rule is None:
            entries = _entries(arm)
            found |= _of(entries[rest[0]], rest[1:]) if rest[0] < len(entries) else set()
    return found


def _entries(annotation: Any) -> list[Any]:
    try:
        return entries_of(annotation)
    except (IndexError, TypeError):
        return []
