"""Batch integration in lanes: a lane takes the next motion when its own has ended.

The fast path (`advance`) makes the steps of all lanes together. A step that it flags is copied out
of its lane and finished by `step_loop`, as if its motion were alone, so that the bits of a motion
depend on nothing but the motion.
"""

from __future__ import annotations

from typing import Any

from linkages.kernel.code.operands import (
    Bool,
    Int,
    floats,
    integers,
    minimum,
    select,
    select_of,
)
from linkages.kernel.code.procedure import Procedure, traced
from linkages.solvers.loops.margins import write_held
from linkages.solvers.loops.memory import (
    ACCEPTED_STEPS,
    ACTIVE,
    ANGLES,
    END,
    EVALUATION_TIME,
    EVALUATIONS,
    EVENT_VALUES,
    FROM,
    FUNCTION,
    FUNCTIONS,
    HALF,
    LENGTH,
    LEVELS,
    LOWER,
    LOWEST,
    NOW,
    OF_SAMPLING,
    QUARTER,
    REJECTED,
    REJECTED_STEPS,
    SAMPLE,
    SAMPLES,
    SCALAR_STEPS,
    STATUS,
    STEPPER_SIZE,
    STEPS,
    STOP,
    THETA,
    TO,
    TURNS,
    VALUES,
    WORD,
    Lanes,
    SystemView,
    T,
)
from linkages.solvers.loops.scalar_stages import call_step
from linkages.solvers.loops.step_loop import (
    DONE,
    INTERRUPTED,
    STEP_BUDGET,
    TICKS,
    control_at,
    note_steps,
    observe,
    record_at,
    system_at,
    table_at,
)

NOBODY = -1
# Of a lane whose samples are taken: whether some are left, whether rows behind the end have been
# counted and whether they cannot be evaluated, whether the next sample is before the end, and what
# was there at first.
OPEN, KNOWN, BROKEN, BETWEEN, FIRST_SAMPLE, FIRST_EVALUATION, FIRST_TIME = range(7)


@traced
def spread(code: Procedure, source: Int, target: Int, count: Int, lane: Int, lanes: Int) -> None:
    """Copy numbers of a motion into a lane."""
    numbers, rows = integers(source), integers(target + WORD * lane)
    with code.for_range(count) as k:
        rows[k * lanes] = numbers[k]


@traced
def collect(code: Procedure, source: Int, target: Int, count: Int, lane: Int, lanes: Int) -> None:
    """Copy numbers of a lane into those of its motion."""
    rows, numbers = integers(source + WORD * lane), integers(target)
    with code.for_range(count) as k:
        numbers[k] = rows[k * lanes]


@traced
def put_functions(code: Procedure, lanes: Lanes, lane: Int, system: SystemView) -> None:
    """Put the parameters of what events watch into a lane."""
    own = integers(integers(system.pointers)[FUNCTIONS])
    with code.for_range(lanes.events) as event:
        place = FUNCTION * event + 2
        size = integers(lanes.function_sizes)[event]
        spread(own[place], integers(lanes.functions)[place], size, lane, lanes.lanes)


@traced
def put_held(_code: Procedure, lanes: Lanes, lane: Int, system: SystemView) -> None:
    """Put modes, what is remembered, and its tangents into a lane."""
    place = lanes.parameters + WORD * (lanes.size - system.holding) * lanes.lanes
    spread(system.held, place, system.holding, lane, lanes.lanes)


@traced
def put(code: Procedure, lanes: Lanes, lane: Int, system: SystemView) -> None:
    """Put what changes of a motion on its way into a lane."""
    put_held(lanes, lane, system)
    spread(system.rows, lanes.rows, system.width, lane, lanes.lanes)
    spread(system.stepper, lanes.stepper, STEPPER_SIZE, lane, lanes.lanes)
    pointers = integers(system.pointers)
    spread(pointers[TURNS], lanes.turns, system.n, lane, lanes.lanes)
    spread(pointers[ANGLES], lanes.angles, system.counted, lane, lanes.lanes)
    spread(pointers[EVENT_VALUES], lanes.values, VALUES * lanes.events, lane, lanes.lanes)
    with code.if_(system.holding > 0):
        put_functions(lanes, lane, system)


@traced
def enter(_code: Procedure, lanes: Lanes, lane: Int, system: SystemView, atol: Int) -> None:
    """Put a motion that has begun into a lane, with all of its numbers."""
    spread(system.parameters, lanes.parameters, lanes.size, lane, lanes.lanes)
    spread(atol, lanes.atol, 2 * system.n, lane, lanes.lanes)
    spread(system.margin_scale, lanes.scale, system.blocks, lane, lanes.lanes)
    spread(system.smallest_margins, lanes.smallest, system.blocks, lane, lanes.lanes)
    spread(integers(system.pointers)[LEVELS], lanes.levels, lanes.events, lane, lanes.lanes)
    put_functions(lanes, lane, system)
    put(lanes, lane, system)


def sampling(lanes: Any, lane: Int) -> Any:
    """What is known of the samples of a lane: entries from OPEN to FIRST_TIME."""
    return integers(lanes.sampling + WORD * OF_SAMPLING * lane)


def status_in(lanes: Any, lane: Int) -> Any:
    """Status of a lane."""
    return integers(lanes.stepper)[STATUS * lanes.lanes + lane]


def motion_in(lanes: Any, lane: Int) -> Any:
    """Address of the context of the motion in a lane."""
    return integers(lanes.motions)[integers(lanes.places)[lane]]


@traced
def take_out(_code: Procedure, lanes: Lanes, lane: Int, rows: Int) -> None:
    """Give a motion what its lane has made, with some rows of the workspace."""
    system, table, record = parts_of(motion_in(lanes, lane))
    collect(lanes.rows, system.rows, rows * system.width, lane, lanes.lanes)
    collect(lanes.stepper, system.stepper, STEPPER_SIZE, lane, lanes.lanes)
    collect(lanes.turns, record.final_turns, system.n, lane, lanes.lanes)
    collect(lanes.angles, record.angles, system.counted, lane, lanes.lanes)
    values = integers(system.pointers)[EVENT_VALUES]
    collect(lanes.values, values, VALUES * lanes.events, lane, lanes.lanes)
    note_steps(system, table, record)


def parts_of(context: Int) -> tuple[Any, Any, Any]:
    """System, tableau and record of a motion that is not an argument."""
    return system_at(context, False), table_at(context, False), record_at(context, False)


@traced
def leave(_code: Procedure, lanes: Lanes, lane: Int, outcome: Int) -> None:
    """End the motion of a lane."""
    integers(lanes.outcomes)[integers(lanes.places)[lane]] = outcome
    floats(lanes.control)[NOW] += 1.0
    integers(lanes.places)[lane] = NOBODY
    floats(lanes.stepper)[ACTIVE * lanes.lanes + lane] = 0.0


@traced
def refill(code: Procedure, lanes: Lanes, lane: Int, first: Int) -> Int:
    """Begin the next motion in a lane; returns the number of the one behind it.

    A motion that has ended already leaves its numbers behind: a lane that nobody uses goes on with
    some that the kernel can be evaluated for.
    """
    following, places = code.variable(first), integers(lanes.places)
    with code.while_(lambda: (following < lanes.number) & (places[lane] == NOBODY)):
        context = integers(lanes.motions)[following]
        places[lane] = following
        following.set(following + 1)
        outcome = call_step(code, lanes.begin, context)
        system = system_at(context, False)
        stepper = floats(system.stepper)
        enter(lanes, lane, system, control_at(context, False).atol)
        with code.if_((outcome != DONE) | (stepper[T] == stepper[END])):
            leave(lanes, lane, outcome)
    return code.value(following)


@traced
def fill_idle(_code: Procedure, lanes: Lanes, lane: Int) -> None:
    """Fill an idle lane with valid data: that of the first motion."""
    context = integers(lanes.motions)[0]
    system = system_at(context, False)
    enter(lanes, lane, system, control_at(context, False).atol)
    floats(lanes.stepper)[ACTIVE * lanes.lanes + lane] = 0.0


@traced
def keep_samples(code: Procedure, lanes: Lanes, lane: Int) -> None:
    """Note where the samples of a lane begin, should one of them not be taken."""
    own, (_, _, record) = sampling(lanes, lane), parts_of(motion_in(lanes, lane))
    counters, stepper = integers(record.counters), integers(lanes.stepper)
    own[OPEN], own[KNOWN] = code.value(1), code.value(0)
    own[FIRST_SAMPLE], own[FIRST_EVALUATION] = counters[SAMPLES], counters[EVALUATIONS]
    own[FIRST_TIME] = stepper[SAMPLE * lanes.lanes + lane]


@traced
def give_up_samples(code: Procedure, lanes: Lanes, lane: Int) -> None:
    """Leave all samples of a step to the motion alone."""
    own, (_, _, record) = sampling(lanes, lane), parts_of(motion_in(lanes, lane))
    counters, stepper = integers(record.counters), integers(lanes.stepper)
    counters[SAMPLES], counters[EVALUATIONS] = own[FIRST_SAMPLE], own[FIRST_EVALUATION]
    stepper[SAMPLE * lanes.lanes + lane] = own[FIRST_TIME]
    own[OPEN] = code.value(0)


@traced
def aim(code: Procedure, lanes: Lanes, lane: Int) -> Int:
    """Say where a lane is evaluated next; returns whether its sample is before the end."""
    stepper, own = floats(lanes.stepper + WORD * lane), sampling(lanes, lane)
    width = lanes.lanes
    t, h, end = stepper[FROM * width], stepper[LENGTH * width], stepper[TO * width]
    time = stepper[SAMPLE * width]
    stepper[THETA * width], stepper[EVALUATION_TIME * width] = 1.0, end
    with code.if_((own[OPEN] == 0) | (time == end)):
        code.return_(0)
    stepper[THETA * width] = minimum((time - t) / h, 1.0)
    stepper[EVALUATION_TIME * width] = time
    return code.value(1)


@traced
def take_sample(code: Procedure, lanes: Lanes, lane: Int, row: Int) -> None:
    """Write a row of the workspace as the next sample of a lane."""
    own, (system, table, record) = sampling(lanes, lane), parts_of(motion_in(lanes, lane))
    size = WORD * system.width
    target = system.rows + size * table.rows
    collect(lanes.rows + size * row * lanes.lanes, target, system.width, lane, lanes.lanes)
    collect(lanes.turns, record.final_turns, system.n, lane, lanes.lanes)
    write_held(system, record, integers(record.counters)[SAMPLES])
    code.call_at(system.sample, Int, system.pointers, target)
    stepper, width = floats(lanes.stepper + WORD * lane), lanes.lanes
    following = floats(system.stepper)[SAMPLE]
    stepper[SAMPLE * width] = following
    left = stepper[TO * width] - following
    ahead = select(stepper[LENGTH * width] >= 0.0, left, -left)
    with code.if_(~(ahead >= 0.0)):
        own[OPEN] = code.value(0)


@traced
def sample_lane(code: Procedure, lanes: Lanes, lane: Int, between: Int) -> Bool:
    """Take the sample of a lane that has been evaluated; returns whether that was possible."""
    own, (_, table, record) = sampling(lanes, lane), parts_of(motion_in(lanes, lane))
    with code.if_(between == 0) as case:
        take_sample(lanes, lane, table.end)
    with case.else_():
        with code.if_((own[BROKEN] != 0) | (status_in(lanes, lane) != 0)):
            give_up_samples(lanes, lane)
            code.return_(False)
        counters = integers(record.counters)
        with code.if_(own[KNOWN] == 0):
            counters[EVALUATIONS] += table.rows - 1 - table.end
        own[KNOWN] = code.value(1)
        counters[EVALUATIONS] += 1
        take_sample(lanes, lane, table.rows)
    return code.value(True)


@traced
def compute_rows(code: Procedure, lanes: Lanes) -> None:
    """Compute the rows behind the ends of all steps."""
    code.call_at(lanes.further, Int, lanes.pointers)
    with code.for_range(lanes.lanes) as lane:
        sampling(lanes, lane)[BROKEN] = status_in(lanes, lane)


@traced
def sample_lanes(code: Procedure, lanes: Lanes, bits: Int) -> Int:
    """Take all samples within the steps of some lanes; both are bits, one for each lane.

    Returns those in which one cannot be evaluated, with all as it was: they are finished alone.
    """
    failed, running, computed = code.variable(0), code.variable(True), code.variable(False)
    with code.for_range(lanes.lanes) as lane:
        sampling(lanes, lane)[OPEN] = code.value(0)
        with code.if_((bits >> lane) & 1 != 0):
            keep_samples(lanes, lane)
    with code.while_(lambda: running):
        any_between = code.variable(False)
        with code.for_range(lanes.lanes) as lane:
            between = aim(lanes, lane)
            sampling(lanes, lane)[BETWEEN] = between
            any_between.set(any_between | (between != 0))
        with code.if_(any_between):
            with code.if_(~computed):
                compute_rows(lanes)
                computed.set(True)
            code.call_at(lanes.between, Int, lanes.pointers)
        running.set(False)
        weight = code.variable(1)
        with code.for_range(lanes.lanes) as lane:
            own = sampling(lanes, lane)
            with code.if_(own[OPEN] != 0):
                with code.if_(~sample_lane(lanes, lane, own[BETWEEN])):
                    failed.set(failed + weight)
                running.set(running | (own[OPEN] != 0))
            weight.set(weight * 2)
    return code.value(failed)


@traced
def conclude(code: Procedure, lanes: Lanes, lane: Int) -> None:
    """Finish a step that needs more than arithmetic."""
    context = motion_in(lanes, lane)
    system, table, _ = parts_of(context)
    stepper, status = floats(system.stepper), integers(system.stepper)
    floats(lanes.control)[SCALAR_STEPS] += 1.0
    take_out(lanes, lane, table.end + 1)
    with code.if_(status[STATUS] != 0):  # which a motion alone knows better
        status[STATUS] = call_step(code, system.attempt, system.pointers)
    outcome = call_step(code, lanes.conclude, context)
    put(lanes, lane, system)
    with code.if_((outcome != DONE) | (stepper[T] == stepper[END])):
        leave(lanes, lane, outcome)


@traced
def observe_samples(code: Procedure, lanes: Lanes, lane: Int) -> None:
    """Renormalise the deviation vectors of a lane after its samples."""
    system, _, record = parts_of(motion_in(lanes, lane))
    with code.if_(record.observer != 0):
        collect(lanes.rows, system.rows, system.width, lane, lanes.lanes)
        observe(code, record, floats(lanes.stepper)[T * lanes.lanes + lane])
        spread(system.rows, lanes.rows, system.width, lane, lanes.lanes)
        put_held(lanes, lane, system)


@traced
def has_ended(code: Procedure, lanes: Lanes, lane: Int) -> Bool:
    """Whether a lane has come to the last time of its motion by itself."""
    stepper, width = floats(lanes.stepper + WORD * lane), lanes.lanes
    with code.if_(integers(lanes.places)[lane] == NOBODY):
        code.return_(False)
    return stepper[T * width] == stepper[END * width]


@traced
def trials_left(_code: Procedure, lanes: Lanes, lane: Int) -> Int:
    """Number of trials that the motion of a lane may still make."""
    context = motion_in(lanes, lane)
    counters = integers(record_at(context, False).counters)
    stepper = floats(lanes.stepper + WORD * lane)
    made = stepper[ACCEPTED_STEPS * lanes.lanes] + stepper[REJECTED_STEPS * lanes.lanes]
    budget = control_at(context, False).budget
    return budget - counters[STEPS] - counters[REJECTED] - made.to_int


@traced
def end_where_due(code: Procedure, lanes: Lanes, stop: Bool) -> Int:
    """End motions that may not go on; returns how many trials the others may make, 0 for none."""
    ticks = code.variable(0)
    with code.for_range(lanes.lanes) as lane, code.if_(integers(lanes.places)[lane] != NOBODY):
        left = trials_left(lanes, lane)
        with code.if_(stop | (left <= 0)) as case:
            take_out(lanes, lane, 1)
            leave(lanes, lane, select_of(Int, stop, INTERRUPTED, STEP_BUDGET))
        with case.else_():
            most = select(ticks > 0, ticks, TICKS)
            ticks.set(minimum(left, most))
    return code.value(ticks)


@traced
def advance_lanes(code: Procedure, lanes: Lanes) -> Int:
    """Integrate all motions; writes their outcomes. Returns the number of trials of all lanes.

    After a stop, motions that have not begun keep the outcome that stands there.
    """
    following, spent, running = code.variable(0), code.variable(0), code.variable(True)
    with code.for_range(lanes.lanes) as lane:
        following.set(refill(lanes, lane, following))
        with code.if_(integers(lanes.places)[lane] == NOBODY):
            fill_idle(lanes, lane)
    with code.while_(lambda: running):
        stop = floats(lanes.control)[STOP] != 0.0
        ticks = end_where_due(lanes, stop)
        flagged, observed = code.variable(0), code.variable(0)
        with code.if_(stop):
            code.return_(spent)
        with code.if_(ticks > 0):
            result = code.call_at(lanes.advance, Int, lanes.pointers, ticks)
            spent.set(spent + lanes.lanes * (result >> HALF))
            flagged.set(result & LOWEST)
            observed.set((result & LOWER) >> QUARTER)
        running.set(False)
        with code.for_range(lanes.lanes) as lane:
            with code.if_((observed >> lane) & 1 != 0):
                observe_samples(lanes, lane)
            with code.if_((flagged >> lane) & 1 != 0) as case:
                conclude(lanes, lane)
            with case.else_(), code.if_(has_ended(lanes, lane)):
                take_out(lanes, lane, 1)
                leave(lanes, lane, DONE)
            with code.if_(integers(lanes.places)[lane] == NOBODY):
                following.set(refill(lanes, lane, following))
            running.set(running | (integers(lanes.places)[lane] != NOBODY))
    return code.value(spent)
