"""Laws that drives prescribe and loads follow: formulas, harmonics, rises, run-ups and tables.

References
----------
.. [1] R. L. Norton, *Cam Design and Manufacturing Handbook*, 2nd ed., Industrial Press, 2009:
   double-dwell cams (cycloidal, modified sine, 3-4-5 polynomial, simple harmonic).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Annotated, Any, ClassVar, Generic, Literal, TypeVar, assert_never

from pydantic import Field, field_validator, model_validator

from linkages.components.contributed.component import component
from linkages.components.contributed.functions import (
    TIME,
    Function,
    Interpolation,
    Number,
    Operation,
    Table,
    applied,
    extremes,
    unpaired,
)
from linkages.components.contributed.load_measures import measured_by
from linkages.components.contributed.state_laws import STATES, value_of
from linkages.components.contributed.terms import Parameter, named_number
from linkages.discovery import plugged
from linkages.operations import ELEMENTARY
from linkages.reading.paths import KeyPath
from linkages.spec import quantities
from linkages.spec.formulas import (
    PARAMETER,
    VALUE,
    Call,
    Clock,
    Constant,
    Formula,
    Node,
    Sensed,
)
from linkages.spec.law_fields import ArgumentRule, LawRule, PlaceRule
from linkages.spec.models import rule_of
from linkages.spec.quantities import (
    Angle,
    AngularSpeed,
    Damping,
    Duration,
    Force,
    Frequency,
    Instant,
    Length,
    Pressure,
    Quantity,
    Speed,
    Stiffness,
    Text,
    Torque,
    TorsionalDamping,
    TorsionalStiffness,
    Voltage,
)

__all__ = ["NOTHING", "REFUSED", "TIME", "NamedLaw", "Rate", "Value", "argument"]

Value = TypeVar("Value")
Rate = TypeVar("Rate")
"""What a law gives, and its rate: quantities of a dimension that the field of the law fixes."""

NOTHING: Any = 0.0
"""The default of a quantity, whatever it measures."""

REFUSED = (
    "a drive prescribes a motion as a function of time alone; what depends on the motion is a "
    "load, a spring or a damper"
)
"""Why laws of drives do not depend on quantities of the mechanism."""


class NamedLaw(ABC):
    """A law that a mapping of the definition file describes."""

    @abstractmethod
    def function(self, path: KeyPath) -> Function:
        """Return the function, of time unless it says otherwise; `path` is the mapping's place."""


def argument(path: KeyPath, key: str, value: float, structural: bool = False) -> Number:
    """A number of the definition file."""
    return Number(Parameter((*path, key), value, structural))


def translated(formula: Formula, path: KeyPath) -> Function:
    """Return the function that a formula at `path` is.

    Its numbers are parameters at ``(*path, 0)``, ``(*path, 1)``, … from left to right. Equal ones
    are one parameter, so that jumps of equal arguments have one mode. How often to multiply in a
    power, a whole number of turns within a sine, and zeros are structure.
    """
    return _Translation(path).of(formula.tree)


class _Translation:
    def __init__(self, path: KeyPath) -> None:
        self.path = path
        self.numbers: dict[float, Parameter] = {}
        self.repeating = False
        self._known: dict[tuple[int, bool], Function] = {}

    def of(self, node: Node) -> Function:
        """The function of a part, which stands behind several conditions but once in the text."""
        key = id(node), self.repeating
        if key not in self._known:
            self._known[key] = self._of(node)
        return self._known[key]

    def _of(self, node: Node) -> Function:
        match node:
            case Clock():
                return TIME
            case Constant(value):
                own = Parameter((*self.path, len(self.numbers)), value, structural=True)
                return Number(self.numbers.setdefault(value, own))
            case Sensed(word, (name, *_)) if word == PARAMETER:
                return Number(named_number(name))
            case Sensed(word, (name, *_)) if word == VALUE:
                return value_of((STATES, name))
            case Sensed():
                return measured_by(node)
            case Call("power", (base, Constant(exponent))):
                return applied("power", self.of(base), exponent)
            case Call("mul", (Constant(turns, None), Sensed("angle") as angle)) if (
                self.repeating and turns.is_integer()
            ):
                return applied("mul", turns, measured_by(angle))
            case Call(name, arguments):
                before = self.repeating
                self.repeating = (name in ELEMENTARY and ELEMENTARY[name].periodic) or (
                    before and name in ("add", "sub", "neg")
                )
                result = tuple(self.of(argument) for argument in arguments)
                self.repeating = before
                return Operation(name, result)
            case _:
                assert_never(node)


@component
class Harmonic(Generic[Value]):
    """mean + amplitude·sin(ω·t + phase) with ω = 2π·frequency or ω = angular_frequency.

    Parameters
    ----------
    amplitude, mean
        In the units of what the law gives.
    frequency
        Hertz.
    angular_frequency
        Radians per second; given instead of the frequency.
    phase
        Radians.
    """

    amplitude: Value
    mean: Value = Field(default=NOTHING)
    frequency: Frequency | None = None
    angular_frequency: AngularSpeed | None = None
    phase: Angle = 0.0

    @model_validator(mode="after")
    def _one_frequency(self) -> Any:
        if (self.frequency is None) == (self.angular_frequency is None):
            result = "neither" if self.frequency is None else "both"
            raise ValueError(f"expected either 'frequency' or 'angular_frequency', found {result}")
        return self


@component
class HarmonicLaw(NamedLaw, Generic[Value]):
    """A harmonic law of time; see `Harmonic`."""

    harmonic: Harmonic[Value]

    def function(self, path: KeyPath) -> Function:
        """Its numbers are arguments; a mean or a phase of exactly zero is structure."""
        path = (*path, "harmonic")
        own = self.harmonic
        mean, amplitude = _number(own.mean), _number(own.amplitude)
        if own.frequency is not None:
            rate: Function = 2 * math.pi * argument(path, "frequency", own.frequency)
        else:
            rate = argument(path, "angular_frequency", _number(own.angular_frequency))
        angle = rate * TIME + argument(path, "phase", own.phase, structural=True)
        wave = argument(path, "amplitude", amplitude) * applied("sin", angle)
        return argument(path, "mean", mean, structural=True) + wave


def _number(value: Any) -> float:
    return float(value)


Profile = Literal["cycloidal", "modified-sine", "polynomial", "harmonic"]


@component
class Rise(NamedLaw, Generic[Value]):
    """Constant, then a rise (or a return) along a profile, then constant again.

    Parameters
    ----------
    rise
        The profile. ``cycloidal``, ``modified-sine`` and ``polynomial`` (3-4-5) have a continuous
        acceleration; that of ``harmonic`` jumps at both ends.
    start, to
        Values before and after; `start` is called ``from`` in the file.
    begin
        Time at which the rise begins, in seconds.
    duration
        Seconds, > 0.
    """

    rise: Profile
    to: Value
    duration: Duration
    start: Value = Field(default=NOTHING, alias="from")
    begin: Instant = 0.0

    def function(self, path: KeyPath) -> Function:
        """Its numbers are arguments; a first value or a beginning of exactly 0 is structure."""
        first: Any = self.start
        last: Any = self.to
        start = argument(path, "from", float(first), structural=True)
        begin = argument(path, "begin", self.begin, structural=True)
        part = (TIME - begin) / argument(path, "duration", self.duration)
        inside = applied("select", part, PROFILES[self.rise](part), 0)
        share = applied("select", part - 1, 1, inside)
        return start + (argument(path, "to", float(last)) - start) * share


def _cycloidal(u: Operation) -> Operation:
    """Return u − sin(2πu)/(2π)."""
    return u - applied("sin", 2 * math.pi * u) / (2 * math.pi)


def _polynomial(u: Operation) -> Operation:
    """Return 10u³ − 15u⁴ + 6u⁵."""
    return 10 * u**3 - 15 * u**4 + 6 * u**5


def _harmonic(u: Operation) -> Operation:
    """Return (1 − cos πu)/2."""
    return (1 - applied("cos", math.pi * u)) / 2


def _modified_sine(u: Operation) -> Operation:
    """Quarter sines of the acceleration over 1/8, a half sine over 3/4, and 1/8 again [1]_.

    Each piece is (offset + π·u − a·sin(b·u + c))/(4 + π).
    """

    def piece(offset: float, a: float, b: float, c: float) -> Operation:
        return (offset + math.pi * u - a * applied("sin", b * u + c)) / (4 + math.pi)

    first = piece(0, 0.25, 4 * math.pi, 0)
    middle = piece(2, 2.25, 4 * math.pi / 3, math.pi / 3)
    last = piece(4, 0.25, 4 * math.pi, 0)
    beyond_first = applied("select", u - 0.125, middle, first)
    return applied("select", u - 0.875, last, beyond_first)


PROFILES: dict[str, Callable[[Operation], Operation]] = {
    "cycloidal": _cycloidal,
    "modified-sine": _modified_sine,
    "polynomial": _polynomial,
    "harmonic": _harmonic,
}
"""Normalised profiles s(u) with s(0) = 0 and s(1) = 1."""


@component
class RunUp(Generic[Value, Rate]):
    """At rest until t = 0; then the speed rises smoothly and stays.

    The speed is speed·(3u² − 2u³) with u = t/duration from 0 to 1, so the acceleration is
    continuous.

    Parameters
    ----------
    speed
        The constant speed in the end.
    duration
        Seconds until it is reached, > 0.
    start
        Value until t = 0; called ``from`` in the file.
    """

    speed: Rate
    duration: Duration
    start: Value = Field(default=NOTHING, alias="from")


@component
class RunUpLaw(NamedLaw, Generic[Value, Rate]):
    """A run-up to constant speed; see `RunUp`."""

    run_up: RunUp[Value, Rate] = Field(alias="run-up")

    def function(self, path: KeyPath) -> Function:
        """The integral of the speed: start + speed·duration·(u³ − u⁴/2), later a straight line."""
        path = (*path, "run-up")
        first: Any = self.run_up.start
        last: Any = self.run_up.speed
        duration = argument(path, "duration", self.run_up.duration)
        u = TIME / duration
        rising = applied("select", u, u**3 - 0.5 * u**4, 0)
        turned = applied("select", u - 1, u - 0.5, rising)
        speed = argument(path, "speed", float(last))
        start = argument(path, "from", float(first), structural=True)
        return start + speed * duration * turned


WHOLE = 1e-9
"""Difference from a whole number of periods in a turn that rounding of units explains."""


@component
class TablePoints(Generic[Value]):
    """Values at given times, or over any other quantity, and what joins them.

    Parameters
    ----------
    times
        Seconds, increasing, at least three (two for straight lines).
    values
        One for each time or place.
    over
        What the table is a function of if it is not time: ``crank.angle``, or a formula.
    at
        Places on the axis of `over`, in the place of times.
    periodic
        Whether the law repeats; the first and the last value are then equal.
    interpolation
        ``linear``, ``pchip`` or ``spline``; pchip for loads and spline for drives if not given.
    file
        A CSV file in the folder of the definition file, in the place of times (or places) and
        values.
    columns
        Its columns with times (or places) and values: their names, or their numbers from 1; the
        first two if not given.
    units
        Units of both columns; SI if not given.
    """

    times: tuple[Instant, ...] = ()
    values: tuple[Value, ...] = ()
    over: Annotated[Formula, ArgumentRule()] | None = None
    at: tuple[Annotated[Constant, PlaceRule()], ...] = ()
    periodic: bool = False
    interpolation: Interpolation | None = None
    file: Text | None = None
    columns: tuple[Text, Text] | None = None
    units: tuple[Text, Text] | None = None

    @property
    def places(self) -> tuple[float, ...]:
        """Times, or places over any other quantity, in SI."""
        return self.times if self.over is None else tuple(place.value for place in self.at)

    @property
    def turning(self) -> bool:
        """Whether a turn of an angle, which it is a function of, is a whole number of periods."""
        periods = 2 * math.pi / (self.places[-1] - self.places[0])
        return self.over is not None and self.periodic and abs(periods - round(periods)) < WHOLE

    @model_validator(mode="after")
    def _fits(self) -> Any:
        keys = ("times", "values") if self.over is None else ("at", "values")
        expected = f"{keys[0]!r} and 'values'"
        if self.file is not None:
            raise ValueError(
                f"files are read with a definition file only, in its folder; expected {expected}"
            )
        other, of = ("at", "time") if self.over is None else ("times", "'over'")
        if getattr(self, other):
            hint = "; 'over' says what of" if self.over is None else ""
            raise ValueError(f"{other!r} is given for a table of {of}; expected {keys[0]!r}{hint}")
        missing = [key for key in keys if not getattr(self, key)]
        if missing or self.columns or self.units:
            key = "file" if self.columns or self.units else missing[0]
            raise ValueError(f"missing key {key!r}: expected {expected}, or 'file'")
        what = "times" if self.over is None else "places"
        least = "two" if self.interpolation == "linear" else "three"
        if fault := unpaired({what: self.places, "values": self.values}, least):
            raise ValueError(fault[1])
        first, last = self.values[0], self.values[-1]
        if self.periodic and first != last:
            expected = "expected the same first and last value of a periodic table"
            raise ValueError(f"{expected}, found {first:g} and {last:g}")
        return self


class _TableLaw(NamedLaw, Generic[Value]):
    """What loads and drives have in common; each says what joins its points unasked."""

    usual: ClassVar[Interpolation]
    held: ClassVar[bool]
    table: TablePoints[Value]

    def function(self, path: KeyPath) -> Table:
        """Polynomials, whose coefficients are arguments of the kernel."""
        path, own = (*path, "table"), self.table
        values: Any = own.values
        over = TIME if own.over is None else translated(own.over, (*path, "over"))
        return Table(
            path, own.places, values, own.periodic, own.interpolation or self.usual, self.held,
            over, own.turning,
        )  # fmt: skip

    @field_validator("table")
    @classmethod
    def _bounded(cls, table: TablePoints[Any]) -> TablePoints[Any]:
        interpolation = table.interpolation or cls.usual
        places = table.places
        result = Table((), places, table.values, table.periodic, interpolation, cls.held)
        if not all(map(math.isfinite, extremes(result, *places[:: len(places) - 1]))):
            raise ValueError(
                f"the polynomials between these values ({interpolation}) overflow; expected "
                f"smaller values, or {'times' if table.over is None else 'places'} that are "
                "further apart"
            )
        return table


@component
class LoadTable(_TableLaw[Value], Generic[Value]):
    """A load given by values at some times or places; outside it keeps the first and the last."""

    usual: ClassVar[Interpolation] = "pchip"
    held: ClassVar[bool] = True

    table: TablePoints[Value]


@component
class DriveTable(_TableLaw[Value], Generic[Value]):
    """A motion given by values at some times; outside them its speed stays what it is there."""

    usual: ClassVar[Interpolation] = "spline"
    held: ClassVar[bool] = False

    table: TablePoints[Value]

    @field_validator("table")
    @classmethod
    def _smooth(cls, table: TablePoints[Any]) -> TablePoints[Any]:
        if table.over is not None:
            raise ValueError(f"'over' is refused: {REFUSED}")
        if table.interpolation == "linear":
            raise ValueError(
                "straight lines make the speed of a drive jump, which takes infinite forces; "
                "expected interpolation 'spline', or 'pchip', whose acceleration jumps"
            )
        return table


GROUP = "linkages.laws"
"""Entry points that name laws of other packages by the keys that tell them."""

Law = float | Formula | NamedLaw


def _rule(value: Any, rate: Any = None) -> LawRule:
    """What gives a quantity; one that has a rate is a motion."""
    own = rule_of(value)
    assert isinstance(own, Quantity)
    named: dict[str, Any] = {"harmonic": HarmonicLaw[value], "rise": Rise[value]}
    if rate is not None:
        named["run-up"] = RunUpLaw[value, rate]
    named["table"] = LoadTable[value] if rate is None else DriveTable[value]
    named |= {name: law[value] for name, law in plugged(GROUP)}
    refused = "" if rate is None else REFUSED
    return LawRule(own.dimension, tuple(named.items()), refused, own.bound)


AngleLaw = Annotated[Law, _rule(Angle, AngularSpeed)]
LengthLaw = Annotated[Law, _rule(Length, Speed)]
ForceLaw = Annotated[Law, _rule(Force)]
TorqueLaw = Annotated[Law, _rule(Torque)]
StiffnessLaw = Annotated[Law, _rule(Stiffness)]
DampingLaw = Annotated[Law, _rule(Damping)]
TorsionalStiffnessLaw = Annotated[Law, _rule(TorsionalStiffness)]
TorsionalDampingLaw = Annotated[Law, _rule(TorsionalDamping)]
PressureLaw = Annotated[Law, _rule(Pressure)]
VoltageLaw = Annotated[Law, _rule(Voltage)]
ShareLaw = Annotated[Law, _rule(quantities.Number, Frequency)]
"""Of the way along a curve."""


def function_of(law: Law, path: KeyPath) -> Function:
    """Return the function that a law at `path` is, of time and of what it senses.

    A constant law of exactly zero is structure.
    """
    if isinstance(law, NamedLaw):
        return law.function(path)
    if isinstance(law, Formula):
        return translated(law, path)
    return Number(Parameter(path, law, structural=True))
