"""From a definition to a mechanism: from a file, a text, or a document."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any

from linkages.components.contributed.component import Component, ListedComponent
from linkages.components.mechanisms.declared_names import formulas_in
from linkages.components.mechanisms.mechanism import Mechanism, in_whole
from linkages.components.mechanisms.registry import SECTIONS, read_components, read_section
from linkages.errors import InputError
from linkages.reading.document import Document, find, parse, read
from linkages.reading.overrides import apply
from linkages.reading.paths import KeyPath, dotted, split


def load(
    file: str | FilePath,
    set: Mapping[str, object] | None = None,  # noqa: A002
    *,
    tables_from: str | FilePath | None = None,
) -> Mechanism:
    """Read a definition file.

    Parameters
    ----------
    file
        A path, or the name of a mechanism shipped with the package.
    set
        Dotted path of the file → value to use instead, as `Mechanism.with_values` takes them, e.g.
        ``{"clearances.r1.size": 1e-4}``.
    tables_from
        A folder: the CSV files of tables that the definition names may be below it as well.
        Otherwise they must be below the folder of the definition.

    Raises
    ------
    InputError
        With every problem of the file: line, what was found and what is expected.

    Examples
    --------
    >>> import linkages
    >>> linkages.load("pendulum", set={"bars.rod.length": "350 mm"})
    Mechanism('Pendulum', gravity=1, joints=1, bars=1, free=1, simulate=1)
    """
    if not isinstance(file, str | FilePath):
        raise TypeError(f"file must be a path or a name, found {file!r}")
    tables = None if tables_from is None else FilePath(tables_from)
    return from_document(apply(replace(read(find(file)), tables=tables), set or {}))


def loads(text: str, set: Mapping[str, object] | None = None) -> Mechanism:  # noqa: A002
    """Read a definition from a text.

    Parameters
    ----------
    text
        YAML, as it would stand in a definition file. It cannot name files of tables, for there is
        no folder to look for them in.
    set
        As in `load`.

    Raises
    ------
    InputError
        With every problem of the text: line, what was found and what is expected.
    """
    if not isinstance(text, str):
        raise TypeError(f"text must be the text of a definition, found {text!r}")
    return from_document(apply(parse(text, "text"), set or {}))


def from_document(document: Document) -> Mechanism:
    """Build the mechanism that a document defines; raises InputError like `load`."""
    document, components = read_components(document)
    return Mechanism(
        components=components,
        defined=components,
        name=str(document.content.get("name") or FilePath(document.source).stem),
        source=document.source,
        document=document,
    )


def reread(
    mechanism: Mechanism, component: Component, values: Mapping[KeyPath, object]
) -> Component | None:
    """A component of a mechanism with other values, read as a definition file is.

    Returns: the new component; None if it cannot be read by itself: what is wrong with it, or with
    the units of its formulas, or what else must change with it, is for `Mechanism.with_values` to
    say.
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
    start: KeyPath = (section, 0) if listed else where
    moved = {dotted((*start, *path[len(where) :])): value for path, value in values.items()}
    alone = Document(definition.source, content, {}, {}, definition.folder, (), definition.tables)
    try:
        result = read_section(apply(alone, in_whole(alone, {start: component}, moved)), section)
    except InputError:
        return None
    if len(result) != 1 or type(result[0]) is not type(component):
        return None
    (made,) = result
    with_units = [formula for formula in formulas_in(made) if formula.has_units]
    if with_units:
        before = list(formulas_in(component))
        if any(formula not in before for formula in with_units):
            return None
    if listed:
        changed: Any = made
        return changed if where[1] == 0 else replace(changed, index=where[1])
    return made if made.path == where else None


def owner(mechanism: Mechanism, path: str) -> tuple[int, KeyPath] | None:
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
