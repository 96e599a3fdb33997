"""Equations of states beside those of the motion: pressures, filters, temperatures."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Annotated, ClassVar

from linkages.components.contributed.component import Component, Section, component
from linkages.components.contributed.state_laws import STATES, InternalState
from linkages.components.laws import translated
from linkages.reading.paths import KeyPath
from linkages.spec.formulas import (
    Constant,
    Formula,
    described,
    powers,
    product,
    unit_of,
    unit_text,
)
from linkages.spec.law_fields import ArgumentRule, PlaceRule
from linkages.spec.quantities import Name
from linkages.spec.units import Dimension

START = Constant(0.0)


@component
class StateEquation(Component):
    """A state z with dz/dt = f, which laws sense as ``name.value``.

    Parameters
    ----------
    name
        Name of the state.
    rate
        f: a number or a formula of time, of quantities of the mechanism, of parameters and states.
    initial
        The value at t = 0, in SI or with a unit, which is then that of the state.
    scale
        A large value, in the same unit: the absolute tolerance of an integration is a part of it.
        The size of the initial value if not given, or 1 in SI if that is 0.
    """

    section: ClassVar[str] = STATES
    opens: ClassVar[Section] = Section(
        "mapping", 'filtered: {initial: 0, rate: "(crank.speed - filtered.value)/0.05"}'
    )

    name: Name
    rate: Annotated[Formula, ArgumentRule(constant=True)]
    initial: Annotated[Constant, PlaceRule()] = START
    scale: Annotated[Constant, PlaceRule()] | None = None

    def problems(self) -> tuple[tuple[KeyPath, str], ...]:
        """A scale above zero, of the dimension of the initial value."""
        return tuple(self._faults())

    def _faults(self) -> Iterator[tuple[KeyPath, str]]:
        if self.scale is None:
            return
        path, own = (*self.path, "scale"), self.scale.unit
        if not self.scale.value > 0.0:
            yield path, "expected a value > 0"
        if own is not None and self.initial.unit is None:
            yield path, "has a unit; expected one of 'initial' as well"
        elif own is not None and self.initial.unit is not None:
            expected, found = powers(self.initial.unit), powers(own)
            if found != expected:
                yield path, f"expected {described(expected)}, found {described(found)}"

    def dimension_of(self, key: str) -> Dimension | None:
        """The rate is that of the initial value, if this has a unit."""
        if key != "rate" or self.initial.unit is None:
            return None
        per_second = product(powers(self.initial.unit), ({"second": Fraction(1)}, -1))
        return Dimension(f"rate of {self.name!r}", unit_of(per_second))

    def terms(self) -> tuple[InternalState, ...]:
        """The state."""
        rate = translated(self.rate, (*self.path, "rate"))
        own, initial = self.scale, self.initial
        scale = (abs(initial.value) or 1.0) if own is None else own.value
        return (InternalState(self.path, unit_text(initial.unit), rate, scale, initial.value),)
