"""The common period of drives and loads."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.functions import (
    Function,
    Measured,
    Number,
    Operation,
    Table,
    Time,
)
from linkages.components.contributed.load_measures import Slide, Turn
from linkages.components.contributed.state_laws import (
    exchanged,
    leaves,
    time_functions,
    winding,
)
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.inputs import law_values
from linkages.operations import ELEMENTARY
from linkages.topology.decomposition import followers_of, leaders_first

MOST_PERIODS = 1000
"""Largest number of one drive's periods within the common one."""

EQUAL = 1e-9
"""Relative difference below which periods count as commensurable."""

MOST_PARTS = 12
"""Parts of a period that may be periods themselves; parts of these are tried again."""

SAMPLES, FEW = 1000, 16
"""Times at which a law is compared with itself a part of its period later, and first ones."""

ROUND_OFF = 1e-12
"""Difference, relative to the largest magnitude of a law, below which its values are the same."""


class NoPeriodError(ValueError):
    """There is no common period; the message says why."""


@dataclass(frozen=True)
class _Course:
    """What a function of time does."""

    rate: float  # its mean rate
    # Periods of what it does beyond that; None if it does not repeat
    periods: tuple[float, ...] | None
    least: bool = False  # whether it is known that no part of its only period is one, too

    @property
    def constant(self) -> bool:
        """Whether it does not depend on time."""
        return self.periods == () and not self.rate


def common_period(mechanism: Mechanism) -> float:
    """Time after which all drives and loads repeat, in seconds.

    It is the least one of every law (as far as `MOST_PARTS` tells), and a multiple of all of them.
    Bodies that follow driven ones by welds and gears have then made whole turns, too.
    """
    return _common(_periods(mechanism))


def incommensurate_periods(mechanism: Mechanism) -> tuple[float, ...]:
    """Periods in seconds, the longest first, of drives and loads that have none in common.

    Each is the common one of all that do have one. Two laws repeat together only approximately
    then: their phases run through all combinations.
    """
    groups: list[list[float]] = []
    for period in _periods(mechanism):
        for group in groups:
            with contextlib.suppress(NoPeriodError):
                _common([*group, period])
                group.append(period)
                break
        else:
            groups.append([period])
    return tuple(sorted(map(_common, groups), reverse=True))


def _periods(mechanism: Mechanism) -> list[float]:
    """Periods of all laws of drives and loads, and of whole turns that bodies make."""
    periods: list[float] = []
    rates: dict[str, float] = {}
    for name, drive in mechanism.prescribed.items():
        course = _reduced(drive.law)
        if course.periods is None:
            raise NoPeriodError(f"the law of drive {name!r} does not repeat")
        periods += course.periods
        if course.rate:
            if not mechanism.bodies[name].rotates:
                raise NoPeriodError(f"drive {name!r} moves on and on: its law does not repeat")
            rates[name] = course.rate
    turning = _turning(mechanism, rates)
    periods += [2 * math.pi / abs(rate) for rate in turning.values()]
    for turn in mechanism.lifting:
        if turn.body in turning:
            raise NoPeriodError(f"a cam feels whole turns of {turn.body!r}, which turns on and on")
    for load in mechanism.loads:
        written = (load.law, *(state.law for state in load.states))
        if load.given:
            functions = load.laws
        elif mechanism.prescribed or any(Time() in leaves(law) for law in written):
            functions = _timed(load.functions, mechanism, turning, "a load")
        else:
            continue
        periods += _periods_of(functions, "the law of a load")
    for state in mechanism.sampled.values():
        assert state.period is not None
        periods.append(state.period.parameter.value)
    for state in mechanism.states:
        if mechanism.prescribed or Time() in leaves(state.law):
            functions = _timed((state.law,), mechanism, turning, state.name)
            periods += _periods_of(functions, f"the law of {state.name}")
    if not periods:
        raise NoPeriodError("nothing depends on time, so there is no period of the drives")
    return periods


def _timed(
    laws: Iterable[Function], mechanism: Mechanism, turning: Mapping[str, float], what: str
) -> tuple[Function, ...]:
    """The parts of laws of state that depend on time, where drives prescribe some coordinates."""
    driven = [_driven(law, mechanism) for law in laws]
    felt = (m.measure for law in driven for m in winding(law) if isinstance(m.measure, Turn))
    if on := [body for turn in felt for body in turn.bodies if body in turning]:
        raise NoPeriodError(f"{what} feels whole turns of {on[0]!r}, which turns on and on")
    return tuple(part for law in driven for part in time_functions(law))


def _periods_of(functions: Iterable[Function], what: str) -> list[float]:
    """Periods of functions of time."""
    periods: list[float] = []
    for function in functions:
        course = _reduced(function)
        if course.periods is None or course.rate:
            raise NoPeriodError(f"{what} does not repeat")
        periods += course.periods
    return periods


def _driven(law: Function, mechanism: Mechanism) -> Function:
    """A law of a load, in which coordinates that drives prescribe are their laws of time."""

    def prescribed(found: Measured) -> Function:
        match found:
            case Measured(0, Turn(body, None) | Slide(body)) if body in mechanism.prescribed:
                return mechanism.prescribed[body].law
        return found

    return exchanged(law, prescribed)


def _turning(mechanism: Mechanism, rates: Mapping[str, float]) -> dict[str, float]:
    """Mean rates of all bodies that drives turn on and on, by welds and gears as well."""
    followers = followers_of(mechanism)
    result = dict(rates)

    def leaders(name: str) -> list[str]:
        return [other for other, _ in followers[name].parts if other in followers]

    for name in leaders_first(followers, leaders, rates):
        parts = followers[name].parts
        shares = [result.get(other, 0.0) * ratio.value for other, ratio in parts]
        total = math.fsum(shares)
        still = abs(total) <= EQUAL * sum(map(abs, shares))
        result[name] = 0.0 if still else total
    return {name: value for name, value in result.items() if value}


def _reduced(function: Function) -> _Course:
    """Mean rate of a law, and the least period of what it does beyond that.

    A formula says only how often its parts repeat: sin(t)**2 repeats twice as often. So values of
    the law are compared, unless it is a sine or cosine.
    """
    course = _course(function)
    if not course.periods or course.least:
        return course
    try:
        period = _common(list(course.periods))
    except NoPeriodError:
        return course
    # the golden section spreads times evenly, and no period meets them twice
    spread = (np.arange(SAMPLES) + 0.5) * (math.sqrt(5) - 1) / 2 % 1.0
    start = period * spread

    def beyond(times: NDArray[np.float64]) -> NDArray[np.float64]:
        return law_values(function, times) - course.rate * times

    first = beyond(start)
    least = ROUND_OFF * float(np.abs(first + course.rate * start).max())
    if not np.isfinite(first).all() or np.ptp(first) <= least:
        return replace(course, periods=(period,))

    def repeating(period: float) -> NDArray[np.int64]:
        """Numbers of parts of a period that are periods themselves."""
        parts = np.arange(2, MOST_PARTS + 1)
        for some in (slice(FEW), slice(None)):  # a few times tell of most that they are not
            later = beyond(start[some] + (period / parts)[:, None])
            parts = parts[(np.abs(later - first[some]) <= least).all(axis=1)]
            if not len(parts):
                break
        return parts

    while len(parts := repeating(period)):
        period /= parts[-1]
    return replace(course, periods=(period,))


def _course(function: Function) -> _Course:
    """Mean rate and periods of a function."""
    match function:
        case Number():
            return _Course(0.0, ())
        case Time():
            return _Course(1.0, ())
        case Table():
            inner = _course(function.over)
            if not function.periodic:
                return _Course(0.0, None) if inner.rate else inner
            return _repeated(inner, function.places[-1] - function.places[0])
        case Operation("neg", (a,)):
            inner = _course(a)
            return replace(inner, rate=-inner.rate)
        case Operation("add" | "sub" as name, (a, b)):
            one, other = _course(a), _course(b)
            sign = 1.0 if name == "add" else -1.0
            least = (one.least and other.constant) or (other.least and one.constant)
            return _Course(one.rate + sign * other.rate, _joined([one, other]), least)
        case Operation("mul" | "div" as name, (a, b)):
            return _product(name, a, b)
        case Operation(name, (a,)) if name in ELEMENTARY and ELEMENTARY[name].periodic:
            inner = _course(a)
            least = name in ("sin", "cos") and inner.periods == () and bool(inner.rate)
            return replace(_repeated(inner, 2 * math.pi), least=least)
        case Operation(_, arguments):
            courses = [_course(argument) for argument in arguments]
            if any(course.rate for course in courses):
                return _Course(0.0, None)
            return _Course(0.0, _joined(courses))
    return _Course(0.0, None)


def _repeated(inner: _Course, span: float) -> _Course:
    """What repeats whenever its argument has grown by a span."""
    if inner.periods is None:
        return inner
    own = (span / abs(inner.rate),) if inner.rate else ()
    return _Course(0.0, (*inner.periods, *own))


def _product(name: str, a: Function, b: Function) -> _Course:
    """A constant factor scales the rate; otherwise both have to repeat."""
    one, other = _course(a), _course(b)
    if other.constant:
        factor = _factor(b)
        if name == "div" and not factor:
            return _Course(0.0, None)
        return replace(one, rate=one.rate * factor if name == "mul" else one.rate / factor)
    if one.constant and name == "mul":
        return replace(other, rate=other.rate * _factor(a))
    if one.rate or other.rate:
        return _Course(0.0, None)
    return _Course(0.0, _joined([one, other]))


def _factor(function: Function) -> float:
    """The value of a function that does not depend on time."""
    if isinstance(function, Number):
        return function.parameter.value
    return float(law_values(function, np.zeros(1))[0])


def _joined(courses: Iterable[_Course]) -> tuple[float, ...] | None:
    result: list[float] = []
    for course in courses:
        if course.periods is None:
            return None
        result += course.periods
    return tuple(result)


def _common(periods: list[float]) -> float:
    """The least common multiple of periods whose ratios are those of whole numbers."""
    first = periods[0]
    multiple = Fraction(1)
    for period in periods[1:]:
        ratio = period / first
        fraction = Fraction(ratio).limit_denominator(MOST_PERIODS)
        if fraction <= 0 or abs(float(fraction) - ratio) > EQUAL * ratio:
            raise NoPeriodError(
                f"periods {first:.9g} s and {period:.9g} s have no common multiple of at most "
                f"{MOST_PERIODS} of them"
            )
        multiple = Fraction(
            math.lcm(multiple.numerator, fraction.numerator),
            math.gcd(multiple.denominator, fraction.denominator),
        )
    if multiple > MOST_PERIODS:
        raise NoPeriodError(f"the common period would last {float(multiple):.6g} of {first:.6g} s")
    return float(multiple) * first
