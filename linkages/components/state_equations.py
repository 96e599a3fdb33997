"""States beside those of the motion: pressures, filters, and what digital controllers hold."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Annotated, ClassVar

from linkages.components.contributed.component import Component, Fault, Section, component
from linkages.components.contributed.functions import Number, constant
from linkages.components.contributed.state_laws import STATES, InternalState
from linkages.components.laws import translated
from linkages.reading.paths import KeyPath
from linkages.spec.formulas import (
    PARAMETER,
    Constant,
    Formula,
    Sensed,
    described,
    powers,
    product,
    unit_of,
    unit_text,
)
from linkages.spec.law_fields import ArgumentRule, PlaceRule
from linkages.spec.quantities import Name
from linkages.spec.units import DURATION, Dimension

START = Constant(0.0)

Period = Annotated[Formula, ArgumentRule(constant=True)]


def period_faults(period: Formula) -> Iterator[Fault]:
    """What is wrong with the period of updates."""
    match period.tree:
        case Constant(value) if value > 0.0:
            return
        case Sensed(word) if word == PARAMETER:
            return
    expected = "expected a time > 0 (seconds, or with a unit), or the name of a parameter"
    yield "period", f"{expected}, found {period.text!r}"


def period_of(period: Formula, path: KeyPath) -> Number:
    """The period of updates, a number at a path or a parameter; of one with faults any."""
    result = translated(period, path)
    return result if isinstance(result, Number) else constant(1.0)


@component
class _State(Component):
    """A quantity that laws sense as ``name.value``.

    Parameters
    ----------
    name
        Name of the state.
    initial
        The value at t = 0, in SI or with a unit, which is then that of the state.
    scale
        A large value, in the same unit: the absolute tolerance of an integration is a part of it.
        The size of the initial value if not given, or 1 in SI if that is 0.
    """

    name: Name
    initial: Annotated[Constant, PlaceRule()] = START
    scale: Annotated[Constant, PlaceRule()] | None = None

    def faults(self) -> Iterator[Fault]:
        """A scale above zero, of the dimension of the initial value."""
        if self.scale is None:
            return
        own = self.scale.unit
        if not self.scale.value > 0.0:
            yield "scale", "expected a value > 0"
        if own is not None and self.initial.unit is None:
            yield "scale", "has a unit; expected one of 'initial' as well"
        elif own is not None and self.initial.unit is not None:
            expected, found = powers(self.initial.unit), powers(own)
            if found != expected:
                yield "scale", f"expected {described(expected)}, found {described(found)}"

    def _dimension(self, name: str, per_second: int) -> Dimension | None:
        """That of the initial value over a power of time, if this has a unit."""
        if self.initial.unit is None:
            return None
        over = product(powers(self.initial.unit), ({"second": Fraction(1)}, -per_second))
        own = unit_text(self.initial.unit) if not per_second else ""
        return Dimension(name, own or unit_of(over))

    def _state(self, law: Formula, key: str, period: Number | None = None) -> InternalState:
        own, initial = self.scale, self.initial
        scale = (abs(initial.value) or 1.0) if own is None else own.value
        return InternalState(
            self.path, unit_text(initial.unit), translated(law, (*self.path, key)), scale,
            initial.value, period,
        )  # fmt: skip


@component
class StateEquation(_State):
    """A state z with dz/dt = f.

    Parameters
    ----------
    rate
        f: a number or a formula of time, of quantities of the mechanism, of parameters and states.
    """

    section: ClassVar[str] = STATES
    opens: ClassVar[Section] = Section(
        "mapping", 'filtered: {initial: 0, rate: "(crank.speed - filtered.value)/0.05"}'
    )

    rate: Annotated[Formula, ArgumentRule(constant=True)]

    def dimension_of(self, key: str) -> Dimension | None:
        """The rate is that of the initial value, if this has a unit."""
        return self._dimension(f"rate of {self.name!r}", 1) if key == "rate" else None

    def terms(self) -> tuple[InternalState, ...]:
        """The state."""
        return (self._state(self.rate, "rate"),)


@component
class SampledState(_State):
    """A state that becomes f at multiples of a period, and is held between them.

    Parameters
    ----------
    next
        f: a number or a formula of time, of quantities of the mechanism, of parameters and states,
        all as they are before the update.
    period
        Seconds from one update to the next, > 0, or the name of a parameter.
    """

    section: ClassVar[str] = STATES
    told_by: ClassVar[str] = "next"

    next: Annotated[Formula, ArgumentRule(constant=True)]
    period: Period

    def faults(self) -> Iterator[Fault]:
        """Those of any state, and of the period."""
        yield from super().faults()
        yield from period_faults(self.period)

    def dimension_of(self, key: str) -> Dimension | None:
        """The next value is what the initial one is, if this has a unit."""
        if key == "period":
            return DURATION
        return self._dimension(f"value of {self.name!r}", 0) if key == "next" else None

    def terms(self) -> tuple[InternalState, ...]:
        """The state."""
        return (self._state(self.next, "next", period_of(self.period, (*self.path, "period"))),)
