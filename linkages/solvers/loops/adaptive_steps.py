"""Compiled loop of steps whose length follows a tolerance.

Printed code makes them (`linkages.solvers.printed`), until one needs more than arithmetic: that
step is finished here.
"""

from __future__ import annotations

import math

from linkages.solvers.loops.commit import (
    DONE,
    EVENT,
    INTERRUPTED,
    SINGULAR,
    STEP_BUDGET,
    STEP_TOO_SMALL,
    begin,
    commit,
    cut_short,
    margin_outcome,
    outcome_of,
)
from linkages.solvers.printed.control import SHRINK_TURNING
from linkages.solvers.steps.compiled import (
    call_advance,
    call_hook,
    call_step,
    compiled,
    floats,
    integers,
    tuple_at,
)
from linkages.solvers.steps.stages import LOWER, status_of
from linkages.solvers.steps.views import (
    ACCEPTED,
    BEFORE,
    CARRY,
    END,
    ERROR,
    EVALUATIONS,
    FACTOR,
    FIRST,
    FRESH,
    FROM,
    KIND,
    LENGTH,
    NEXT_CARRY,
    NOW,
    PLAIN,
    REJECTED,
    REJECTED_BEFORE,
    REJECTIONS,
    SAMPLE,
    SAMPLES,
    SMALLEST_STEP,
    STATUS,
    STEPS,
    STOP,
    TAKEN,
    TO,
    TROUBLE,
    WORD,
    Control,
    H,
    Hook,
    Record,
    SwitchingView,
    SystemView,
    T,
    TableView,
)
from linkages.solvers.watched.counting import expect_end
from linkages.solvers.watched.margins import check_margins
from linkages.solvers.watched.sampling import take_samples

system_at, table_at, record_at = tuple_at(SystemView), tuple_at(TableView), tuple_at(Record)
hook_at, switching_at, control_at = tuple_at(Hook), tuple_at(SwitchingView), tuple_at(Control)
TABLE = WORD * len(SystemView._fields)
RECORD = TABLE + WORD * len(TableView._fields)
HOOK = RECORD + WORD * len(Record._fields)
SWITCHING = HOOK + WORD * len(Hook._fields)
CONTROL = SWITCHING + WORD * len(SwitchingView._fields)
# A trial that leaves the reach of a block says nothing about how far that block reaches.
SHRINK_BLOCKED = 0.25
# Behind a change of a mode forces may grow like roots (t^1.5 in a contact): errors fall with low
# powers of the step there, whatever the order.
SHRINK_FRESH = 0.1
# An estimate of such an error is small by accident now and then, so no step that is far too long
# must be tried: the first of its kind is so much shorter than smooth equations would allow, and
# later ones are at most twice as long as the last.
CAUTIOUS = 3e-4
# Trials between two looks at whether to stop.
TICKS = 64


@compiled
def set_sample(system: SystemView, record: Record) -> None:
    """Say when the next sample is to be taken."""
    pace, taken = floats(system.pace), integers(record.counters)[SAMPLES]
    never = math.copysign(math.inf, pace[END] - pace[T])
    pace[SAMPLE] = floats(record.time)[taken] if taken < record.samples else never


@compiled
def begin_motion(context: int) -> int:
    """Evaluate a motion at its start, and choose the first step; returns an `Outcome`."""
    system, record = system_at(context), record_at(context + RECORD)
    pace = floats(system.pace)
    if pace[PLAIN] != 0.0 and call_step(control_at(context + CONTROL).start, system.frame) == 0:
        return DONE
    outcome = begin(system, record, pace[T], 0.0)
    if outcome != DONE or pace[T] == pace[END]:
        return outcome
    integers(record.counters)[EVALUATIONS] += 1
    call_step(system.first, system.frame)
    pace[FIRST], pace[BEFORE] = abs(pace[H]), 1.0
    set_sample(system, record)
    return outcome


@compiled
def note_steps(system: SystemView, table: TableView, record: Record) -> None:
    """Count the steps that printed code has made."""
    counters, pace = integers(record.counters), floats(system.pace)
    taken, rejected = int(pace[TAKEN]), int(pace[REJECTIONS])
    counters[STEPS] += taken
    counters[REJECTED] += rejected
    counters[EVALUATIONS] += table.end * (taken + rejected)
    pace[TAKEN] = pace[REJECTIONS] = 0.0
    floats(record.control)[NOW] = pace[T]


@compiled
def change_mode(system: SystemView, record: Record, switching: SwitchingView, finest: float) -> int:
    """Make the change of a mode that was found, and begin anew behind it."""
    pace = floats(system.pace)
    t, left = pace[T], pace[END] - pace[T]
    forward = -1.0 if system.backward != 0 else 1.0
    outcome = int(call_hook(switching.change, switching.context, t, forward, t))
    if outcome == DONE and left != 0.0:
        integers(record.counters)[EVALUATIONS] += 1
        call_step(system.first, system.frame)
        h = pace[H]
        kind = integers(switching.kind)[0]
        last = floats(switching.first_steps)[kind]
        most = 2.0 * last if last > 0.0 else CAUTIOUS * abs(h)
        pace[H] = math.copysign(min(abs(h), max(most, finest)), h)
        pace[BEFORE], pace[FRESH], pace[KIND] = 1.0, 1.0, float(kind)
    return outcome


@compiled
def accept(
    system: SystemView, table: TableView, record: Record, switching: SwitchingView,
    h: float, t_end: float, next_carry: float, factor: float, changing: bool,
) -> int:  # fmt: skip
    """Make the end of the step in the workspace the start of the next one."""
    pace = floats(system.pace)
    expect_end(system, table, record, h)
    commit(system, table, record, t_end)
    outcome = margin_outcome(system, record)
    if pace[FRESH] != 0.0 and not changing and t_end != pace[END]:
        floats(switching.first_steps)[int(pace[KIND])] = abs(h)
    pace[H] = h * (min(factor, 1.0) if pace[REJECTED_BEFORE] != 0.0 else factor)
    finest = SMALLEST_STEP * max(abs(pace[T]), pace[FIRST])
    pace[T], pace[CARRY], pace[BEFORE] = t_end, next_carry, pace[ERROR]
    pace[TROUBLE] = pace[REJECTED_BEFORE] = pace[FRESH] = 0.0
    if changing and outcome == DONE:
        outcome = change_mode(system, record, switching, finest)
    set_sample(system, record)
    return outcome


@compiled
def reject(
    system: SystemView, record: Record, switching: SwitchingView,
    t: float, h: float, t_end: float, factor: float,
) -> int:  # fmt: skip
    """Make the next trial shorter, unless it would be too short."""
    pace = floats(system.pace)
    integers(record.counters)[REJECTED] += 1
    if switching.look != 0:
        if pace[FRESH] != 0.0:
            factor = min(factor, SHRINK_FRESH)
        elif pace[REJECTED_BEFORE] == 0.0:
            # beyond a change forces may bend: errors there say nothing of those before
            part = call_hook(switching.guess, switching.context, t, h, t_end)
            factor = min(factor, max(part, SHRINK_FRESH))
    pace[REJECTED_BEFORE] = 1.0
    pace[H] = h * factor
    if abs(pace[H]) < SMALLEST_STEP * max(abs(t), pace[FIRST]):
        trouble = int(pace[TROUBLE])
        return outcome_of(record, trouble) if trouble != 0 else STEP_TOO_SMALL
    return DONE


@compiled
def conclude_step(context: int) -> int:
    """Finish the trial in the workspace; returns an `Outcome`."""
    system, table, record = (
        system_at(context),
        table_at(context + TABLE),
        record_at(context + RECORD),
    )
    hook, switching = hook_at(context + HOOK), switching_at(context + SWITCHING)
    pace = floats(system.pace)
    t, h, t_end, next_carry = pace[FROM], pace[LENGTH], pace[TO], pace[NEXT_CARRY]
    factor, accepted, changing = pace[FACTOR], pace[ACCEPTED] > 0.0, False
    integers(record.counters)[EVALUATIONS] += table.end
    status = status_of(system, integers(system.pace)[STATUS])
    if accepted and switching.look != 0:
        part = call_hook(switching.look, switching.context, t, h, t_end)
        if part < 0.0 and abs(h) > SMALLEST_STEP * max(abs(t), pace[FIRST]):
            accepted, factor = False, SHRINK_TURNING
        changing = 0.0 <= part <= 1.0
        if 0.0 <= part < 1.0:
            h *= part
            t_end = t + h
            next_carry = (t_end - t) - (h - pace[CARRY])
    if accepted and h != 0.0:
        part = check_margins(system, table, record, t, h, t_end)
        if part < 1.0:
            return cut_short(system, table, record, t, h, part, SINGULAR)
        if hook.function != 0:
            part = call_hook(hook.function, hook.context, t, h, t_end)
            if part <= 1.0:
                return cut_short(system, table, record, t, h, part, EVENT)
        status = take_samples(system, table, record, t, h, t_end, 0.0)
    if status != 0:
        # A sample that cannot be evaluated belongs to a step that should not be made.
        pace[TROUBLE] = float(status)
        return reject(system, record, switching, t, h, t_end, SHRINK_BLOCKED)
    if accepted:
        return accept(system, table, record, switching, h, t_end, next_carry, factor, changing)
    return reject(system, record, switching, t, h, t_end, factor)


@compiled
def go_on(context: int, conclude: int) -> int:
    """Make some steps, unless the motion is to stop; returns an `Outcome`."""
    system, table, record = (
        system_at(context),
        table_at(context + TABLE),
        record_at(context + RECORD),
    )
    control, counters = control_at(context + CONTROL), integers(record.counters)
    if floats(record.control)[STOP] != 0.0:
        return INTERRUPTED
    left = control.budget - counters[STEPS] - counters[REJECTED]
    if left <= 0:
        return STEP_BUDGET
    found = call_advance(control.advance, system.frame, min(left, TICKS))
    note_steps(system, table, record)
    if found & LOWER == 0:
        return DONE
    return call_step(conclude, context)


@compiled
def adaptive_steps(context: int, flagged: int, begin: int, conclude: int) -> int:
    """Integrate a motion with an error estimate kept at a tolerance; returns an `Outcome`.

    `context` is the address of a `SystemView`, `TableView`, `Record`, `Hook`, `SwitchingView` and
    `Control` in a row; `flagged` is 1 where printed code has gone on up to a step that is to be
    finished, and 0 at the start. `begin` and `conclude` are addresses of the functions above: lanes
    call the same machine code. Row 0 holds the state, in the end the final one; its time is
    ``control[NOW]``.
    """
    pace = floats(system_at(context).pace)
    outcome = call_step(begin if flagged == 0 else conclude, context)
    while outcome == DONE and pace[T] != pace[END]:
        outcome = go_on(context, conclude)
    return outcome
