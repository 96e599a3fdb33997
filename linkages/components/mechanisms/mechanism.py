"""A mechanism: components that fit together, and the terms that they contribute."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from importlib import import_module
from pathlib import Path as FilePath

from linkages.components.clearance import Clearance
from linkages.components.contact_clearance import ContactClearance
from linkages.components.contributed.component import Component, Term
from linkages.components.contributed.listed import numbered
from linkages.components.contributed.terms import (
    PLAYING,
    Body,
    Path,
)
from linkages.components.free import FreeAngle, FreePosition
from linkages.components.guide_clearance import GuideClearance
from linkages.components.mechanisms.consistency import Declared, findings
from linkages.components.mechanisms.contributions import Contributions
from linkages.components.mechanisms.gathered import read_components
from linkages.components.mechanisms.kept import depends, keeping, valued
from linkages.components.mechanisms.registry import SECTIONS
from linkages.components.mechanisms.written import document_of
from linkages.components.parameter import NumberOfFormulas
from linkages.components.simulation import SimulationDefaults
from linkages.components.torsional_damper import ClearanceDamper
from linkages.errors import InputError, Problem
from linkages.reading.document import Document
from linkages.reading.overrides import apply
from linkages.reading.paths import dotted, split
from linkages.reading.replacing import replaced
from linkages.reading.wording import suggestion
from linkages.reading.writing import as_yaml
from linkages.spec.tolerance_zones import ToleranceZone, zones_in


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
    sensitive: tuple[Path, ...] = field(default=(), repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "components", tuple(self.components))
        for component in self.components:
            if not isinstance(component, Component):
                raise TypeError(
                    f"components must be bars, joints and the like, found {component!r}"
                )
        found = findings(self.components, Declared(self.components))
        if found:
            raise self.error(found)
        ordered = sorted(numbered(self.components), key=_place)
        object.__setattr__(self, "components", tuple(ordered))

    def __repr__(self) -> str:
        counts = Counter(component.section for component in self.components)
        parts = [repr(self.name), *(f"{section}={count}" for section, count in counts.items())]
        return f"Mechanism({', '.join(parts)})"

    def _repr_html_(self) -> str:
        """What notebooks show: a drawing, mobility and components."""
        return str(import_module("linkages.plots.notebook").mechanism_html(self))  # stands above

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

    def problem(self, path: Path, message: str) -> Problem:
        """A problem at a place of the definition, with its line where there is a file."""
        return self.definition.problem(path, message)

    def error(self, found: Iterable[tuple[Path, str]]) -> InputError:
        """An error that lists problems at their places."""
        return InputError(self.source, [self.problem(path, message) for path, message in found])

    @cached_property
    def term_groups(self) -> tuple[tuple[Term, ...], ...]:
        """The same for each component."""
        return tuple(self.terms_of(component) for component in self.components)

    @cached_property
    def parameters(self) -> dict[Path, float]:
        """Numbers that formulas share, by their paths."""
        own = (c for c in self.components if isinstance(c, NumberOfFormulas))
        return {component.path: component.value.value for component in own}

    def terms_of(self, component: Component) -> tuple[Term, ...]:
        """What one component contributes."""
        terms = component.terms()
        if self.parameters and not isinstance(component, NumberOfFormulas):
            terms = valued(terms, self.parameters)
        for asked in self.sensitive:
            where = (asked, component.path, self.definition)
            terms = keeping(terms, partial(depends, *where))
        return terms

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

    def keeping(self, paths: Iterable[str]) -> Mechanism:
        """The same mechanism for which some numbers stay arguments of kernels.

        Parameters
        ----------
        paths
            Dotted paths of the definition. A zero, a right angle or a ratio of one there, or in
            what follows from it, is no structure then.

        Raises
        ------
        InputError
            If a path leads to no number.
        """
        asked = tuple(split(path) or (path,) for path in paths)
        found = [(p, "found no number there") for p in asked if not self._has_number(p)]
        if found:
            raise self.error(found)
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
        document, components = read_components(apply(self.definition, values))
        name = str(document.content["name"]) if "name" in values else self.name
        return replace(
            self, components=components, defined=components, name=name, document=document
        )

    def _has_number(self, path: Path) -> bool:
        """Whether a path leads to a number of a component, written or not."""
        known: list[Path] = []
        owned = any(path[: len(c.path)] == c.path for c in self.components)
        keeping(self.terms, lambda number: known.append(number.path))
        given = self.definition.value(path) is not None
        return owned and (given or any(own[: len(path)] == path for own in known))

    def exchanging(self, others: Mapping[int, tuple[Component, tuple[Term, ...]]]) -> Mechanism:
        """The same mechanism with other numbers in some components.

        Parameters
        ----------
        others
            Place among `components` → one that differs from it in numbers only, so that all fit
            together as before; and its terms.
        """
        found = object.__new__(type(self))
        components, groups = list(self.components), list(self.term_groups)
        for place, (component, terms) in others.items():
            components[place], groups[place] = component, terms
        vars(found).update({name: getattr(self, name) for name in self.__dataclass_fields__})
        vars(found).update(components=tuple(components))
        if found.parameters != self.parameters:
            groups = [valued(terms, found.parameters) for terms in groups]
        vars(found).update(term_groups=tuple(groups))
        return found

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
