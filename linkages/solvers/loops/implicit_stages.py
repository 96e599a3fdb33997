"""Stages of a collocation step, solved by fixed-point iteration down to round-off.

References
----------
.. [1] E. Hairer, R. I. McLachlan, A. Razakarivony, "Achieving Brouwer's law with implicit
       Runge–Kutta methods", BIT 48 (2008), 231–243.
"""

from __future__ import annotations

import math

from linkages.kernel.code.operands import (
    Real,
    Whole,
    floats,
    fused,
    integers,
    larger_of,
)
from linkages.kernel.code.printed import printed
from linkages.kernel.code.procedure import Procedure
from linkages.solvers.steps.stages import NOT_FINITE, address_of, call_clock, call_rates, finite
from linkages.solvers.steps.views import EVALUATIONS, WORD, Nodes, Record, SystemView

NOT_SETTLED = -2
ITERATIONS = 50
# Iterations end where changes cease to shrink [1]_. A change that does so above this fraction of
# the accelerations is no round-off: the iteration does not converge.
SETTLED = 1e-9


@printed
def set_clocks(code: Procedure, system: SystemView, nodes: Nodes, t: Real, h: Real) -> Whole:
    """Evaluate what depends on time alone at every stage; iterations do not change it."""
    with code.count(nodes.stages) as i:
        timed = nodes.timed + WORD * i * nodes.timed_size
        time = fused(floats(nodes.c)[i], h, t)
        status = call_clock(system.clock, time, system.parameters, timed)
        with code.when(status != 0):
            code.leave(status)
    return code.value(0)


@printed
def place_stages(code: Procedure, system: SystemView, nodes: Nodes, first: Whole, h: Real) -> None:
    """Write the coordinates and speeds of all stages, from their accelerations."""
    n, s, width = system.n, nodes.stages, system.width
    rows, A, AA, c = floats(system.rows), floats(nodes.A), floats(nodes.AA), floats(nodes.c)
    with code.count(s) as i:
        row = (first + i) * width
        with code.count(n) as k:
            single, double = code.variable(0.0), code.variable(0.0)
            with code.count(s) as j:
                acceleration = rows[(first + j) * width + 2 * n + k]
                single.set(fused(A[i * s + j], acceleration, single))
                double.set(fused(AA[i * s + j], acceleration, double))
            moved = fused(h, double, c[i] * rows[n + k])
            rows[row + k] = fused(h, moved, rows[k])
            rows[row + n + k] = fused(h, single, rows[n + k])


@printed
def evaluate_stages(
    code: Procedure, system: SystemView, nodes: Nodes, record: Record, first: Whole, changes: Whole
) -> Whole:
    """Evaluate all stages; returns the status.

    Writes the largest change of an acceleration and the largest acceleration to `changes`.
    """
    n, width = system.n, system.width
    rows, kept = floats(system.rows), floats(nodes.kept)
    change, largest = code.variable(0.0), code.variable(0.0)
    with code.count(nodes.stages) as i:
        state = address_of(system, first + i)
        base = (first + i) * width + 2 * n
        with code.count(n) as k:
            kept[k] = rows[base + k]
        integers(record.counters)[EVALUATIONS] += 1
        timed = nodes.timed + WORD * i * nodes.timed_size
        out = state + WORD * 2 * n
        status = call_rates(system.rates, state, system.parameters, timed, out)
        with code.when(status != 0):
            code.leave(status)
        with code.when(~finite(system, first + i, 3 * n)):
            code.leave(NOT_FINITE)
        with code.count(n) as k:
            change.set(larger_of(change, abs(rows[base + k] - kept[k])))
            largest.set(larger_of(largest, abs(rows[base + k])))
    found = floats(changes)
    found[0], found[1] = change, largest
    return code.value(0)


@printed
def solve_stages(
    code: Procedure, system: SystemView, nodes: Nodes, record: Record,
    first: Whole, t: Real, h: Real,
) -> Whole:  # fmt: skip
    """Solve the stages in rows first, first + 1, … of a step from row 0.

    The accelerations in these rows are the starting values. Returns 0, 1 + block, NOT_FINITE, or
    NOT_SETTLED.
    """
    status = set_clocks(system, nodes, t, h)
    with code.when(status != 0):
        code.leave(status)
    before = code.variable(math.inf)
    with code.count(ITERATIONS):
        place_stages(system, nodes, first, h)
        status = evaluate_stages(system, nodes, record, first, nodes.changes)
        with code.when(status != 0):
            code.leave(status)
        change, largest = floats(nodes.changes)[0], floats(nodes.changes)[1]
        settled = ~(change < before) & (change <= SETTLED * largest)
        with code.when((change == 0.0) | settled):
            code.leave(0)
        before.set(change)
    return code.value(NOT_SETTLED)


@printed
def finish_step(
    code: Procedure, system: SystemView, nodes: Nodes, first: Whole, row: Whole, h: Real
) -> None:
    """Write the end of a step to a row, summed with compensation.

    ``nodes.carry`` holds what row 0 is too small by, ``nodes.next_carry`` becomes that of the row.
    """
    n, width = system.n, system.width
    rows, b, bA = floats(system.rows), floats(nodes.b), floats(nodes.bA)
    carry, following = floats(nodes.carry), floats(nodes.next_carry)
    with code.count(n) as k:
        single, double = code.variable(0.0), code.variable(0.0)
        with code.count(nodes.stages) as j:
            acceleration = rows[(first + j) * width + 2 * n + k]
            single.set(fused(b[j], acceleration, single))
            double.set(fused(bA[j], acceleration, double))
        # The carry of the speed moves the coordinate as well.
        speed = rows[n + k] + fused(h, double, carry[n + k])
        moved, gained = fused(h, speed, carry[k]), fused(h, single, carry[n + k])
        rows[row * width + k] = rows[k] + moved
        rows[row * width + n + k] = rows[n + k] + gained
        following[k] = (rows[k] - rows[row * width + k]) + moved
        following[n + k] = (rows[n + k] - rows[row * width + n + k]) + gained
