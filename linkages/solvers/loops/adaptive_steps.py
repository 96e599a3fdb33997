"""Compiled loop of steps whose length follows a tolerance."""

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
from linkages.solvers.loops.step_size import (
    CAUTIOUS,
    SHRINK_BLOCKED,
    SHRINK_FRESH,
    SHRINK_TURNING,
    error_norm,
    first_step,
    next_factor,
)
from linkages.solvers.steps.compiled import call_hook, compiled, floats, integers
from linkages.solvers.steps.stages import try_step
from linkages.solvers.steps.views import (
    EVALUATIONS,
    REJECTED,
    STEPS,
    STOP,
    Hook,
    Record,
    Switching,
    System,
    Table,
)
from linkages.solvers.watched.counting import expect_end
from linkages.solvers.watched.margins import check_margins, turns_too_far
from linkages.solvers.watched.sampling import take_samples

# Steps below this many units in the last place of time no longer move it reliably.
SMALLEST_STEP = 16 * 2.220446049250313e-16


@compiled
def adaptive_steps(
    system: System,
    table: Table,
    record: Record,
    hook: Hook,
    switching: Switching,
    start: float,
    end: float,
    rtol: float,
    atol: int,
    zeros: int,
    order: int,
    memory: float,
    budget: int,
) -> int:
    """Integrate from start to end with an error estimate of an order kept at a tolerance.

    Row 0 holds the state; `atol` and `zeros` are addresses of (2n,) numbers; `memory` weighs the
    error of the step before in the control of the next one. Returns an
    `Outcome`; the final state is in row 0, its time in ``control[NOW]``.
    """
    exponent = 1.0 / (order + 1)
    counters, control = integers(record.counters), floats(record.control)
    outcome = begin(system, record, start, 0.0)
    if outcome != DONE or start == end:
        return outcome
    counters[EVALUATIONS] += 1
    h = first_step(system, start, end - start, order, rtol, atol, zeros)
    t, carry, first = start, 0.0, abs(h)
    trouble, rejected, before = 0, False, 1.0
    error, fresh, kind = 0.0, False, 0
    while outcome == DONE and t != end:
        if control[STOP] != 0.0:
            return INTERRUPTED
        if counters[STEPS] + counters[REJECTED] >= budget:
            return STEP_BUDGET
        # Time is summed with compensation: `carry` is what t is too large by.
        moved = h - carry
        t_end = t + moved
        next_carry = (t_end - t) - moved
        remaining = (end - t) + carry
        finest = SMALLEST_STEP * max(abs(t), first)
        if 1.01 * abs(h) >= abs(remaining):
            h, t_end, next_carry = remaining, end, 0.0
        counters[EVALUATIONS] += table.end
        status = try_step(system, table, t, h, t_end)
        factor, accepted = SHRINK_BLOCKED, False
        if status == 0:
            error = error_norm(system, table, h, rtol, atol)
            factor = next_factor(error, before, exponent, memory)
            accepted = error <= 1.0
            if accepted and turns_too_far(system, table.end, h):
                accepted, factor = False, SHRINK_TURNING
        changing = False
        if accepted and switching.look != 0:
            part = call_hook(switching.look, switching.context, t, h, t_end)
            if part < 0.0 and abs(h) > finest:
                accepted, factor = False, SHRINK_TURNING
            changing = 0.0 <= part <= 1.0
            if 0.0 <= part < 1.0:
                h *= part
                t_end = t + h
                next_carry = (t_end - t) - (h - carry)
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
            accepted, factor, trouble = False, SHRINK_BLOCKED, status
        if accepted:
            expect_end(system, table, record, h)
            commit(system, table, record, t_end)
            outcome = margin_outcome(system, record)
            t, carry, before = t_end, next_carry, error
            if fresh and not changing and t != end:
                floats(switching.first_steps)[kind] = abs(h)
            h *= min(factor, 1.0) if rejected else factor
            trouble, rejected, fresh = 0, False, False
            if changing and outcome == DONE:
                outcome = int(call_hook(switching.change, switching.context, t, end - start, t))
                if outcome == DONE and t != end:
                    counters[EVALUATIONS] += 1
                    h = first_step(system, t, end - t, order, rtol, atol, zeros)
                    kind = integers(switching.kind)[0]
                    last = floats(switching.first_steps)[kind]
                    most = 2.0 * last if last > 0.0 else CAUTIOUS * abs(h)
                    h = math.copysign(min(abs(h), max(most, finest)), h)
                    before, fresh = 1.0, True
        else:
            counters[REJECTED] += 1
            if switching.look != 0:
                if fresh:
                    factor = min(factor, SHRINK_FRESH)
                elif not rejected:
                    # beyond a change forces may bend: errors there say nothing of those before
                    part = call_hook(switching.guess, switching.context, t, h, t_end)
                    factor = min(factor, max(part, SHRINK_FRESH))
            rejected = True
            h *= factor
            if abs(h) < finest:
                return outcome_of(record, trouble) if trouble != 0 else STEP_TOO_SMALL
    return outcome
