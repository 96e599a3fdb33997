"""Location of events within an accepted step.

The dense output is searched first; the step itself, repeated in part, then gives the last digits.
Loops call `watch_step` through its address, so that runs without events need not load it.
"""

from __future__ import annotations

import math
from typing import Any

from linkages.kernel.code.operands import (
    Bool,
    Int,
    Real,
    floor,
    maximum,
    minimum,
    select,
    select_of,
)
from linkages.kernel.code.procedure import Procedure, traced
from linkages.solvers.loops.control import SLACK, meeting
from linkages.solvers.loops.margins import interpolate
from linkages.solvers.loops.memory import FUNCTION, TWO_PI, VALUES, KernelTable, Motion
from linkages.solvers.loops.scalar_stages import (
    call_clock,
    call_rates,
    further_stages,
    try_step,
    wrap_angles,
)

SEARCHES, POLISHES = 60, 8
# Of a step: where searching the dense output gives way to repeating the step.
NEAR, EXACT = 1e-9, 1e-15


@traced
def evaluate_function(code: Procedure, motion: Motion, event: Int, row: Int, t: Real) -> None:
    """Evaluate a compiled function and its rate; where it cannot be, they are nan."""
    function = KernelTable(code, motion.functions.after(FUNCTION * event).pointer, lasting=False)
    result, status = motion.values.after(VALUES * event), code.variable(call_clock(function, t))
    with code.if_(status == 0):
        status.set(call_rates(function, motion.row(row), result))
    with code.if_(status != 0):
        result[0], result[1] = math.nan, math.nan


@traced
def value(code: Procedure, motion: Motion, event: Int, row: Int, t: Real) -> Real:
    """Function of an event, less its level, at the state in a row and its time."""
    events, n, level = motion.events, motion.n, motion.levels[event]
    with code.if_(motion.functions[FUNCTION * event] != 0):
        evaluate_function(motion, event, row, t)
        code.return_(motion.event_values(event).value - level)
    weights = events.weights.after(event * 2 * n)
    state, turns = motion.row(row), motion.turns
    total = code.variable(-level)
    with code.for_range(2 * n) as i:
        total.set(total + weights[i] * state[i])
    with code.if_(events.period[event] == 0.0), code.for_range(n) as i:
        total.set(total + weights[i] * TWO_PI * turns[i].to_real)
    return code.value(total)


@traced
def slope(code: Procedure, motion: Motion, event: Int, row: Int) -> Real:
    """Rate of the function of an event; the row has been evaluated, by `value` last of all."""
    n = motion.n
    with code.if_(motion.functions[FUNCTION * event] != 0):
        code.return_(motion.event_values(event).rate)
    weights = motion.events.weights.after(event * 2 * n)
    rates, total = motion.row(row, n), code.variable(0.0)
    with code.for_range(2 * n) as i:
        total.set(total + weights[i] * rates[i])
    return code.value(total)


@traced
def dense_value(
    _code: Procedure, motion: Motion, event: Int, t: Real, h: Real, theta: Real
) -> Real:
    """Function of an event, less its level, by the dense output at a fraction of a step."""
    interpolate(motion, motion.interpolate, h, theta)
    return value(motion, event, motion.scratch, t + theta * h)


@traced
def prepare_dense(code: Procedure, motion: Motion, t: Real, h: Real) -> Bool:
    """Make a step again with all rows of its dense output; whether that is possible."""
    motion.counters.evaluations += motion.cost + motion.scratch - 1 - motion.end
    code.return_if(try_step(motion, t, h, t + h) != 0, False)
    return further_stages(motion, t, h, t + h) == 0


@traced
def turning_point(
    code: Procedure, motion: Motion, event: Int, t: Real, h: Real, side: Real
) -> Real:
    """Fraction of a step where the function is least (side 1) or greatest (side -1).

    Golden section on the dense output; near enough to tell whether a level lies beyond.
    """

    def at(theta: Real) -> Real:
        return side * dense_value(motion, event, t, h, theta)

    ratio = 0.5 * (math.sqrt(5.0) - 1.0)
    low, high = code.variable(0.0), code.variable(1.0)
    a, b = code.variable(1.0 - ratio), code.variable(ratio)
    at_a, at_b = code.variable(at(a)), code.variable(at(b))
    with code.for_range(SEARCHES // 2):
        with code.if_(at_a < at_b) as case:
            high.set(b)
            b.set(a)
            at_b.set(at_a)
            a.set(high - ratio * (high - low))
            at_a.set(at(a))
        with case.else_():
            low.set(a)
            a.set(b)
            at_a.set(at_b)
            b.set(low + ratio * (high - low))
            at_b.set(at(b))
    return 0.5 * (low + high)


@traced
def search(
    code: Procedure, motion: Motion,
    event: Int, t: Real, h: Real, begun: Real, ended: Real, target: Real,
) -> Real:  # fmt: skip
    """Fraction between two others where the dense output takes a value (Illinois method)."""

    def at(theta: Real) -> Real:
        return dense_value(motion, event, t, h, theta) - target

    low, high = code.variable(begun), code.variable(ended)
    at_low, at_high = code.variable(at(low)), code.variable(at(high))
    with code.if_(at_low * at_high >= 0.0):
        # The crossing is a round-off beyond one of the ends.
        code.return_(select(abs(at_low) < abs(at_high), begun, ended))
    theta, kept, moved = code.variable(ended), code.variable(0), code.variable(0.0)
    with code.for_range(SEARCHES):
        theta.set((low * at_high - high * at_low) / (at_high - at_low))
        here = at(theta)
        code.break_if(here == 0.0)
        with code.if_(here * at_high > 0.0) as case:
            moved.set(high - theta)
            high.set(theta)
            at_high.set(here)
            at_low.set(at_low * select_of(Real, kept == 1, 0.5, 1.0))
            kept.set(1)
        with case.else_():
            moved.set(theta - low)
            low.set(theta)
            at_low.set(here)
            at_high.set(at_high * select_of(Real, kept == -1, 0.5, 1.0))
            kept.set(-1)
        code.break_if(minimum(moved, high - low) < NEAR)
    return code.value(theta)


@traced
def polish(
    code: Procedure, motion: Motion,
    event: Int, t: Real, h: Real, begun: Real, low: Real, high: Real, target: Real,
) -> Real:  # fmt: skip
    """Fraction where the step itself, repeated in part, takes a value (Newton's method).

    It stays between two others, also where the function is no more than round-off. The workspace is
    left with the step up to there.
    """
    last, theta = code.variable(1.0), code.variable(begun)
    with code.for_range(POLISHES):
        motion.counters.evaluations += motion.cost
        code.return_if(try_step(motion, t, theta * h, t + theta * h) != 0, theta)
        miss = value(motion, event, motion.end, t + theta * h) - target
        rate = h * slope(motion, event, motion.end)
        # Touching a level, the function has no rate to divide by.
        code.return_if((miss == 0.0) | (abs(rate) * last <= abs(miss)), theta)
        last.set(abs(miss / rate))
        code.return_if(last < EXACT, theta)
        theta.set(minimum(maximum(theta - miss / rate, low), high))
    return code.value(theta)


# What `watch_step` returns where the integration goes on.
GO_ON = 2.0
# Two units in the last place: t + θh may be rounded once or twice.
SAME_TIME = 4.5e-16


@traced
def note(code: Procedure, motion: Motion, event: Int, time: Real) -> None:
    """Record a crossing with the state at the end of the step in the workspace."""
    events = motion.events
    n, first, result = motion.n, events.first, events.found
    place = first[event] + result[event]
    result[event] += 1
    code.return_if(place >= first[event + 1])
    events.time[place] = time
    row, state = motion.row(motion.end), events.state.after(place * 2 * n)
    state.take(row, 2 * n)
    wrap_angles(motion, state, events.turns.after(place * n))
    events.held.after(place * motion.holding).take(motion.held, motion.holding)
    motion.expect_end(Int, motion)
    motion.count(Int, motion, row, events.angles.after(place * motion.counted))


def crossed_levels(
    motion: Motion, event: Int, side: Real, start: Real, stop: Real
) -> tuple[Any, Any]:
    """First and last number of the levels that are crossed upward (side 1) or downward."""
    period = motion.events.period[event]
    slack = SLACK * maximum(abs(motion.levels[event]), 1.0)
    start, stop = side * start + slack, side * stop + slack
    alone = period == 0.0
    one = select_of(Int, (start < 0.0) & (stop >= 0.0), 0, -1)
    first = select(alone, 0, floor(start / period) + 1)
    return first, select(alone, one, floor(stop / period))


@traced
def cross_piece(
    code: Procedure, motion: Motion,
    event: Int, t: Real, h: Real, low: Real, high: Real, start: Real, stop: Real,
) -> Real:  # fmt: skip
    """Record the crossings of a piece of a step on which the function rises or falls.

    Returns the fraction of a crossing that ends the integration, or GO_ON.
    """
    events, side = motion.events, select_of(Real, stop > start, 1.0, -1.0)
    code.return_if(side * events.direction[event].to_real < 0.0, GO_ON)
    first, last = crossed_levels(motion, event, side, start, stop)
    with code.for_range(last + 1 - first) as further:
        target = side * (first + further).to_real * events.period[event]
        theta = code.variable(low + (high - low) * (target - start) / (stop - start))
        with code.if_(prepare_dense(motion, t, h)):
            theta.set(search(motion, event, t, h, low, high, target))
        theta.set(polish(motion, event, t, h, theta, low, high, target))
        note(motion, event, t + theta * h)
        code.return_if(events.found[event] == events.terminal[event], theta)
    return code.value(GO_ON)


@traced
def watch_event(code: Procedure, motion: Motion, event: Int, t: Real, h: Real, t_end: Real) -> Real:
    """Record the crossings of one event within a step; see `cross_piece`."""
    kept, level = motion.event_values(event), motion.levels[event]
    start, before = code.variable(0.0), code.variable(0.0)
    with code.if_(kept.before == t) as case:  # as the step before left them
        start.set(kept.value_before - level)
        before.set(h * kept.rate_before)
    with case.else_():
        start.set(value(motion, event, 0, t))
        before.set(h * slope(motion, event, 0))
    stop = value(motion, event, motion.end, t_end)
    after = h * slope(motion, event, motion.end)
    with code.if_(motion.functions[FUNCTION * event] != 0):
        # the next step starts there
        kept.before, kept.value_before, kept.rate_before = t_end, kept.value, kept.rate
    with code.if_(before * after >= 0.0):
        code.return_if((before * (stop - start) < 0.0) | (start == stop), GO_ON)
        code.return_(cross_piece(motion, event, t, h, 0.0, 1.0, start, stop))
    # The function turns within the step, not further away than where its tangents meet.
    side = select_of(Real, after > 0.0, 1.0, -1.0)
    bound = meeting(start, before, stop, after)
    further = maximum(side * start, side * stop)
    first, last = crossed_levels(motion, event, side, bound, side * further)
    code.return_if(last < first, GO_ON)
    code.return_if(~prepare_dense(motion, t, h), GO_ON)
    middle = turning_point(motion, event, t, h, side)
    least = dense_value(motion, event, t, h, middle)
    end = cross_piece(motion, event, t, h, 0.0, middle, start, least)
    code.return_if(end != GO_ON, end)
    return cross_piece(motion, event, t, h, middle, 1.0, least, stop)


@traced
def forget_later(code: Procedure, motion: Motion, time: Real, forward: Bool) -> None:
    """Drop recorded crossings after a time at which another event ends the integration."""
    events = motion.events
    first, result, times = events.first, events.found, events.time
    with code.for_range(events.number) as event:
        room = first[event + 1] - first[event]
        with code.while_(lambda: (result[event] > 0) & (result[event] <= room)):
            latest = times[first[event] + result[event] - 1]
            later = select(forward, latest > time, ~(latest > time))
            code.break_if(~later | (abs(latest - time) <= SAME_TIME * abs(time)))
            result[event] -= 1


@traced
def watch_step(code: Procedure, motion: Motion, t: Real, h: Real, t_end: Real) -> Real:
    """Record all crossings within the accepted step in the workspace.

    Returns the fraction of the step at which the integration ends, with the workspace holding the
    step up to there; or GO_ON, with the workspace as it was, apart from its dense output.
    """
    counters, part = motion.counters, code.variable(GO_ON)
    evaluations = code.variable(counters.evaluations)
    with code.for_range(motion.events.number) as event:
        result = watch_event(motion, event, t, h, t_end)
        part.set(minimum(part, result))
        with code.if_(counters.evaluations != evaluations):
            counters.evaluations += motion.cost
            evaluations.set(counters.evaluations)
            try_step(motion, t, h, t_end)
    with code.if_(part != GO_ON):
        forget_later(motion, t + part * h, h > 0.0)
        counters.evaluations += motion.cost
        try_step(motion, t, part * h, t + part * h)
    return code.value(part)
