"""Compiled loop of steps of equal length."""

from __future__ import annotations

from linkages.solvers.commit import (
    DIVERGED,
    DONE,
    INTERRUPTED,
    SINGULAR,
    STEP_BUDGET,
    begin,
    commit,
    cut_short,
    margin_outcome,
    outcome_of,
)
from linkages.solvers.compiled import compiled, entry, floats, integers
from linkages.solvers.margins import check_margins
from linkages.solvers.sampling import take_samples
from linkages.solvers.stages import NOT_FINITE, try_step
from linkages.solvers.views import EVALUATIONS, STOP, Record, System, Table

# Relative to the step, below this distance a sample time is meant to be the step's end.
SNAP = 1e-9
BISECTIONS = 60


@compiled
def reachable_part(system: System, table: Table, record: Record, t: float, h: float) -> float:
    """Longest fraction of a failed step that can be made, left in the workspace."""
    made, failed = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (made + failed)
        if try_step(system, table, t, middle * h, t + middle * h) == 0:
            made = middle
        else:
            failed = middle
    integers(record.counters)[EVALUATIONS] += (BISECTIONS + 1) * table.end
    if made > 0.0:
        try_step(system, table, t, made * h, t + made * h)
    return made


@entry
def fixed_steps(
    system: System,
    table: Table,
    record: Record,
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
        status = take_samples(system, table, record, t, h, t_end, slack)
        if status != 0:
            return outcome_of(record, status)
        commit(system, table, record, t_end)
        outcome = margin_outcome(system, record)
    return outcome
