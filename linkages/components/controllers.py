"""PID controllers: a force or torque that brings a quantity to its setpoint.

References
----------
.. [1] K. J. Åström, T. Hägglund, *Advanced PID Control*, ISA, 2006: derivative of what is measured
   (3.3), tracking against windup (3.5).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Annotated, ClassVar

from linkages.components.contributed.attachments import Attached, BetweenJoints, OnSlider
from linkages.components.contributed.component import Fault, Section, component
from linkages.components.contributed.functions import (
    Function,
    Measured,
    Number,
    applied,
)
from linkages.components.contributed.load_measures import GROUND, Load, Turn
from linkages.components.contributed.state_laws import InternalState, value_of
from linkages.components.contributed.terms import Parameter
from linkages.components.laws import translated
from linkages.components.state_equations import Period, period_faults, period_of
from linkages.reading.paths import KeyPath
from linkages.spec.formulas import Constant, Formula, Powers, described, powers, product
from linkages.spec.law_fields import ArgumentRule, PlaceRule
from linkages.spec.quantities import (
    BarName,
    BarOrGroundName,
    Duration,
    Force,
    Name,
    Torque,
)
from linkages.spec.units import DURATION, Dimension, unit

Gain = Annotated[Constant, PlaceRule()]
_GAINS = {"proportional": 0, "integral": -1, "derivative": 1}
"""Gain → the power of time by which it differs from effort per quantity."""
NONE = Constant(0.0)


@component
class _Controller(Attached):
    """An effort u = P·e + I·∫e dt − D·dy/dt with the error e = setpoint − y [1]_.

    Parameters
    ----------
    name
        Name of the controller.
    of
        The quantity y that is controlled: ``crank.speed``, or a formula of some.
    setpoint
        What it should be: a number, or a formula, of time perhaps.
    proportional
        Gain P: effort per error, in SI or with a unit.
    integral
        Gain I: effort per error and second.
    derivative
        Gain D: effort per rate of the quantity, which must be a position, an angle or a distance.
    limits
        Least and greatest effort; none if not given.
    tracking
        Time in seconds over which the integral follows an effort at its limit; P/I if not given.
    period
        Of a digital controller: seconds from one update of the effort to the next, > 0, or the name
        of a parameter. Between them the effort is held. None of a continuous controller.
    """

    section: ClassVar[str] = "controllers"

    name: Name
    of: Annotated[Formula, ArgumentRule()]
    setpoint: Annotated[Formula, ArgumentRule(constant=True)]
    proportional: Gain = NONE
    integral: Gain = NONE
    derivative: Gain = NONE
    limits: tuple[float, float] | None = None
    tracking: Duration | None = None
    period: Period | None = None

    def faults(self) -> Iterator[Fault]:
        """A gain, a rate for the derivative, limits in order, a time for tracking."""
        gains = {key: getattr(self, key).value for key in _GAINS}
        if not any(gains.values()):
            yield (), "expected a gain: 'proportional', 'integral' or 'derivative'"
        if gains["derivative"] and self._rate is None:
            message = "expected a position, an angle or a distance for 'derivative', which has a "
            yield "of", f"{message}rate; found {self.of.text!r}"
        if self.limits is not None and not self.limits[0] < self.limits[1]:
            yield "limits", "expected the least effort first, then the greatest"
        if self.tracking is not None and (self.limits is None or not gains["integral"]):
            yield "tracking", "found without 'limits' and 'integral'; expected both"
        usual = gains["proportional"] * gains["integral"] > 0
        if self.limits and gains["integral"] and self.tracking is None and not usual:
            yield (), "missing key 'tracking': without a proportional gain nothing gives it"
        if self.period is not None:
            yield from period_faults(self.period)

    def dimension_of(self, key: str) -> Dimension | None:
        """The period is a time."""
        return DURATION if key == "period" else None

    def measuring(
        self, measured: Callable[[Formula], Powers | None]
    ) -> Iterator[tuple[KeyPath, str]]:
        """What is wrong with the units of setpoint and gains."""
        quantity = measured(self.of)
        if quantity is None:
            return
        if self.setpoint.has_units and (result := measured(self.setpoint)) not in (None, quantity):
            message = f"expected {described(quantity)}, as {self.of.text!r} is, found"
            yield (*self.path, "setpoint"), f"{message} {described(result or {})}"
        effort = powers(unit(self.measure.unit))
        for key, order in _GAINS.items():
            own = getattr(self, key).unit
            expected = product(effort, (quantity, -1), ({"second": Fraction(1)}, order))
            if own is not None and powers(own) != expected:
                message = f"expected {described(expected)}, found {described(powers(own))}"
                yield (*self.path, key), message

    @property
    def _rate(self) -> Function | None:
        """The rate of the quantity, if it is a value of a measure."""
        match translated(self.of, (*self.path, "of")):
            case Measured(0, measure):
                return Measured(1, measure)
        return None

    def _gain(self, key: str) -> Number:
        return Number(Parameter((*self.path, key), getattr(self, key).value, structural=True))

    def terms(self) -> tuple[Load, ...]:
        """The effort, with the integral as its internal state."""
        quantity = translated(self.of, (*self.path, "of"))
        error = translated(self.setpoint, (*self.path, "setpoint")) - quantity
        wanted: Function = self._gain("proportional") * error
        path, integral = (*self.path, "integral"), self._gain("integral")
        if self._rate is not None:
            wanted = wanted - self._gain("derivative") * self._rate
        if integral.parameter.absent:
            return self._applied(self._limited(wanted))
        wanted = wanted + value_of(path)
        limited = self._limited(wanted)
        change = integral * error
        if self.limits is not None:
            change = change + (limited - wanted) / self._tracking
        return self._applied(limited, InternalState(path, self.measure.unit, change))

    def _applied(self, effort: Function, *integral: InternalState) -> tuple[Load, ...]:
        """The effort, or the one of the last update, with sums in the place of integrals."""
        if self.period is None:
            return self._acting(effort, *integral)
        period, path = period_of(self.period, (*self.path, "period")), (*self.path, "effort")
        held = InternalState(path, self.measure.unit, effort, period=period)
        sums = (
            replace(state, law=state.value + period * state.law, period=period)
            for state in integral
        )
        return self._acting(held.value, held, *sums)

    def _acting(self, law: Function, *states: InternalState) -> tuple[Load, ...]:
        return (self.acting(law, called="controller", applied=True, states=states),)

    @property
    def _tracking(self) -> Function:
        if self.tracking is None:
            return self._gain("proportional") / self._gain("integral")
        return Number(Parameter((*self.path, "tracking"), self.tracking))

    def _limited(self, effort: Function) -> Function:
        if self.limits is None:
            return effort
        least, most = (
            Number(Parameter((*self.path, "limits", place), limit))
            for place, limit in enumerate(self.limits)
        )
        return applied("min", applied("max", effort, least), most)


@component
class TorqueController(_Controller):
    """A controller whose torque turns a bar or plate.

    Parameters
    ----------
    bar
        The bar or plate that it turns.
    against
        What gets the opposite torque; the ground if not given.
    """

    opens: ClassVar[Section] = Section(
        "mapping", "pace: {bar: crank, of: crank.speed, setpoint: 20 rad/s, proportional: 5}"
    )

    bar: BarName
    against: BarOrGroundName = GROUND
    limits: tuple[Torque, Torque] | None = None

    def faults(self) -> Iterator[Fault]:
        """Two bodies."""
        yield from super().faults()
        if self.against == self.bar:
            yield "against", f"expected another body than {self.bar!r}"

    @property
    def measure(self) -> Turn:
        """The angle of the bar against the other body."""
        return Turn(self.bar, None if self.against == GROUND else self.against)


@component
class ForceController(_Controller, OnSlider):
    """A controller whose force pushes a slider along its axis."""

    limits: tuple[Force, Force] | None = None


@component
class ControllerBetweenJoints(_Controller, BetweenJoints):
    """A controller whose force pushes two joints apart."""

    limits: tuple[Force, Force] | None = None
