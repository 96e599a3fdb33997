"""Error norm and next step length.

They are right to about 1e-10: a step that is longer by so much is as good as any.

References
----------
.. [1] E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
       Springer 1993, (II.10.17).
.. [2] E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996,
       section IV.2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from linkages.kernel.code.operands import (
    Bool,
    Real,
    copysign,
    fma,
    maximum,
    minimum,
    polynomial,
    rint,
    select,
    sqrt,
)
from linkages.solvers.loops.memory import SMALLEST_STEP, Stepper
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
