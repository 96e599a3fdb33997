"""Step loop of a single motion, for all methods.

A method tries steps: `explicit_steps`, which go on by themselves until one of them needs more than
arithmetic, or `collocation_steps`. Their length follows the tolerance or is given. Each trial is
finished here.
"""

from __future__ import annotations

import math
from typing import Any

from linkages.kernel.code.operands import (
    Bool,
    Int,
    Real,
    copysign,
    floats,
    fma,
    integers,
    maximum,
    minimum,
    select,
)
from linkages.kernel.code.procedure import Procedure, traced
from linkages.solvers.loops.control import SHRINK_TURNING, finest_step
from linkages.solvers.loops.margins import (
    SNAP,
    arrive,
    check_margins,
    expect_end,
    is_too_small,
    reachable_part,
    start_angles,
    take_samples,
    write_sample,
)
from linkages.solvers.loops.memory import (
    ACCEPTED,
    ACCEPTED_STEPS,
    AFTER_SWITCH,
    BEFORE,
    BEFORE_CHANGE,
    BEHIND_CHANGE,
    BLOCK,
    CARRY,
    END,
    ERROR,
    EVALUATIONS,
    FACTOR,
    FIRST,
    FIRST_LENGTH,
    FROM,
    HALVED,
    LAST_STATUS,
    LENGTH,
    LOWER,
    NEXT_CARRY,
    NOT_FINITE,
    NOT_SETTLED,
    NOW,
    REJECTED,
    REJECTED_BEFORE,
    REJECTED_STEPS,
    SAMPLE,
    SAMPLES,
    START,
    STATUS,
    STEP,
    STEPS,
    STOP,
    SWITCH_KIND,
    TO,
    UNOBSERVED,
    Control,
    H,
    Hook,
    Record,
    SwitchingView,
    SystemView,
    T,
    TableView,
)
from linkages.solvers.loops.predicates import HALVINGS
from linkages.solvers.loops.scalar_stages import (
    call_hook,
    call_step,
    evaluate_at,
    finite,
    status_of,
    wrap_angles,
)
from linkages.solvers.trajectory import Outcome

# Compiled code takes plain integers.
DONE = int(Outcome.DONE)
UNREACHABLE = int(Outcome.UNREACHABLE)
SINGULAR = int(Outcome.SINGULAR)
STEP_TOO_SMALL = int(Outcome.STEP_TOO_SMALL)
DIVERGED = int(Outcome.NOT_FINITE)
STEP_BUDGET = int(Outcome.STEP_BUDGET)
INTERRUPTED = int(Outcome.INTERRUPTED)
NOT_CONVERGED = int(Outcome.NOT_CONVERGED)
EVENT = int(Outcome.EVENT)
SLIDING = int(Outcome.SLIDING)
CHATTER = int(Outcome.CHATTER)


@traced
def outcome_of(code: Procedure, record: Record, status: Int) -> Int:
    """Outcome that a failed evaluation stands for; notes its block."""
    with code.if_(status == NOT_FINITE):
        code.return_(DIVERGED)
    with code.if_(status == NOT_SETTLED):
        code.return_(NOT_CONVERGED)
    integers(record.counters)[BLOCK] = status - 1
    return code.value(UNREACHABLE)


@traced
def margin_outcome(code: Procedure, system: SystemView, record: Record) -> Int:
    """SINGULAR if a margin in row 0 is too small, noting its block; DONE otherwise."""
    with code.for_range(system.blocks) as block, code.if_(is_too_small(system, 0, block)):
        integers(record.counters)[BLOCK] = block
        code.return_(SINGULAR)
    return code.value(DONE)


def observe(code: Procedure, record: Any, t: Real, when: float = STEP) -> None:
    """Show row 0 to what follows every step, and is told what was done."""
    with code.if_(record.observer != 0):
        call_hook(record.observer, record.observed, t, code.value(when), t)


@traced
def begin(code: Procedure, system: SystemView, record: Record, start: Real, near: Real) -> Int:
    """Evaluate row 0 at the start and take the samples within `near` of it."""
    counters = integers(record.counters)
    floats(record.control)[NOW] = start
    with code.if_(~finite(system, 0, 2 * system.n)):
        code.return_(DIVERGED)
    wrap_angles(system, system.rows, record.final_turns, record.final_turns)
    counters[EVALUATIONS] += 1
    status = evaluate_at(system, start, 0)
    with code.if_(status != 0):
        code.return_(outcome_of(record, status))
    with code.if_(~finite(system, 0, 3 * system.n)):
        code.return_(DIVERGED)
    start_angles(system, record)
    with code.while_(lambda: counters[SAMPLES] < record.samples):
        with code.if_(abs(floats(record.time)[counters[SAMPLES]] - start) > near):
            code.break_()
        write_sample(system, record, 0)
    observe(code, record, start, START)
    return margin_outcome(system, record)


@traced
def settle(code: Procedure, system: SystemView) -> None:
    """Replace coordinates that are carried along in row 0 by what the iteration found there."""
    rows, result = floats(system.rows), 3 * system.n + 2 * system.blocks
    with code.for_range(system.carried) as i:
        place = system.first_carried + i
        rows[place] = rows[result + i]
        rows[system.n + place] = rows[result + system.carried + i]


@traced
def commit(
    code: Procedure, system: SystemView, table: TableView, record: Record, t_end: Real
) -> None:
    """Make the end of an accepted step the start of the next one.

    Where dependent angles are expected there must be known.
    """
    arrive(system, record, table.end)
    rows, last = floats(system.rows), table.end * system.width
    with code.for_range(system.width) as i:
        rows[i] = rows[last + i]
    settle(system)
    wrap_angles(system, system.rows, record.final_turns, record.final_turns)
    observe(code, record, t_end)
    floats(record.control)[NOW] = t_end
    integers(record.counters)[STEPS] += 1


@traced
def cut_short(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    t: Real, h: Real, part: Real, outcome: Int,
) -> Int:  # fmt: skip
    """End a run with the part of a step that is in the workspace."""
    with code.if_(part == 0.0):
        code.return_(outcome)
    t_end = t + part * h
    status = take_samples(system, table, record, t, part * h, t_end, 0.0)
    with code.if_(status != 0):
        code.return_(outcome_of(record, status))
    expect_end(system, table, record, part * h)
    commit(system, table, record, t_end)
    return outcome


# Where the parts of a context begin: a `SystemView`, `TableView`, `Record`, `Hook`, `SwitchingView`
# and `Control` in a row.
TABLE = len(SystemView._fields)
RECORD = TABLE + len(TableView._fields)
HOOK = RECORD + len(Record._fields)
SWITCHING = HOOK + len(Hook._fields)
CONTROL = SWITCHING + len(SwitchingView._fields)
# A trial that leaves the reach of a block says nothing about how far that block reaches.
SHRINK_BLOCKED = 0.25
# Behind a change of a mode forces may grow like roots (t^1.5 in a contact): errors fall with low
# powers of the step there, whatever the order.
SHRINK_FRESH = 0.1
# An estimate of such an error is small by accident now and then, so no step that is far too long
# must be tried: the first of its kind is so much shorter than smooth equations would allow, and
# later ones are at most twice as long as the last.
CAUTIOUS = 3e-4
# Entries of `Control.grid`.
ORIGIN, SPACING, NEXT = range(3)
# Trials between two looks at whether to stop.
TICKS = 64


@traced
def set_sample(code: Procedure, system: SystemView, record: Record) -> None:
    """Say when the next sample is to be taken."""
    stepper, taken = floats(system.stepper), integers(record.counters)[SAMPLES]
    stepper[SAMPLE] = copysign(math.inf, stepper[END] - stepper[T])
    with code.if_(taken < record.samples):
        stepper[SAMPLE] = floats(record.time)[taken]


@traced
def begin_motion(code: Procedure, context: Int) -> Int:
    """Evaluate a motion at its start, and choose the first step; returns an `Outcome`."""
    system, record, control = system_at(context), record_at(context), control_at(context)
    stepper, near = floats(system.stepper), code.variable(0.0)
    with code.if_(control.equal > 0):
        near.set(SNAP * abs(floats(control.grid)[SPACING]))
    plain = (control.start != 0) & (stepper[UNOBSERVED] != 0.0)
    with code.if_(plain), code.if_(call_step(code, control.start, system.pointers) == 0):
        code.return_(DONE)
    outcome = begin(system, record, stepper[T], near)
    with code.if_((outcome != DONE) | (stepper[T] == stepper[END]) | (control.equal > 0)):
        code.return_(outcome)
    integers(record.counters)[EVALUATIONS] += 1
    call_step(code, system.first, system.pointers)
    stepper[FIRST], stepper[BEFORE] = abs(stepper[H]), 1.0
    set_sample(system, record)
    return outcome


@traced
def note_steps(_code: Procedure, system: SystemView, table: TableView, record: Record) -> None:
    """Count the steps that generated code has made."""
    counters, stepper = integers(record.counters), floats(system.stepper)
    taken, rejected = stepper[ACCEPTED_STEPS].to_int, stepper[REJECTED_STEPS].to_int
    counters[STEPS] += taken
    counters[REJECTED] += rejected
    counters[EVALUATIONS] += table.cost * (taken + rejected)
    stepper[ACCEPTED_STEPS], stepper[REJECTED_STEPS] = 0.0, 0.0
    floats(record.control)[NOW] = stepper[T]


@traced
def change_mode(
    code: Procedure, system: SystemView, record: Record, switching: SwitchingView,
    control: Control, finest: Real,
) -> Int:  # fmt: skip
    """Make the change of a mode that was found, and begin anew behind it."""
    stepper = floats(system.stepper)
    t = stepper[T]
    forward = select(system.backward != 0, code.value(-1.0), 1.0)
    observe(code, record, t, BEFORE_CHANGE)
    outcome = call_hook(switching.apply, switching.context, t, forward, t).to_int
    with code.if_(outcome == DONE):
        observe(code, record, t, BEHIND_CHANGE)
    adaptive = control.equal == 0
    with code.if_((outcome == DONE) & (stepper[END] - t != 0.0) & adaptive):
        integers(record.counters)[EVALUATIONS] += 1
        call_step(code, system.first, system.pointers)
        h, kind, lengths = stepper[H], integers(switching.kind)[0], floats(switching.first_steps)
        with code.if_(stepper[FIRST_LENGTH] > 0.0):
            lengths[stepper[SWITCH_KIND].to_int] = stepper[FIRST_LENGTH]
            stepper[FIRST_LENGTH] = 0.0
        last = lengths[kind]
        most = select(last > 0.0, 2.0 * last, CAUTIOUS * abs(h))
        stepper[H] = copysign(minimum(abs(h), maximum(most, finest)), h)
        stepper[BEFORE], stepper[AFTER_SWITCH], stepper[SWITCH_KIND] = 1.0, 1.0, kind.to_real
    return outcome


@traced
def accept(
    code: Procedure, system: SystemView, table: TableView, record: Record, switching: SwitchingView,
    control: Control, h: Real, t_end: Real, next_carry: Real, factor: Real, changing: Bool,
) -> Int:  # fmt: skip
    """Make the end of the step in the workspace the start of the next one."""
    stepper = floats(system.stepper)
    expect_end(system, table, record, h)
    commit(system, table, record, t_end)
    outcome = code.variable(margin_outcome(system, record))
    with code.if_((stepper[AFTER_SWITCH] != 0.0) & ~changing):
        stepper[FIRST_LENGTH] = abs(h)
    cautious = select(stepper[REJECTED_BEFORE] != 0.0, minimum(factor, 1.0), factor)
    stepper[H] = h * cautious
    finest = finest_step(stepper, stepper[T])
    stepper[T], stepper[CARRY], stepper[BEFORE] = t_end, next_carry, stepper[ERROR]
    stepper[LAST_STATUS], stepper[REJECTED_BEFORE], stepper[AFTER_SWITCH] = 0.0, 0.0, 0.0
    with code.if_(changing & (outcome == DONE)):
        outcome.set(change_mode(system, record, switching, control, finest))
    set_sample(system, record)
    return code.value(outcome)


@traced
def reject(
    code: Procedure, system: SystemView, record: Record, switching: SwitchingView,
    t: Real, h: Real, t_end: Real, most: Real,
) -> Int:  # fmt: skip
    """Make the next trial shorter, unless it would be too short."""
    stepper, factor = floats(system.stepper), code.variable(most)
    integers(record.counters)[REJECTED] += 1
    with code.if_(switching.find != 0):
        with code.if_(stepper[AFTER_SWITCH] != 0.0) as case:
            factor.set(minimum(factor, SHRINK_FRESH))
        with case.else_(), code.if_(stepper[REJECTED_BEFORE] == 0.0):
            # beyond a change forces may bend: errors there say nothing of those before
            part = call_hook(switching.estimate, switching.context, t, h, t_end)
            factor.set(minimum(factor, maximum(part, SHRINK_FRESH)))
    stepper[REJECTED_BEFORE] = 1.0
    stepper[H] = h * factor
    with code.if_(abs(stepper[H]) < finest_step(stepper, t)):
        trouble = stepper[LAST_STATUS].to_int
        with code.if_(trouble != 0):
            code.return_(outcome_of(record, trouble))
        code.return_(STEP_TOO_SMALL)
    return code.value(DONE)


@traced
def give_up(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    t: Real, h: Real, status: Int,
) -> Int:  # fmt: skip
    """End a run with the part of an equal step that can be made; returns an `Outcome`."""
    outcome = outcome_of(record, status)
    with code.if_(outcome != UNREACHABLE):
        code.return_(outcome)
    part = reachable_part(system, table, record, t, h)
    return cut_short(system, table, record, t, h, part, outcome)


@traced
def conclude_step(code: Procedure, context: Int) -> Int:
    """Finish the trial in the workspace; returns an `Outcome`."""
    system, table, record = system_at(context), table_at(context), record_at(context)
    hook, switching, control = hook_at(context), switching_at(context), control_at(context)
    stepper, adaptive = floats(system.stepper), control.equal == 0
    t, next_carry, factor = (
        stepper[FROM],
        code.variable(stepper[NEXT_CARRY]),
        code.variable(stepper[FACTOR]),
    )
    h, t_end = code.variable(stepper[LENGTH]), code.variable(stepper[TO])
    accepted, changing = code.variable(stepper[ACCEPTED] > 0.0), code.variable(False)
    counters, near = integers(record.counters), code.variable(0.0)
    counters[EVALUATIONS] += table.cost
    taken = code.variable(counters[SAMPLES])
    status = code.variable(status_of(system, integers(system.stepper)[STATUS]))
    with code.if_(~adaptive):
        with code.if_(status != 0):
            code.return_(give_up(system, table, record, t, h, status))
        near.set(SNAP * abs(floats(control.grid)[SPACING]))
    with code.if_(accepted & (switching.find != 0)):
        part = call_hook(switching.find, switching.context, t, h, t_end)
        with code.if_((part < 0.0) & (abs(h) > finest_step(stepper, t))):
            accepted.set(False)
            factor.set(SHRINK_TURNING)
        # one at the very end is met by the next step, which begins there
        changing.set((part >= 0.0) & (part < 1.0))
        with code.if_(changing):
            h.set(h * part)
            t_end.set(t + h)
            next_carry.set((t_end - t) - (h - stepper[CARRY]))
            near.set(0.0)
    with code.if_(accepted & (h != 0.0)):
        part = check_margins(system, table, record, t, h, t_end)
        with code.if_(part < 1.0):
            code.return_(cut_short(system, table, record, t, h, part, SINGULAR))
        with code.if_(hook.function != 0):
            part = call_hook(hook.function, hook.context, t, h, t_end)
            with code.if_(part <= 1.0):
                code.return_(cut_short(system, table, record, t, h, part, EVENT))
        status.set(take_samples(system, table, record, t, h, t_end, near))
    with code.if_(status != 0):
        with code.if_(~adaptive):
            code.return_(outcome_of(record, status))
        # A sample that cannot be evaluated belongs to a step that should not be made, and those
        # before it belong to the next one.
        stepper[LAST_STATUS] = status.to_real
        counters[SAMPLES] = taken
        code.return_(reject(system, record, switching, t, h, t_end, SHRINK_BLOCKED))
    with code.if_(~accepted):
        code.return_(reject(system, record, switching, t, h, t_end, factor))
    return accept(system, table, record, switching, control, h, t_end, next_carry, factor, changing)


@traced
def try_equal_step(code: Procedure, system: SystemView, control: Control) -> None:
    """Try the next of some equal steps, or what is left of one behind a change of a mode.

    Multiplied rather than added up: t is right to its last digit after any number of steps.
    """
    stepper, grid = floats(system.stepper), floats(control.grid)
    start, h, t, count = grid[ORIGIN], grid[SPACING], stepper[T], code.value(control.equal).to_real

    def end_of(number: Real) -> Real:
        return select(number == count, stepper[END], fma(number, h, start))

    whole = t == end_of(grid[NEXT])
    with code.if_(whole):
        grid[NEXT] += 1.0
    stepper[FROM], stepper[TO] = t, end_of(grid[NEXT])
    stepper[LENGTH] = select(whole, h, stepper[TO] - t)
    stepper[NEXT_CARRY], stepper[FACTOR], stepper[ACCEPTED] = 0.0, 1.0, 1.0
    # such a step cannot be halved to see what modes do
    integers(system.stepper)[HALVED] = code.value(HALVINGS)
    integers(system.stepper)[STATUS] = call_step(code, system.attempt, system.pointers)


@traced
def go_on(code: Procedure, context: Int, conclude: Int) -> Int:
    """Make some steps, unless the motion is to stop; returns an `Outcome`."""
    system, table, record = system_at(context), table_at(context), record_at(context)
    control, counters = control_at(context), integers(record.counters)
    with code.if_(floats(record.control)[STOP] != 0.0):
        code.return_(INTERRUPTED)
    left = control.budget - counters[STEPS] - counters[REJECTED]
    with code.if_(left <= 0):
        code.return_(STEP_BUDGET)
    with code.if_(control.equal > 0):
        try_equal_step(system, control)
        code.return_(call_step(code, conclude, context))
    ticks = minimum(left, code.value(TICKS))
    result = code.call_at(control.advance, Int, system.pointers, ticks)
    note_steps(system, table, record)
    with code.if_(result & LOWER == 0):
        code.return_(DONE)
    return call_step(code, conclude, context)


@traced
def step_loop(code: Procedure, context: Int, flagged: Int, begin: Int, conclude: Int) -> Int:
    """Integrate a motion from its start to its end; returns an `Outcome`.

    `context` is the address of a `SystemView`, `TableView`, `Record`, `Hook`, `SwitchingView` and
    `Control` in a row; `flagged` is 1 where generated code has gone on up to a step that is to be
    finished, and 0 at the start. `begin` and `conclude` are addresses of the functions above: lanes
    call the same machine code. Row 0 holds the state, in the end the final one; its time is
    ``control[NOW]``.
    """
    stepper = floats(system_at(context).stepper)
    outcome = code.variable(call_step(code, select(flagged == 0, begin, conclude), context))
    with code.while_(lambda: (outcome == DONE) & (stepper[T] != stepper[END])):
        outcome.set(go_on(context, conclude))
    return code.value(outcome)


def system_at(context: Int, lasting: bool = True) -> Any:
    """The first part of a context, which lasts where it is an argument."""
    return context.code.fields_at(context, SystemView, 0, lasting)


def table_at(context: Int, lasting: bool = True) -> Any:
    """Its tableau."""
    return context.code.fields_at(context, TableView, TABLE, lasting)


def record_at(context: Int, lasting: bool = True) -> Any:
    """Its record."""
    return context.code.fields_at(context, Record, RECORD, lasting)


def hook_at(context: Int, lasting: bool = True) -> Any:
    """What sees its accepted steps."""
    return context.code.fields_at(context, Hook, HOOK, lasting)


def switching_at(context: Int, lasting: bool = True) -> Any:
    """What changes its modes."""
    return context.code.fields_at(context, SwitchingView, SWITCHING, lasting)


def control_at(context: Int, lasting: bool = True) -> Any:
    """How its steps follow a tolerance."""
    return context.code.fields_at(context, Control, CONTROL, lasting)
