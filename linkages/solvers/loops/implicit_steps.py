"""Compiled loop of equal steps of a collocation method.

What is off the regular course (the end of reach, singular positions) is located by steps of an
explicit method from the same start: a table of it comes along.
"""

from __future__ import annotations

from linkages.solvers.loops.commit import (
    DIVERGED,
    DONE,
    EVENT,
    INTERRUPTED,
    NOT_CONVERGED,
    SINGULAR,
    STEP_BUDGET,
    begin,
    commit,
    cut_short,
    margin_outcome,
    outcome_of,
)
from linkages.solvers.loops.implicit_stages import finish_step, solve_stages
from linkages.solvers.steps.compiled import call_hook, compiled, floats, integers
from linkages.solvers.steps.stages import NOT_FINITE, evaluate, set_clock, try_step
from linkages.solvers.steps.views import (
    EVALUATIONS,
    SAMPLES,
    STOP,
    Hook,
    Nodes,
    Record,
    SystemView,
    TableView,
)
from linkages.solvers.watched.counting import expect_by_nodes
from linkages.solvers.watched.margins import check_margins
from linkages.solvers.watched.reach import reachable_part
from linkages.solvers.watched.sampling import SNAP, write_sample


@compiled
def predict(system: SystemView, nodes: Nodes, first: int, steps: int) -> None:
    """Starting values of a step: the accelerations of the last one, continued."""
    n, s, width = system.n, nodes.stages, system.width
    rows, ahead, kept = floats(system.rows), floats(nodes.ahead), floats(nodes.kept)
    for k in range(n):
        place = first * width + 2 * n + k
        for i in range(s):
            kept[i] = rows[2 * n + k]
            if steps > 0:
                kept[i] *= ahead[i * (s + 1) + s]
                for j in range(s):
                    kept[i] += ahead[i * (s + 1) + j] * rows[place + j * width]
        for i in range(s):
            rows[place + i * width] = kept[i]


@compiled
def end_step(
    system: SystemView, nodes: Nodes, record: Record, first: int, row: int, t_end: float, h: float
) -> int:
    """Write the end of a step whose stages are solved, and evaluate it."""
    finish_step(system, nodes, first, row, h)
    integers(record.counters)[EVALUATIONS] += 1
    status = set_clock(system, t_end)
    return evaluate(system, row) if status == 0 else status


@compiled
def make_step(
    system: SystemView, nodes: Nodes, record: Record, first: int, row: int, t: float, h: float
) -> int:
    """Make a step from row 0 to a row, by way of the stages in rows from `first` on."""
    status = solve_stages(system, nodes, record, first, t, h)
    if status != 0:
        return status
    return end_step(system, nodes, record, first, row, t + h, h)


@compiled
def sample_step(
    system: SystemView,
    nodes: Nodes,
    table: TableView,
    record: Record,
    t: float,
    h: float,
    slack: float,
) -> int:
    """Take the samples of a step, each by a step of its own, so that they have its full order."""
    n, width, counters = system.n, system.width, integers(record.counters)
    rows, first = floats(system.rows), nodes.first
    while counters[SAMPLES] < record.samples:
        time = floats(record.time)[counters[SAMPLES]]
        left = (t + h) - time if h > 0.0 else time - (t + h)
        if left < -slack:
            break
        if left <= slack:
            expect_by_nodes(system, nodes, record, first, h)
            write_sample(system, record, table.end)
            continue
        part = (time - t) / h
        for place in range(2 * n, 3 * n):
            for i in range(nodes.stages):
                step_value = rows[(first + i) * width + place]
                target = (first + nodes.stages + i) * width + place
                rows[target] = rows[place] + part * (step_value - rows[place])
        other = first + nodes.stages
        status = make_step(system, nodes, record, other, table.rows, t, part * h)
        if status != 0:
            return status
        expect_by_nodes(system, nodes, record, other, part * h)
        write_sample(system, record, table.rows)
    return 0


@compiled
def fail(
    system: SystemView, table: TableView, record: Record, t: float, h: float, t_end: float
) -> int:
    """Find out why a step failed, with an explicit method, and end the run where it is due."""
    status = try_step(system, t, h, t_end)
    integers(record.counters)[EVALUATIONS] += table.end
    if status == 0:
        return NOT_CONVERGED
    if status == NOT_FINITE:
        return DIVERGED
    outcome = outcome_of(record, status)
    part = reachable_part(system, table, record, t, h)
    return cut_short(system, table, record, t, h, part, outcome)


@compiled
def implicit_steps(
    system: SystemView,
    nodes: Nodes,
    table: TableView,
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
    carry, following = floats(nodes.carry), floats(nodes.next_carry)
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
        t = start + i * h
        t_end = end if i == count - 1 else start + (i + 1) * h
        predict(system, nodes, nodes.first, i)
        status = make_step(system, nodes, record, nodes.first, table.end, t, h)
        if status != 0:
            return fail(system, table, record, t, h, t_end)
        evaluations = counters[EVALUATIONS]
        part = check_margins(system, table, record, t, h, t_end)
        if part < 1.0:
            return cut_short(system, table, record, t, h, part, SINGULAR)
        if hook.function != 0:
            part = call_hook(hook.function, hook.context, t, h, t_end)
            if part <= 1.0:
                return cut_short(system, table, record, t, h, part, EVENT)
        if counters[EVALUATIONS] != evaluations:
            # The search has put steps of the explicit method in the place of this one.
            end_step(system, nodes, record, nodes.first, table.end, t_end, h)
        # Samples write other carries.
        for k in range(2 * system.n):
            floats(nodes.held)[k] = following[k]
        status = sample_step(system, nodes, table, record, t, h, slack)
        if status != 0:
            return fail(system, table, record, t, h, t_end)
        for k in range(2 * system.n):
            carry[k] = floats(nodes.held)[k]
        expect_by_nodes(system, nodes, record, nodes.first, h)
        commit(system, table, record, t_end)
        outcome = margin_outcome(system, record)
    return outcome
