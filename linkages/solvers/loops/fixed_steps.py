"""Compiled loop of steps of equal length."""

from __future__ import annotations

from linkages.solvers.loops.commit import (
    DIVERGED,
    DONE,
    EVENT,
    INTERRUPTED,
    SINGULAR,
    STEP_BUDGET,
    begin,
    commit,
    cut_short,
    margin_outcome,
    outcome_of,
)
from linkages.solvers.steps.compiled import call_hook, compiled, floats, integers
from linkages.solvers.steps.stages import NOT_FINITE, try_step
from linkages.solvers.steps.views import (
    EVALUATIONS,
    STOP,
    Hook,
    Record,
    SwitchingView,
    SystemView,
    TableView,
)
from linkages.solvers.watched.counting import expect_end
from linkages.solvers.watched.margins import check_margins
from linkages.solvers.watched.reach import reachable_part
from linkages.solvers.watched.sampling import SNAP, take_samples


@compiled
def fixed_steps(
    system: SystemView,
    table: TableView,
    record: Record,
    hook: Hook,
    switching: SwitchingView,
    start: float,
    end: float,
    count: int,
    budget: int,
) -> int:
    """Integrate from start to end in `count` steps, of which `budget` may be used.

    Row 0 holds the state. Returns an `Outcome`; the final state is in row 0, its time in
    ``control[NOW]``.
    """
    h = (end - start) / count
    counters, control = integers(record.counters), floats(record.control)
    slack = SNAP * abs(h)
    outcome = begin(system, record, start, slack)
    if start == end:
        return outcome
    for i in range(count):
        if outcome != DONE:
            return outcome
        if control[STOP] != 0.0:
            return INTERRUPTED
        if i == budget:
            return STEP_BUDGET
        # Multiplied rather than added up: t is right to its last digit after any number of steps.
        t = start + i * h
        t_end = end if i == count - 1 else start + (i + 1) * h
        made, reached = h, t_end
        while True:
            counters[EVALUATIONS] += table.end
            status = try_step(system, t, made, reached)
            if status == NOT_FINITE:
                return DIVERGED
            if status != 0:
                outcome = outcome_of(record, status)
                part = reachable_part(system, table, record, t, made)
                return cut_short(system, table, record, t, made, part, outcome)
            changing = False
            if switching.look != 0:
                part = call_hook(switching.look, switching.context, t, made, reached)
                changing = 0.0 <= part <= 1.0
                if 0.0 <= part < 1.0:
                    made *= part
                    reached = t + made
            if made != 0.0:
                part = check_margins(system, table, record, t, made, reached)
                if part < 1.0:
                    return cut_short(system, table, record, t, made, part, SINGULAR)
                if hook.function != 0:
                    part = call_hook(hook.function, hook.context, t, made, reached)
                    if part <= 1.0:
                        return cut_short(system, table, record, t, made, part, EVENT)
                near = slack if reached == t_end else 0.0
                status = take_samples(system, table, record, t, made, reached, near)
                if status != 0:
                    return outcome_of(record, status)
            expect_end(system, table, record, made)
            commit(system, table, record, reached)
            outcome = margin_outcome(system, record)
            if changing and outcome == DONE:
                outcome = int(call_hook(switching.change, switching.context, t, h, reached))
            if reached == t_end or outcome != DONE:
                break
            # what is left of the step behind a change
            t, made, reached = reached, t_end - reached, t_end
    return outcome
