"""Length of the first and of the next step of an adaptive method."""

from __future__ import annotations

import math

from linkages.solvers.steps.compiled import compiled, floats
from linkages.solvers.steps.stages import evaluate, finite, set_clock
from linkages.solvers.steps.views import System, Table
from linkages.solvers.watched.margins import margins_of

# Measured on pendulums and Duffing's equation at rtol 1e-10: against the usual 0.9, fewer rejected
# steps outweigh shorter ones, so that 0.8 takes 4 to 11 % fewer evaluations and errs less. On the
# nine-bar proportional-integral control (exponents 0.7 and 0.4, 0.8 and 0.3, 0.8 and 0.2 of 1/p)
# rejects fewer steps, yet for the same error dop853 and vern9 need 2 to 18 % more evaluations.
SAFETY = 0.8
SHRINK_MOST, GROW_MOST = 1 / 3, 6.0
# A trial that leaves the reach of a block says nothing about how far that block reaches.
SHRINK_BLOCKED = 0.25
# Halving is enough for links that turned too far to be watched.
SHRINK_TURNING = 0.5
# An end at which everything is so much steeper than at the start says nothing about round-off: a
# trial that dived into a wall must not excuse itself.
WILD = 1e4
# Behind a change of a mode forces may grow like roots (t^1.5 in a contact): errors fall with low
# powers of the step there, whatever the order.
SHRINK_FRESH = 0.1
# An estimate of such an error is small by accident now and then, so no step that is far too long
# must be tried: the first of its kind is so much shorter than smooth equations would allow, and
# later ones are at most twice as long as the last.
CAUTIOUS = 3e-4
OVERFLOW = 1e150
# Steps that were much better than asked for say nothing about how the error develops.
LEAST_BEFORE = 1e-4
# The factor is measured: a nine-bar on its way to a change point scatters by 0.01 to 0.05 ε/m³
# where its time and state are moved by units in their last place.
ROUNDING, TINY = 0.05 * 2.220446049250313e-16, 1e-30


@compiled
def rounding(system: System, end: int) -> float:
    """Relative round-off of accelerations, from the least margin at both ends of a step.

    A link's component found as ``sqrt(L² - n²)`` carries a relative error ε/m² at the relative
    margin m, and accelerations divide by it once more. No step is short enough to show a smaller
    error, however smooth the motion is; without this allowance the steps before a singular
    position would shrink to nothing.
    """
    scale = floats(system.margin_scale)
    first, last = floats(margins_of(system, 0)), floats(margins_of(system, end))
    least = 1.0
    for block in range(system.blocks):
        least = min(least, min(abs(first[block]), abs(last[block])) / scale[block])
    return ROUNDING / max(least**3, TINY)


@compiled
def error_norm(system: System, table: Table, h: float, rtol: float, atol: int) -> float:
    """Root mean square of the error estimate in units of the tolerance and of round-off.

    With two estimates e₅ and e₃ it is ``|h| |e₅|² / sqrt(|e₅|² + 0.01 |e₃|²)`` (Hairer, Nørsett &
    Wanner, II.10.17); with one, its norm. `atol` is the address of (2n,) numbers.
    """
    n, width, end = system.n, system.width, table.end
    rows, weights, least = floats(system.rows), floats(table.error), floats(atol)
    noise = abs(h) * rounding(system, end)
    early, late = 0.0, 0.0
    for i in range(2 * n):
        early = max(early, abs(rows[n + i]))
        late = max(late, abs(rows[end * width + n + i]))
    main, low = 0.0, 0.0
    for i in range(2 * n):
        first, second = 0.0, 0.0
        for j in range(end + 1):
            slope = rows[j * width + n + i]
            first += weights[j] * slope
            second += weights[end + 1 + j] * slope
        start, stop = abs(rows[i]), abs(rows[end * width + i])
        steepest = max(abs(rows[n + i]), abs(rows[end * width + n + i]))
        if late > WILD * early:
            steepest = abs(rows[n + i])
        unit = 1.0 / (least[i] + rtol * max(start, stop) + noise * steepest)
        main += (first * unit) ** 2
        low += (second * unit) ** 2
    if main == 0.0:
        return 0.0
    return abs(h) * main / math.sqrt((main + 0.01 * low) * (2 * n))


@compiled
def next_factor(error: float, before: float, exponent: float, memory: float) -> float:
    """Factor from a step to the next one, or to its repetition, from the error norm.

    With `memory` > 0 this is Gustafsson's PI control in the form of Hairer & Wanner (IV.2):
    ``safety · error^-(exponent - 0.75 memory) · before^memory``, where `before` is the error norm
    of the step before. With 0 it is the elementary control by the last error alone.
    """
    if error == 0.0:
        return GROW_MOST
    # Written so that nan, the quotient of two overflows, is caught as well.
    if not error < OVERFLOW:
        return SHRINK_MOST
    factor = SAFETY * error ** -(exponent - 0.75 * memory)
    if memory > 0.0:
        factor *= max(before, LEAST_BEFORE) ** memory
    return min(GROW_MOST, max(SHRINK_MOST, factor))


@compiled
def tolerance_norm(system: System, values: int, minus: int, rtol: float, atol: int) -> float:
    """Root mean square of ``values - minus`` in units of the tolerance at row 0."""
    n = system.n
    total = 0.0
    for i in range(2 * n):
        unit = floats(atol)[i] + rtol * abs(floats(system.rows)[i])
        total += ((floats(values)[i] - floats(minus)[i]) / unit) ** 2
    return math.sqrt(total / (2 * n))


@compiled
def first_step(
    system: System, t: float, span: float, order: int, rtol: float, atol: int, zeros: int
) -> float:
    """First step by the method of Hairer, Nørsett & Wanner, II.4, with the sign of `span`.

    Evaluates the kernel once, in row 1. `zeros` is the address of (2n,) zeros.
    """
    n, rows = system.n, floats(system.rows)
    if n == 0:
        return span
    slope = system.rows + 8 * n
    d0 = tolerance_norm(system, system.rows, zeros, rtol, atol)
    d1 = tolerance_norm(system, slope, zeros, rtol, atol)
    length = 1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1
    length = min(length, abs(span))
    h = math.copysign(length, span)
    for i in range(2 * n):
        rows[system.width + i] = rows[i] + h * rows[n + i]
    if set_clock(system, t + h) != 0 or evaluate(system, 1) != 0:
        return 0.1 * h
    if not finite(system, 1, 3 * n):
        return 0.1 * h
    d2 = tolerance_norm(system, slope + 8 * system.width, slope, rtol, atol) / length
    largest = max(d1, d2)
    other = max(1e-6, 1e-3 * length)
    if largest > 1e-15:
        other = (0.01 / largest) ** (1.0 / (order + 1))
    return math.copysign(min(100 * length, other, abs(span)), span)
