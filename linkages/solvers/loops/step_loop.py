"""Step loop of a single motion, for all methods.

A method tries steps: `explicit_steps`, which go on by themselves until one of them needs more than
arithmetic, or `collocation_steps`. Their length follows the tolerance or is given. Each trial is
finished here.
"""

from __future__ import annotations

import math
from typing import Any

from linkages.kernel.code.operands import (
    Real,
    Truth,
    Whole,
    choose,
    floats,
    fused,
    integers,
    larger_of,
    smaller_of,
    with_sign_of,
)
from linkages.kernel.code.procedure import Procedure, printed
from linkages.solvers.loops.control import SHRINK_TURNING
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
    FRESH,
    FROM,
    HALVED,
    KIND,
    LENGTH,
    LOWER,
    NEXT_CARRY,
    NOT_FINITE,
    NOT_SETTLED,
    NOW,
    PLAIN,
    REJECTED,
    REJECTED_BEFORE,
    REJECTIONS,
    SAMPLE,
    SAMPLES,
    SMALLEST_STEP,
    START,
    STATUS,
    STEP,
    STEPS,
    STOP,
    TAKEN,
    TO,
    TROUBLE,
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


@printed
def outcome_of(code: Procedure, record: Record, status: Whole) -> Whole:
    """Outcome that a failed evaluation stands for; notes its block."""
    with code.when(status == NOT_FINITE):
        code.leave(DIVERGED)
    with code.when(status == NOT_SETTLED):
        code.leave(NOT_CONVERGED)
    integers(record.counters)[BLOCK] = status - 1
    return code.value(UNREACHABLE)


@printed
def margin_outcome(code: Procedure, system: SystemView, record: Record) -> Whole:
    """SINGULAR if a margin in row 0 is too small, noting its block; DONE otherwise."""
    with code.count(system.blocks) as block, code.when(is_too_small(system, 0, block)):
        integers(record.counters)[BLOCK] = block
        code.leave(SINGULAR)
    return code.value(DONE)


def observe(code: Procedure, record: Any, t: Real, when: float = STEP) -> None:
    """Show row 0 to what follows every step, and is told what was done."""
    with code.when(record.observer != 0):
        call_hook(record.observer, record.observed, t, code.value(when), t)


@printed
def begin(code: Procedure, system: SystemView, record: Record, start: Real, near: Real) -> Whole:
    """Evaluate row 0 at the start and take the samples within `near` of it."""
    counters = integers(record.counters)
    floats(record.control)[NOW] = start
    with code.when(~finite(system, 0, 2 * system.n)):
        code.leave(DIVERGED)
    wrap_angles(system, system.rows, record.final_turns, record.final_turns)
    counters[EVALUATIONS] += 1
    status = evaluate_at(system, start, 0)
    with code.when(status != 0):
        code.leave(outcome_of(record, status))
    with code.when(~finite(system, 0, 3 * system.n)):
        code.leave(DIVERGED)
    start_angles(system, record)
    with code.during(lambda: counters[SAMPLES] < record.samples):
        with code.when(abs(floats(record.time)[counters[SAMPLES]] - start) > near):
            code.stop()
        write_sample(system, record, 0)
    observe(code, record, start, START)
    return margin_outcome(system, record)


@printed
def settle(code: Procedure, system: SystemView) -> None:
    """Replace coordinates that are carried along in row 0 by what the iteration found there."""
    rows, found = floats(system.rows), 3 * system.n + 2 * system.blocks
    with code.count(system.carried) as i:
        place = system.first_carried + i
        rows[place] = rows[found + i]
        rows[system.n + place] = rows[found + system.carried + i]


@printed
def commit(
    code: Procedure, system: SystemView, table: TableView, record: Record, t_end: Real
) -> None:
    """Make the end of an accepted step the start of the next one.

    Where dependent angles are expected there must be known.
    """
    arrive(system, record, table.end)
    rows, last = floats(system.rows), table.end * system.width
    with code.count(system.width) as i:
        rows[i] = rows[last + i]
    settle(system)
    wrap_angles(system, system.rows, record.final_turns, record.final_turns)
    observe(code, record, t_end)
    floats(record.control)[NOW] = t_end
    integers(record.counters)[STEPS] += 1


@printed
def cut_short(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    t: Real, h: Real, part: Real, outcome: Whole,
) -> Whole:  # fmt: skip
    """End a run with the part of a step that is in the workspace."""
    with code.when(part == 0.0):
        code.leave(outcome)
    t_end = t + part * h
    status = take_samples(system, table, record, t, part * h, t_end, 0.0)
    with code.when(status != 0):
        code.leave(outcome_of(record, status))
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


@printed
def set_sample(code: Procedure, system: SystemView, record: Record) -> None:
    """Say when the next sample is to be taken."""
    pace, taken = floats(system.pace), integers(record.counters)[SAMPLES]
    pace[SAMPLE] = with_sign_of(math.inf, pace[END] - pace[T])
    with code.when(taken < record.samples):
        pace[SAMPLE] = floats(record.time)[taken]


@printed
def begin_motion(code: Procedure, context: Whole) -> Whole:
    """Evaluate a motion at its start, and choose the first step; returns an `Outcome`."""
    system, record, control = system_at(context), record_at(context), control_at(context)
    pace, near = floats(system.pace), code.variable(0.0)
    with code.when(control.equal > 0):
        near.set(SNAP * abs(floats(control.grid)[SPACING]))
    plain = (control.start != 0) & (pace[PLAIN] != 0.0)
    with code.when(plain), code.when(call_step(code, control.start, system.frame) == 0):
        code.leave(DONE)
    outcome = begin(system, record, pace[T], near)
    with code.when((outcome != DONE) | (pace[T] == pace[END]) | (control.equal > 0)):
        code.leave(outcome)
    integers(record.counters)[EVALUATIONS] += 1
    call_step(code, system.first, system.frame)
    pace[FIRST], pace[BEFORE] = abs(pace[H]), 1.0
    set_sample(system, record)
    return outcome


@printed
def note_steps(_code: Procedure, system: SystemView, table: TableView, record: Record) -> None:
    """Count the steps that printed code has made."""
    counters, pace = integers(record.counters), floats(system.pace)
    taken, rejected = pace[TAKEN].whole, pace[REJECTIONS].whole
    counters[STEPS] += taken
    counters[REJECTED] += rejected
    counters[EVALUATIONS] += table.cost * (taken + rejected)
    pace[TAKEN], pace[REJECTIONS] = 0.0, 0.0
    floats(record.control)[NOW] = pace[T]


@printed
def change_mode(
    code: Procedure, system: SystemView, record: Record, switching: SwitchingView,
    control: Control, finest: Real,
) -> Whole:  # fmt: skip
    """Make the change of a mode that was found, and begin anew behind it."""
    pace = floats(system.pace)
    t = pace[T]
    forward = choose(system.backward != 0, code.value(-1.0), 1.0)
    observe(code, record, t, BEFORE_CHANGE)
    outcome = call_hook(switching.change, switching.context, t, forward, t).whole
    with code.when(outcome == DONE):
        observe(code, record, t, BEHIND_CHANGE)
    adaptive = control.equal == 0
    with code.when((outcome == DONE) & (pace[END] - t != 0.0) & adaptive):
        integers(record.counters)[EVALUATIONS] += 1
        call_step(code, system.first, system.frame)
        h, kind = pace[H], integers(switching.kind)[0]
        last = floats(switching.first_steps)[kind]
        most = choose(last > 0.0, 2.0 * last, CAUTIOUS * abs(h))
        pace[H] = with_sign_of(smaller_of(abs(h), larger_of(most, finest)), h)
        pace[BEFORE], pace[FRESH], pace[KIND] = 1.0, 1.0, kind.real
    return outcome


def finest_step(pace: Any, t: Any) -> Any:
    """Least length of a step that moves time reliably."""
    return SMALLEST_STEP * larger_of(abs(t), pace[FIRST])


@printed
def accept(
    code: Procedure, system: SystemView, table: TableView, record: Record, switching: SwitchingView,
    control: Control, h: Real, t_end: Real, next_carry: Real, factor: Real, changing: Truth,
) -> Whole:  # fmt: skip
    """Make the end of the step in the workspace the start of the next one."""
    pace = floats(system.pace)
    expect_end(system, table, record, h)
    commit(system, table, record, t_end)
    outcome = code.variable(margin_outcome(system, record))
    with code.when((pace[FRESH] != 0.0) & ~changing & (t_end != pace[END])):
        floats(switching.first_steps)[pace[KIND].whole] = abs(h)
    cautious = choose(pace[REJECTED_BEFORE] != 0.0, smaller_of(factor, 1.0), factor)
    pace[H] = h * cautious
    finest = finest_step(pace, pace[T])
    pace[T], pace[CARRY], pace[BEFORE] = t_end, next_carry, pace[ERROR]
    pace[TROUBLE], pace[REJECTED_BEFORE], pace[FRESH] = 0.0, 0.0, 0.0
    with code.when(changing & (outcome == DONE)):
        outcome.set(change_mode(system, record, switching, control, finest))
    set_sample(system, record)
    return code.value(outcome)


@printed
def reject(
    code: Procedure, system: SystemView, record: Record, switching: SwitchingView,
    t: Real, h: Real, t_end: Real, most: Real,
) -> Whole:  # fmt: skip
    """Make the next trial shorter, unless it would be too short."""
    pace, factor = floats(system.pace), code.variable(most)
    integers(record.counters)[REJECTED] += 1
    with code.when(switching.look != 0):
        with code.when(pace[FRESH] != 0.0) as case:
            factor.set(smaller_of(factor, SHRINK_FRESH))
        with case.otherwise(), code.when(pace[REJECTED_BEFORE] == 0.0):
            # beyond a change forces may bend: errors there say nothing of those before
            part = call_hook(switching.guess, switching.context, t, h, t_end)
            factor.set(smaller_of(factor, larger_of(part, SHRINK_FRESH)))
    pace[REJECTED_BEFORE] = 1.0
    pace[H] = h * factor
    with code.when(abs(pace[H]) < finest_step(pace, t)):
        trouble = pace[TROUBLE].whole
        with code.when(trouble != 0):
            code.leave(outcome_of(record, trouble))
        code.leave(STEP_TOO_SMALL)
    return code.value(DONE)


@printed
def give_up(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    t: Real, h: Real, status: Whole,
) -> Whole:  # fmt: skip
    """End a run with the part of an equal step that can be made; returns an `Outcome`."""
    outcome = outcome_of(record, status)
    with code.when(outcome != UNREACHABLE):
        code.leave(outcome)
    part = reachable_part(system, table, record, t, h)
    return cut_short(system, table, record, t, h, part, outcome)


@printed
def conclude_step(code: Procedure, context: Whole) -> Whole:
    """Finish the trial in the workspace; returns an `Outcome`."""
    system, table, record = system_at(context), table_at(context), record_at(context)
    hook, switching, control = hook_at(context), switching_at(context), control_at(context)
    pace, adaptive = floats(system.pace), control.equal == 0
    t, next_carry, factor = pace[FROM], code.variable(pace[NEXT_CARRY]), code.variable(pace[FACTOR])
    h, t_end = code.variable(pace[LENGTH]), code.variable(pace[TO])
    accepted, changing = code.variable(pace[ACCEPTED] > 0.0), code.variable(False)
    counters, near = integers(record.counters), code.variable(0.0)
    counters[EVALUATIONS] += table.cost
    taken = code.variable(counters[SAMPLES])
    status = code.variable(status_of(system, integers(system.pace)[STATUS]))
    with code.when(~adaptive):
        with code.when(status != 0):
            code.leave(give_up(system, table, record, t, h, status))
        near.set(SNAP * abs(floats(control.grid)[SPACING]))
    with code.when(accepted & (switching.look != 0)):
        part = call_hook(switching.look, switching.context, t, h, t_end)
        with code.when((part < 0.0) & (abs(h) > finest_step(pace, t))):
            accepted.set(False)
            factor.set(SHRINK_TURNING)
        # one at the very end is met by the next step, which begins there
        changing.set((part >= 0.0) & (part < 1.0))
        with code.when(changing):
            h.set(h * part)
            t_end.set(t + h)
            next_carry.set((t_end - t) - (h - pace[CARRY]))
            near.set(0.0)
    with code.when(accepted & (h != 0.0)):
        part = check_margins(system, table, record, t, h, t_end)
        with code.when(part < 1.0):
            code.leave(cut_short(system, table, record, t, h, part, SINGULAR))
        with code.when(hook.function != 0):
            part = call_hook(hook.function, hook.context, t, h, t_end)
            with code.when(part <= 1.0):
                code.leave(cut_short(system, table, record, t, h, part, EVENT))
        status.set(take_samples(system, table, record, t, h, t_end, near))
    with code.when(status != 0):
        with code.when(~adaptive):
            code.leave(outcome_of(record, status))
        # A sample that cannot be evaluated belongs to a step that should not be made, and those
        # before it belong to the next one.
        pace[TROUBLE] = status.real
        counters[SAMPLES] = taken
        code.leave(reject(system, record, switching, t, h, t_end, SHRINK_BLOCKED))
    with code.when(~accepted):
        code.leave(reject(system, record, switching, t, h, t_end, factor))
    return accept(system, table, record, switching, control, h, t_end, next_carry, factor, changing)


@printed
def try_equal_step(code: Procedure, system: SystemView, control: Control) -> None:
    """Try the next of some equal steps, or what is left of one behind a change of a mode.

    Multiplied rather than added up: t is right to its last digit after any number of steps.
    """
    pace, grid = floats(system.pace), floats(control.grid)
    start, h, t, count = grid[ORIGIN], grid[SPACING], pace[T], control.equal.real

    def end_of(number: Real) -> Real:
        return choose(number == count, pace[END], fused(number, h, start))

    whole = t == end_of(grid[NEXT])
    with code.when(whole):
        grid[NEXT] += 1.0
    pace[FROM], pace[TO] = t, end_of(grid[NEXT])
    pace[LENGTH] = choose(whole, h, pace[TO] - t)
    pace[NEXT_CARRY], pace[FACTOR], pace[ACCEPTED] = 0.0, 1.0, 1.0
    # such a step cannot be halved to see what modes do
    integers(system.pace)[HALVED] = code.value(HALVINGS)
    integers(system.pace)[STATUS] = call_step(code, system.attempt, system.frame)


@printed
def go_on(code: Procedure, context: Whole, conclude: Whole) -> Whole:
    """Make some steps, unless the motion is to stop; returns an `Outcome`."""
    system, table, record = system_at(context), table_at(context), record_at(context)
    control, counters = control_at(context), integers(record.counters)
    with code.when(floats(record.control)[STOP] != 0.0):
        code.leave(INTERRUPTED)
    left = control.budget - counters[STEPS] - counters[REJECTED]
    with code.when(left <= 0):
        code.leave(STEP_BUDGET)
    with code.when(control.equal > 0):
        try_equal_step(system, control)
        code.leave(call_step(code, conclude, context))
    ticks = smaller_of(left, code.value(TICKS))
    found = code.call_at(control.advance, Whole, system.frame, ticks)
    note_steps(system, table, record)
    with code.when(found & LOWER == 0):
        code.leave(DONE)
    return call_step(code, conclude, context)


@printed
def step_loop(
    code: Procedure, context: Whole, flagged: Whole, begin: Whole, conclude: Whole
) -> Whole:
    """Integrate a motion from its start to its end; returns an `Outcome`.

    `context` is the address of a `SystemView`, `TableView`, `Record`, `Hook`, `SwitchingView` and
    `Control` in a row; `flagged` is 1 where printed code has gone on up to a step that is to be
    finished, and 0 at the start. `begin` and `conclude` are addresses of the functions above: lanes
    call the same machine code. Row 0 holds the state, in the end the final one; its time is
    ``control[NOW]``.
    """
    pace = floats(system_at(context).pace)
    outcome = code.variable(call_step(code, choose(flagged == 0, begin, conclude), context))
    with code.during(lambda: (outcome == DONE) & (pace[T] != pace[END])):
        outcome.set(go_on(context, conclude))
    return code.value(outcome)


def system_at(context: Whole, lasting: bool = True) -> Any:
    """The first part of a context, which lasts where it is an argument."""
    return context.code.fields_at(context, SystemView, 0, lasting)


def table_at(context: Whole, lasting: bool = True) -> Any:
    """Its tableau."""
    return context.code.fields_at(context, TableView, TABLE, lasting)


def record_at(context: Whole, lasting: bool = True) -> Any:
    """Its record."""
    return context.code.fields_at(context, Record, RECORD, lasting)


def hook_at(context: Whole, lasting: bool = True) -> Any:
    """What sees its accepted steps."""
    return context.code.fields_at(context, Hook, HOOK, lasting)


def switching_at(context: Whole, lasting: bool = True) -> Any:
    """What changes its modes."""
    return context.code.fields_at(context, SwitchingView, SWITCHING, lasting)


def control_at(context: Whole, lasting: bool = True) -> Any:
    """How its steps follow a tolerance."""
    return context.code.fields_at(context, Control, CONTROL, lasting)
