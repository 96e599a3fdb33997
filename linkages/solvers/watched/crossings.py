"""Find where events happen within an accepted step.

The loops of all methods call `watch_step` through its address, so that runs without events
neither load it nor pay for it.
"""

from __future__ import annotations

from typing import Any

from linkages.kernel.code.operands import (
    Real,
    Truth,
    Whole,
    choose,
    choose_of,
    floats,
    floor_of,
    integers,
    larger_of,
    smaller_of,
)
from linkages.kernel.code.printed import printed
from linkages.kernel.code.procedure import Procedure
from linkages.solvers.printed.crossings import SLACK
from linkages.solvers.steps.stages import address_of, try_step
from linkages.solvers.steps.turns import wrap_angles
from linkages.solvers.steps.views import (
    EVALUATIONS,
    FUNCTION,
    VALUES,
    WORD,
    Events,
    Record,
    SystemView,
    TableView,
)
from linkages.solvers.watched.counting import counted_angle, expect_end
from linkages.solvers.watched.locate import (
    dense_value,
    polish,
    prepare_dense,
    search,
    slope,
    turning_point,
    value,
)

SYSTEM_WORDS, TABLE_WORDS = len(SystemView._fields), len(TableView._fields)
RECORD_WORDS = len(Record._fields)
# What `watch_step` returns where the integration goes on.
GO_ON = 2.0
# Two units in the last place: t + θh may be rounded once or twice.
SAME_TIME = 4.5e-16


@printed
def note(
    code: Procedure, system: SystemView, table: TableView, events: Events, record: Record,
    event: Whole, time: Real, h: Real,
) -> None:  # fmt: skip
    """Record a crossing with the state at the end of the step of length h in the workspace."""
    n, found = system.n, integers(events.found)
    first = integers(events.first)
    place = first[event] + found[event]
    found[event] += 1
    with code.when(place >= first[event + 1]):
        code.leave()
    source, state = floats(address_of(system, table.end)), events.state + WORD * place * 2 * n
    floats(events.time)[place] = time
    with code.count(2 * n) as i:
        floats(state)[i] = source[i]
    wrap_angles(system, state, record.final_turns, events.turns + WORD * place * n)
    with code.count(system.holding) as i:
        floats(events.held)[place * system.holding + i] = floats(system.held)[i]
    expect_end(system, table, record, h)
    angles = events.angles + WORD * place * system.counted
    with code.count(system.counted) as i:
        floats(angles)[i] = counted_angle(system, record, table.end, i)


def crossed_levels(events: Any, event: Any, side: Real, start: Any, stop: Any) -> tuple[Any, Any]:
    """First and last number of the levels that are crossed upward (side 1) or downward."""
    period = floats(events.period)[event]
    slack = SLACK * larger_of(abs(floats(events.level)[event]), 1.0)
    start, stop = side * start + slack, side * stop + slack
    alone = period == 0.0
    one = choose_of(Whole, (start < 0.0) & (stop >= 0.0), 0, -1)
    first = choose(alone, 0, floor_of(start / period) + 1)
    return first, choose(alone, one, floor_of(stop / period))


@printed
def cross_piece(
    code: Procedure, system: SystemView, table: TableView, events: Events, record: Record,
    event: Whole, t: Real, h: Real, low: Real, high: Real, start: Real, stop: Real,
) -> Real:  # fmt: skip
    """Record the crossings of a piece of a step on which the function rises or falls.

    Returns the fraction of a crossing that ends the integration, or GO_ON.
    """
    side = choose_of(Real, stop > start, 1.0, -1.0)
    with code.when(side * integers(events.direction)[event].real < 0.0):
        code.leave(GO_ON)
    first, last = crossed_levels(events, event, side, start, stop)
    with code.count(last + 1 - first) as further:
        target = side * (first + further).real * floats(events.period)[event]
        theta = code.variable(low + (high - low) * (target - start) / (stop - start))
        with code.when(prepare_dense(system, table, record, t, h)):
            theta.set(search(system, table, events, record, event, t, h, low, high, target))
        theta.set(polish(system, table, events, record, event, t, h, theta, low, high, target))
        note(system, table, events, record, event, t + theta * h, theta * h)
        with code.when(integers(events.found)[event] == integers(events.terminal)[event]):
            code.leave(theta)
    return code.value(GO_ON)


def kept_of(events: Any, event: Whole) -> Any:
    """What is kept of the function of an event."""
    return floats(events.values + WORD * VALUES * event)


@printed
def watch_event(
    code: Procedure, system: SystemView, table: TableView, events: Events, record: Record,
    event: Whole, t: Real, h: Real, t_end: Real,
) -> Real:  # fmt: skip
    """Record the crossings of one event within a step; see `cross_piece`."""
    kept, level = kept_of(events, event), floats(events.level)[event]
    start, before = code.variable(0.0), code.variable(0.0)
    with code.when(kept[2] == t) as case:  # as the step before left them
        start.set(kept[3] - level)
        before.set(h * kept[4])
    with case.otherwise():
        start.set(value(system, events, record, event, 0, t))
        before.set(h * slope(system, events, event, 0))
    stop = value(system, events, record, event, table.end, t_end)
    after = h * slope(system, events, event, table.end)
    with code.when(integers(events.functions)[FUNCTION * event] != 0):
        # the next step starts there
        kept[2], kept[3], kept[4] = t_end, kept[0], kept[1]
    with code.when(before * after >= 0.0):
        with code.when((before * (stop - start) < 0.0) | (start == stop)):
            code.leave(GO_ON)
        code.leave(cross_piece(system, table, events, record, event, t, h, 0.0, 1.0, start, stop))
    # The function turns within the step, not further away than where its tangents meet.
    side = choose_of(Real, after > 0.0, 1.0, -1.0)
    bound = start + before * (stop - after - start) / (before - after)
    further = larger_of(side * start, side * stop)
    first, last = crossed_levels(events, event, side, bound, side * further)
    with code.when(last < first):
        code.leave(GO_ON)
    with code.when(~prepare_dense(system, table, record, t, h)):
        code.leave(GO_ON)
    middle = turning_point(system, table, events, record, event, t, h, side)
    least = dense_value(system, table, events, record, event, t, h, middle)
    end = cross_piece(system, table, events, record, event, t, h, 0.0, middle, start, least)
    with code.when(end != GO_ON):
        code.leave(end)
    return cross_piece(system, table, events, record, event, t, h, middle, 1.0, least, stop)


@printed
def forget_later(code: Procedure, events: Events, time: Real, forward: Truth) -> None:
    """Drop recorded crossings after a time at which another event ends the integration."""
    first, found, times = integers(events.first), integers(events.found), floats(events.time)
    with code.count(events.events) as event:
        room = first[event + 1] - first[event]
        with code.during(lambda: (found[event] > 0) & (found[event] <= room)):
            latest = times[first[event] + found[event] - 1]
            later = choose(forward, latest > time, ~(latest > time))
            with code.when(~later | (abs(latest - time) <= SAME_TIME * abs(time))):
                code.stop()
            found[event] -= 1


@printed
def watch_step(code: Procedure, context: Whole, t: Real, h: Real, t_end: Real) -> Real:
    """Record all crossings within the accepted step in the workspace.

    Returns the fraction of the step at which the integration ends, with the workspace holding the
    step up to there; or GO_ON, with the workspace as it was, apart from its dense output.
    """
    system = code.fields_at(context, SystemView)
    table = code.fields_at(context, TableView, SYSTEM_WORDS)
    record = code.fields_at(context, Record, SYSTEM_WORDS + TABLE_WORDS)
    events = code.fields_at(context, Events, SYSTEM_WORDS + TABLE_WORDS + RECORD_WORDS)
    counters, part = integers(record.counters), code.variable(GO_ON)
    evaluations = code.variable(counters[EVALUATIONS])
    with code.count(events.events) as event:
        found = watch_event(system, table, events, record, event, t, h, t_end)
        part.set(smaller_of(part, found))
        with code.when(counters[EVALUATIONS] != evaluations):
            counters[EVALUATIONS] += table.end
            evaluations.set(counters[EVALUATIONS])
            try_step(system, t, h, t_end)
    with code.when(part != GO_ON):
        forget_later(events, t + part * h, h > 0.0)
        counters[EVALUATIONS] += table.end
        try_step(system, t, part * h, t + part * h)
    return code.value(part)
