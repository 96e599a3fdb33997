"""Many motions side by side: a lane takes the next motion when its own has ended.

Printed code makes the steps of all lanes together. A step that needs more than arithmetic is taken
out of its lane and finished by the functions of `adaptive_steps`, as if its motion were alone; the
bits of a motion therefore depend on nothing but the motion.
"""

from __future__ import annotations

from linkages.solvers.loops.adaptive_steps import (
    CONTROL,
    RECORD,
    TABLE,
    TICKS,
    control_at,
    note_steps,
    record_at,
    system_at,
    table_at,
)
from linkages.solvers.loops.commit import DONE, INTERRUPTED, STEP_BUDGET
from linkages.solvers.steps.compiled import call_advance, call_step, compiled, floats, integers
from linkages.solvers.steps.stages import HALF, LOWER
from linkages.solvers.steps.views import (
    ACTIVE,
    ALONE,
    ANGLES,
    END,
    EVENT_VALUES,
    FUNCTION,
    FUNCTIONS,
    LEVELS,
    NOW,
    PACE,
    REJECTED,
    REJECTIONS,
    STATUS,
    STEPS,
    STOP,
    TAKEN,
    TURNS,
    VALUES,
    WORD,
    Lanes,
    SystemView,
    T,
)

NOBODY = -1


@compiled
def spread(source: int, target: int, count: int, lane: int, lanes: int) -> None:
    """Copy numbers of a motion into a lane."""
    numbers, rows = integers(source), integers(target + WORD * lane)
    for k in range(count):
        rows[k * lanes] = numbers[k]


@compiled
def collect(source: int, target: int, count: int, lane: int, lanes: int) -> None:
    """Copy numbers of a lane into those of its motion."""
    rows, numbers = integers(source + WORD * lane), integers(target)
    for k in range(count):
        numbers[k] = rows[k * lanes]


@compiled
def put_functions(lanes: Lanes, lane: int, system: SystemView) -> None:
    """Put the parameters of what events watch into a lane."""
    own = integers(integers(system.frame)[FUNCTIONS])
    for event in range(lanes.events):
        place = FUNCTION * event + 2
        size = integers(lanes.function_sizes)[event]
        spread(own[place], integers(lanes.functions)[place], size, lane, lanes.lanes)


@compiled
def put(lanes: Lanes, lane: int, system: SystemView) -> None:
    """Put what changes of a motion on its way into a lane."""
    held = lanes.size - system.holding
    place = lanes.parameters + WORD * held * lanes.lanes
    spread(system.held, place, system.holding, lane, lanes.lanes)
    spread(system.rows, lanes.rows, system.width, lane, lanes.lanes)
    spread(system.pace, lanes.pace, PACE, lane, lanes.lanes)
    spread(integers(system.frame)[TURNS], lanes.turns, system.n, lane, lanes.lanes)
    spread(integers(system.frame)[ANGLES], lanes.angles, system.counted, lane, lanes.lanes)
    spread(
        integers(system.frame)[EVENT_VALUES], lanes.values, VALUES * lanes.events, lane, lanes.lanes
    )
    if system.holding > 0:
        put_functions(lanes, lane, system)


@compiled
def enter(lanes: Lanes, lane: int, system: SystemView, atol: int) -> None:
    """Put a motion that has begun into a lane, with all of its numbers."""
    spread(system.parameters, lanes.parameters, lanes.size, lane, lanes.lanes)
    spread(atol, lanes.atol, 2 * system.n, lane, lanes.lanes)
    spread(system.margin_scale, lanes.scale, system.blocks, lane, lanes.lanes)
    spread(system.smallest_margins, lanes.smallest, system.blocks, lane, lanes.lanes)
    spread(integers(system.frame)[LEVELS], lanes.levels, lanes.events, lane, lanes.lanes)
    put_functions(lanes, lane, system)
    put(lanes, lane, system)


@compiled
def take_out(lanes: Lanes, lane: int, rows: int) -> None:
    """Give a motion what its lane has made, with some rows of the workspace."""
    context = integers(lanes.motions)[integers(lanes.places)[lane]]
    system, record = system_at(context), record_at(context + RECORD)
    collect(lanes.rows, system.rows, rows * system.width, lane, lanes.lanes)
    collect(lanes.pace, system.pace, PACE, lane, lanes.lanes)
    collect(lanes.turns, record.final_turns, system.n, lane, lanes.lanes)
    collect(lanes.angles, record.angles, system.counted, lane, lanes.lanes)
    values = integers(system.frame)[EVENT_VALUES]
    collect(lanes.values, values, VALUES * lanes.events, lane, lanes.lanes)
    note_steps(system, table_at(context + TABLE), record)


@compiled
def leave(lanes: Lanes, lane: int, outcome: int) -> None:
    """End the motion of a lane."""
    integers(lanes.outcomes)[integers(lanes.places)[lane]] = outcome
    floats(lanes.control)[NOW] += 1.0
    integers(lanes.places)[lane] = NOBODY
    floats(lanes.pace)[ACTIVE * lanes.lanes + lane] = 0.0


@compiled
def refill(lanes: Lanes, lane: int, following: int) -> int:
    """Begin the next motion in a lane; returns the number of the one behind it.

    A motion that has ended already leaves its numbers behind: a lane that nobody uses goes on with
    some that the kernel can be evaluated for.
    """
    while following < lanes.number and integers(lanes.places)[lane] == NOBODY:
        context = integers(lanes.motions)[following]
        system, control = system_at(context), control_at(context + CONTROL)
        integers(lanes.places)[lane] = following
        following += 1
        outcome = call_step(lanes.begin, context)
        enter(lanes, lane, system, control.atol)
        if outcome != DONE or floats(system.pace)[T] == floats(system.pace)[END]:
            leave(lanes, lane, outcome)
    return following


@compiled
def park(lanes: Lanes, lane: int) -> None:
    """Give a lane that has nothing to do the numbers of the first motion."""
    context = integers(lanes.motions)[0]
    enter(lanes, lane, system_at(context), control_at(context + CONTROL).atol)
    floats(lanes.pace)[ACTIVE * lanes.lanes + lane] = 0.0


@compiled
def conclude(lanes: Lanes, lane: int) -> None:
    """Finish a step that needs more than arithmetic."""
    context = integers(lanes.motions)[integers(lanes.places)[lane]]
    system, pace = system_at(context), floats(system_at(context).pace)
    floats(lanes.control)[ALONE] += 1.0
    take_out(lanes, lane, table_at(context + TABLE).end + 1)
    if integers(system.pace)[STATUS] != 0:  # which a motion alone knows better
        integers(system.pace)[STATUS] = call_step(system.attempt, system.frame)
    outcome = call_step(lanes.conclude, context)
    put(lanes, lane, system)
    if outcome != DONE or pace[T] == pace[END]:
        leave(lanes, lane, outcome)


@compiled
def trials_left(lanes: Lanes, lane: int) -> int:
    """Number of trials that the motion of a lane may still make."""
    context = integers(lanes.motions)[integers(lanes.places)[lane]]
    counters = integers(record_at(context + RECORD).counters)
    pace = floats(lanes.pace + WORD * lane)
    made = pace[TAKEN * lanes.lanes] + pace[REJECTIONS * lanes.lanes]
    budget = control_at(context + CONTROL).budget
    return budget - counters[STEPS] - counters[REJECTED] - int(made)


@compiled
def end_where_due(lanes: Lanes, stop: bool) -> int:
    """End motions that may not go on; returns how many trials the others may make, 0 for none."""
    ticks = 0
    for lane in range(lanes.lanes):
        if integers(lanes.places)[lane] == NOBODY:
            continue
        left = trials_left(lanes, lane)
        if stop or left <= 0:
            take_out(lanes, lane, 1)
            leave(lanes, lane, INTERRUPTED if stop else STEP_BUDGET)
        else:
            ticks = min(left, ticks) if ticks > 0 else min(left, TICKS)
    return ticks


@compiled
def advance_lanes(lanes: Lanes) -> int:
    """Integrate all motions; writes their outcomes. Returns the number of trials of all lanes.

    After a stop, motions that have not begun keep the outcome that stands there.
    """
    following, spent, running = 0, 0, True
    for lane in range(lanes.lanes):
        following = refill(lanes, lane, following)
        if integers(lanes.places)[lane] == NOBODY:
            park(lanes, lane)
    while running:
        stop = floats(lanes.control)[STOP] != 0.0
        ticks, flagged = end_where_due(lanes, stop), 0
        if stop:
            return spent
        if ticks > 0:
            found = call_advance(lanes.advance, lanes.frame, ticks)
            spent += lanes.lanes * (found >> HALF)
            flagged = found & LOWER
        running = False
        for lane in range(lanes.lanes):
            if (flagged >> lane) & 1:
                conclude(lanes, lane)
            if integers(lanes.places)[lane] == NOBODY:
                following = refill(lanes, lane, following)
            running = running or integers(lanes.places)[lane] != NOBODY
    return spent
