"""Start a run, and go from the end of one step to the start of the next."""

from __future__ import annotations

from typing import Any

from linkages.kernel.code.operands import Real, Whole, floats, integers
from linkages.kernel.code.printed import printed
from linkages.kernel.code.procedure import Procedure
from linkages.solvers.outcome import Outcome
from linkages.solvers.steps.stages import NOT_FINITE, call_hook, evaluate_at, finite
from linkages.solvers.steps.turns import wrap_angles
from linkages.solvers.steps.views import (
    BLOCK,
    EVALUATIONS,
    NOW,
    SAMPLES,
    START,
    STEP,
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


@printed
def outcome_of(code: Procedure, record: Record, status: Whole) -> Whole:
    """Outcome that a failed evaluation stands for; notes its block."""
    with code.when(status == NOT_FINITE):
        code.leave(DIVERGED)
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
