"""Where within a step the function of an event takes a value.

The dense output is searched first; the step itself, repeated in part, then gives the last digits.
"""

from __future__ import annotations

import math

from linkages.kernel.code.operands import (
    Real,
    Truth,
    Whole,
    choose,
    choose_of,
    floats,
    integers,
    larger_of,
    smaller_of,
)
from linkages.kernel.code.printed import printed
from linkages.kernel.code.procedure import Procedure
from linkages.solvers.steps.stages import (
    address_of,
    call_clock,
    call_rates,
    further_stages,
    try_step,
)
from linkages.solvers.steps.views import (
    EVALUATIONS,
    FUNCTION,
    TWO_PI,
    VALUES,
    WORD,
    Events,
    Record,
    SystemView,
    TableView,
)
from linkages.solvers.watched.sampling import interpolate

SEARCHES, POLISHES = 60, 8
# Of a step: where searching the dense output gives way to repeating the step.
NEAR, EXACT = 1e-9, 1e-15


@printed
def evaluate_function(
    code: Procedure, system: SystemView, events: Events, event: Whole, row: Whole, t: Real
) -> None:
    """Evaluate a compiled function and its rate; where it cannot be, they are nan."""
    functions = integers(events.functions + WORD * FUNCTION * event)
    out = events.values + WORD * VALUES * event
    status = code.variable(call_clock(functions[0], t, functions[2], functions[3]))
    with code.when(status == 0):
        state = address_of(system, row)
        status.set(call_rates(functions[1], state, functions[2], functions[3], out))
    with code.when(status != 0):
        found = floats(out)
        found[0], found[1] = math.nan, math.nan


@printed
def value(
    code: Procedure, system: SystemView, events: Events, record: Record,
    event: Whole, row: Whole, t: Real,
) -> Real:  # fmt: skip
    """Function of an event, less its level, at the state in a row and its time."""
    n, level = system.n, floats(events.level)[event]
    with code.when(integers(events.functions)[FUNCTION * event] != 0):
        evaluate_function(system, events, event, row, t)
        code.leave(floats(events.values)[VALUES * event] - level)
    weights = floats(events.weights + WORD * event * 2 * n)
    state, turns = floats(address_of(system, row)), integers(record.final_turns)
    total = code.variable(-level)
    with code.count(2 * n) as i:
        total.set(total + weights[i] * state[i])
    with code.when(floats(events.period)[event] == 0.0), code.count(n) as i:
        total.set(total + weights[i] * TWO_PI * turns[i].real)
    return code.value(total)


@printed
def slope(code: Procedure, system: SystemView, events: Events, event: Whole, row: Whole) -> Real:
    """Rate of the function of an event; the row has been evaluated, by `value` last of all."""
    n = system.n
    with code.when(integers(events.functions)[FUNCTION * event] != 0):
        code.leave(floats(events.values)[VALUES * event + 1])
    weights = floats(events.weights + WORD * event * 2 * n)
    rates, total = floats(address_of(system, row) + WORD * n), code.variable(0.0)
    with code.count(2 * n) as i:
        total.set(total + weights[i] * rates[i])
    return code.value(total)


@printed
def dense_value(
    _code: Procedure, system: SystemView, table: TableView, events: Events, record: Record,
    event: Whole, t: Real, h: Real, theta: Real,
) -> Real:  # fmt: skip
    """Function of an event, less its level, by the dense output at a fraction of a step."""
    interpolate(system, h, theta)
    return value(system, events, record, event, table.rows, t + theta * h)


@printed
def prepare_dense(
    code: Procedure, system: SystemView, table: TableView, record: Record, t: Real, h: Real
) -> Truth:
    """Make a step again with all rows of its dense output; whether that is possible."""
    integers(record.counters)[EVALUATIONS] += table.rows - 1
    with code.when(try_step(system, t, h, t + h) != 0):
        code.leave(False)
    return further_stages(system, t, h, t + h) == 0


@printed
def turning_point(
    code: Procedure, system: SystemView, table: TableView, events: Events, record: Record,
    event: Whole, t: Real, h: Real, side: Real,
) -> Real:  # fmt: skip
    """Fraction of a step where the function is least (side 1) or greatest (side -1).

    Golden section on the dense output; near enough to tell whether a level lies beyond.
    """

    def at(theta: Real) -> Real:
        return side * dense_value(system, table, events, record, event, t, h, theta)

    ratio = 0.5 * (math.sqrt(5.0) - 1.0)
    low, high = code.variable(0.0), code.variable(1.0)
    a, b = code.variable(1.0 - ratio), code.variable(ratio)
    at_a, at_b = code.variable(at(a)), code.variable(at(b))
    with code.count(SEARCHES // 2):
        with code.when(at_a < at_b) as case:
            high.set(b)
            b.set(a)
            at_b.set(at_a)
            a.set(high - ratio * (high - low))
            at_a.set(at(a))
        with case.otherwise():
            low.set(a)
            a.set(b)
            at_a.set(at_b)
            b.set(low + ratio * (high - low))
            at_b.set(at(b))
    return 0.5 * (low + high)


@printed
def search(
    code: Procedure, system: SystemView, table: TableView, events: Events, record: Record,
    event: Whole, t: Real, h: Real, begun: Real, ended: Real, target: Real,
) -> Real:  # fmt: skip
    """Fraction between two others where the dense output takes a value (Illinois method)."""

    def at(theta: Real) -> Real:
        return dense_value(system, table, events, record, event, t, h, theta) - target

    low, high = code.variable(begun), code.variable(ended)
    at_low, at_high = code.variable(at(low)), code.variable(at(high))
    with code.when(at_low * at_high >= 0.0):
        # The crossing is a round-off beyond one of the ends.
        code.leave(choose(abs(at_low) < abs(at_high), begun, ended))
    theta, kept, moved = code.variable(ended), code.variable(0), code.variable(0.0)
    with code.count(SEARCHES):
        theta.set((low * at_high - high * at_low) / (at_high - at_low))
        here = at(theta)
        with code.when(here == 0.0):
            code.stop()
        with code.when(here * at_high > 0.0) as case:
            moved.set(high - theta)
            high.set(theta)
            at_high.set(here)
            at_low.set(at_low * choose_of(Real, kept == 1, 0.5, 1.0))
            kept.set(1)
        with case.otherwise():
            moved.set(theta - low)
            low.set(theta)
            at_low.set(here)
            at_high.set(at_high * choose_of(Real, kept == -1, 0.5, 1.0))
            kept.set(-1)
        with code.when(smaller_of(moved, high - low) < NEAR):
            code.stop()
    return code.value(theta)


@printed
def polish(
    code: Procedure, system: SystemView, table: TableView, events: Events, record: Record,
    event: Whole, t: Real, h: Real, begun: Real, low: Real, high: Real, target: Real,
) -> Real:  # fmt: skip
    """Fraction where the step itself, repeated in part, takes a value (Newton's method).

    It stays between two others, where the function of an event is no more than round-off, too. The
    workspace is left with the step up to there.
    """
    last, theta = code.variable(1.0), code.variable(begun)
    with code.count(POLISHES):
        integers(record.counters)[EVALUATIONS] += table.end
        with code.when(try_step(system, t, theta * h, t + theta * h) != 0):
            code.leave(theta)
        miss = value(system, events, record, event, table.end, t + theta * h) - target
        rate = h * slope(system, events, event, table.end)
        # Touching a level, the function has no rate to divide by.
        with code.when((miss == 0.0) | (abs(rate) * last <= abs(miss))):
            code.leave(theta)
        last.set(abs(miss / rate))
        with code.when(last < EXACT):
            code.leave(theta)
        theta.set(smaller_of(larger_of(theta - miss / rate, low), high))
    return code.value(theta)
