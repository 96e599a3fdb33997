"""Samples at requested times, taken from a step while it is at hand."""

from __future__ import annotations

from linkages.solvers.steps.compiled import call_step, compiled, floats, integers
from linkages.solvers.steps.stages import address_of, evaluate, further_stages, set_clock
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


@compiled
def write_sample(system: SystemView, record: Record, row: int) -> None:
    """Write the state and the accelerations in a row as the next sample."""
    n, counters = system.n, integers(record.counters)
    k = counters[SAMPLES]
    source = floats(address_of(system, row))
    state = record.state + WORD * k * 2 * n
    for i in range(2 * n):
        floats(state)[i] = source[i]
    for i in range(n):
        floats(record.acceleration)[k * n + i] = source[2 * n + i]
    wrap_angles(system, state, record.final_turns, record.turns + WORD * k * n)
    for i in range(system.counted):
        floats(record.sampled)[k * system.counted + i] = counted_angle(system, record, row, i)
    for i in range(system.holding):
        floats(record.sampled_held)[k * system.holding + i] = floats(system.held)[i]
    counters[SAMPLES] = k + 1


@compiled
def interpolate(system: SystemView, h: float, theta: float) -> None:
    """Write the state at the fraction theta of a step into the last row, by the dense output."""
    floats(system.pace)[LENGTH], floats(system.pace)[THETA] = h, theta
    call_step(system.interpolate, system.frame)


@compiled
def sample_between(
    system: SystemView,
    table: TableView,
    record: Record,
    t: float,
    h: float,
    t_end: float,
    slack: float,
) -> int:
    """Take the samples within a step from t to t_end, of which there is one at least.

    Sample times within `slack` of the end take the state at the end as it is. The further
    stages of the dense output are computed for a step only if it has other samples. Returns 0,
    or the status of the kernel where a sample (or such a stage) cannot be evaluated.
    """
    counters = integers(record.counters)
    more = table.rows - 1 - table.end
    while counters[SAMPLES] < record.samples:
        time = floats(record.time)[counters[SAMPLES]]
        left = t_end - time if h > 0.0 else time - t_end
        if left < -slack:
            break
        if left <= slack:
            expect_end(system, table, record, h)
            write_sample(system, record, table.end)
            continue
        if more > 0:
            counters[EVALUATIONS] += more
            status = further_stages(system, t, h, t_end)
            if status != 0:
                return status
            more = 0
        theta = min((time - t) / h, 1.0)
        interpolate(system, h, theta)
        counters[EVALUATIONS] += 1
        status = set_clock(system, time)
        if status == 0:
            status = evaluate(system, table.rows)
        if status != 0:
            return status
        expect_between(system, table, record, h, theta)
        write_sample(system, record, table.rows)
    return 0


@compiled
def take_samples(
    system: SystemView,
    table: TableView,
    record: Record,
    t: float,
    h: float,
    t_end: float,
    slack: float,
) -> int:
    """Take all samples that fall within an accepted step; see `sample_between`."""
    k = integers(record.counters)[SAMPLES]
    if k == record.samples:
        return 0
    time = floats(record.time)[k]
    if (t_end - time if h > 0.0 else time - t_end) < -slack:
        return 0
    return sample_between(system, table, record, t, h, t_end, slack)
