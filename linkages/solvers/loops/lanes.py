"""Many motions side by side: a lane takes the next motion when its own has ended.

Printed code makes the steps of all lanes together. A step that needs more than arithmetic is taken
out of its lane and finished by the functions of `adaptive_steps`, as if its motion were alone; the
bits of a motion therefore depend on nothing but the motion.
"""

from __future__ import annotations

from typing import Any

from linkages.kernel.code.operands import (
    Truth,
    Whole,
    choose,
    choose_of,
    floats,
    integers,
    smaller_of,
)
from linkages.kernel.code.printed import printed
from linkages.kernel.code.procedure import Procedure
from linkages.solvers.loops.adaptive_steps import (
    TICKS,
    control_at,
    note_steps,
    record_at,
    system_at,
    table_at,
)
from linkages.solvers.loops.commit import DONE, INTERRUPTED, STEP_BUDGET
from linkages.solvers.steps.stages import HALF, LOWER, call_step
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


@printed
def spread(
    code: Procedure, source: Whole, target: Whole, count: Whole, lane: Whole, lanes: Whole
) -> None:
    """Copy numbers of a motion into a lane."""
    numbers, rows = integers(source), integers(target + WORD * lane)
    with code.count(count) as k:
        rows[k * lanes] = numbers[k]


@printed
def collect(
    code: Procedure, source: Whole, target: Whole, count: Whole, lane: Whole, lanes: Whole
) -> None:
    """Copy numbers of a lane into those of its motion."""
    rows, numbers = integers(source + WORD * lane), integers(target)
    with code.count(count) as k:
        numbers[k] = rows[k * lanes]


@printed
def put_functions(code: Procedure, lanes: Lanes, lane: Whole, system: SystemView) -> None:
    """Put the parameters of what events watch into a lane."""
    own = integers(integers(system.frame)[FUNCTIONS])
    with code.count(lanes.events) as event:
        place = FUNCTION * event + 2
        size = integers(lanes.function_sizes)[event]
        spread(own[place], integers(lanes.functions)[place], size, lane, lanes.lanes)


@printed
def put(code: Procedure, lanes: Lanes, lane: Whole, system: SystemView) -> None:
    """Put what changes of a motion on its way into a lane."""
    held = lanes.size - system.holding
    place = lanes.parameters + WORD * held * lanes.lanes
    spread(system.held, place, system.holding, lane, lanes.lanes)
    spread(system.rows, lanes.rows, system.width, lane, lanes.lanes)
    spread(system.pace, lanes.pace, PACE, lane, lanes.lanes)
    frame = integers(system.frame)
    spread(frame[TURNS], lanes.turns, system.n, lane, lanes.lanes)
    spread(frame[ANGLES], lanes.angles, system.counted, lane, lanes.lanes)
    spread(frame[EVENT_VALUES], lanes.values, VALUES * lanes.events, lane, lanes.lanes)
    with code.when(system.holding > 0):
        put_functions(lanes, lane, system)


@printed
def enter(_code: Procedure, lanes: Lanes, lane: Whole, system: SystemView, atol: Whole) -> None:
    """Put a motion that has begun into a lane, with all of its numbers."""
    spread(system.parameters, lanes.parameters, lanes.size, lane, lanes.lanes)
    spread(atol, lanes.atol, 2 * system.n, lane, lanes.lanes)
    spread(system.margin_scale, lanes.scale, system.blocks, lane, lanes.lanes)
    spread(system.smallest_margins, lanes.smallest, system.blocks, lane, lanes.lanes)
    spread(integers(system.frame)[LEVELS], lanes.levels, lanes.events, lane, lanes.lanes)
    put_functions(lanes, lane, system)
    put(lanes, lane, system)


def motion_in(lanes: Any, lane: Whole) -> Any:
    """Address of the context of the motion in a lane."""
    return integers(lanes.motions)[integers(lanes.places)[lane]]


@printed
def take_out(_code: Procedure, lanes: Lanes, lane: Whole, rows: Whole) -> None:
    """Give a motion what its lane has made, with some rows of the workspace."""
    system, table, record = parts_of(motion_in(lanes, lane))
    collect(lanes.rows, system.rows, rows * system.width, lane, lanes.lanes)
    collect(lanes.pace, system.pace, PACE, lane, lanes.lanes)
    collect(lanes.turns, record.final_turns, system.n, lane, lanes.lanes)
    collect(lanes.angles, record.angles, system.counted, lane, lanes.lanes)
    values = integers(system.frame)[EVENT_VALUES]
    collect(lanes.values, values, VALUES * lanes.events, lane, lanes.lanes)
    note_steps(system, table, record)


def parts_of(context: Whole) -> tuple[Any, Any, Any]:
    """System, tableau and record of a motion that is not an argument."""
    return system_at(context, False), table_at(context, False), record_at(context, False)


@printed
def leave(_code: Procedure, lanes: Lanes, lane: Whole, outcome: Whole) -> None:
    """End the motion of a lane."""
    integers(lanes.outcomes)[integers(lanes.places)[lane]] = outcome
    floats(lanes.control)[NOW] += 1.0
    integers(lanes.places)[lane] = NOBODY
    floats(lanes.pace)[ACTIVE * lanes.lanes + lane] = 0.0


@printed
def refill(code: Procedure, lanes: Lanes, lane: Whole, first: Whole) -> Whole:
    """Begin the next motion in a lane; returns the number of the one behind it.

    A motion that has ended already leaves its numbers behind: a lane that nobody uses goes on with
    some that the kernel can be evaluated for.
    """
    following, places = code.variable(first), integers(lanes.places)
    with code.during(lambda: (following < lanes.number) & (places[lane] == NOBODY)):
        context = integers(lanes.motions)[following]
        places[lane] = following
        following.set(following + 1)
        outcome = call_step(code, lanes.begin, context)
        system = system_at(context, False)
        pace = floats(system.pace)
        enter(lanes, lane, system, control_at(context, False).atol)
        with code.when((outcome != DONE) | (pace[T] == pace[END])):
            leave(lanes, lane, outcome)
    return code.value(following)


@printed
def park(_code: Procedure, lanes: Lanes, lane: Whole) -> None:
    """Give a lane that has nothing to do the numbers of the first motion."""
    context = integers(lanes.motions)[0]
    system = system_at(context, False)
    enter(lanes, lane, system, control_at(context, False).atol)
    floats(lanes.pace)[ACTIVE * lanes.lanes + lane] = 0.0


@printed
def conclude(code: Procedure, lanes: Lanes, lane: Whole) -> None:
    """Finish a step that needs more than arithmetic."""
    context = motion_in(lanes, lane)
    system, table, _ = parts_of(context)
    pace, status = floats(system.pace), integers(system.pace)
    floats(lanes.control)[ALONE] += 1.0
    take_out(lanes, lane, table.end + 1)
    with code.when(status[STATUS] != 0):  # which a motion alone knows better
        status[STATUS] = call_step(code, system.attempt, system.frame)
    outcome = call_step(code, lanes.conclude, context)
    put(lanes, lane, system)
    with code.when((outcome != DONE) | (pace[T] == pace[END])):
        leave(lanes, lane, outcome)


@printed
def trials_left(_code: Procedure, lanes: Lanes, lane: Whole) -> Whole:
    """Number of trials that the motion of a lane may still make."""
    context = motion_in(lanes, lane)
    counters = integers(record_at(context, False).counters)
    pace = floats(lanes.pace + WORD * lane)
    made = pace[TAKEN * lanes.lanes] + pace[REJECTIONS * lanes.lanes]
    budget = control_at(context, False).budget
    return budget - counters[STEPS] - counters[REJECTED] - made.whole


@printed
def end_where_due(code: Procedure, lanes: Lanes, stop: Truth) -> Whole:
    """End motions that may not go on; returns how many trials the others may make, 0 for none."""
    ticks = code.variable(0)
    with code.count(lanes.lanes) as lane, code.when(integers(lanes.places)[lane] != NOBODY):
        left = trials_left(lanes, lane)
        with code.when(stop | (left <= 0)) as case:
            take_out(lanes, lane, 1)
            leave(lanes, lane, choose_of(Whole, stop, INTERRUPTED, STEP_BUDGET))
        with case.otherwise():
            most = choose(ticks > 0, ticks, TICKS)
            ticks.set(smaller_of(left, most))
    return code.value(ticks)


@printed
def advance_lanes(code: Procedure, lanes: Lanes) -> Whole:
    """Integrate all motions; writes their outcomes. Returns the number of trials of all lanes.

    After a stop, motions that have not begun keep the outcome that stands there.
    """
    following, spent, running = code.variable(0), code.variable(0), code.variable(True)
    with code.count(lanes.lanes) as lane:
        following.set(refill(lanes, lane, following))
        with code.when(integers(lanes.places)[lane] == NOBODY):
            park(lanes, lane)
    with code.during(lambda: running):
        stop = floats(lanes.control)[STOP] != 0.0
        ticks, flagged = end_where_due(lanes, stop), code.variable(0)
        with code.when(stop):
            code.leave(spent)
        with code.when(ticks > 0):
            found = code.call_at(lanes.advance, Whole, lanes.frame, ticks)
            spent.set(spent + lanes.lanes * (found >> HALF))
            flagged.set(found & LOWER)
        running.set(False)
        with code.count(lanes.lanes) as lane:
            with code.when((flagged >> lane) & 1 != 0):
                conclude(lanes, lane)
            with code.when(integers(lanes.places)[lane] == NOBODY):
                following.set(refill(lanes, lane, following))
            running.set(running | (integers(lanes.places)[lane] != NOBODY))
    return code.value(spent)
