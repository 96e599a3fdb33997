"""Stages of an explicit Runge–Kutta step, over a kernel given by addresses."""

from __future__ import annotations

from linkages.solvers.steps.compiled import (
    call_clock,
    call_rates,
    call_step,
    compiled,
    floats,
    integers,
)
from linkages.solvers.steps.views import (
    FROM,
    LARGEST_ANGLE,
    LARGEST_STATE,
    LENGTH,
    NOT_FINITE,
    TO,
    WORD,
    SystemView,
)

HALF, LOWER = 32, 2**32 - 1


@compiled
def address_of(system: SystemView, row: int) -> int:
    """Address of a row of the workspace."""
    return system.rows + WORD * row * system.width


@compiled
def finite(system: SystemView, row: int, columns: int) -> bool:
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
def set_clock(system: SystemView, t: float) -> int:
    """Evaluate what depends on time alone; returns the status of the kernel."""
    return call_clock(system.clock, t, system.parameters, system.timed)


@compiled
def evaluate(system: SystemView, row: int) -> int:
    """Evaluate the kernel at the state in a row; 0, 1 + block, or NOT_FINITE."""
    state = address_of(system, row)
    out = state + WORD * 2 * system.n
    status = call_rates(system.rates, state, system.parameters, system.timed, out)
    # A kernel fed with infinities finds its blocks out of reach, which is not what went wrong.
    if status != 0 and not finite(system, row, 2 * system.n):
        return NOT_FINITE
    return status


@compiled
def try_step(system: SystemView, t: float, h: float, t_end: float) -> int:
    """Step from row 0 to row `TableView.end`; 0, 1 + block, or NOT_FINITE."""
    return run(system, system.attempt, t, h, t_end)


@compiled
def further_stages(system: SystemView, t: float, h: float, t_end: float) -> int:
    """Compute the rows behind the end of a step, which its dense output needs; as `try_step`."""
    return run(system, system.further, t, h, t_end)


@compiled
def run(system: SystemView, function: int, t: float, h: float, t_end: float) -> int:
    """Run a printed function over a time."""
    pace = floats(system.pace)
    pace[FROM], pace[LENGTH], pace[TO] = t, h, t_end
    return status_of(system, call_step(function, system.frame))


@compiled
def status_of(system: SystemView, found: int) -> int:
    """Status of a printed function, which returns the row as well."""
    if found <= 0:
        return found
    # A kernel fed with infinities finds its blocks out of reach, which is not what went wrong.
    return found & LOWER if finite(system, found >> HALF, 2 * system.n) else NOT_FINITE
