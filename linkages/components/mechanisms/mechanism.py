"""A mechanism: consistent components and the terms that they contribute."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cache, cached_property, partial
from operator import is_not
from pathlib import Path as FilePath
from typing import Any

from linkages.components.contributed.component import Component, Term, numbered
from linkages.components.contributed.functions import Number
from linkages.components.contributed.load_measures import Load
from linkages.components.contributed.state_laws import InternalState
from linkages.components.contributed.terms import PLAYING, Body, Parameter, Prescribed
from linkages.components.joint_clearances import (
    Clearance,
    ContactClearance,
    GuideClearance,
)
from linkages.components.mechanisms.consistency import Declared, findings
from linkages.components.mechanisms.contributions import Contributions
from linkages.components.mechanisms.registry import SECTIONS, read_components
from linkages.components.scene import FreeAngle, FreePosition, NumberOfFormulas, SimulationDefaults
from linkages.components.springs import ClearanceDamper
from linkages.components.transmissions import CamContact
from linkages.components.wall_contacts import WallContact
from linkages.discovery import html_of
from linkages.errors import InputError, Problem
from linkages.reading.document import Document
from linkages.reading.output_files import replaced
from linkages.reading.overrides import apply, as_yaml
from linkages.reading.paths import KeyPath, dotted, split
from linkages.reading.wording import suggestion
from linkages.spec.conversion import ToleranceZone, zone_of, zones_in
from linkages.spec.formulas import Constant, Formula
from linkages.spec.models import written_fields


def document_of(
    components: Iterable[Component],
    source: str,
    document: Document | None = None,
    defined: Iterable[Component] = (),
) -> Document:
    """The definition of some components.

    `document`, `defined`: a definition, and the components that it defines: those that are still
    among `components` keep their entries as they stand there, with lines.
    """
    base = Document(source, {}, {}) if document is None else document
    before = {component.path: component for component in defined}
    content = {"name": base.content["name"]} if "name" in base.content else {}
    kept: set[KeyPath] = set()
    for component in sorted(components, key=lambda entry: getattr(entry, "index", 0)):
        if before.get(component.path) == component:
            kept.add(component.path)
            _enter(content, component.path, base.value(component.path))
        else:
            entry = _with_tolerances(entry_of(component), base.value(component.path))
            _enter(content, component.path, entry)

    def stays(path: KeyPath) -> bool:
        return any(path[: len(component)] == component for component in kept)

    positions = {p: at for p, at in base.positions.items() if len(p) < 2 or stays(p)}
    overridden = {p: text for p, text in base.overridden.items() if stays(p)}
    whole = {path[:1]: path for path in kept if path[:1] in base.overridden}
    overridden |= {path: base.overridden[section] for section, path in whole.items()}
    return Document(source, content, positions, overridden, base.folder, base.changed, base.tables)


def _enter(content: dict[str, Any], path: KeyPath, entry: Any) -> None:
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
    return value if fields is None else {key: _plain(item) for key, item in fields.items()}


def keeping(item: Any, kept: Callable[[Parameter], bool | None]) -> Any:
    """A term (or several) in which some numbers are no structure."""
    return changed(item, lambda number: replace(number, kept=True) if kept(number) else number)


def valued(item: Any, values: Mapping[KeyPath, float]) -> Any:
    """A term (or several) in which the numbers that formulas share have their values."""

    def with_value(number: Parameter) -> Parameter:
        if number.path in values:
            return replace(number, value=values[number.path])
        return number

    return changed(item, with_value)


def changed(item: Any, change: Callable[[Parameter], Parameter]) -> Any:
    """A term (or several) with something done to all of its numbers; itself if that is nothing."""
    if isinstance(item, Parameter):
        return change(item)
    if isinstance(item, tuple):
        parts = tuple([changed(part, change) for part in item])
        return parts if any(map(is_not, parts, item)) else item
    kind: Any = type(item)
    names = _field_names(kind)
    if not names and isinstance(item, Mapping):
        entries = {name: changed(part, change) for name, part in item.items()}
        return entries if any(map(is_not, entries.values(), item.values())) else item
    own = {}
    for name in names:
        before = getattr(item, name)
        if (after := changed(before, change)) is not before:
            own[name] = after
    return replace(item, **own) if own else item


@cache
def _field_names(kind: Any) -> tuple[str, ...]:
    """Fields of a dataclass; none of anything else."""
    return tuple(field.name for field in fields(kind)) if is_dataclass(kind) else ()


def depends(asked: Sequence[KeyPath], definition: Document, parameter: Parameter) -> bool:
    """Whether a number may change with one of its component that is asked for."""
    if not parameter.path:
        return False
    own = any(parameter.path[: len(each)] == each for each in asked)
    return own or definition.value(parameter.path) is None


@dataclass(frozen=True, kw_only=True, repr=False)
class Mechanism(Contributions):
    """A planar linkage, from a definition file or built in Python.

    Two mechanisms are equal if they have the same name and components, wherever they come from.

    Parameters
    ----------
    components
        Bars, joints, sliders, …; kept section by section as in a definition file, and within a
        section in the order given, which reports and results keep. The indices of loads, springs
        and whatever else has no name are closed up where some are missing.
    name
        For titles.
    source
        What messages call the place that it comes from.
    document
        The definition file that it was read from, if there is one; `definition` is what it is now.
    defined
        What `document` defines.
    sensitive
        Paths of numbers that are no structure, whatever their value; see `keeping`.

    Raises
    ------
    InputError
        With everything that does not fit together.
    """

    components: tuple[Component, ...]
    name: str = "mechanism"
    source: str = field(default="mechanism", compare=False)
    document: Document | None = field(default=None, repr=False, compare=False)
    defined: tuple[Component, ...] = field(default=(), repr=False, compare=False)
    sensitive: tuple[KeyPath, ...] = field(default=(), repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "components", tuple(self.components))
        for component in self.components:
            if not isinstance(component, Component):
                raise TypeError(
                    f"components must be bars, joints and the like, found {component!r}"
                )
        read = self.document is not None and self.components is self.defined
        # what was read from a document has been looked at with its faulty entries
        if not read and (result := findings(self.components, Declared(self.components))):
            raise self.error(result)
        ordered = sorted(numbered(self.components), key=_place)
        object.__setattr__(self, "components", tuple(ordered))

    def __repr__(self) -> str:
        counts = Counter(component.section for component in self.components)
        parts = [repr(self.name), *(f"{section}={count}" for section, count in counts.items())]
        return f"Mechanism({', '.join(parts)})"

    def _repr_html_(self) -> str:
        """What notebooks show: a drawing, mobility and components."""
        return html_of(self)

    @cached_property
    def definition(self) -> Document:
        """The definition of this very mechanism: its file, or what would stand in one.

        What was changed in Python stands there as it is now, everything else as it was read.
        """
        if self.document is not None and self.components == self.defined:
            return self.document
        return document_of(self.components, self.source, self.document, self.defined)

    def to_yaml(self) -> str:
        """The definition as YAML text, from which `linkages.loads` makes an equal mechanism.

        Texts such as ``0.3*cos(60 deg)`` stand as they were read, and numbers with all digits;
        what was changed in Python stands as it is now. Comments are not kept, and tables that were
        read from files stand in the text itself.

        Examples
        --------
        >>> import linkages
        >>> mechanism = linkages.load("slider-crank")
        >>> linkages.loads(mechanism.to_yaml()) == mechanism
        True
        """
        definition = self.definition
        name = {"name": self.name}  # first, and not that of whatever file this is read from
        return as_yaml(replace(definition, content=name | definition.content | name))

    def save(self, path: str | FilePath) -> FilePath:
        """Write `to_yaml` to a file, and return its path.

        The file appears whole or not at all; one of that name is replaced when the new one is
        complete.
        """
        file = FilePath(path)
        with replaced(file) as temporary:
            temporary.write_text(self.to_yaml(), encoding="utf-8")
        return file

    @property
    def changes(self) -> tuple[str, ...]:
        """In what it differs from its file, as assignments such as ``bars.rod.length=0.3``."""
        return self.definition.changes

    @property
    def file_name(self) -> str:
        """The name of its file, without the folders of a machine."""
        return FilePath(self.source).name

    def problem(self, path: KeyPath, message: str) -> Problem:
        """A problem at a place of the definition, with its line where there is a file."""
        return self.definition.problem(path, message)

    def error(self, found: Iterable[tuple[KeyPath, str]]) -> InputError:
        """An error that lists problems at their places."""
        return InputError(self.source, [self.problem(path, message) for path, message in found])

    @cached_property
    def term_groups(self) -> tuple[tuple[Term, ...], ...]:
        """The same for each component."""
        return tuple(self.terms_of(component) for component in self.components)

    @cached_property
    def parameters(self) -> dict[KeyPath, float]:
        """Numbers that formulas share, by their paths."""
        own = (c for c in self.components if isinstance(c, NumberOfFormulas))
        return {component.path: component.value.value for component in own}

    @cached_property
    def _sharing(self) -> frozenset[int]:
        """Places of components whose terms use shared parameters."""

        def shares(terms: tuple[Term, ...]) -> bool:
            paths: list[KeyPath] = []
            keeping(terms, lambda number: paths.append(number.path))
            return not self.parameters.keys().isdisjoint(paths)

        return frozenset(p for p, terms in enumerate(self.term_groups) if shares(terms))

    def terms_of(self, component: Component) -> tuple[Term, ...]:
        """What one component contributes."""
        terms = component.terms()
        if self.parameters and not isinstance(component, NumberOfFormulas):
            terms = valued(terms, self.parameters)
        where = component.path
        asked = [path for path in self.sensitive if path[: len(where)] == where]
        return keeping(terms, partial(depends, asked, self.definition)) if asked else terms

    @property
    def clearances(self) -> tuple[Clearance | ContactClearance, ...]:
        """Joints with clearance."""
        return tuple(c for c in self.components if isinstance(c, Clearance | ContactClearance))

    @cached_property
    def tolerances(self) -> dict[str, ToleranceZone]:
        """Dotted path → tolerance zone of every number of the definition that states one.

        Numbers are their nominal values everywhere else; tolerances do not count when mechanisms
        are compared.
        """
        return {dotted(path): zone for path, zone in zones_in(self.definition.content).items()}

    @cached_property
    def simulation(self) -> SimulationDefaults:
        """How its author wants it to be simulated."""
        own = (c for c in self.components if isinstance(c, SimulationDefaults))
        return next(own, SimulationDefaults())

    @property
    def opening(self) -> tuple[ContactClearance | GuideClearance, ...]:
        """Clearances whose two sides may part."""
        kinds = ContactClearance | GuideClearance
        return tuple(c for c in self.components if isinstance(c, kinds))

    @property
    def walls(self) -> tuple[WallContact | CamContact, ...]:
        """What may touch walls and cams, and leave them."""
        return tuple(c for c in self.components if isinstance(c, WallContact | CamContact))

    @property
    def worn(self) -> tuple[Clearance | ContactClearance | GuideClearance, ...]:
        """Clearances whose surfaces wear."""
        kinds = Clearance | ContactClearance | GuideClearance
        clearances = (c for c in self.components if isinstance(c, kinds))
        return tuple(c for c in clearances if c.wear is not None)

    def keeping(self, paths: Iterable[str]) -> Mechanism:
        """The same mechanism for which some numbers stay arguments of kernels.

        Parameters
        ----------
        paths
            Dotted paths of the definition. A zero, a right angle or a ratio of one there, or in
            what follows from it, is no structure then.
        """
        asked = tuple(split(path) or (path,) for path in paths)
        result = [(p, "found no number there") for p in asked if not self._has_number(p)]
        if result:
            raise self.error(result)
        return replace(self, sensitive=tuple(dict.fromkeys((*self.sensitive, *asked))))

    def with_values(self, values: Mapping[str, object]) -> Mechanism:
        """The same mechanism with other values at some paths of its definition.

        Parameters
        ----------
        values
            Dotted path → value. Numbers (NumPy's as well) are SI; texts are read as they would be
            in a definition file, with units and arithmetic; quantities of pint carry their unit;
            lists, mappings and arrays are taken as they are. A path may lead to a whole entry, or
            to one that does not exist yet.

        Raises
        ------
        InputError
            With every path that leads nowhere and every value that cannot be used.

        Examples
        --------
        >>> import linkages
        >>> mechanism = linkages.load("slider-crank")
        >>> fast = mechanism.with_values({"bars.rod.length": 0.32, "drives.crank.speed": "900 rpm"})
        >>> fast == linkages.loads(fast.to_yaml())
        True
        """
        known = {component.path: component for component in self.components}
        changed = apply(self.definition, in_whole(self.definition, known, values))
        document, components = read_components(changed)
        name = str(document.content["name"]) if "name" in values else self.name
        return replace(
            self, components=components, defined=components, name=name, document=document
        )

    def _has_number(self, path: KeyPath) -> bool:
        """Whether a path leads to a number of a component, written or not."""
        known: list[KeyPath] = []
        owned = any(path[: len(c.path)] == c.path for c in self.components)
        keeping(self.terms, lambda number: known.append(number.path))
        given = self.definition.value(path) is not None
        return owned and (given or any(own[: len(path)] == path for own in known))

    def exchanging(self, others: Mapping[int, tuple[Component, tuple[Term, ...]]]) -> Mechanism:
        """The same mechanism with other numbers in some components.

        `others`: place among `components` → one that differs from it in numbers only, so that all
        fit together as before; and its terms.
        """
        components, groups = list(self.components), list(self.term_groups)
        for place, (component, terms) in others.items():
            components[place], groups[place] = component, terms
        result = self._with_components(components)
        if result.parameters != self.parameters:
            for place in self._sharing.union(others):
                groups[place] = valued(groups[place], result.parameters)
        vars(result).update(term_groups=tuple(groups))
        return result

    def with_loads(self, loads: Iterable[Load]) -> Mechanism:
        """The same mechanism with loads that no component contributes, behind its own."""
        result = self._with_components(self.components)
        vars(result).update(term_groups=(*self.term_groups, tuple(loads)))
        return result

    def with_deviations(self, given: Mapping[str, Parameter]) -> Mechanism:
        """The same mechanism with drives that accelerate beyond their laws, each by a number.

        The deviation from the law and its rate are internal states, zero at first.
        """
        if not given:
            return self
        groups = [[*terms] for terms in self.term_groups]
        states = []
        for name, number in given.items():
            unit = "rad" if self.bodies[name].rotates else "m"
            path, faster = ("drives", name, "deviation"), ("drives", name, "deviation_rate")
            rate = InternalState(faster, f"{unit}/s", Number(number))
            states += [InternalState(path, unit, rate.value), rate]
            added = (dotted(path), dotted(faster), number)
            for terms in groups:
                terms[:] = [
                    replace(t, deviation=added) if isinstance(t, Prescribed) and t.body == name
                    else t
                    for t in terms
                ]  # fmt: skip
        result = self._with_components(self.components)
        vars(result).update(term_groups=(*map(tuple, groups), tuple(states)))
        return result

    def _with_components(self, components: Iterable[Component]) -> Mechanism:
        """The same fields with components that are known to fit together."""
        result = object.__new__(type(self))
        vars(result).update({name: getattr(self, name) for name in self.__dataclass_fields__})
        vars(result).update(components=tuple(components))
        return result

    def with_component(self, component: Component) -> Mechanism:
        """The same mechanism with one more component."""
        return replace(self, components=(*self.components, component))

    def with_state(self, state: Mapping[str, tuple[float, float]]) -> Mechanism:
        """The same mechanism with other free coordinates, or the same in another state.

        Parameters
        ----------
        state
            Free coordinate → value and rate; clearances that are not named keep theirs.

        Raises
        ------
        TypeError, ValueError
            If it names no body, or a body without value and rate.
        """
        _require_state(self.bodies, state)
        kept: list[Component] = []
        for component in self.components:
            if isinstance(component, Clearance) and component.name in state:
                angle, speed = state[component.name]
                kept.append(replace(component, angle=angle, speed=speed))
            elif isinstance(component, ContactClearance | GuideClearance):
                kept.append(component.at(state))
            elif not isinstance(component, FreeAngle | FreePosition):
                kept.append(component)
        for name, (value, rate) in state.items():
            if self.bodies[name].kind in PLAYING:
                continue
            if self.bodies[name].rotates:
                kept.append(FreeAngle(name=name, angle=value, speed=rate))
            else:
                kept.append(FreePosition(name=name, position=value, speed=rate))
        return replace(self, components=tuple(kept))

    def ideal(self) -> Mechanism:
        """The same mechanism without its clearances and the friction in them."""
        gone = (Clearance, ContactClearance, GuideClearance, ClearanceDamper)
        kept = tuple(c for c in self.components if not isinstance(c, gone))
        return replace(self, components=kept, name=f"{self.name} (ideal)")


def in_whole(
    document: Document, components: Mapping[KeyPath, Component], values: Mapping[str, object]
) -> Mapping[str, object]:
    """Values of lists that a document does not write, with those of their defaults beside them.

    The offset of a clearance, for example, is [0, 0] unless it is written.
    """
    if not isinstance(values, Mapping):
        return values
    result: dict[str, Any] = {}
    for text, value in values.items():
        *parent, last = split(str(text)) or (str(text),)
        owner = components.get(tuple(parent[:-1]))
        default = getattr(owner, str(parent[-1]), None) if owner else None
        written = document.value(tuple(parent)) is not None
        if isinstance(default, tuple) and last in range(len(default)) and not written:
            result.setdefault(dotted(tuple(parent)), list(default))[int(last)] = value
        else:
            result[text] = value
    return result


def _require_state(bodies: Mapping[str, Body], state: object) -> None:
    if not isinstance(state, Mapping):
        expected = 'state must be a mapping such as {"crank": (0.1, 2.0)}'
        raise TypeError(f"{expected}, found {state!r}")
    for name, pair in state.items():
        if name not in bodies:
            near = suggestion(str(name), bodies) or f"; expected one of: {', '.join(bodies)}"
            raise ValueError(f"state: unknown body {name!r}{near}")
        try:
            _, _ = pair
        except (TypeError, ValueError):
            expected = f"state: expected the value and the rate of {name}"
            raise ValueError(f"{expected}, found {pair!r}") from None


def _place(component: Component) -> tuple[int, int]:
    """Where a component stands in a definition: its section, then its index in lists."""
    sections = list(SECTIONS)
    section = component.section
    place = sections.index(section) if section in sections else len(sections)
    return place, getattr(component, "index", 0)
