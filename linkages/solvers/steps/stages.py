"""Stages of an explicit Runge–Kutta step, over a kernel given by addresses."""

from __future__ import annotations

from linkages.solvers.steps.compiled import call_clock, call_rates, compiled, floats, integers
from linkages.solvers.steps.views import NODE, STEP_END, WORD, System, Table

NOT_FINITE = -1
LARGEST_STATE = 1e150
# An angle that moves by this much within one step has nothing to do with the motion any more.
LARGEST_ANGLE = 1e9


@compiled
def address_of(system: System, row: int) -> int:
    """Address of a row of the workspace."""
    return system.rows + WORD * row * system.width


@compiled
def finite(system: System, row: int, columns: int) -> bool:
    """Whether the first columns of a row are numbers that a motion can have."""
    values, rotates = floats(address_of(system, row)), integers(system.rotates)
    for i in range(columns):
        # Written so that nan, which compares false with everything, is caught.
        if not abs(values[i]) < LARGEST_STATE:
            return False
    for i in range(system.n):  # noqa: SIM110 (compiled code has no generators)
        if abs(values[i]) > LARGEST_ANGLE and rotates[i] != 0:
            return False
    return True


@compiled
def set_clock(system: System, t: float) -> int:
    """Evaluate what depends on time alone; returns the status of the kernel."""
    return call_clock(system.clock, t, system.parameters, system.timed)


@compiled
def evaluate(system: System, row: int) -> int:
    """Evaluate the kernel at the state in a row; 0, 1 + block, or NOT_FINITE."""
    state = address_of(system, row)
    out = state + WORD * 2 * system.n
    status = call_rates(system.rates, state, system.parameters, system.timed, out)
    # A kernel fed with infinities finds its blocks out of reach, which is not what went wrong.
    if status != 0 and not finite(system, row, 2 * system.n):
        return NOT_FINITE
    return status


@compiled
def run_stages(
    system: System, table: Table, first: int, last: int, t: float, h: float, t_end: float
) -> int:
    """Compute rows first..last of a step of length h from time t and row 0.

    Rows at the end of the step are evaluated at `t_end` rather than at ``t + h``, so that the end
    of a step and the start of the next one are at the same time to the last bit.
    """
    rows, starts, places = floats(system.rows), integers(table.starts), integers(table.places)
    weights, clocks, c = floats(table.weights), integers(table.clocks), floats(table.c)
    for row in range(first, last + 1):
        for i in range(2 * system.n):
            slope = 0.0
            for j in range(starts[row], starts[row + 1]):
                slope += weights[j] * rows[places[j] + i]
            rows[row * system.width + i] = rows[i] + h * slope
        status = 0
        if clocks[row] == NODE:
            status = set_clock(system, t + c[row] * h)
        elif clocks[row] == STEP_END:
            status = set_clock(system, t_end)
        if status == 0:
            status = evaluate(system, row)
        if status != 0:
            return status
    return 0


@compiled
def try_step(system: System, table: Table, t: float, h: float, t_end: float) -> int:
    """Step from row 0 to row `table.end`; 0, 1 + block, or NOT_FINITE."""
    status = run_stages(system, table, 1, table.end, t, h, t_end)
    if status == 0 and not finite(system, table.end, 3 * system.n):
        return NOT_FINITE
    return status
