"""Many motions side by side: a lane takes the next motion when its own has ended.

Printed code makes the steps of all lanes together. A step that needs more than arithmetic is taken
out of its lane and finished by the functions of `step_loop`, as if its motion were alone; the
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
from linkages.kernel.code.procedure import Procedure, printed
from linkages.solvers.loops.margins import write_held
from linkages.solvers.loops.memory import (
    ACTIVE,
    ALONE,
    ANGLES,
    AT,
    END,
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
    PACE,
    QUARTER,
    REJECTED,
    REJECTIONS,
    SAMPLE,
    SAMPLES,
    STATUS,
    STEPS,
    STOP,
    TAKEN,
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
def put_held(_code: Procedure, lanes: Lanes, lane: Whole, system: SystemView) -> None:
    """Put modes, what is remembered, and its tangents into a lane."""
    place = lanes.parameters + WORD * (lanes.size - system.holding) * lanes.lanes
    spread(system.held, place, system.holding, lane, lanes.lanes)


@printed
def put(code: Procedure, lanes: Lanes, lane: Whole, system: SystemView) -> None:
    """Put what changes of a motion on its way into a lane."""
    put_held(lanes, lane, system)
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


def sampling(lanes: Any, lane: Whole) -> Any:
    """What is known of the samples of a lane: entries from OPEN to FIRST_TIME."""
    return integers(lanes.sampling + WORD * OF_SAMPLING * lane)


def status_in(lanes: Any, lane: Whole) -> Any:
    """Status of a lane."""
    return integers(lanes.pace)[STATUS * lanes.lanes + lane]


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
def keep_samples(code: Procedure, lanes: Lanes, lane: Whole) -> None:
    """Note where the samples of a lane begin, should one of them not be taken."""
    own, (_, _, record) = sampling(lanes, lane), parts_of(motion_in(lanes, lane))
    counters, pace = integers(record.counters), integers(lanes.pace)
    own[OPEN], own[KNOWN] = code.value(1), code.value(0)
    own[FIRST_SAMPLE], own[FIRST_EVALUATION] = counters[SAMPLES], counters[EVALUATIONS]
    own[FIRST_TIME] = pace[SAMPLE * lanes.lanes + lane]


@printed
def give_up_samples(code: Procedure, lanes: Lanes, lane: Whole) -> None:
    """Leave all samples of a step to the motion alone."""
    own, (_, _, record) = sampling(lanes, lane), parts_of(motion_in(lanes, lane))
    counters, pace = integers(record.counters), integers(lanes.pace)
    counters[SAMPLES], counters[EVALUATIONS] = own[FIRST_SAMPLE], own[FIRST_EVALUATION]
    pace[SAMPLE * lanes.lanes + lane] = own[FIRST_TIME]
    own[OPEN] = code.value(0)


@printed
def aim(code: Procedure, lanes: Lanes, lane: Whole) -> Whole:
    """Say where a lane is evaluated next; returns whether its sample is before the end."""
    pace, own = floats(lanes.pace + WORD * lane), sampling(lanes, lane)
    width = lanes.lanes
    t, h, end = pace[FROM * width], pace[LENGTH * width], pace[TO * width]
    time = pace[SAMPLE * width]
    pace[THETA * width], pace[AT * width] = 1.0, end
    with code.when((own[OPEN] == 0) | (time == end)):
        code.leave(0)
    pace[THETA * width] = smaller_of((time - t) / h, 1.0)
    pace[AT * width] = time
    return code.value(1)


@printed
def take_sample(code: Procedure, lanes: Lanes, lane: Whole, row: Whole) -> None:
    """Write a row of the workspace as the next sample of a lane."""
    own, (system, table, record) = sampling(lanes, lane), parts_of(motion_in(lanes, lane))
    size = WORD * system.width
    target = system.rows + size * table.rows
    collect(lanes.rows + size * row * lanes.lanes, target, system.width, lane, lanes.lanes)
    collect(lanes.turns, record.final_turns, system.n, lane, lanes.lanes)
    write_held(system, record, integers(record.counters)[SAMPLES])
    code.call_at(system.sample, Whole, system.frame, target)
    pace, width = floats(lanes.pace + WORD * lane), lanes.lanes
    following = floats(system.pace)[SAMPLE]
    pace[SAMPLE * width] = following
    left = pace[TO * width] - following
    ahead = choose(pace[LENGTH * width] >= 0.0, left, -left)
    with code.when(~(ahead >= 0.0)):
        own[OPEN] = code.value(0)


@printed
def sample_lane(code: Procedure, lanes: Lanes, lane: Whole, between: Whole) -> Truth:
    """Take the sample of a lane that has been evaluated; returns whether that was possible."""
    own, (_, table, record) = sampling(lanes, lane), parts_of(motion_in(lanes, lane))
    with code.when(between == 0) as case:
        take_sample(lanes, lane, table.end)
    with case.otherwise():
        with code.when((own[BROKEN] != 0) | (status_in(lanes, lane) != 0)):
            give_up_samples(lanes, lane)
            code.leave(False)
        counters = integers(record.counters)
        with code.when(own[KNOWN] == 0):
            counters[EVALUATIONS] += table.rows - 1 - table.end
        own[KNOWN] = code.value(1)
        counters[EVALUATIONS] += 1
        take_sample(lanes, lane, table.rows)
    return code.value(True)


@printed
def compute_rows(code: Procedure, lanes: Lanes) -> None:
    """Compute the rows behind the ends of all steps."""
    code.call_at(lanes.further, Whole, lanes.frame)
    with code.count(lanes.lanes) as lane:
        sampling(lanes, lane)[BROKEN] = status_in(lanes, lane)


@printed
def sample_lanes(code: Procedure, lanes: Lanes, bits: Whole) -> Whole:
    """Take all samples within the steps of some lanes; both are bits, one for each lane.

    Returns those in which one cannot be evaluated, with all as it was: they are finished alone.
    """
    failed, running, computed = code.variable(0), code.variable(True), code.variable(False)
    with code.count(lanes.lanes) as lane:
        sampling(lanes, lane)[OPEN] = code.value(0)
        with code.when((bits >> lane) & 1 != 0):
            keep_samples(lanes, lane)
    with code.during(lambda: running):
        any_between = code.variable(False)
        with code.count(lanes.lanes) as lane:
            between = aim(lanes, lane)
            sampling(lanes, lane)[BETWEEN] = between
            any_between.set(any_between | (between != 0))
        with code.when(any_between):
            with code.when(~computed):
                compute_rows(lanes)
                computed.set(True)
            code.call_at(lanes.between, Whole, lanes.frame)
        running.set(False)
        weight = code.variable(1)
        with code.count(lanes.lanes) as lane:
            own = sampling(lanes, lane)
            with code.when(own[OPEN] != 0):
                with code.when(~sample_lane(lanes, lane, own[BETWEEN])):
                    failed.set(failed + weight)
                running.set(running | (own[OPEN] != 0))
            weight.set(weight * 2)
    return code.value(failed)


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
def observe_samples(code: Procedure, lanes: Lanes, lane: Whole) -> None:
    """Renormalise the deviation vectors of a lane after its samples."""
    system, _, record = parts_of(motion_in(lanes, lane))
    with code.when(record.observer != 0):
        collect(lanes.rows, system.rows, system.width, lane, lanes.lanes)
        observe(code, record, floats(lanes.pace)[T * lanes.lanes + lane])
        spread(system.rows, lanes.rows, system.width, lane, lanes.lanes)
        put_held(lanes, lane, system)


@printed
def has_ended(code: Procedure, lanes: Lanes, lane: Whole) -> Truth:
    """Whether a lane has come to the last time of its motion by itself."""
    pace, width = floats(lanes.pace + WORD * lane), lanes.lanes
    with code.when(integers(lanes.places)[lane] == NOBODY):
        code.leave(False)
    return pace[T * width] == pace[END * width]


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
        ticks = end_where_due(lanes, stop)
        flagged, observed = code.variable(0), code.variable(0)
        with code.when(stop):
            code.leave(spent)
        with code.when(ticks > 0):
            found = code.call_at(lanes.advance, Whole, lanes.frame, ticks)
            spent.set(spent + lanes.lanes * (found >> HALF))
            flagged.set(found & LOWEST)
            observed.set((found & LOWER) >> QUARTER)
        running.set(False)
        with code.count(lanes.lanes) as lane:
            with code.when((observed >> lane) & 1 != 0):
                observe_samples(lanes, lane)
            with code.when((flagged >> lane) & 1 != 0) as case:
                conclude(lanes, lane)
            with case.otherwise(), code.when(has_ended(lanes, lane)):
                take_out(lanes, lane, 1)
                leave(lanes, lane, DONE)
            with code.when(integers(lanes.places)[lane] == NOBODY):
                following.set(refill(lanes, lane, following))
            running.set(running | (integers(lanes.places)[lane] != NOBODY))
    return code.value(spent)
