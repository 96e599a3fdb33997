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
from linkages.solvers.steps.compiled import call_hook, entry, floats, integers
from linkages.solvers.steps.stages import NOT_FINITE, try_step
from linkages.solvers.steps.views import EVALUATIONS, STOP, Hook, Record, System, Table
from linkages.solvers.watched.counting import expect_end
from linkages.solvers.watched.margins import check_margins
from linkages.solvers.watched.reach import reachable_part
from linkages.solvers.watched.sampling import SNAP, take_samples


@entry
def fixed_steps(
    system: System,
    table: Table,
    record: Record,
    hook: Hook,
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
        counters[EVALUATIONS] += table.end
        status = try_step(system, table, t, h, t_end)
        if status == NOT_FINITE:
            return DIVERGED
        if status != 0:
            outcome = outcome_of(record, status)
            part = reachable_part(system, table, record, t, h)
            return cut_short(system, table, record, t, h, part, outcome)
        part = check_margins(system, table, record, t, h, t_end)
        if part < 1.0:
            return cut_short(system, table, record, t, h, part, SINGULAR)
        if hook.function != 0:
            part = call_hook(hook.function, hook.context, t, h, t_end)
            if part <= 1.0:
                return cut_short(system, table, record, t, h, part, EVENT)
        status = take_samples(system, table, record, t, h, t_end, slack)
        if status != 0:
            return outcome_of(record, status)
        expect_end(system, table, record, h)
        commit(system, table, record, t_end)
        outcome = margin_outcome(system, record)
    return outcome
