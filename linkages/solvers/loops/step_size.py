"""Length of the first step of an adaptive method, and what else shortens one."""

from __future__ import annotations

import math

from linkages.solvers.steps.compiled import compiled, floats
from linkages.solvers.steps.stages import evaluate, finite, set_clock
from linkages.solvers.steps.views import System

# A trial that leaves the reach of a block says nothing about how far that block reaches.
SHRINK_BLOCKED = 0.25
# Behind a change of a mode forces may grow like roots (t^1.5 in a contact): errors fall with low
# powers of the step there, whatever the order.
SHRINK_FRESH = 0.1
# An estimate of such an error is small by accident now and then, so no step that is far too long
# must be tried: the first of its kind is so much shorter than smooth equations would allow, and
# later ones are at most twice as long as the last.
CAUTIOUS = 3e-4


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
