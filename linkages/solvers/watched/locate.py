"""Where within a step the function of an event takes a value.

The dense output is searched first; the step itself, repeated in part, then gives the last digits.
"""

from __future__ import annotations

import math

from linkages.solvers.steps.compiled import (
    call_clock,
    call_rates,
    compiled,
    floats,
    inlined,
    integers,
)
from linkages.solvers.steps.stages import address_of, further_stages, try_step
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


@inlined
def evaluate_function(system: SystemView, events: Events, event: int, row: int, t: float) -> None:
    """Evaluate a compiled function and its rate; where it cannot be, they are nan."""
    functions = integers(events.functions + WORD * FUNCTION * event)
    out = events.values + WORD * VALUES * event
    status = call_clock(functions[0], t, functions[2], functions[3])
    if status == 0:
        state = address_of(system, row)
        status = call_rates(functions[1], state, functions[2], functions[3], out)
    if status != 0:
        floats(out)[0] = floats(out)[1] = math.nan


@inlined
def value(
    system: SystemView, events: Events, record: Record, event: int, row: int, t: float
) -> float:
    """Function of an event, less its level, at the state in a row and its time."""
    n = system.n
    if integers(events.functions)[FUNCTION * event] != 0:
        evaluate_function(system, events, event, row, t)
        return floats(events.values)[VALUES * event] - floats(events.level)[event]
    weights = floats(events.weights + WORD * event * 2 * n)
    state, turns = floats(address_of(system, row)), integers(record.final_turns)
    total = -floats(events.level)[event]
    for i in range(2 * n):
        total += weights[i] * state[i]
    if floats(events.period)[event] == 0.0:
        for i in range(n):
            total += weights[i] * TWO_PI * turns[i]
    return total


@inlined
def slope(system: SystemView, events: Events, event: int, row: int) -> float:
    """Rate of the function of an event; the row has been evaluated, by `value` last of all."""
    n = system.n
    if integers(events.functions)[FUNCTION * event] != 0:
        return floats(events.values)[VALUES * event + 1]
    weights = floats(events.weights + WORD * event * 2 * n)
    rates = floats(address_of(system, row) + WORD * n)
    total = 0.0
    for i in range(2 * n):
        total += weights[i] * rates[i]
    return total


@compiled
def dense_value(
    system: SystemView,
    table: TableView,
    events: Events,
    record: Record,
    event: int,
    t: float,
    h: float,
    theta: float,
) -> float:
    """Function of an event, less its level, by the dense output at a fraction of a step."""
    interpolate(system, h, theta)
    return value(system, events, record, event, table.rows, t + theta * h)


@compiled
def prepare_dense(system: SystemView, table: TableView, record: Record, t: float, h: float) -> bool:
    """Make a step again with all rows of its dense output; whether that is possible."""
    integers(record.counters)[EVALUATIONS] += table.rows - 1
    if try_step(system, t, h, t + h) != 0:
        return False
    return further_stages(system, t, h, t + h) == 0


@compiled
def turning_point(
    system: SystemView,
    table: TableView,
    events: Events,
    record: Record,
    event: int,
    t: float,
    h: float,
    side: float,
) -> float:
    """Fraction of a step where the function is least (side 1) or greatest (side -1).

    Golden section on the dense output; near enough to tell whether a level lies beyond.
    """
    ratio = 0.5 * (math.sqrt(5.0) - 1.0)
    low, high = 0.0, 1.0
    a, b = 1.0 - ratio, ratio
    at_a = side * dense_value(system, table, events, record, event, t, h, a)
    at_b = side * dense_value(system, table, events, record, event, t, h, b)
    for _ in range(SEARCHES // 2):
        if at_a < at_b:
            high, b, at_b = b, a, at_a
            a = high - ratio * (high - low)
            at_a = side * dense_value(system, table, events, record, event, t, h, a)
        else:
            low, a, at_a = a, b, at_b
            b = low + ratio * (high - low)
            at_b = side * dense_value(system, table, events, record, event, t, h, b)
    return 0.5 * (low + high)


@compiled
def search(
    system: SystemView,
    table: TableView,
    events: Events,
    record: Record,
    event: int,
    t: float,
    h: float,
    low: float,
    high: float,
    target: float,
) -> float:
    """Fraction between two others where the dense output takes a value (Illinois method)."""
    at_low = dense_value(system, table, events, record, event, t, h, low) - target
    at_high = dense_value(system, table, events, record, event, t, h, high) - target
    if at_low * at_high >= 0.0:
        # The crossing is a round-off beyond one of the ends.
        return low if abs(at_low) < abs(at_high) else high
    theta, kept = high, 0
    for _ in range(SEARCHES):
        theta = (low * at_high - high * at_low) / (at_high - at_low)
        here = dense_value(system, table, events, record, event, t, h, theta) - target
        if here == 0.0:
            break
        if here * at_high > 0.0:
            moved, high, at_high = high - theta, theta, here
            at_low *= 0.5 if kept == 1 else 1.0
            kept = 1
        else:
            moved, low, at_low = theta - low, theta, here
            at_high *= 0.5 if kept == -1 else 1.0
            kept = -1
        if min(moved, high - low) < NEAR:
            break
    return theta


@compiled
def polish(
    system: SystemView,
    table: TableView,
    events: Events,
    record: Record,
    event: int,
    t: float,
    h: float,
    theta: float,
    low: float,
    high: float,
    target: float,
) -> float:
    """Fraction where the step itself, repeated in part, takes a value (Newton's method).

    It stays between two others, where the function of an event is no more than round-off, too. The
    workspace is left with the step up to there.
    """
    last = 1.0
    for _ in range(POLISHES):
        integers(record.counters)[EVALUATIONS] += table.end
        if try_step(system, t, theta * h, t + theta * h) != 0:
            return theta
        miss = value(system, events, record, event, table.end, t + theta * h) - target
        rate = h * slope(system, events, event, table.end)
        # Touching a level, the function has no rate to divide by.
        if miss == 0.0 or abs(rate) * last <= abs(miss):
            return theta
        last = abs(miss / rate)
        if last < EXACT:
            return theta
        theta = min(max(theta - miss / rate, low), high)
    return theta
