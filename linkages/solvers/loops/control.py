"""Judgement of a trial step: its error, the next length, and whether something may lie within it.

Lengths are right to about 1e-10: a step that is longer by so much is as good as any. Where no
comparison finds an event, a mode change, whole turns or a singular position possible, what looks
for them (`crossings`, `mode_changes`, `margins`) would find nothing.

References
----------
.. [1] E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
       Springer 1993, (II.10.17).
.. [2] E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996,
       section IV.2.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from linkages.kernel.code.elementary_functions import elementary
from linkages.kernel.code.operands import (
    Bool,
    Real,
    RealArray,
    copysign,
    fma,
    maximum,
    minimum,
    polynomial,
    rint,
    select,
    sqrt,
)
from linkages.kernel.dyads import LEAST_MARGIN
from linkages.solvers.loops.memory import SMALLEST_STEP, TWO_PI, EventValues, Stepper
from linkages.solvers.loops.row_layout import RowLayout, StepMemory, combined
from linkages.solvers.tableau import Tableau

_ROOT_HALF = 0x3FE6A09E667F3BCD
"""The bits of sqrt(1/2): mantissas are taken from there to sqrt(2)."""
_FRACTION = 52
_LARGEST = 1000.0
"""Of logarithms to base two whose power is a normal number."""


def binary_logarithm(x: Real) -> Real:
    """The logarithm to base two of a positive normal number.

    With the mantissa m it is ``k + 2/ln 2 · artanh((m - 1)/(m + 1))``, as a series.
    """
    exponent = (x.bits - _ROOT_HALF) >> _FRACTION
    m = (x.bits - (exponent << _FRACTION)).with_bits
    s = (m - 1.0) / (m + 1.0)
    series = polynomial(s * s, [2 / math.log(2) / k for k in range(1, 15, 2)])
    return fma(s, series, exponent.to_real)


def binary_power(y: Real) -> Real:
    """Two to a power between ±1000; the nearest of these for others."""
    y = select(y < _LARGEST, y, _LARGEST)
    y = select(y > -_LARGEST, y, -_LARGEST)
    whole = rint(y)
    power = polynomial(y - whole, [math.log(2) ** k / math.factorial(k) for k in range(11)])
    return (power.bits + (whole.to_int << _FRACTION)).with_bits


# Measured on pendulums and Duffing's equation at rtol 1e-10: against the usual 0.9, fewer rejected
# steps outweigh shorter ones, so that 0.8 takes 4 to 11 % fewer evaluations and errs less. On the
# nine-bar proportional-integral control (exponents 0.7 and 0.4, 0.8 and 0.3, 0.8 and 0.2 of 1/p)
# rejects fewer steps, yet for the same error dop853 and vern9 need 2 to 18 % more evaluations.
SAFETY = 0.8
SHRINK_MOST, GROW_MOST = 1 / 3, 6.0
# Halving is enough for links that turned too far to be watched.
SHRINK_TURNING = 0.5
# Most that a relative margin, the sine of an angle, may change by within a step at the rates of its
# stages: over longer steps its extrapolation from the ends says nothing about what lies between.
MOST_CHANGE = 0.35
# An end at which everything is so much steeper than at the start says nothing about round-off: a
# trial that dived into a wall must not excuse itself.
WILD = 1e4
OVERFLOW = 1e150
# Steps that were much better than asked for say nothing about how the error develops.
LEAST_BEFORE = 1e-4
LEAST_ERROR = 1e-30
# The factor is measured: a nine-bar on its way to a change point scatters by 0.01 to 0.05 ε/m³
# where its time and state are moved by units in their last place.
ROUNDING, TINY = 0.05 * 2.220446049250313e-16, 1e-30


def begin_trial(stepper: Stepper) -> tuple[Real, Real, Real]:
    """Write the times of the next trial; returns its length, end, and what the end is too large by.

    Times are summed with compensation. A trial that would end just before the final time ends then.
    """
    t, carry, last = stepper.t, stepper.carry, stepper.end
    h = copysign(minimum(abs(stepper.h), stepper.longest), stepper.h)
    moved, remaining = h - carry, (last - t) + carry
    end = t + moved
    next_carry = (end - t) - moved
    ends = 1.01 * abs(h) >= abs(remaining)
    h, end = select(ends, remaining, h), select(ends, last, end)
    next_carry = select(ends, 0.0, next_carry)
    stepper.start, stepper.length, stepper.stop, stepper.next_carry = t, h, end, next_carry
    return h, end, next_carry


def finest_step(stepper: Stepper, t: Real) -> Real:
    """Least length of a step that moves time reliably."""
    return SMALLEST_STEP * maximum(abs(t), stepper.first)


class Judged(NamedTuple):
    """Mean error in units of what is allowed, factor to the next length, and acceptance."""

    error: Real
    factor: Real
    accepted: Bool


def judge(tableau: Tableau, layout: RowLayout, memory: StepMemory, gain: float) -> Judged:
    """Write what is thought of the step in the workspace; `gain` as `next_factor` has it."""
    stepper = memory.stepper
    length = abs(stepper.length)
    error = _error_norm(tableau, layout, memory, length)
    factor = next_factor(error, stepper.before, tableau.error_order, gain)
    small = error <= 1.0
    if not layout.blocks:
        return Judged(error, factor, small)
    far = _turns_too_far(tableau.stages, layout, memory, length)
    return Judged(error, select(small & far, SHRINK_TURNING, factor), small & ~far)


def _rounding(end: int, layout: RowLayout, memory: StepMemory) -> Real:
    """Relative round-off of accelerations, from the least margin at both ends of a step.

    A link's component found as ``sqrt(L² - n²)`` carries a relative error ε/m² at the relative
    margin m, and accelerations divide by it once more. Without this allowance the steps before a
    singular position would shrink to nothing, for none is short enough to show a smaller error.
    """
    code, scale, least = memory.code, memory.scale, memory.code.variable(1.0)
    first, last = (memory.row(row, layout.margins) for row in (0, end))
    for i in code.for_entries(layout.blocks):
        here = minimum(abs(first[i]), abs(last[i])) / scale[i]
        least.set(minimum(least, here))
    return ROUNDING / maximum(least * least * least, TINY)


def _error_norm(tableau: Tableau, layout: RowLayout, memory: StepMemory, length: Real) -> Real:
    """The error of a step of some length.

    With two estimates e₅ and e₃ it is ``|h| |e₅|² / sqrt(|e₅|² + 0.01 |e₃|²)`` [1]_; with one, its
    norm.
    """
    code, n, end = memory.code, layout.n, tableau.stages
    noise, rtol, atol = (length * _rounding(end, layout, memory), memory.stepper.rtol, memory.atol)
    slopes = [memory.row(row, n) for row in range(end + 1)]
    begun, reached = memory.row(0), memory.row(end)
    early, late = code.variable(0.0), code.variable(0.0)
    for i in code.for_entries(2 * n):
        early.set(maximum(early, abs(slopes[0][i])))
        late.set(maximum(late, abs(slopes[end][i])))
    wild = late > WILD * early
    totals = [code.variable(0.0) for _ in tableau.error]
    for i in code.for_entries(2 * n):
        first, last = abs(slopes[0][i]), abs(slopes[end][i])
        allowed = fma(rtol, maximum(abs(begun[i]), abs(reached[i])), atol[i])
        unit = 1.0 / fma(noise, select(wild, first, maximum(first, last)), allowed)
        for weights, total in zip(tableau.error.tolist(), totals, strict=True):
            scaled = combined(weights, slopes, i) * unit
            total.set(fma(scaled, scaled, total))
    main, *low = totals
    both = fma(low[0], 0.01, main) if low else main
    return select(main == 0.0, 0.0, length * main / sqrt(both * (2.0 * n)))


def next_factor(error: Real, before: Real, order: int, gain: float) -> Real:
    """Factor from a step to the next one, or to its repetition, from the error norm.

    With a `gain` above 0 this is Gustafsson's PI control in the form of [2]_: ``safety ·
    error^(0.75 gain - 1/(order + 1)) · before^gain``, where `before` is the error norm of the step
    before. With 0 it is the elementary control.
    """
    exponent = 1.0 / (order + 1) - 0.75 * gain
    # Written so that nan, the quotient of two overflows, is caught as well.
    fine = error < OVERFLOW
    power = -exponent * binary_logarithm(select(fine, maximum(error, LEAST_ERROR), 1.0))
    if gain:
        power = fma(binary_logarithm(maximum(before, LEAST_BEFORE)), gain, power)
    factor = SAFETY * binary_power(power)
    return select(fine, minimum(maximum(factor, SHRINK_MOST), GROW_MOST), SHRINK_MOST)


def _turns_too_far(end: int, layout: RowLayout, memory: StepMemory, length: Real) -> Bool:
    """Whether links turn so far within a step that a singular position could be overlooked."""
    code, scale, excess = memory.code, memory.scale, memory.code.variable(0.0)
    rates = [memory.row(row, layout.margins + layout.blocks) for row in range(end + 1)]
    for i in code.for_entries(layout.blocks):
        most = code.value(0.0)
        for rate in rates:
            most = maximum(most, abs(rate[i]))
        excess.set(maximum(excess, length * most - MOST_CHANGE * scale[i]))
    return excess > 0.0


# The sine is concave on both sides of zero: over MOST_CHANGE, tan(x)/x stays below this.
CONCAVITY = 1.1


def passes_zero(before: Real, fall: Real, after: Real, rise: Real) -> Bool:
    """Whether a margin, extrapolated with its changes from both ends of a step, crosses zero."""
    side = before >= 0.0
    ahead, behind = fma(fall, CONCAVITY, before), fma(rise, -CONCAVITY, after)
    return (select(side, ahead, -ahead) < 0.0) & (select(side, behind, -behind) < 0.0)


def is_small(margin: Real, change: Real, scale: Real, smallest: Real) -> Bool:
    """Whether a margin is singular, or smaller than a run allows and still falling."""
    early = (margin * change < 0.0) & (abs(margin) < smallest)
    return (abs(margin) < LEAST_MARGIN * scale) | early


def write_expected(layout: RowLayout, memory: StepMemory, h: Real, weights: Sequence[Any]) -> None:
    """Write where dependent angles are after a time h, from weights of their speeds in rows."""
    place = layout.cosines + 2 * layout.counted
    speeds = [memory.row(row, place) for row in range(len(weights))]
    for i in memory.code.for_entries(layout.counted):
        memory.ahead[i] = fma(h, combined(weights, speeds, i), memory.angles[i])


def nearest_turn(sine: Real, cosine: Real, expected: Real) -> Real:
    """The angle of a unit vector, with the turns that bring it closest to where it should be."""
    angle = elementary("atan2", sine, cosine)
    return fma(rint((expected - angle) / TWO_PI), TWO_PI, angle)


def write_counted(
    layout: RowLayout,
    memory: StepMemory,
    row: RealArray,
    into: RealArray,
    where: Bool | None = None,
) -> None:
    """Write the dependent angles in a row, in some lanes, close to where they are expected."""
    cosines, sines = (row.after(layout.cosines + place) for place in (0, layout.counted))
    for i in memory.code.for_entries(layout.counted):
        result = nearest_turn(sines[i], cosines[i], memory.ahead[i])
        into[i] = result if where is None else select(where, result, into[i])


# A state on a level, as a run from a located crossing starts with, lies beyond it.
SLACK = 1e-12


def meeting(start: Real, rise: Real, end: Real, fall: Real) -> Real:
    """Value at which the tangents at both ends of a step, with these changes, meet."""
    return start + rise * (end - fall - start) / (rise - fall)


def level_crossed(start: Real, rise: Real, end: Real, fall: Real, level: Real) -> Bool:
    """Whether a function, less its level, with these values and changes may cross zero."""
    slack = SLACK * maximum(abs(level), 1.0)

    def beyond(side: Real, low: Real, high: Real) -> Bool:
        return (fma(side, low, slack) < 0.0) & (fma(side, high, slack) >= 0.0)

    steady = beyond(copysign(1.0, end - start), start, end)
    bound, side = meeting(start, rise, end, fall), copysign(1.0, fall)
    turned = beyond(side, bound, start) | beyond(side, bound, end)
    return steady | ((rise * fall < 0.0) & turned)


class CrossedLevels:
    """Watches the events of a trial."""

    def __init__(self, tableau: Tableau, layout: RowLayout, memory: StepMemory) -> None:
        self._end, self._memory = tableau.stages, memory
        self._events = [memory.event_values(event) for event in range(layout.events)]

    def need_more(self, h: Real, end: Real) -> Bool:
        """Evaluate all events at the end of a step, of length h; where it is to be looked at."""
        memory, result = self._memory, self._memory.code.value(False)
        for event, kept in enumerate(self._events):
            self._evaluate(event, kept, end)
            level = memory.levels[event]
            crossed = level_crossed(
                kept.value_before - level, h * kept.rate_before,
                kept.value - level, h * kept.rate, level,
            )  # fmt: skip
            result = result | crossed | (kept.before != memory.stepper.t)
        return result

    def keep(self, where: Bool, end: Real) -> None:
        """Make values at the end of a step those at the start of the next one, in some lanes."""
        for kept in self._events:
            kept.before = select(where, end, kept.before)
            kept.value_before = select(where, kept.value, kept.value_before)
            kept.rate_before = select(where, kept.rate, kept.rate_before)

    def _evaluate(self, event: int, kept: EventValues, end: Real) -> None:
        """Evaluate a function and its rate at the end; nan where that is not possible."""
        memory, functions = self._memory, self._memory.event(event)
        timed = memory.call_clock(end, functions)
        sound = (timed == 0) & (memory.call_rates(memory.row(self._end), kept, functions) == 0)
        kept.value, kept.rate = (select(sound, each, math.nan) for each in (kept.value, kept.rate))


# Value of a function that is no more than round-off, beside its change in a step.
ROUND_OFF = 1e-9
# How far from a cubic a function may be at a stage beside its variation, and how far from zero,
# beside that, it does not matter. Measured on 260 random motions between two walls with friction:
# 0.1 missed releases of a tenth of a period.
UNLIKE, FAR = 0.03, 10.0
# How often a step is halved to see what functions do: more is round-off.
HALVINGS = 8
# A stage is this far below zero, beside the ends of its step, before it is looked at.
BELOW = 1e-9


def with_sign_of_mode(mode: Real, value: Real) -> Real:
    """Function of a switch, or its rate: it is not negative as long as its mode is right."""
    return select(mode == 0.0, 1.0, mode) * value  # 0 is a mode that sticks


def cubic_through(start: Real, rise: Real, end: Real, fall: Real) -> tuple[Real, Real]:
    """Coefficients of x² and x³ of the cubic with these values and rates at 0 and 1."""
    change = end - start
    return 3.0 * change - 2.0 * rise - fall, rise + fall - 2.0 * change


def round_off_of(start: Real, rise: Real) -> Real:
    """How far below zero a function may be that a change has just made right."""
    return maximum(ROUND_OFF * rise, -2.0 * start)


def least_of_stages(start: Real, rise: Real, end: Real) -> Real:
    """Value below which a stage is looked at."""
    return -maximum(round_off_of(start, rise), BELOW * (abs(start) + end))


def dips(start: Real, rise: Real, end: Real, fall: Real) -> Bool:
    """Whether a function may be below zero between the ends of a step."""
    turns = (start > 0.0) & (rise < 0.0) & (fall > 0.0)
    return turns & (meeting(start, rise, end, fall) < 0.0)


def unlike_cubic(
    start: Real, rise: Real, end: Real, fall: Real, stages: Iterable[tuple[Any, Real]]
) -> Bool:
    """Whether values at some fractions of a step are so far from the cubic that it says nothing."""
    c2, c3 = cubic_through(start, rise, end, fall)
    code, low, high = start.code, minimum(start, end), maximum(start, end)
    low, high, apart = code.variable(low), code.variable(high), code.variable(0.0)
    for x, here in stages:
        cubic = fma(fma(fma(c3, x, c2), x, rise), x, start)
        apart.set(maximum(apart, abs(here - cubic)))
        low.set(minimum(low, here))
        high.set(maximum(high, here))
    return (apart > UNLIKE * (high - low)) & (low < FAR * apart)


class Modes:
    """Watches the modes of a trial of length `h`."""

    def __init__(self, tableau: Tableau, layout: RowLayout, memory: StepMemory, h: Real) -> None:
        self._tableau, self._layout, self._memory, self._h = tableau, layout, memory, h
        self._stepper = memory.stepper

    def need_more(self, accepted: Bool) -> tuple[Bool, Bool]:
        """In which lanes a step, accepted or not, is to be looked at; in which it is too long.

        One that follows a switch is also looked at where it is rejected. One that is too long to
        say what functions do is halved, unless a change ahead says where to end it.
        """
        no = changes = ahead = unresolved = self._memory.code.value(False)
        if not self._layout.active:
            return no, no
        for switch, owner in enumerate(self._layout.active):
            here = self._switch(switch)
            if owner >= 0:  # it is watched where another mode is +1
                watched = self._memory.held[owner] > 0.0
                here = tuple(watched & where for where in here)
            changes, ahead, unresolved = changes | here[0], ahead | here[1], unresolved | here[2]
        fresh, again = self._stepper.after_switch > 0.0, self._stepper.rejected_before > 0.0
        ahead = ahead & ~again
        plain = (self._stepper.halved < HALVINGS) & ~(ahead | fresh)
        result = select(accepted, changes | unresolved, ahead | fresh)
        return result, accepted & unresolved & plain

    def halve(self, where: Bool, commits: Bool) -> None:
        """Count how often steps are halved, in some lanes; it ends with a step that counts."""
        if self._layout.active:
            before = self._stepper.halved
            self._stepper.halved = select(commits, 0, select(where, before + 1, before))

    def _switch(self, switch: int) -> tuple[Bool, Bool, Bool]:
        """Where it may change within an accepted step, crosses its zero, or cannot be told of."""
        memory, end, mode = self._memory, self._tableau.stages, self._memory.held[switch]
        values = [memory.row(row, self._layout.functions + switch) for row in range(end + 1)]
        seen = [with_sign_of_mode(mode, value[0]) for value in values]
        modes = len(self._layout.active)
        rise, fall = (with_sign_of_mode(mode, values[row][modes]) * self._h for row in (0, end))
        start, stop = seen[0], seen[end]
        depth = self._memory.code.value(math.inf)
        for here in seen[1:end]:
            depth = minimum(depth, here)
        changes = (stop < 0.0) | dips(start, rise, stop, fall)
        changes = changes | (depth < least_of_stages(start, rise, stop))
        stages = [(float(self._tableau.c[row]), seen[row]) for row in self._tableau.quarters]
        unresolved = unlike_cubic(start, rise, stop, fall, stages)
        return changes, (start > 0.0) & (stop < 0.0), unresolved
