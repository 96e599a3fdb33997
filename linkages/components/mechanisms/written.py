"""Components as a definition file would have them: what a mechanism is, whoever made it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from linkages.components.contributed.component import Component
from linkages.components.mechanisms.registry import SECTIONS
from linkages.reading.document import Document
from linkages.reading.paths import Path
from linkages.spec.annotations import written_fields
from linkages.spec.formulas import Constant, Formula
from linkages.spec.tolerance_zones import zone_of


def document_of(
    components: Iterable[Component],
    source: str,
    document: Document | None = None,
    defined: Iterable[Component] = (),
) -> Document:
    """The definition of some components.

    Parameters
    ----------
    components
        Those of a mechanism.
    source
        What messages call the place that they come from.
    document, defined
        A definition, and the components that it defines: those that are still among `components`
        keep their entries as they stand there, with lines.
    """
    base = Document(source, {}, {}) if document is None else document
    before = {component.path: component for component in defined}
    content = {"name": base.content["name"]} if "name" in base.content else {}
    kept: set[Path] = set()
    for component in sorted(components, key=lambda entry: getattr(entry, "index", 0)):
        if before.get(component.path) == component:
            kept.add(component.path)
            _enter(content, component.path, base.value(component.path))
        else:
            entry = _with_tolerances(entry_of(component), base.value(component.path))
            _enter(content, component.path, entry)

    def stays(path: Path) -> bool:
        return any(path[: len(component)] == component for component in kept)

    positions = {p: at for p, at in base.positions.items() if len(p) < 2 or stays(p)}
    overridden = {p: text for p, text in base.overridden.items() if stays(p)}
    whole = {path[:1]: path for path in kept if path[:1] in base.overridden}
    overridden |= {path: base.overridden[section] for section, path in whole.items()}
    return Document(source, content, positions, overridden, base.folder, base.changed, base.tables)


def _enter(content: dict[str, Any], path: Path, entry: Any) -> None:
    section, *rest = path
    if not rest:
        content[str(section)] = entry
    elif isinstance(rest[0], int):
        content.setdefault(str(section), []).append(entry)
    else:
        content.setdefault(str(section), {})[rest[0]] = entry


def _with_tolerances(entry: Any, before: Any) -> Any:
    """An entry in which numbers that have not changed keep their tolerances."""
    if isinstance(entry, dict) and isinstance(before, dict):
        return {key: _with_tolerances(value, before.get(key)) for key, value in entry.items()}
    if isinstance(entry, list) and isinstance(before, list) and len(entry) == len(before):
        return [_with_tolerances(*pair) for pair in zip(entry, before, strict=True)]
    zone = zone_of(before) if isinstance(before, str) else None
    return entry if zone is None or zone.nominal != entry else before


def entry_of(component: Component) -> Any:
    """What stands in the section of a component for it; defaults are left out."""
    section = SECTIONS.get(component.section)
    given = () if section is None else section.given
    entry = {key: value for key, value in _plain(component).items() if key not in given}
    alone = section is not None and section.field is not None and set(entry) == {section.field}
    return next(iter(entry.values())) if alone else entry


def _plain(value: Any) -> Any:
    if isinstance(value, Formula):
        return value.text
    if isinstance(value, Constant):
        return value.value if value.unit is None else f"{value.value!r} {value.unit}"
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(entry) for entry in value]
    fields = written_fields(value)
    return value if fields is None else {key: _plain(found) for key, found in fields.items()}
