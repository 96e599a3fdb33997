"""What every component is: frozen data that answers what it contributes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, Literal, dataclass_transform

from pydantic import ConfigDict
from pydantic.dataclasses import dataclass as validated_dataclass

from linkages.components.contributed.contacts import Contact
from linkages.components.contributed.ends import End
from linkages.components.contributed.functions import Number
from linkages.components.contributed.measures import Friction, Load
from linkages.components.contributed.references import References
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
    Path,
    Play,
    PointMass,
    Prescribed,
    Relation,
)
from linkages.spec.formula_dimensions import Powers
from linkages.spec.formulas import Formula

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
    | Contact
    | End
    | Friction
)
"""What components contribute."""


@dataclass_transform(kw_only_default=True, frozen_default=True)
def component(cls: type) -> Any:
    """Make a frozen, keyword-only dataclass whose fields are the keys of the definition file."""
    make: Callable[..., Any] = validated_dataclass(
        frozen=True, kw_only=True, config=ConfigDict(extra="forbid")
    )
    return make(cls)


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
    def path(self) -> Path:
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
        """Names of joints and bodies that must exist."""
        return References()

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """What is wrong within this component alone, beyond the types of its fields."""
        return ()

    def measuring(
        self,
        measured: Callable[[Formula], Powers | None],  # noqa: ARG002
    ) -> Iterable[tuple[Path, str]]:
        """What is wrong with units that formulas ask of other fields.

        Parameters
        ----------
        measured
            What a formula with sound units measures.
        """
        return ()
