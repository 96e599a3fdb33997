"""Batch integration in lanes: a lane takes the next motion when its own has ended.

The fast path (`advance`) makes the steps of all lanes together. A step that it flags is copied out
of its lane and finished by `step_loop`, so that the bits of a motion depend on the motion alone.
"""

from __future__ import annotations

from typing import Any

from linkages.kernel.code.operands import Bool, Int, IntArray, RealArray, minimum, select, select_of
from linkages.kernel.code.procedure import Procedure, traced
from linkages.solvers.loops.margins import write_held
from linkages.solvers.loops.memory import (
    FUNCTION,
    HALF,
    LOWER,
    LOWEST,
    QUARTER,
    STEPPER_SIZE,
    TICKS,
    VALUES,
    KernelTable,
    Lanes,
    Motion,
    Sampling,
    Stepper,
)
from linkages.solvers.loops.step_loop import note_steps, observe
from linkages.solvers.trajectory import Outcome

NOBODY = -1


@traced
def spread(
    code: Procedure, source: IntArray, target: IntArray, count: Int, lane: Int, lanes: Int
) -> None:
    """Copy numbers of a motion into a lane."""
    with code.for_range(count) as k:
        target[k * lanes + lane] = source[k]


@traced
def collect(
    code: Procedure, source: IntArray, target: IntArray, count: Int, lane: Int, lanes: Int
) -> None:
    """Copy numbers of a lane into those of its motion."""
    with code.for_range(count) as k:
        target[k] = source[k * lanes + lane]


@traced
def put_functions(code: Procedure, lanes: Lanes, lane: Int, motion: Motion) -> None:
    """Put the parameters of what events watch into a lane."""
    with code.for_range(lanes.events) as event:
        own, wide = (
            KernelTable(code, each.functions.after(FUNCTION * event).pointer, lasting=False)
            for each in (motion, lanes)
        )
        size = lanes.function_sizes[event]
        spread(own.parameters, wide.parameters, size, lane, lanes.lanes)


@traced
def put_held(_code: Procedure, lanes: Lanes, lane: Int, motion: Motion) -> None:
    """Put modes, what is remembered, and its tangents into a lane."""
    spread(motion.held, lanes.held, motion.holding, lane, lanes.lanes)


def changing(motion: Motion, events: Int) -> list[tuple[str, Any]]:
    """Names of arrays that change on the way of a motion, and how many of their entries."""
    return [
        ("stepper", STEPPER_SIZE),
        ("turns", motion.n),
        ("angles", motion.counted),
        ("values", VALUES * events),
    ]


@traced
def put(code: Procedure, lanes: Lanes, lane: Int, motion: Motion) -> None:
    """Put what changes of a motion on its way into a lane."""
    put_held(lanes, lane, motion)
    for name, size in [("rows", motion.width), *changing(motion, lanes.events)]:
        spread(getattr(motion, name), getattr(lanes, name), size, lane, lanes.lanes)
    with code.if_(motion.holding > 0):
        put_functions(lanes, lane, motion)


@traced
def enter(_code: Procedure, lanes: Lanes, lane: Int, motion: Motion) -> None:
    """Put a motion that has begun into a lane, with all of its numbers."""
    for name, size in (
        ("parameters", lanes.size),
        ("atol", 2 * motion.n),
        ("scale", motion.blocks),
        ("smallest", motion.blocks),
        ("levels", lanes.events),
    ):
        spread(getattr(motion, name), getattr(lanes, name), size, lane, lanes.lanes)
    put_functions(lanes, lane, motion)
    put(lanes, lane, motion)


def sampling(lanes: Lanes, lane: Int) -> Sampling:
    """What is known of the samples of a lane."""
    return Sampling(lanes.code, lanes.sampling.after(len(Sampling.entries()) * lane).pointer)


def stepper_in(lanes: Lanes, lane: Int) -> Stepper:
    """The stepper of a lane."""
    first = RealArray(lanes.code, lanes.stepper.pointer).after(lane)
    return Stepper(lanes.code, first.pointer, lanes.lanes)


def motion_in(lanes: Lanes, lane: Int) -> Motion:
    """The motion in a lane."""
    return Motion.at(lanes.motions[lanes.occupants[lane]])


@traced
def take_out(_code: Procedure, lanes: Lanes, lane: Int, rows: Int) -> None:
    """Give a motion what its lane has made, with some rows of the workspace."""
    motion = motion_in(lanes, lane)
    for name, size in [("rows", rows * motion.width), *changing(motion, lanes.events)]:
        collect(getattr(lanes, name), getattr(motion, name), size, lane, lanes.lanes)
    note_steps(motion)


@traced
def leave(_code: Procedure, lanes: Lanes, lane: Int, outcome: Int) -> None:
    """End the motion of a lane."""
    lanes.outcomes[lanes.occupants[lane]] = outcome
    lanes.control.now += 1.0
    lanes.occupants[lane] = NOBODY
    stepper_in(lanes, lane).active = 0.0


@traced
def refill(code: Procedure, lanes: Lanes, lane: Int, first: Int) -> Int:
    """Begin the next motion in a lane; returns the number of the one behind it.

    A lane that nobody uses keeps numbers for which the kernel can be evaluated.
    """
    following, occupants = code.variable(first), lanes.occupants
    with code.while_(lambda: (following < lanes.number) & (occupants[lane] == NOBODY)):
        motion = Motion.at(lanes.motions[following])
        occupants[lane] = following
        following.set(following + 1)
        outcome = lanes.begin(Int, motion)
        enter(lanes, lane, motion)
        with code.if_((outcome != Outcome.DONE) | (motion.stepper.t == motion.stepper.end)):
            leave(lanes, lane, outcome)
    return code.value(following)


@traced
def fill_idle(_code: Procedure, lanes: Lanes, lane: Int) -> None:
    """Fill an idle lane with valid data: that of the first motion."""
    enter(lanes, lane, Motion.at(lanes.motions[0]))
    stepper_in(lanes, lane).active = 0.0


@traced
def keep_samples(code: Procedure, lanes: Lanes, lane: Int) -> None:
    """Note where the samples of a lane begin, should one of them not be taken."""
    own, motion = sampling(lanes, lane), motion_in(lanes, lane)
    counters, stepper = motion.counters, stepper_in(lanes, lane)
    own.open, own.known = code.value(1), code.value(0)
    own.first_sample, own.first_evaluation = counters.samples, counters.evaluations
    own.first_time = stepper.sample


@traced
def give_up_samples(code: Procedure, lanes: Lanes, lane: Int) -> None:
    """Leave all samples of a step to the motion alone."""
    own, motion = sampling(lanes, lane), motion_in(lanes, lane)
    counters, stepper = motion.counters, stepper_in(lanes, lane)
    counters.samples, counters.evaluations = own.first_sample, own.first_evaluation
    stepper.sample = own.first_time
    own.open = code.value(0)


@traced
def aim(code: Procedure, lanes: Lanes, lane: Int) -> Int:
    """Say where a lane is evaluated next; returns whether its sample is before the end."""
    stepper, own = stepper_in(lanes, lane), sampling(lanes, lane)
    t, h, end, time = stepper.start, stepper.length, stepper.stop, stepper.sample
    stepper.theta, stepper.evaluation_time = 1.0, end
    code.return_if((own.open == 0) | (time == end), 0)
    stepper.theta, stepper.evaluation_time = minimum((time - t) / h, 1.0), time
    return code.value(1)


@traced
def take_sample(code: Procedure, lanes: Lanes, lane: Int, row: Int) -> None:
    """Write a row of the workspace as the next sample of a lane."""
    own, motion = sampling(lanes, lane), motion_in(lanes, lane)
    source, target = lanes.rows.after(row * motion.width * lanes.lanes), motion.row(motion.scratch)
    collect(source, target, motion.width, lane, lanes.lanes)
    collect(lanes.turns, motion.turns, motion.n, lane, lanes.lanes)
    write_held(motion, motion.counters.samples)
    motion.sample(Int, motion, target)
    stepper, following = stepper_in(lanes, lane), motion.stepper.sample
    stepper.sample = following
    left = stepper.stop - following
    ahead = select(stepper.length >= 0.0, left, -left)
    with code.if_(~(ahead >= 0.0)):
        own.open = code.value(0)


@traced
def sample_lane(code: Procedure, lanes: Lanes, lane: Int, between: Int) -> Bool:
    """Take the sample of a lane that has been evaluated; returns whether that was possible."""
    own, motion = sampling(lanes, lane), motion_in(lanes, lane)
    with code.if_(between == 0) as case:
        take_sample(lanes, lane, motion.end)
    with case.else_():
        with code.if_((own.broken != 0) | (stepper_in(lanes, lane).status != 0)):
            give_up_samples(lanes, lane)
            code.return_(False)
        counters = motion.counters
        with code.if_(own.known == 0):
            counters.evaluations += motion.scratch - 1 - motion.end
        own.known = code.value(1)
        counters.evaluations += 1
        take_sample(lanes, lane, motion.scratch)
    return code.value(True)


@traced
def compute_rows(code: Procedure, lanes: Lanes) -> None:
    """Compute the rows behind the ends of all steps."""
    lanes.further(Int, lanes)
    with code.for_range(lanes.lanes) as lane:
        sampling(lanes, lane).broken = stepper_in(lanes, lane).status


@traced
def sample_lanes(code: Procedure, lanes: Lanes, bits: Int) -> Int:
    """Take all samples within the steps of some lanes; returns bits of those that fail."""
    failed, running, computed = code.variable(0), code.variable(True), code.variable(False)
    with code.for_range(lanes.lanes) as lane:
        sampling(lanes, lane).open = code.value(0)
        with code.if_((bits >> lane) & 1 != 0):
            keep_samples(lanes, lane)
    with code.while_(lambda: running):
        any_between = code.variable(False)
        with code.for_range(lanes.lanes) as lane:
            between = aim(lanes, lane)
            sampling(lanes, lane).between = between
            any_between.set(any_between | (between != 0))
        with code.if_(any_between):
            with code.if_(~computed):
                compute_rows(lanes)
                computed.set(True)
            lanes.between(Int, lanes)
        running.set(False)
        weight = code.variable(1)
        with code.for_range(lanes.lanes) as lane:
            own = sampling(lanes, lane)
            with code.if_(own.open != 0):
                with code.if_(~sample_lane(lanes, lane, own.between)):
                    failed.set(failed + weight)
                running.set(running | (own.open != 0))
            weight.set(weight * 2)
    return code.value(failed)


@traced
def conclude(code: Procedure, lanes: Lanes, lane: Int) -> None:
    """Finish a step that needs more than arithmetic."""
    motion = motion_in(lanes, lane)
    lanes.control.scalar_steps += 1.0
    take_out(lanes, lane, motion.end + 1)
    with code.if_(motion.stepper.status != 0):  # which a motion alone knows better
        motion.stepper.status = motion.attempt(Int, motion)
    outcome = lanes.conclude(Int, motion)
    put(lanes, lane, motion)
    with code.if_((outcome != Outcome.DONE) | (motion.stepper.t == motion.stepper.end)):
        leave(lanes, lane, outcome)


@traced
def observe_samples(code: Procedure, lanes: Lanes, lane: Int) -> None:
    """Renormalise the deviation vectors of a lane after its samples."""
    motion = motion_in(lanes, lane)
    with code.if_(motion.tangents.watch.exists):
        collect(lanes.rows, motion.rows, motion.width, lane, lanes.lanes)
        observe(code, motion, stepper_in(lanes, lane).t)
        spread(motion.rows, lanes.rows, motion.width, lane, lanes.lanes)
        put_held(lanes, lane, motion)


@traced
def has_ended(code: Procedure, lanes: Lanes, lane: Int) -> Bool:
    """Whether a lane has come to the last time of its motion by itself."""
    stepper = stepper_in(lanes, lane)
    code.return_if(lanes.occupants[lane] == NOBODY, False)
    return stepper.t == stepper.end


@traced
def trials_left(_code: Procedure, lanes: Lanes, lane: Int) -> Int:
    """Number of trials that the motion of a lane may still make."""
    motion = motion_in(lanes, lane)
    stepper = stepper_in(lanes, lane)
    made = stepper.accepted_steps + stepper.rejected_steps
    return motion.budget - motion.counters.steps - motion.counters.rejected - made.to_int


@traced
def end_where_due(code: Procedure, lanes: Lanes, stop: Bool) -> Int:
    """End motions that may not go on; returns how many trials the others may make, 0 for none."""
    ticks = code.variable(0)
    with code.for_range(lanes.lanes) as lane, code.if_(lanes.occupants[lane] != NOBODY):
        left = trials_left(lanes, lane)
        with code.if_(stop | (left <= 0)) as case:
            take_out(lanes, lane, 1)
            leave(lanes, lane, select_of(Int, stop, Outcome.INTERRUPTED, Outcome.STEP_BUDGET))
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
        with code.if_(lanes.occupants[lane] == NOBODY):
            fill_idle(lanes, lane)
    with code.while_(lambda: running):
        stop = lanes.control.stop != 0.0
        ticks = end_where_due(lanes, stop)
        flagged, observed = code.variable(0), code.variable(0)
        code.return_if(stop, spent)
        with code.if_(ticks > 0):
            result = lanes.advance(Int, lanes, ticks)
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
                leave(lanes, lane, Outcome.DONE)
            with code.if_(lanes.occupants[lane] == NOBODY):
                following.set(refill(lanes, lane, following))
            running.set(running | (lanes.occupants[lane] != NOBODY))
    return code.value(spent)
