"""Find where within an accepted step a mode changes; compiled by the first run that has modes.

The functions of all switches and their rates are written by the kernel with every stage. Those at
both ends of a step say whether one crosses zero within, or dips below it and comes back. The step
itself, repeated in part, then gives the time: cubics through values and rates at both ends of what
is left converge so fast that no dense output is needed.
"""

from __future__ import annotations

from linkages.solvers.printed.modes import BELOW, FAR, ROUND_OFF, UNLIKE
from linkages.solvers.steps.compiled import compiled, floats, integers, tuple_at
from linkages.solvers.steps.stages import address_of, try_step
from linkages.solvers.steps.views import (
    EVALUATIONS,
    WORD,
    Record,
    SwitchesView,
    SystemView,
    TableView,
)

system_at, table_at = tuple_at(SystemView), tuple_at(TableView)
record_at, switches_at = tuple_at(Record), tuple_at(SwitchesView)
SYSTEM_WORDS, TABLE_WORDS = len(SystemView._fields), len(TableView._fields)
RECORD_WORDS = len(Record._fields)
# What `look` returns where no mode changes.
GO_ON = 2.0
# Of the length of a step: as near to the change as times can be told apart.
EXACT = 1e-14
# Repetitions of a step: far more than cubics need, enough to halve it down to its last digit.
SEARCHES, DIPS = 60, 8
# Where a rejected step is repeated up to a change, so that it lies within.
BEHIND = 1.001
# How often a step is halved to see what functions do: more is round-off.
HALVINGS = 8


@compiled
def functions_of(system: SystemView, modes: int, row: int) -> int:
    """Address of the functions of all switches in a row; their rates follow."""
    return address_of(system, row) + WORD * (system.width - 2 * modes)


@compiled
def seen(system: SystemView, modes: int, row: int, switch: int) -> tuple[float, float]:
    """Function of a switch and its rate, not negative as long as its mode is right."""
    mode, found = floats(system.held)[switch], floats(functions_of(system, modes, row))
    if mode == 0.0:  # it sticks
        mode = 1.0
    return mode * found[switch], mode * found[modes + switch]


@compiled
def first_zero(start: float, rise: float, end: float, fall: float) -> float:
    """Where on [0, 1] the cubic with these values and rates at 0 and 1 becomes negative.

    The place 0 itself counts as positive.
    """
    change = end - start
    c2, c3 = 3.0 * change - 2.0 * rise - fall, rise + fall - 2.0 * change
    low, high = 0.0, 1.0
    for _ in range(50):
        x = 0.5 * (low + high)
        if start + x * (rise + x * (c2 + x * c3)) > 0.0:
            low = x
        else:
            high = x
    return 0.5 * (low + high)


@compiled
def least_place(start: float, rise: float, end: float, fall: float) -> float:
    """Where on [0, 1] such a cubic, which falls at 0 and rises at 1, is least."""
    change = end - start
    c2, c3 = 3.0 * change - 2.0 * rise - fall, rise + fall - 2.0 * change
    low, high = 0.0, 1.0
    for _ in range(30):
        x = 0.5 * (low + high)
        if rise + x * (2.0 * c2 + x * 3.0 * c3) < 0.0:
            low = x
        else:
            high = x
    return 0.5 * (low + high)


@compiled
def try_part(
    system: SystemView, table: TableView, record: Record, t: float, h: float, part: float
) -> bool:
    """Repeat a step in part; whether that is possible."""
    integers(record.counters)[EVALUATIONS] += table.end
    return try_step(system, t, part * h, t + part * h) == 0


@compiled
def locate(
    system: SystemView,
    table: TableView,
    record: Record,
    modes: int,
    switch: int,
    t: float,
    h: float,
    part: float,
) -> float:
    """Fraction of a step at which a function crosses zero, which is negative at `part` of it.

    The workspace is left with the step up to there.
    """
    low, high = 0.0, part
    start, rise = seen(system, modes, 0, switch)
    end, fall = seen(system, modes, table.end, switch)
    rise, fall = rise * h, fall * h
    if start <= 0.0 and rise <= 0.0:  # as a run begins that ended here
        try_part(system, table, record, t, h, 0.0)
        return 0.0
    width, theta, last = high - low, high, abs(end)
    for search in range(SEARCHES):
        theta = low + width * first_zero(start, width * rise, end, width * fall)
        if search % 4 == 3:  # in case that cubics say nothing
            theta = 0.5 * (low + high)
        if not try_part(system, table, record, t, h, theta):
            high = theta
            width = high - low
            continue
        here, rate = seen(system, modes, table.end, switch)
        rate *= h
        if here == 0.0 or abs(here) <= EXACT * abs(rate):
            break
        if here > 0.0:
            low, start, rise = theta, here, rate
        else:
            high, end, fall = theta, here, rate
        width = high - low
        # where the function is round-off alone it ceases to shrink
        if width < EXACT or (abs(here) >= 0.5 * last and abs(here) < ROUND_OFF * abs(rate)):
            break
        last = abs(here)
    return theta


@compiled
def crossing(
    system: SystemView,
    table: TableView,
    record: Record,
    modes: int,
    switch: int,
    t: float,
    h: float,
    part: float,
) -> float:
    """Fraction of a step at which a mode changes before `part` of it, which is in the workspace.

    If there is one the workspace is left with the step up to there, otherwise with any.
    """
    start, rise = seen(system, modes, 0, switch)
    end, fall = seen(system, modes, table.end, switch)
    rise, fall = rise * h, fall * h
    # where another change makes the step short, what began it is a round-off below zero
    slack = max(ROUND_OFF * rise, -2.0 * start)
    if end < 0.0:
        if rise > 0.0 and fall > 0.0 and start < slack and -end < slack:
            return GO_ON
        return locate(system, table, record, modes, switch, t, h, part)
    if start > 0.0 and rise < 0.0 and fall > 0.0:
        low, high = 0.0, part
        for _ in range(DIPS):
            width = high - low
            # it falls no deeper than where the tangents meet
            if start + rise * (end - width * fall - start) / (rise - fall) >= 0.0:
                return GO_ON
            theta = low + width * least_place(start, width * rise, end, width * fall)
            if not try_part(system, table, record, t, h, theta):
                return GO_ON
            here, rate = seen(system, modes, table.end, switch)
            if here < 0.0:
                return locate(system, table, record, modes, switch, t, h, theta)
            if rate * h < 0.0:
                low, start, rise = theta, here, rate * h
            else:
                high, end, fall = theta, here, rate * h
        return GO_ON
    least = -max(slack, BELOW * (abs(start) + end))
    for row in range(1, table.end):
        here, _ = seen(system, modes, row, switch)
        if here < least:
            theta = floats(table.c)[row] * part
            if not 0.0 < theta < part or not try_part(system, table, record, t, h, theta):
                return GO_ON
            here, _ = seen(system, modes, table.end, switch)
            if here < 0.0:
                return locate(system, table, record, modes, switch, t, h, theta)
            return GO_ON
    return GO_ON


@compiled
def unresolved(
    system: SystemView, table: TableView, switches: SwitchesView, switch: int, h: float
) -> bool:
    """Whether a function varies so much within a step that its ends do not say if it crosses zero.

    At stages it is then far from the cubic through both ends, beside its own variation.
    """
    start, rise = seen(system, switches.modes, 0, switch)
    end, fall = seen(system, switches.modes, table.end, switch)
    rise, fall, change = h * rise, h * fall, end - start
    c2, c3 = 3.0 * change - 2.0 * rise - fall, rise + fall - 2.0 * change
    low, high, apart = min(start, end), max(start, end), 0.0
    for k in range(switches.compared):
        row = integers(switches.rows)[k]
        x = floats(table.c)[row]
        here, _ = seen(system, switches.modes, row, switch)
        apart = max(apart, abs(here - (start + x * (rise + x * (c2 + x * c3)))))
        low, high = min(low, here), max(high, here)
    return apart > UNLIKE * (high - low) and low < FAR * apart


@compiled
def look(context: int, t: float, h: float, t_end: float) -> float:
    """Find the first change of a mode within the accepted step in the workspace.

    Returns the fraction of the step, with the workspace holding the step up to there; or GO_ON,
    with the workspace as it was; or a number below zero where the step is too long to say.
    """
    system = system_at(context)
    table = table_at(context + WORD * SYSTEM_WORDS)
    record = record_at(context + WORD * (SYSTEM_WORDS + TABLE_WORDS))
    switches = switches_at(context + WORD * (SYSTEM_WORDS + TABLE_WORDS + RECORD_WORDS))
    active, held = integers(switches.active), floats(system.held)
    evaluations, halved = integers(record.counters), integers(switches.halved)
    if halved[0] < HALVINGS:
        for switch in range(switches.modes):
            watched = active[switch] < 0 or held[active[switch]] > 0.0
            if watched and unresolved(system, table, switches, switch, h):
                halved[0] += 1
                return -1.0
    halved[0] = 0
    part, last, switch = 1.0, -1, 0
    while switch < switches.modes:
        watched = active[switch] < 0 or held[active[switch]] > 0.0
        if watched and switch != last:
            before = evaluations[EVALUATIONS]
            found = crossing(system, table, record, switches.modes, switch, t, h, part)
            # another one may come before it; one at the same time follows with the next step
            if found <= part if last < 0 else found < (1.0 - EXACT) * part:
                part, last, switch = found, switch, 0
                continue
            if evaluations[EVALUATIONS] != before:
                evaluations[EVALUATIONS] += table.end
                try_step(system, t, part * h, t_end if last < 0 else t + part * h)
        switch += 1
    if last < 0:
        return GO_ON
    integers(switches.pending)[0] = last
    return part


@compiled
def guess(context: int, t: float, h: float, t_end: float) -> float:  # noqa: ARG001
    """About at which fraction of the rejected step in the workspace the first mode changes.

    A little behind it; more than 1 where none does.
    """
    system = system_at(context)
    table = table_at(context + WORD * SYSTEM_WORDS)
    switches = switches_at(context + WORD * (SYSTEM_WORDS + TABLE_WORDS + RECORD_WORDS))
    active, held = integers(switches.active), floats(system.held)
    part = GO_ON
    for switch in range(switches.modes):
        if active[switch] < 0 or held[active[switch]] > 0.0:
            start, rise = seen(system, switches.modes, 0, switch)
            end, fall = seen(system, switches.modes, table.end, switch)
            if start > 0.0 and end < 0.0:
                part = min(part, BEHIND * first_zero(start, h * rise, end, h * fall))
    return part
