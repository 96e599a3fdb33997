"""The components that a definition has, or a list of everything that is wrong with it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, TypeGuard

from linkages.components.contributed.component import Component
from linkages.components.contributed.terms import Path
from linkages.components.mechanisms.consistency import Declared, findings
from linkages.components.mechanisms.registry import SECTIONS, Known
from linkages.errors import InputError, Problem
from linkages.reading.document import Document
from linkages.reading.wording import nearest, shown
from linkages.spec.conversion import QuantityError
from linkages.spec.quantities import NameRule
from linkages.spec.table_files import with_tables
from linkages.spec.tolerance_zones import has_tolerance
from linkages.spec.validation import validated


def read_components(document: Document) -> tuple[Document, tuple[Component, ...]]:
    """The components of a definition, and the definition with its tables read from their files.

    Raises
    ------
    InputError
        With every problem of the definition.
    """
    document, faulty_tables = with_tables(document)
    gathered = _Gathered(document, problems=faulty_tables)
    gathered.top_level()
    for key, section in SECTIONS.items():
        if key in document.content:
            gathered.section(key, section)
    declared = Declared(
        gathered.components,
        gathered.ground,
        gathered.joints,
        gathered.bodies,
        complete=not gathered.lost,
    )
    gathered.problems += [
        document.problem(path, message) for path, message in findings(gathered.components, declared)
    ]
    if not gathered.problems and not declared.bodies:
        message = "nothing here can move; expected bars, such as " + SECTIONS["bars"].example
        gathered.add(("bars",), message)
    if gathered.problems:
        raise InputError(document.source, gathered.problems)
    return document, tuple(gathered.components)


def read_section(document: Document, key: str) -> tuple[Component, ...]:
    """The components of one section, for themselves: whether they fit others is not looked at.

    Raises
    ------
    InputError
        With every problem of the section.
    """
    document, faulty_tables = with_tables(document)
    gathered = _Gathered(document, problems=faulty_tables)
    gathered.section(key, SECTIONS[key])
    found = [problem for component in gathered.components for problem in component.problems()]
    gathered.problems += [document.problem(path, message) for path, message in found]
    if gathered.problems:
        raise InputError(document.source, gathered.problems)
    return tuple(gathered.components)


@dataclass
class _Gathered:
    """Components and problems found so far, and the names that faulty entries declare."""

    document: Document
    components: list[Component] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    ground: set[str] = field(default_factory=set)
    joints: set[str] = field(default_factory=set)
    bodies: list[tuple[str, str]] = field(default_factory=list)
    lost: bool = False  # a whole section could not be read: nobody knows what it declares

    def top_level(self) -> None:
        known = ["name", *SECTIONS]
        for key in self.document.content:
            if key not in known:
                near = nearest(key, known)
                self.lost = self.lost or near is not None
                expected = (
                    f"did you mean {near!r}?" if near else f"expected one of: {', '.join(known)}"
                )
                self.add((key,), f"unknown key {key!r}; {expected}")
        name = self.document.content.get("name")
        if name is not None and (not isinstance(name, str) or not name.isprintable()):
            self.add(("name",), "expected one line of text")
        options = self.document.content.get("simulate")
        for key, value in (options if isinstance(options, dict) else {}).items():
            if has_tolerance(value):
                self.add(("simulate", key), f"options have no tolerance, found {shown(value)}")

    def add(self, path: Path, message: str) -> None:
        self.problems.append(self.document.problem(path, message))

    def section(self, key: str, section: Known) -> None:
        for path, raw, given in self.entries(key, section):
            entry = raw if section.field is None else {section.field: raw}
            model = section.choose(entry)
            if section.for_sliders is not None and path[-1] in self.sliders:
                model = section.for_sliders
            built = validated(model, entry, self.document, path, self.problems, **given)
            if built is None:
                self.remember(path, entry)
            else:
                self.components.append(built)

    @property
    def sliders(self) -> set[object]:
        """What the file calls sliders and nothing else, right or wrong."""
        content = self.document.content
        bars, sliders = (content.get(key) for key in ("bars", "sliders"))
        taken = set(bars) if isinstance(bars, dict) else set()
        return set(sliders) - taken if isinstance(sliders, dict) else set()

    def entries(self, key: str, section: Known) -> Iterator[tuple[Path, Any, dict[str, Any]]]:
        content = self.document.content[key]
        if section.form == "value":
            yield (key,), content, {}
        elif content is None:
            return
        elif section.form == "mapping" and isinstance(content, dict):
            for name, raw in content.items():
                yield (key, name), raw, {"name": name}
        elif section.form == "list" and isinstance(content, list):
            for index, raw in enumerate(content):
                yield (key, index), raw, {"index": index}
        else:
            self.lost = True
            example = f"[{section.example}]" if section.form == "list" else section.example
            self.add((key,), f"expected a {section.form} such as {example}")

    def remember(self, path: Path, raw: object) -> None:
        """Note what a faulty entry declares, so that its users are not reported as well."""
        if not _is_name(path[-1]):
            return  # nothing that passes validation can use it, and no message should repeat it
        if path[0] == "joints":
            self.ground.add(str(path[1]))
        kind = {"bars": "bar", "sliders": "slider", "clearances": "clearance"}.get(str(path[0]))
        if kind is None:
            return
        self.bodies.append((str(path[1]), kind))
        if isinstance(raw, dict):
            for key in ("joints", "points", "joint"):
                value = raw.get(key)
                names = value if isinstance(value, list | dict) else [value]
                self.joints.update(name for name in names if _is_name(name))


def _is_name(found: object) -> TypeGuard[str]:
    try:
        NameRule().read(found)
    except QuantityError:
        return False
    return True
