"""Base class of components: frozen data that contributes terms to the equations."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import cycle
from types import MappingProxyType
from typing import Any, ClassVar, Literal, dataclass_transform

from pydantic import ConfigDict
from pydantic.dataclasses import dataclass as validated_dataclass

from linkages.components.contributed.functions import Number
from linkages.components.contributed.load_measures import GROUND, Actuation, End, Friction, Load
from linkages.components.contributed.normal_forces import Contact
from linkages.components.contributed.state_laws import InternalState
from linkages.components.contributed.terms import (
    Body,
    CamSize,
    Displacement,
    Gravity,
    GroundPin,
    Hint,
    Initial,
    NamedNumber,
    Parameter,
    Play,
    PointMass,
    Prescribed,
    Relation,
)
from linkages.reading.paths import KeyPath
from linkages.spec.formulas import Formula, Powers
from linkages.spec.models import PARAMETERS, documented_fields, field_texts, naming
from linkages.spec.quantities import JOINTS, NameRule
from linkages.spec.units import Dimension


@dataclass(frozen=True)
class References:
    """Names that a component uses: each must be declared by another component.

    Parameters
    ----------
    joints, ground, moving
        Paths and names of joints: any, of the ground, not of the ground.
    bodies
        Paths, names and the kinds of bodies that are expected.
    points
        Paths, bodies, and joints that these must have.
    meeting
        Paths, bodies, and joints at which these must turn, as they are or with a slider that they
        carry; the body may be ``"ground"``.
    carried
        Paths, sliders, and what must carry their axes: a body, or None for the ground.
    """

    joints: tuple[tuple[KeyPath, str], ...] = ()
    ground: tuple[tuple[KeyPath, str], ...] = ()
    moving: tuple[tuple[KeyPath, str], ...] = ()
    bodies: tuple[tuple[KeyPath, str, tuple[str, ...]], ...] = ()
    points: tuple[tuple[KeyPath, str, str], ...] = ()
    meeting: tuple[tuple[KeyPath, str, str], ...] = ()
    carried: tuple[tuple[KeyPath, str, str | None], ...] = ()


Fault = tuple[str | KeyPath, str]
"""A key of an entry, or the steps to it (none of the entry itself), and what is wrong there."""

Term = (
    Body
    | GroundPin
    | Displacement
    | Play
    | Relation
    | CamSize
    | PointMass
    | Prescribed
    | Initial
    | Gravity
    | Hint
    | NamedNumber
    | Load
    | Actuation
    | Contact
    | End
    | Friction
    | InternalState
)
"""What components contribute."""


@dataclass_transform(kw_only_default=True, frozen_default=True)
def component(cls: type) -> Any:
    """Make a frozen, keyword-only dataclass whose fields are the keys of the definition file.

    Its docstring then describes inherited fields as well.
    """
    make: Callable[..., Any] = validated_dataclass(
        frozen=True, kw_only=True, config=ConfigDict(extra="forbid", defer_build=True)
    )
    made = make(cls)
    text, texts = inspect.cleandoc(cls.__doc__ or ""), field_texts(made)
    own = documented_fields(text)
    inherited = [f"{name}\n    {texts[name]}" for name in texts if name not in own]
    if inherited:
        head, _, rest = text.partition(PARAMETERS)
        entries = "\n".join([*inherited, *([rest] if rest else [])])
        made.__doc__ = f"{head.rstrip()}{PARAMETERS}{entries}"
    return made


@dataclass(frozen=True)
class Section:
    """How a section of the definition file is read.

    Parameters
    ----------
    form
        ``"mapping"`` of names to entries, ``"list"`` of entries, or a single ``"value"``.
    example
        What an entry looks like, for messages.
    field
        The field that takes an entry which is not a mapping of keys (a position, a vector).
    """

    form: Literal["mapping", "list", "value"]
    example: str
    field: str | None = None

    @property
    def given(self) -> tuple[str, ...]:
        """Fields of a component that do not stand in its entry."""
        return {"mapping": ("name",), "list": ("index",), "value": ()}[self.form]


class Component:
    """Contributes terms; never integrates, draws, parses or prints.

    A subclass sets `section`, its place in the definition file, and overrides `terms` and,
    where it names other components, `references`. It is found by itself where it stands in
    `linkages.components`; others are registered by `linkages.register` or an entry point of the
    group ``linkages.components``.

    Attributes
    ----------
    section
        The section of the definition file.
    told_by
        The key that tells its entries from those of other components of the section; empty for the
        one whose entries have none of these keys.
    names_slider
        Whether it is meant by an entry that bears the name of a slider, where keys do not tell.
    opens
        How its section is read, if that is a new one.
    no_body
        What to write instead where its name is given in place of a body's; empty if it may be.
    misplaced
        Keys that it does not have, and what to write instead.
    """

    section: ClassVar[str]
    told_by: ClassVar[str] = ""
    names_slider: ClassVar[bool] = False
    opens: ClassVar[Section | None] = None
    no_body: ClassVar[str] = ""
    misplaced: ClassVar[Mapping[str, str]] = MappingProxyType({})

    @property
    def path(self) -> KeyPath:
        """Where this component stands in the definition file."""
        name = getattr(self, "name", None)
        return (self.section,) if name is None else (self.section, name)

    def number(self, key: str) -> Parameter:
        """The number at a key; exactly zero is structure."""
        return Parameter((*self.path, key), getattr(self, key), structural=True)

    def operand(self, key: str) -> Number:
        """The number at a key in a law; zero is a value like others."""
        return Number(Parameter((*self.path, key), getattr(self, key)))

    def pair(self, values: tuple[float, float], *place: str) -> tuple[Parameter, Parameter]:
        """Two numbers at a place of the entry; exactly zero is structure."""
        x, y = (
            Parameter((*self.path, *place, index), value, structural=True)
            for index, value in enumerate(values)
        )
        return x, y

    def terms(self) -> tuple[Term, ...]:
        """What this component contributes to the mechanism."""
        raise TypeError(f"{type(self).__name__} contributes no terms")

    def references(self) -> References:
        """Names of joints and bodies that must exist: those that its fields are."""
        model: Any = type(self)
        names: list[tuple[KeyPath, str, NameRule]] = []
        for key, (rules, several) in naming(model).items():
            value, path = getattr(self, key), self.path if key == "name" else (*self.path, key)
            if several:
                named = enumerate(zip(value or (), cycle(rules)))
                names += [((*path, place), name, rule) for place, (name, rule) in named]
            elif isinstance(value, str):
                names.append((path, value, rules[0]))
        return References(
            joints=tuple((path, name) for path, name, rule in names if rule.of == JOINTS[:1]),
            moving=tuple((path, name) for path, name, rule in names if rule.of == JOINTS[1:]),
            bodies=tuple(
                (path, name, rule.of)
                for path, name, rule in names
                if rule.of[0] not in JOINTS and not (rule.ground and name == GROUND)
            ),
        )

    def problems(self) -> tuple[tuple[KeyPath, str], ...]:
        """What is wrong within this component alone, beyond the types of its fields."""
        faults = ((key if isinstance(key, tuple) else (key,), message)
                  for key, message in (*self._paired(), *self.faults()))  # fmt: skip
        return tuple(((*self.path, *steps), message) for steps, message in faults)

    def faults(self) -> Iterable[Fault]:
        """What is wrong, but for pairs of names that cannot be one."""
        return ()

    def _paired(self) -> Iterator[Fault]:
        """Names of two things that are the same, or the ground in second place."""
        model: Any = type(self)
        for key, (rules, _) in naming(model).items():
            pair, kinds = getattr(self, key), rules[-1].of
            if len(rules) < 2 or pair is None:
                continue
            if pair[0] == pair[1]:
                what = f"{kinds[0]}s" if len(kinds) == 1 else "bodies"
                yield key, f"expected two different {what}, found {pair[0]!r} twice"
            elif pair[1] == GROUND and len(kinds) > 1:
                yield (key, 1), "expected a bar or plate; the ground can stand first only"

    def dimension_of(self, key: str) -> Dimension | None:  # noqa: ARG002
        """What a formula at a key gives, where the type of its field does not say it."""
        return None

    def measuring(
        self,
        measured: Callable[[Formula], Powers | None],  # noqa: ARG002
    ) -> Iterable[tuple[KeyPath, str]]:
        """What is wrong with units that formulas ask of other fields.

        `measured`: what a formula with sound units measures.
        """
        return ()


@component
class ListedComponent(Component):
    """A component that stands in a list.

    Parameters
    ----------
    index
        Place in the list of its section.
    """

    index: int

    @property
    def path(self) -> KeyPath:
        """The section and the place in its list."""
        return (self.section, self.index)


def numbered(components: Iterable[Component]) -> tuple[Component, ...]:
    """The same components; indices of lists count from 0 without gaps."""
    result = list(components)
    places: dict[str, list[int]] = {}
    for entry in result:
        if isinstance(entry, ListedComponent):
            places.setdefault(entry.section, []).append(entry.index)
    first = {
        section: {index: place for place, index in reversed([*enumerate(sorted(indices))])}
        for section, indices in places.items()
    }
    for number, entry in enumerate(result):
        if isinstance(entry, ListedComponent):
            place = first[entry.section][entry.index]
            made: Any = entry
            result[number] = entry if entry.index == place else replace(made, index=place)
    return tuple(result)


def reference(names: tuple[str, str]) -> str | None:
    """The first of two bodies as terms have it: None for the ground."""
    return None if names[0] == GROUND else names[0]
