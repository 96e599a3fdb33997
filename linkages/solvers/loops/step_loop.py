"""Step loop of a single motion, for all methods.

A method tries steps: `explicit_steps`, which go on by themselves until one of them needs more than
arithmetic, or `collocation_steps`. Each trial is finished here.
"""

from __future__ import annotations

from linkages.kernel.code.operands import (
    Bool,
    Function,
    Int,
    Real,
    copysign,
    fma,
    maximum,
    minimum,
    select,
)
from linkages.kernel.code.procedure import Procedure, traced
from linkages.solvers.loops.control import HALVINGS, SHRINK_TURNING, finest_step
from linkages.solvers.loops.margins import (
    SNAP,
    check_margins,
    is_too_small,
    reachable_part,
    start_angles,
    take_samples,
    write_sample,
)
from linkages.solvers.loops.memory import (
    BEFORE_CHANGE,
    BEHIND_CHANGE,
    FLAGGED_STEP,
    LOWER,
    NOT_FINITE,
    NOT_SETTLED,
    PAUSED,
    START,
    START_OF_MOTION,
    STEP,
    TICKS,
    Motion,
)
from linkages.solvers.loops.scalar_stages import evaluate_at, finite, status_of, wrap_angles
from linkages.solvers.trajectory import Outcome


@traced
def outcome_of(code: Procedure, motion: Motion, status: Int) -> Int:
    """Outcome that a failed evaluation stands for; notes its block."""
    code.return_if(status == NOT_FINITE, Outcome.NOT_FINITE)
    code.return_if(status == NOT_SETTLED, Outcome.NOT_CONVERGED)
    motion.counters.block = status - 1
    return code.value(Outcome.UNREACHABLE)


@traced
def margin_outcome(code: Procedure, motion: Motion) -> Int:
    """SINGULAR if a margin in row 0 is too small, noting its block; DONE otherwise."""
    with code.for_range(motion.blocks) as block, code.if_(is_too_small(motion, 0, block)):
        motion.counters.block = block
        code.return_(Outcome.SINGULAR)
    return code.value(Outcome.DONE)


def observe(code: Procedure, motion: Motion, t: Real, when: float = STEP) -> None:
    """Show row 0 to what follows every step, and is told what was done."""
    with code.if_(motion.tangents.watch.exists):
        motion.tangents.watch(Int, motion, t, code.value(when))


@traced
def begin(code: Procedure, motion: Motion, start: Real, near: Real) -> Int:
    """Evaluate row 0 at the start and take the samples within `near` of it."""
    counters = motion.counters
    motion.control.now = start
    code.return_if(~finite(motion, 0, 2 * motion.n), Outcome.NOT_FINITE)
    wrap_angles(motion, motion.rows, motion.turns)
    counters.evaluations += 1
    status = evaluate_at(motion, start, 0)
    with code.if_(status != 0):
        code.return_(outcome_of(motion, status))
    code.return_if(~finite(motion, 0, 3 * motion.n), Outcome.NOT_FINITE)
    start_angles(motion)
    with code.while_(lambda: counters.samples < motion.samples):
        code.break_if(abs(motion.times[counters.samples] - start) > near)
        write_sample(motion, 0)
    observe(code, motion, start, START)
    return margin_outcome(motion)


@traced
def settle(code: Procedure, motion: Motion) -> None:
    """Replace coordinates that are carried along in row 0 by what the iteration found there."""
    rows, result = motion.rows, 3 * motion.n + 2 * motion.blocks
    with code.for_range(motion.carried) as i:
        place = motion.first_carried + i
        rows[place] = rows[result + i]
        rows[motion.n + place] = rows[result + motion.carried + i]


@traced
def commit(code: Procedure, motion: Motion, t_end: Real) -> None:
    """Make the end of an accepted step the start of the next one."""
    motion.commit(Int, motion)
    observe(code, motion, t_end)
    motion.control.now = t_end
    motion.counters.steps += 1


@traced
def cut_short(code: Procedure, motion: Motion, t: Real, h: Real, part: Real, outcome: Int) -> Int:
    """End a run with the part of a step that is in the workspace."""
    code.return_if(part == 0.0, outcome)
    t_end = t + part * h
    status = take_samples(motion, t, part * h, t_end, 0.0)
    with code.if_(status != 0):
        code.return_(outcome_of(motion, status))
    commit(motion, t_end)
    return outcome


# A trial that leaves the reach of a block says nothing about how far that block reaches.
SHRINK_BLOCKED = 0.25
# Behind a change of a mode forces may grow like roots (t^1.5 in a contact): errors fall with low
# powers of the step there, whatever the order.
SHRINK_FRESH = 0.1
# An estimate of such an error is small by accident now and then, so no step that is far too long
# must be tried: the first of its kind is so much shorter than smooth equations would allow, and
# later ones are at most twice as long as the last.
CAUTIOUS = 3e-4
# Entries of `Motion.grid`.
ORIGIN, SPACING, NEXT = range(3)


@traced
def begin_motion(code: Procedure, motion: Motion) -> Int:
    """Evaluate a motion at its start, and choose the first step; returns an `Outcome`."""
    stepper, near = motion.stepper, code.variable(0.0)
    with code.if_(motion.equal > 0):
        near.set(SNAP * abs(motion.grid[SPACING]))
    plain = motion.begin.exists & (stepper.unobserved != 0.0)
    with code.if_(plain), code.if_(motion.begin(Int, motion) == 0):
        code.return_(Outcome.DONE)
    outcome = begin(motion, stepper.t, near)
    code.return_if(
        (outcome != Outcome.DONE) | (stepper.t == stepper.end) | (motion.equal > 0), outcome
    )
    motion.counters.evaluations += 1
    motion.first(Int, motion)
    stepper.first, stepper.before = abs(stepper.h), 1.0
    return outcome


@traced
def note_steps(_code: Procedure, motion: Motion) -> None:
    """Count the steps that generated code has made."""
    counters, stepper = motion.counters, motion.stepper
    taken, rejected = stepper.accepted_steps.to_int, stepper.rejected_steps.to_int
    counters.steps += taken
    counters.rejected += rejected
    counters.evaluations += motion.cost * (taken + rejected)
    stepper.accepted_steps, stepper.rejected_steps = 0.0, 0.0
    motion.control.now = stepper.t


@traced
def change_mode(code: Procedure, motion: Motion, finest: Real) -> Int:
    """Make the change of a mode that was found, and begin anew behind it."""
    stepper, switches = motion.stepper, motion.switches
    t = stepper.t
    observe(code, motion, t, BEFORE_CHANGE)
    outcome = switches.apply(Int, motion, t)
    with code.if_(outcome == Outcome.DONE):
        observe(code, motion, t, BEHIND_CHANGE)
    # without a change steps go on as they were
    renewed = (motion.equal == 0) & (switches.last[0] >= 0)
    with code.if_((outcome == Outcome.DONE) & (stepper.end - t != 0.0) & renewed):
        motion.counters.evaluations += 1
        motion.first(Int, motion)
        h, kind, lengths = stepper.h, switches.last[0], switches.first_steps
        with code.if_(stepper.first_length > 0.0):
            lengths[stepper.switch_kind.to_int] = stepper.first_length
            stepper.first_length = 0.0
        last = lengths[kind]
        most = select(last > 0.0, 2.0 * last, CAUTIOUS * abs(h))
        stepper.h = copysign(minimum(abs(h), maximum(most, finest)), h)
        stepper.before, stepper.after_switch, stepper.switch_kind = 1.0, 1.0, kind.to_real
    return outcome


@traced
def accept(
    code: Procedure, motion: Motion,
    h: Real, t_end: Real, next_carry: Real, factor: Real, changing: Bool,
) -> Int:  # fmt: skip
    """Make the end of the step in the workspace the start of the next one."""
    stepper = motion.stepper
    commit(motion, t_end)
    outcome = code.variable(margin_outcome(motion))
    with code.if_((stepper.after_switch != 0.0) & ~changing):
        stepper.first_length = abs(h)
    cautious = select(stepper.rejected_before != 0.0, minimum(factor, 1.0), factor)
    stepper.h = h * cautious
    finest = finest_step(stepper, stepper.t)
    stepper.t, stepper.carry, stepper.before = t_end, next_carry, stepper.error
    stepper.last_status, stepper.rejected_before, stepper.after_switch = 0.0, 0.0, 0.0
    with code.if_(changing & (outcome == Outcome.DONE)):
        outcome.set(change_mode(motion, finest))
    return code.value(outcome)


@traced
def reject(code: Procedure, motion: Motion, t: Real, h: Real, most: Real) -> Int:
    """Make the next trial shorter, unless it would be too short."""
    stepper, switches, factor = motion.stepper, motion.switches, code.variable(most)
    motion.counters.rejected += 1
    with code.if_(switches.find.exists):
        with code.if_(stepper.after_switch != 0.0) as case:
            factor.set(minimum(factor, SHRINK_FRESH))
        with case.else_(), code.if_(stepper.rejected_before == 0.0):
            # beyond a change forces may bend: errors there say nothing of those before
            part = switches.estimate(Real, motion, h)
            factor.set(minimum(factor, maximum(part, SHRINK_FRESH)))
    stepper.rejected_before = 1.0
    stepper.h = h * factor
    with code.if_(abs(stepper.h) < finest_step(stepper, t)):
        trouble = stepper.last_status.to_int
        with code.if_(trouble != 0):
            code.return_(outcome_of(motion, trouble))
        code.return_(Outcome.STEP_TOO_SMALL)
    return code.value(Outcome.DONE)


@traced
def give_up(code: Procedure, motion: Motion, t: Real, h: Real, status: Int) -> Int:
    """End a run with the part of an equal step that can be made; returns an `Outcome`."""
    outcome = outcome_of(motion, status)
    code.return_if(outcome != Outcome.UNREACHABLE, outcome)
    part = reachable_part(motion, t, h)
    return cut_short(motion, t, h, part, outcome)


@traced
def conclude_step(code: Procedure, motion: Motion) -> Int:
    """Finish the trial in the workspace; returns an `Outcome`."""
    switches, events = motion.switches, motion.events
    stepper, adaptive = motion.stepper, motion.equal == 0
    t, next_carry = stepper.start, code.variable(stepper.next_carry)
    factor = code.variable(stepper.factor)
    h, t_end = code.variable(stepper.length), code.variable(stepper.stop)
    accepted, changing = code.variable(stepper.accepted > 0.0), code.variable(False)
    counters, near = motion.counters, code.variable(0.0)
    counters.evaluations += motion.cost
    taken = code.variable(counters.samples)
    status = code.variable(status_of(motion, motion.stepper.status))
    with code.if_(~adaptive):
        with code.if_(status != 0):
            code.return_(give_up(motion, t, h, status))
        near.set(SNAP * abs(motion.grid[SPACING]))
    with code.if_(accepted & switches.find.exists):
        part = switches.find(Real, motion, t, h, t_end)
        with code.if_((part < 0.0) & (SHRINK_FRESH * abs(h) > finest_step(stepper, t))):
            accepted.set(False)
            factor.set(SHRINK_TURNING)
        # one at the very end is met by the next step, which begins there
        changing.set((part >= 0.0) & (part < 1.0))
        with code.if_(changing):
            h.set(h * part)
            t_end.set(t + h)
            next_carry.set((t_end - t) - (h - stepper.carry))
            near.set(0.0)
    with code.if_(accepted & (h != 0.0)):
        part = check_margins(motion, t, h, t_end)
        with code.if_(part < 1.0):
            code.return_(cut_short(motion, t, h, part, Outcome.SINGULAR))
        with code.if_(events.watch.exists):
            part = events.watch(Real, motion, t, h, t_end)
            with code.if_(part <= 1.0):
                code.return_(cut_short(motion, t, h, part, Outcome.EVENT))
        status.set(take_samples(motion, t, h, t_end, near))
    with code.if_(status != 0):
        with code.if_(~adaptive):
            code.return_(outcome_of(motion, status))
        # A sample that cannot be evaluated belongs to a step that should not be made, and those
        # before it belong to the next one.
        stepper.last_status = status.to_real
        counters.samples, stepper.sample = taken, motion.times[taken]
        code.return_(reject(motion, t, h, SHRINK_BLOCKED))
    with code.if_(~accepted):
        code.return_(reject(motion, t, h, factor))
    return accept(motion, h, t_end, next_carry, factor, changing)


@traced
def try_equal_step(code: Procedure, motion: Motion) -> None:
    """Try the next of some equal steps, or what is left of one behind a change of a mode.

    Multiplied rather than added up: t is right to its last digit after any number of steps.
    """
    stepper, grid = motion.stepper, motion.grid
    start, h, t, count = grid[ORIGIN], grid[SPACING], stepper.t, code.value(motion.equal).to_real

    def end_of(number: Real) -> Real:
        return select(number == count, stepper.end, fma(number, h, start))

    whole = t == end_of(grid[NEXT])
    with code.if_(whole):
        grid[NEXT] += 1.0
    stepper.start, stepper.stop = t, end_of(grid[NEXT])
    stepper.length = select(whole, h, stepper.stop - t)
    stepper.next_carry, stepper.factor, stepper.accepted = 0.0, 1.0, 1.0
    # such a step cannot be halved to see what modes do
    motion.stepper.halved = code.value(HALVINGS)
    motion.stepper.status = motion.attempt(Int, motion)


@traced
def go_on(code: Procedure, motion: Motion, conclude: Function) -> Int:
    """Make some steps, unless the motion is to stop; returns an `Outcome`."""
    counters = motion.counters
    code.return_if(motion.control.stop != 0.0, Outcome.INTERRUPTED)
    left = motion.budget - counters.steps - counters.rejected
    code.return_if(left <= 0, Outcome.STEP_BUDGET)
    with code.if_(motion.equal > 0):
        try_equal_step(motion)
        code.return_(conclude(Int, motion))
    result = motion.advance(Int, motion, minimum(left, code.value(TICKS)))
    note_steps(motion)
    code.return_if(result & LOWER == 0, Outcome.DONE)
    return conclude(Int, motion)


@traced
def step_loop(
    code: Procedure, motion: Motion, stage: Int, rounds: Int, begin: Function, conclude: Function
) -> Int:
    """Integrate a motion up to its end; returns an `Outcome`, or PAUSED after so many rounds.

    `stage` is START_OF_MOTION, FLAGGED_STEP where generated code has gone on up to a step that is
    to be finished, or BEHIND_STEP. `begin` and `conclude` are `begin_motion` and `conclude_step`:
    lanes call the same machine code. Row 0 holds the state, in the end the final one.
    """
    stepper, outcome, left = motion.stepper, code.variable(Outcome.DONE), code.variable(rounds)
    with code.if_(stage == START_OF_MOTION):
        outcome.set(begin(Int, motion))
    with code.if_(stage == FLAGGED_STEP):
        outcome.set(conclude(Int, motion))
    with code.while_(lambda: (outcome == Outcome.DONE) & (stepper.t != stepper.end)):
        code.return_if(left == 0, PAUSED)
        left.set(left - 1)
        outcome.set(go_on(motion, conclude))
    return code.value(outcome)
