"""The units of a number in a definition file, by its path: of SI, and as it is written."""

from __future__ import annotations

from typing import Any, get_args, get_origin

from linkages.components.mechanisms.registry import SECTIONS, Known
from linkages.reading.document import Document
from linkages.reading.paths import Path, split, value_at
from linkages.spec.annotations import LISTS, alternatives, fields, infos_of, open_ended, rule_of
from linkages.spec.arithmetic import NumberError, leading_number
from linkages.spec.laws import LawRule
from linkages.spec.quantities import Quantity
from linkages.spec.tolerance_zones import nominal_text


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
    Empty for a pure number, and where the path leads nowhere. A law is in the unit of what
    it gives; a formula has no paths within it.
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


def unit_written(document: Document, path: str) -> str:
    """The unit that a number of a definition is written with; empty if with none."""
    written = document.value(split(path) or ())
    if not isinstance(written, str):
        return ""
    try:
        return leading_number(nominal_text(written).replace("−", "-").strip())[1]
    except NumberError:
        return ""


def _sliders(document: Document) -> list[Path]:
    return [(name,) for name in document.content.get("sliders") or ()]


def _units(section: Known, model: Any, rest: Path) -> set[str]:
    keys = fields(model)
    if section.field is not None and (not rest or rest[0] not in keys):
        return _of(keys[section.field], rest)
    return _of(keys[rest[0]], rest[1:]) if rest and rest[0] in keys else set()


def _of(annotation: Any, rest: Path) -> set[str]:
    """Units of the numbers that an annotation allows at the end of a path."""
    found: set[str] = set()
    for arm in alternatives(annotation):
        rule = rule_of(arm)
        if rule is not None:
            if isinstance(rule, Quantity | LawRule) and not rest:
                found.add(rule.dimension.unit)
        elif rest:
            below = _below(arm, rest[0])
            found |= set() if below is None else _of(below, rest[1:])
    return found


def _below(annotation: Any, step: Any) -> Any:
    """What stands behind a step into a named law, a mapping of names or a list, if anything."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is dict:
        return arguments[1]
    if origin not in LISTS:
        return fields(annotation).get(step) if infos_of(annotation) else None
    if not isinstance(step, int):
        return None
    if open_ended(annotation):
        return arguments[0]
    return arguments[step] if step < len(arguments) else None
