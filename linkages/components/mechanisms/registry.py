"""Registry of sections and components, their JSON Schema and units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from inspect import isclass
from typing import Any, TypeGuard, get_args, get_origin

from linkages.components.contributed.component import Component, Section
from linkages.components.mechanisms.consistency import Declared, findings
from linkages.discovery import modules_of, plugged
from linkages.errors import InputError, Problem
from linkages.reading.document import Document
from linkages.reading.paths import KeyPath, split, value_at
from linkages.reading.wording import nearest, shown
from linkages.spec.conversion import QuantityError, has_tolerance, nominal_text
from linkages.spec.grammar import NumberError, leading_number
from linkages.spec.law_fields import LawRule, with_tables
from linkages.spec.models import (
    LISTS,
    alternatives,
    any_of,
    fields,
    infos_of,
    mapping_schema,
    model_schema,
    open_ended,
    or_nothing,
    rule_of,
    summary,
    value_schema,
)
from linkages.spec.quantities import Name, NameRule, Quantity
from linkages.spec.units import Bound
from linkages.spec.validation import validated

GROUP = "linkages.components"
"""Entry points that name components, and the folder of those of this package."""

_SECTIONS: dict[str, Section] = {
    "gravity": Section("value", "[9.81, 0]", field="acceleration"),
    "joints": Section("mapping", "O: [0, 0]", field="position"),
    "bars": Section("mapping", "crank: {joints: [O, A], length: 0.3}"),
    "sliders": Section("mapping", "piston: {joint: B, through: O}"),
    "clearances": Section("mapping", "r1: {joint: A, bar: rod, size: 0.1 mm}"),
    "masses": Section("mapping", "A: 2 kg", field="mass"),
    "welds": Section("mapping", "A: {bars: [crank, rod], angle: 30 deg}"),
    "gears": Section("list", "{bars: [crank, rod], ratio: -2}"),
    "drives": Section("mapping", "crank: {angle: 0, speed: 60 rpm}"),
    "free": Section("mapping", "crank: {angle: 0.1, speed: 0}"),
    "assembly": Section("mapping", "B: left", field="where"),
    "loads": Section("list", "{slider: piston, force: -100}"),
    "springs": Section("list", "{between: [O, B], stiffness: 4530, length: 0.08}"),
    "dampers": Section("list", "{joint: A, damping: 0.1}"),
    "simulate": Section("value", "{end: 2, samples: 2001}"),
}
"""In the order in which components are kept; whatever opens another one comes behind."""

_REGISTERED: list[type[Component]] = []


@dataclass(frozen=True)
class Known(Section):
    """A section, and the components that its entries may be: the one that no key tells first."""

    models: tuple[type[Component], ...] = ()

    def choose(self, entry: object, slides: bool = False) -> type[Component]:
        """The component that describes an entry, which may bear the name of a slider.

        Of those whose key it has, the one that has most of its keys.
        """
        if meant := [model for model in self.models if slides and model.names_slider]:
            return meant[0]
        keys = entry if isinstance(entry, dict) else {}
        told: list[Any] = [
            model for model in self.models if model.told_by and model.told_by in keys
        ]
        most: Any = max(told, key=lambda m: len(keys.keys() & fields(m).keys()), default=None)
        return self.models[0] if most is None else most


class _Sections(Mapping[str, Known]):
    """All sections by their names; components are looked for when they are first asked for."""

    def __getitem__(self, name: str) -> Known:
        return _known()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(_known())

    def __len__(self) -> int:
        return len(_known())


SECTIONS: Mapping[str, Known] = _Sections()


def components() -> dict[str, type[Component]]:
    """All components by the names of their classes."""
    return {model.__name__: model for known in _known().values() for model in known.models}


def register(model: type[Component]) -> None:
    """Add a component to those that definitions may have.

    One of the same name that was registered before is replaced.

    Raises
    ------
    TypeError, ValueError
        If it is none, or does not go together with those of its section.
    """
    if not (isclass(model) and issubclass(model, Component) and hasattr(model, "section")):
        raise TypeError(f"expected a component with a section, found {model!r}")
    before = list(_REGISTERED)
    _REGISTERED[:] = [*(old for old in before if old.__name__ != model.__name__), model]
    _known.cache_clear()
    try:
        _known()
    except ValueError:
        _REGISTERED[:] = before
        _known.cache_clear()
        raise


def unregister(name: str) -> None:
    """Take away a component that was registered; KeyError if none of that name was."""
    kept = [model for model in _REGISTERED if model.__name__ != name]
    if len(kept) == len(_REGISTERED):
        raise KeyError(name)
    _REGISTERED[:] = kept
    _known.cache_clear()


@cache
def _known() -> dict[str, Known]:
    result: list[Any] = []
    for module in modules_of(GROUP):
        own = (value for value in vars(module).values() if isclass(value))
        result += [value for value in own if value.__module__ == module.__name__]
    models = [m for m in result if issubclass(m, Component) and hasattr(m, "section")]
    models = [model for model in models if not model.__name__.startswith("_")]
    models += [model for _, model in plugged(GROUP)] + _REGISTERED
    opened = dict(sorted((m.section, m.opens) for m in models if m.opens is not None))
    return {
        name: Known(**vars(section), models=_models(name, [m for m in models if m.section == name]))
        for name, section in {**_SECTIONS, **opened}.items()
    }


def _models(section: str, models: list[type[Component]]) -> tuple[type[Component], ...]:
    """Those of a section, the one that no key tells first."""
    keys = [model.told_by for model in models]
    if keys.count("") != 1 or len(set(keys)) < len(keys):
        names = ", ".join(f"{model.__name__} ({model.told_by!r})" for model in models)
        raise ValueError(
            f"section {section!r}: expected one component that no key tells, and another key for "
            f"each of the others; found {names}"
        )
    return tuple(sorted(models, key=lambda model: model.told_by != ""))


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
        result = or_nothing(mapping_schema(value_schema(Name), entry))
        form, example = "Names with their entries, such as", section.example
    elif section.form == "list":
        result = or_nothing({"type": "array", "items": entry})
        form, example = "A list, such as", f"[{section.example}]"
    else:
        result, form, example = entry, "Such as", section.example
    summaries = " ".join(summary(model) for model in section.models)
    return {**result, "description": f"{summaries} {form} {example}"}


def _entry(section: Known) -> Schema:
    """An entry: a mapping that a component describes, or the one field that is written alone."""
    if section.field is None:
        return any_of([{"$ref": f"#/definitions/{m.__name__}"} for m in section.models])
    models = [model_schema(model, section.given) for model in section.models]
    return any_of([model["properties"][section.field] for model in models])


def unit_at(document: Document, path: str) -> str:
    """SI unit of what stands at a path, as text.

    Returns: empty for a pure number, and where the path leads nowhere. A law is in the unit of what
    it gives; a formula has no paths within it.
    """
    result = {rule.dimension.unit for rule in _rules_at(document, path)}
    return result.pop().replace("**", "^").replace("*", " ") if len(result) == 1 else ""


def bound_at(document: Document, path: str) -> Bound:
    """The bound of the number at a path; none of a law, and where the path leads nowhere."""
    result = {rule.bound for rule in _rules_at(document, path)}
    return result.pop() if len(result) == 1 else Bound.NONE


def _rules_at(document: Document, path: str) -> list[Quantity | LawRule]:
    """What a number at a path is read by."""
    steps = split(path) or ()
    section = SECTIONS.get(str(steps[0])) if steps else None
    if section is None:
        return []
    depth = 1 if section.form == "value" else 2
    entry = value_at(document.content, steps[:depth])
    model = section.choose(entry, not _sliders(document).isdisjoint(steps[1:2]))
    return _rules(section, model, steps[depth:])


def unit_written(document: Document, path: str) -> str:
    """The unit that a number of a definition is written with; empty if with none."""
    written = document.value(split(path) or ())
    if not isinstance(written, str):
        return ""
    try:
        return leading_number(nominal_text(written).replace("−", "-").strip())[1]
    except NumberError:
        return ""


def _sliders(document: Document) -> set[object]:
    """What a definition calls sliders and nothing else, right or wrong."""
    bars, sliders = (document.content.get(key) for key in ("bars", "sliders"))
    taken = set(bars) if isinstance(bars, dict) else set()
    return set(sliders) - taken if isinstance(sliders, dict) else set()


def _rules(section: Known, model: Any, rest: KeyPath) -> list[Quantity | LawRule]:
    keys = fields(model)
    if section.field is not None and (not rest or rest[0] not in keys):
        return _of(keys[section.field], rest)
    return _of(keys[rest[0]], rest[1:]) if rest and rest[0] in keys else []


def _of(annotation: Any, rest: KeyPath) -> list[Quantity | LawRule]:
    """Rules of the numbers that an annotation allows at the end of a path."""
    result: list[Quantity | LawRule] = []
    for arm in alternatives(annotation):
        rule = rule_of(arm)
        if rule is not None:
            if isinstance(rule, Quantity | LawRule) and not rest:
                result.append(rule)
        elif rest:
            below = _below(arm, rest[0])
            result += [] if below is None else _of(below, rest[1:])
    return result


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


def read_components(document: Document) -> tuple[Document, tuple[Component, ...]]:
    """The components of a definition, and the definition with its tables read from their files."""
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
    """The components of one section, for themselves: whether they fit others is not looked at."""
    document, faulty_tables = with_tables(document)
    gathered = _Gathered(document, problems=faulty_tables)
    gathered.section(key, SECTIONS[key])
    result = [problem for component in gathered.components for problem in component.problems()]
    gathered.problems += [document.problem(path, message) for path, message in result]
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

    def add(self, path: KeyPath, message: str) -> None:
        self.problems.append(self.document.problem(path, message))

    def section(self, key: str, section: Known) -> None:
        sliders = _sliders(self.document)
        for path, raw, given in self.entries(key, section):
            entry = raw if section.field is None else {section.field: raw}
            model = section.choose(entry, path[-1] in sliders)
            built = validated(model, entry, self.document, path, self.problems, **given)
            if built is None:
                self.remember(path, entry)
            else:
                self.components.append(built)

    def entries(self, key: str, section: Known) -> Iterator[tuple[KeyPath, Any, dict[str, Any]]]:
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

    def remember(self, path: KeyPath, raw: object) -> None:
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
