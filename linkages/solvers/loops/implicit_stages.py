"""Stages of a collocation step, solved by fixed-point iteration down to round-off.

References
----------
.. [1] E. Hairer, R. I. McLachlan, A. Razakarivony, "Achieving Brouwer's law with implicit
       Runge–Kutta methods", BIT 48 (2008), 231–243.
"""

from __future__ import annotations

from linkages.solvers.steps.compiled import call_clock, call_rates, compiled, floats, integers
from linkages.solvers.steps.stages import NOT_FINITE, address_of, finite
from linkages.solvers.steps.views import EVALUATIONS, WORD, Nodes, Record, SystemView

NOT_SETTLED = -2
ITERATIONS = 50
# Iterations end where changes cease to shrink [1]_. A change that does so above this fraction of
# the accelerations is no round-off: the iteration does not converge.
SETTLED = 1e-9


@compiled
def set_clocks(system: SystemView, nodes: Nodes, t: float, h: float) -> int:
    """Evaluate what depends on time alone at every stage; iterations do not change it."""
    for i in range(nodes.stages):
        timed = nodes.timed + WORD * i * nodes.timed_size
        status = call_clock(system.clock, t + floats(nodes.c)[i] * h, system.parameters, timed)
        if status != 0:
            return status
    return 0


@compiled
def place_stages(system: SystemView, nodes: Nodes, first: int, h: float) -> None:
    """Write the coordinates and speeds of all stages, from their accelerations."""
    n, s, width = system.n, nodes.stages, system.width
    rows, A, AA, c = floats(system.rows), floats(nodes.A), floats(nodes.AA), floats(nodes.c)
    for i in range(s):
        row = (first + i) * width
        for k in range(n):
            single, double = 0.0, 0.0
            for j in range(s):
                acceleration = rows[(first + j) * width + 2 * n + k]
                single += A[i * s + j] * acceleration
                double += AA[i * s + j] * acceleration
            rows[row + k] = rows[k] + h * (c[i] * rows[n + k] + h * double)
            rows[row + n + k] = rows[n + k] + h * single


@compiled
def evaluate_stages(
    system: SystemView, nodes: Nodes, record: Record, first: int
) -> tuple[int, float, float]:
    """Evaluate all stages: status, largest change of an acceleration, largest acceleration."""
    n, width = system.n, system.width
    rows, kept = floats(system.rows), floats(nodes.kept)
    largest_change, largest = 0.0, 0.0
    for i in range(nodes.stages):
        state = address_of(system, first + i)
        base = (first + i) * width + 2 * n
        for k in range(n):
            kept[k] = rows[base + k]
        integers(record.counters)[EVALUATIONS] += 1
        timed = nodes.timed + WORD * i * nodes.timed_size
        out = state + WORD * 2 * n
        status = call_rates(system.rates, state, system.parameters, timed, out)
        if status != 0 or not finite(system, first + i, 3 * n):
            return (status if status != 0 else NOT_FINITE), 0.0, 0.0
        for k in range(n):
            largest_change = max(largest_change, abs(rows[base + k] - kept[k]))
            largest = max(largest, abs(rows[base + k]))
    return 0, largest_change, largest


@compiled
def solve_stages(
    system: SystemView, nodes: Nodes, record: Record, first: int, t: float, h: float
) -> int:
    """Solve the stages in rows first, first + 1, … of a step from row 0.

    The accelerations in these rows are the starting values. Returns 0, 1 + block, NOT_FINITE, or
    NOT_SETTLED.
    """
    status = set_clocks(system, nodes, t, h)
    if status != 0:
        return status
    before = 0.0
    for iteration in range(ITERATIONS):
        place_stages(system, nodes, first, h)
        status, change, largest = evaluate_stages(system, nodes, record, first)
        if status != 0:
            return status
        shrinks = iteration == 0 or change < before
        if change == 0.0 or (not shrinks and change <= SETTLED * largest):
            return 0
        before = change
    return NOT_SETTLED


@compiled
def finish_step(system: SystemView, nodes: Nodes, first: int, row: int, h: float) -> None:
    """Write the end of a step to a row, summed with compensation.

    ``nodes.carry`` holds what row 0 is too small by, ``nodes.next_carry`` becomes that of the row.
    """
    n, width = system.n, system.width
    rows, b, bA = floats(system.rows), floats(nodes.b), floats(nodes.bA)
    carry, following = floats(nodes.carry), floats(nodes.next_carry)
    for k in range(n):
        single, double = 0.0, 0.0
        for j in range(nodes.stages):
            acceleration = rows[(first + j) * width + 2 * n + k]
            single += b[j] * acceleration
            double += bA[j] * acceleration
        # The carry of the speed moves the coordinate as well.
        moved = carry[k] + h * (rows[n + k] + (carry[n + k] + h * double))
        gained = carry[n + k] + h * single
        rows[row * width + k] = rows[k] + moved
        rows[row * width + n + k] = rows[n + k] + gained
        following[k] = (rows[k] - rows[row * width + k]) + moved
        following[n + k] = (rows[n + k] - rows[row * width + n + k]) + gained
