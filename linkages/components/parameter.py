"""Parameters: numbers with names, which formulas share."""

from __future__ import annotations

from typing import Annotated, ClassVar

from linkages.components.contributed.component import Component, Section, component
from linkages.components.contributed.terms import PARAMETERS, NamedNumber, Path, named_number
from linkages.operations import formula_functions
from linkages.spec.arithmetic import CONSTANTS
from linkages.spec.formulas import CALLED, Constant
from linkages.spec.laws import PlaceRule
from linkages.spec.quantities import Name

RESERVED = ("t", "and", "or", "not", "rate", *CONSTANTS, *CALLED, *formula_functions())
"""Words that mean something else in formulas."""


@component
class NumberOfFormulas(Component):
    """A number that any formula may use by its name.

    Parameters
    ----------
    name
        A word of letters, digits and _ that means nothing else in formulas.
    value
        In SI, or with a unit.
    """

    section: ClassVar[str] = PARAMETERS
    opens: ClassVar[Section] = Section("mapping", "friction_force: 30 kN", field="value")

    name: Name
    value: Annotated[Constant, PlaceRule()]

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """A name that formulas can read."""
        if not self.name.isidentifier():
            return ((self.path, f"expected a word of letters, digits and _, found {self.name!r}"),)
        if self.name in RESERVED:
            return ((self.path, f"{self.name!r} means something else in formulas"),)
        return ()

    def terms(self) -> tuple[NamedNumber, ...]:
        """The number itself."""
        return (NamedNumber(named_number(self.name, self.value.value)),)
