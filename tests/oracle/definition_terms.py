"""From the plain mapping of a definition to a mechanism, term by term.

It takes no road through YAML, units or validation, and knows nothing of the components that read
sliders, drives, loads and springs: what they make of a file can be compared with it.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from definition_entries import READERS

from linkages import (
    AssemblyHint,
    Bar,
    Clearance,
    FreeAngle,
    FreePosition,
    GroundJoint,
    Mechanism,
    Plate,
    UniformGravity,
)
from linkages.components.contributed.component import Component, Term
from linkages.reading.document import Document


@dataclass(frozen=True)
class Given(Component):
    """Terms as they are, with their place in the definition."""

    section: ClassVar[str] = "given"
    place: tuple[str | int, ...]
    given: tuple[Term, ...]

    @property
    def path(self) -> tuple[str | int, ...]:
        return self.place

    def terms(self) -> tuple[Term, ...]:
        return self.given


class Unchecked(Mechanism):
    """A mechanism whose components fit together by construction."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "components", tuple(self.components))

    @property
    def definition(self) -> Document:
        """No file says the same: problems have a path, and no line."""
        return Document(self.source, {}, {})


def mechanism_of(definition: Mapping[str, Any]) -> Mechanism:
    """The mechanism that a mapping in the form of a definition file describes, all numbers SI."""
    return Unchecked(components=tuple(_components(definition)), name="drawn at random")


def _components(given: Mapping[str, Any]) -> Iterator[Component]:
    if "gravity" in given:
        yield UniformGravity(acceleration=given["gravity"])
    for name, position in given["joints"].items():
        yield GroundJoint(name=name, position=position)
    for name, bar in given["bars"].items():
        yield Plate(name=name, **bar) if "points" in bar else Bar(name=name, **bar)
    for section, read in READERS.items():
        entries = given.get(section, {})
        pairs = entries.items() if isinstance(entries, dict) else enumerate(entries)
        for key, entry in pairs:
            terms = read((section, key), entry)
            yield Given((section, key), terms if isinstance(terms, tuple) else (terms,))
    for name, clearance in given.get("clearances", {}).items():
        yield Clearance(name=name, **clearance)
    for name, start in given.get("free", {}).items():
        kind = FreePosition if "position" in start else FreeAngle
        yield kind(name=name, **start)
    for name, where in given.get("assembly", {}).items():
        yield AssemblyHint(name=name, where=where)
