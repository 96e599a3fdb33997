"""Samples at requested times, taken from a step while it is at hand."""

from __future__ import annotations

from typing import Any

from linkages.kernel.code.operands import Real, Whole, choose, floats, integers, smaller_of
from linkages.kernel.code.printed import printed
from linkages.kernel.code.procedure import Procedure
from linkages.solvers.steps.stages import address_of, call_step, evaluate_at, further_stages
from linkages.solvers.steps.turns import wrap_angles
from linkages.solvers.steps.views import (
    EVALUATIONS,
    LENGTH,
    SAMPLES,
    THETA,
    WORD,
    Record,
    SystemView,
    TableView,
)
from linkages.solvers.watched.counting import counted_angle, expect_between, expect_end

# Relative to a fixed step, below this distance a sample time is meant to be the step's end.
SNAP = 1e-9


@printed
def write_sample(code: Procedure, system: SystemView, record: Record, row: Whole) -> None:
    """Write the state and the accelerations in a row as the next sample."""
    n, counters = system.n, integers(record.counters)
    k = counters[SAMPLES]
    source = floats(address_of(system, row))
    state = record.state + WORD * k * 2 * n
    with code.count(2 * n) as i:
        floats(state)[i] = source[i]
    with code.count(n) as i:
        floats(record.acceleration)[k * n + i] = source[2 * n + i]
    wrap_angles(system, state, record.final_turns, record.turns + WORD * k * n)
    with code.count(system.counted) as i:
        floats(record.sampled)[k * system.counted + i] = counted_angle(system, record, row, i)
    with code.count(system.holding) as i:
        floats(record.sampled_held)[k * system.holding + i] = floats(system.held)[i]
    counters[SAMPLES] = k + 1


def interpolate(system: Any, h: Real, theta: Real) -> None:
    """Write the state at the fraction theta of a step into the last row, by the dense output."""
    pace = floats(system.pace)
    pace[LENGTH], pace[THETA] = h, theta
    call_step(system.code, system.interpolate, system.frame)


def left_of(h: Real, t_end: Real, time: Any) -> Any:
    """How much of a step lies behind a time."""
    return choose(h > 0.0, t_end - time, time - t_end)


@printed
def sample_between(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    t: Real, h: Real, t_end: Real, slack: Real,
) -> Whole:  # fmt: skip
    """Take the samples within a step from t to t_end, of which there is one at least.

    Sample times within `slack` of the end take the state at the end as it is. The further
    stages of the dense output are computed for a step only if it has other samples. Returns 0,
    or the status of the kernel where a sample (or such a stage) cannot be evaluated.
    """
    counters = integers(record.counters)
    more = code.variable(table.rows - 1 - table.end)
    with code.during(lambda: counters[SAMPLES] < record.samples):
        time = floats(record.time)[counters[SAMPLES]]
        left = left_of(h, t_end, time)
        with code.when(left < -slack):
            code.stop()
        with code.when(left <= slack):
            expect_end(system, table, record, h)
            write_sample(system, record, table.end)
            code.again()
        with code.when(more > 0):
            counters[EVALUATIONS] += more
            status = further_stages(system, t, h, t_end)
            with code.when(status != 0):
                code.leave(status)
            more.set(0)
        theta = smaller_of((time - t) / h, 1.0)
        interpolate(system, h, theta)
        counters[EVALUATIONS] += 1
        status = evaluate_at(system, time, table.rows)
        with code.when(status != 0):
            code.leave(status)
        expect_between(system, table, record, h, theta)
        write_sample(system, record, table.rows)
    return code.value(0)


@printed
def take_samples(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    t: Real, h: Real, t_end: Real, slack: Real,
) -> Whole:  # fmt: skip
    """Take all samples that fall within an accepted step; see `sample_between`."""
    k = integers(record.counters)[SAMPLES]
    with code.when(k == record.samples):
        code.leave(0)
    with code.when(left_of(h, t_end, floats(record.time)[k]) < -slack):
        code.leave(0)
    return sample_between(system, table, record, t, h, t_end, slack)
