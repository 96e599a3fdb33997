"""Find where events happen within an accepted step; compiled by the first run that has events.

The loops of all methods call `watch_step` through its address, so that runs without events
neither compile it nor pay for it.
"""

from __future__ import annotations

import math

from linkages.solvers.printed.crossings import SLACK
from linkages.solvers.steps.compiled import compiled, floats, inlined, integers, tuple_at
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

system_at, table_at = tuple_at(SystemView), tuple_at(TableView)
record_at, events_at = tuple_at(Record), tuple_at(Events)
SYSTEM_WORDS, TABLE_WORDS = len(SystemView._fields), len(TableView._fields)
RECORD_WORDS = len(Record._fields)
# What `watch_step` returns where the integration goes on.
GO_ON = 2.0
# Two units in the last place: t + θh may be rounded once or twice, as the compiler fuses it or not.
SAME_TIME = 4.5e-16


@compiled
def note(
    system: SystemView,
    table: TableView,
    events: Events,
    record: Record,
    event: int,
    time: float,
    h: float,
) -> None:
    """Record a crossing with the state at the end of the step of length h in the workspace."""
    n, found = system.n, integers(events.found)
    first = integers(events.first)
    place = first[event] + found[event]
    found[event] += 1
    if place >= first[event + 1]:
        return
    source, state = floats(address_of(system, table.end)), events.state + WORD * place * 2 * n
    floats(events.time)[place] = time
    for i in range(2 * n):
        floats(state)[i] = source[i]
    wrap_angles(system, state, record.final_turns, events.turns + WORD * place * n)
    for i in range(system.holding):
        floats(events.held)[place * system.holding + i] = floats(system.held)[i]
    if system.counted > 0:
        expect_end(system, table, record, h)
        angles = events.angles + WORD * place * system.counted
        for i in range(system.counted):
            floats(angles)[i] = counted_angle(system, record, table.end, i)


@compiled
def crossed_levels(
    events: Events, event: int, side: float, start: float, stop: float
) -> tuple[int, int]:
    """First and last number of the levels that are crossed upward (side 1) or downward."""
    period = floats(events.period)[event]
    slack = SLACK * max(1.0, abs(floats(events.level)[event]))
    start, stop = side * start + slack, side * stop + slack
    if period == 0.0:
        return 0, (0 if start < 0.0 <= stop else -1)
    return math.floor(start / period) + 1, math.floor(stop / period)


@compiled
def cross_piece(
    system: SystemView,
    table: TableView,
    events: Events,
    record: Record,
    event: int,
    t: float,
    h: float,
    low: float,
    high: float,
    start: float,
    stop: float,
) -> float:
    """Record the crossings of a piece of a step on which the function rises or falls.

    Returns the fraction of a crossing that ends the integration, or GO_ON.
    """
    side = 1.0 if stop > start else -1.0
    if side * integers(events.direction)[event] < 0.0:
        return GO_ON
    first, last = crossed_levels(events, event, side, start, stop)
    for number in range(first, last + 1):
        target = side * number * floats(events.period)[event]
        theta = low + (high - low) * (target - start) / (stop - start)
        if prepare_dense(system, table, record, t, h):
            theta = search(system, table, events, record, event, t, h, low, high, target)
        theta = polish(system, table, events, record, event, t, h, theta, low, high, target)
        note(system, table, events, record, event, t + theta * h, theta * h)
        if integers(events.found)[event] == integers(events.terminal)[event]:
            return theta
    return GO_ON


@inlined
def at_start(
    system: SystemView, events: Events, record: Record, event: int, t: float
) -> tuple[float, float]:
    """Function of an event, less its level, and its rate at the start of a step."""
    kept = floats(events.values + WORD * VALUES * event)
    if kept[2] == t:  # as the step before left them
        return kept[3] - floats(events.level)[event], kept[4]
    start = value(system, events, record, event, 0, t)
    return start, slope(system, events, event, 0)


@inlined
def remember(events: Events, event: int, t: float) -> None:
    """Keep what a function has at the end of a step: the next one starts there."""
    if integers(events.functions)[FUNCTION * event] != 0:
        kept = floats(events.values + WORD * VALUES * event)
        kept[2], kept[3], kept[4] = t, kept[0], kept[1]


@inlined
def watch_event(
    system: SystemView,
    table: TableView,
    events: Events,
    record: Record,
    event: int,
    t: float,
    h: float,
    t_end: float,
) -> float:
    """Record the crossings of one event within a step; see `cross_piece`."""
    start, before = at_start(system, events, record, event, t)
    before *= h
    stop = value(system, events, record, event, table.end, t_end)
    after = h * slope(system, events, event, table.end)
    remember(events, event, t_end)
    if before * after >= 0.0:
        if before * (stop - start) < 0.0 or start == stop:
            return GO_ON
        return cross_piece(system, table, events, record, event, t, h, 0.0, 1.0, start, stop)
    # The function turns within the step, not further away than where its tangents meet.
    side = 1.0 if after > 0.0 else -1.0
    bound = start + before * (stop - after - start) / (before - after)
    first, last = crossed_levels(events, event, side, bound, side * max(side * start, side * stop))
    if last < first or not prepare_dense(system, table, record, t, h):
        return GO_ON
    middle = turning_point(system, table, events, record, event, t, h, side)
    least = dense_value(system, table, events, record, event, t, h, middle)
    end = cross_piece(system, table, events, record, event, t, h, 0.0, middle, start, least)
    if end != GO_ON:
        return end
    return cross_piece(system, table, events, record, event, t, h, middle, 1.0, least, stop)


@compiled
def forget_later(events: Events, time: float, forward: bool) -> None:
    """Drop recorded crossings after a time at which another event ends the integration."""
    first, found, times = integers(events.first), integers(events.found), floats(events.time)
    for event in range(events.events):
        while 0 < found[event] <= first[event + 1] - first[event]:
            latest = times[first[event] + found[event] - 1]
            if (latest > time) != forward or abs(latest - time) <= SAME_TIME * abs(time):
                break
            found[event] -= 1


@compiled
def watch_step(context: int, t: float, h: float, t_end: float) -> float:
    """Record all crossings within the accepted step in the workspace.

    Returns the fraction of the step at which the integration ends, with the workspace holding the
    step up to there; or GO_ON, with the workspace as it was, apart from its dense output.
    """
    system = system_at(context)
    table = table_at(context + WORD * SYSTEM_WORDS)
    record = record_at(context + WORD * (SYSTEM_WORDS + TABLE_WORDS))
    events = events_at(context + WORD * (SYSTEM_WORDS + TABLE_WORDS + RECORD_WORDS))
    evaluations = integers(record.counters)[EVALUATIONS]
    part = GO_ON
    for event in range(events.events):
        part = min(part, watch_event(system, table, events, record, event, t, h, t_end))
        if integers(record.counters)[EVALUATIONS] != evaluations:
            integers(record.counters)[EVALUATIONS] += table.end
            evaluations = integers(record.counters)[EVALUATIONS]
            try_step(system, t, h, t_end)
    if part != GO_ON:
        forget_later(events, t + part * h, h > 0.0)
        integers(record.counters)[EVALUATIONS] += table.end
        try_step(system, t, part * h, t + part * h)
    return part
