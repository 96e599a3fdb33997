"""Start a run, and go from the end of one step to the start of the next."""

from __future__ import annotations

from linkages.solvers.outcome import Outcome
from linkages.solvers.steps.compiled import call_hook, compiled, floats, integers
from linkages.solvers.steps.stages import NOT_FINITE, evaluate, finite, set_clock
from linkages.solvers.steps.turns import wrap_angles
from linkages.solvers.steps.views import (
    BLOCK,
    EVALUATIONS,
    NOW,
    SAMPLES,
    STEPS,
    Record,
    SystemView,
    TableView,
)
from linkages.solvers.watched.counting import arrive, expect_end, start_angles
from linkages.solvers.watched.margins import is_too_small
from linkages.solvers.watched.sampling import take_samples, write_sample

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


@compiled
def outcome_of(record: Record, status: int) -> int:
    """Outcome that a failed evaluation stands for; notes its block."""
    if status == NOT_FINITE:
        return DIVERGED
    integers(record.counters)[BLOCK] = status - 1
    return UNREACHABLE


@compiled
def margin_outcome(system: SystemView, record: Record) -> int:
    """SINGULAR if a margin in row 0 is too small, noting its block; DONE otherwise."""
    for block in range(system.blocks):
        if is_too_small(system, 0, block):
            integers(record.counters)[BLOCK] = block
            return SINGULAR
    return DONE


@compiled
def begin(system: SystemView, record: Record, start: float, near: float) -> int:
    """Evaluate row 0 at the start and take the samples within `near` of it."""
    counters = integers(record.counters)
    floats(record.control)[NOW] = start
    if not finite(system, 0, 2 * system.n):
        return DIVERGED
    wrap_angles(system, system.rows, record.final_turns, record.final_turns)
    counters[EVALUATIONS] += 1
    status = set_clock(system, start)
    if status == 0:
        status = evaluate(system, 0)
    if status != 0:
        return outcome_of(record, status)
    if not finite(system, 0, 3 * system.n):
        return DIVERGED
    start_angles(system, record)
    while counters[SAMPLES] < record.samples:
        if abs(floats(record.time)[counters[SAMPLES]] - start) > near:
            break
        write_sample(system, record, 0)
    if record.observer != 0:
        call_hook(record.observer, record.observed, start, 0.0, start)
    return margin_outcome(system, record)


@compiled
def settle(system: SystemView) -> None:
    """Replace coordinates that are carried along in row 0 by what the iteration found there."""
    rows, found = floats(system.rows), 3 * system.n + 2 * system.blocks
    for i in range(system.carried):
        rows[system.first_carried + i] = rows[found + i]
        rows[system.n + system.first_carried + i] = rows[found + system.carried + i]


@compiled
def commit(system: SystemView, table: TableView, record: Record, t_end: float) -> None:
    """Make the end of an accepted step the start of the next one.

    Where dependent angles are expected there must be known.
    """
    arrive(system, record, table.end)
    rows, last = floats(system.rows), table.end * system.width
    for i in range(system.width):
        rows[i] = rows[last + i]
    settle(system)
    wrap_angles(system, system.rows, record.final_turns, record.final_turns)
    if record.observer != 0:
        call_hook(record.observer, record.observed, t_end, 0.0, t_end)
    floats(record.control)[NOW] = t_end
    integers(record.counters)[STEPS] += 1


@compiled
def cut_short(
    system: SystemView,
    table: TableView,
    record: Record,
    t: float,
    h: float,
    part: float,
    outcome: int,
) -> int:
    """End a run with the part of a step that is in the workspace."""
    if part == 0.0:
        return outcome
    t_end = t + part * h
    status = take_samples(system, table, record, t, part * h, t_end, 0.0)
    if status != 0:
        return outcome_of(record, status)
    expect_end(system, table, record, part * h)
    commit(system, table, record, t_end)
    return outcome
