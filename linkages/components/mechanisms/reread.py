"""Components with other values, read again one by one from what the definition says of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from linkages.components.contributed.component import Component
from linkages.components.contributed.listed import ListedComponent
from linkages.components.contributed.terms import Path
from linkages.components.mechanisms.formulas import formulas_in
from linkages.components.mechanisms.gathered import read_section
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.mechanisms.registry import SECTIONS
from linkages.errors import InputError
from linkages.reading.document import Document
from linkages.reading.overrides import apply
from linkages.reading.paths import dotted, split


def reread(
    mechanism: Mechanism, component: Component, values: Mapping[Path, object]
) -> Component | None:
    """A component of a mechanism with other values, read as a definition file is.

    Parameters
    ----------
    mechanism
        Has the component.
    component
        Stands in the definition at its path.
    values
        Paths within its entry → values, as `Mechanism.with_values` takes them.

    Returns
    -------
    The new component; None if it cannot be read by itself: what is wrong with it, or with the units
    of its formulas, or what else must change with it, is for `Mechanism.with_values` to say.
    """
    definition, where = mechanism.definition, component.path
    entry = definition.value(where)
    section = str(where[0])
    if entry is None or section not in SECTIONS:
        return None
    content: dict[str, Any] = {k: definition.content.get(k) for k in ("bars", "sliders")}
    listed = isinstance(component, ListedComponent)
    if len(where) > 1:
        content[section] = [entry] if listed else {where[1]: entry}
    else:
        content[section] = entry
    start: Path = (section, 0) if listed else where
    moved = {dotted((*start, *path[len(where) :])): value for path, value in values.items()}
    alone = Document(definition.source, content, {}, {}, definition.folder, (), definition.tables)
    try:
        found = read_section(apply(alone, moved), section)
    except InputError:
        return None
    if len(found) != 1 or type(found[0]) is not type(component):
        return None
    (made,) = found
    with_units = [formula for formula in formulas_in(made) if formula.has_units]
    if with_units:
        before = list(formulas_in(component))
        if any(formula not in before for formula in with_units):
            return None
    if listed:
        changed: Any = made
        return changed if where[1] == 0 else replace(changed, index=where[1])
    return made if made.path == where else None


def owner(mechanism: Mechanism, path: str) -> tuple[int, Path] | None:
    """The component that a dotted path of the definition belongs to, and the path's steps.

    None if the path is none, or leads to a whole section or entry.
    """
    steps = split(path)
    if steps is None:
        return None
    for place, component in enumerate(mechanism.components):
        own = component.path
        if len(steps) >= len(own) and all(map(_same, own, steps)):
            return place, (*own, *steps[len(own) :])
    return None


def _same(own: str | int, step: str | int) -> bool:
    """An index of a list may be written as a name: ``loads.0.force``."""
    return own == step or (isinstance(own, int) and str(own) == step)
