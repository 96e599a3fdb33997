"""Loop of equal steps of a collocation method.

What is off the regular course (the end of reach, singular positions) is located by steps of an
explicit method from the same start: a table of it comes along.
"""

from __future__ import annotations

from linkages.kernel.code.operands import (
    Real,
    Whole,
    choose,
    floats,
    fused,
    integers,
)
from linkages.kernel.code.printed import printed
from linkages.kernel.code.procedure import Procedure
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
from linkages.solvers.steps.stages import NOT_FINITE, call_hook, evaluate_at, try_step
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
from linkages.solvers.watched.sampling import SNAP, left_of, write_sample


@printed
def predict(code: Procedure, system: SystemView, nodes: Nodes, first: Whole, steps: Whole) -> None:
    """Starting values of a step: the accelerations of the last one, continued."""
    n, s, width = system.n, nodes.stages, system.width
    rows, ahead, kept = floats(system.rows), floats(nodes.ahead), floats(nodes.kept)
    with code.count(n) as k:
        place = first * width + 2 * n + k
        with code.count(s) as i:
            value = code.variable(rows[2 * n + k])
            with code.when(steps > 0):
                value.set(value * ahead[i * (s + 1) + s])
                with code.count(s) as j:
                    value.set(fused(ahead[i * (s + 1) + j], rows[place + j * width], value))
            kept[i] = value
        with code.count(s) as i:
            rows[place + i * width] = kept[i]


@printed
def end_step(
    _code: Procedure, system: SystemView, nodes: Nodes, record: Record,
    first: Whole, row: Whole, t_end: Real, h: Real,
) -> Whole:  # fmt: skip
    """Write the end of a step whose stages are solved, and evaluate it."""
    finish_step(system, nodes, first, row, h)
    integers(record.counters)[EVALUATIONS] += 1
    return evaluate_at(system, t_end, row)


@printed
def make_step(
    code: Procedure, system: SystemView, nodes: Nodes, record: Record,
    first: Whole, row: Whole, t: Real, h: Real,
) -> Whole:  # fmt: skip
    """Make a step from row 0 to a row, by way of the stages in rows from `first` on."""
    status = solve_stages(system, nodes, record, first, t, h)
    with code.when(status != 0):
        code.leave(status)
    return end_step(system, nodes, record, first, row, t + h, h)


@printed
def sample_step(
    code: Procedure, system: SystemView, nodes: Nodes, table: TableView, record: Record,
    t: Real, h: Real, slack: Real,
) -> Whole:  # fmt: skip
    """Take the samples of a step, each by a step of its own, so that they have its full order."""
    n, width, counters = system.n, system.width, integers(record.counters)
    rows, first = floats(system.rows), nodes.first
    with code.during(lambda: counters[SAMPLES] < record.samples):
        time = floats(record.time)[counters[SAMPLES]]
        left = left_of(h, t + h, time)
        with code.when(left < -slack):
            code.stop()
        with code.when(left <= slack):
            expect_by_nodes(system, nodes, record, first, h)
            write_sample(system, record, table.end)
            code.again()
        part, other = (time - t) / h, first + nodes.stages
        with code.count(n) as k, code.count(nodes.stages) as i:
            place = 2 * n + k
            step_value = rows[(first + i) * width + place]
            target = (other + i) * width + place
            rows[target] = fused(part, step_value - rows[place], rows[place])
        status = make_step(system, nodes, record, other, table.rows, t, part * h)
        with code.when(status != 0):
            code.leave(status)
        expect_by_nodes(system, nodes, record, other, part * h)
        write_sample(system, record, table.rows)
    return code.value(0)


@printed
def fail(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    t: Real, h: Real, t_end: Real,
) -> Whole:  # fmt: skip
    """Find out why a step failed, with an explicit method, and end the run where it is due."""
    status = try_step(system, t, h, t_end)
    integers(record.counters)[EVALUATIONS] += table.end
    with code.when(status == 0):
        code.leave(NOT_CONVERGED)
    with code.when(status == NOT_FINITE):
        code.leave(DIVERGED)
    outcome = outcome_of(record, status)
    part = reachable_part(system, table, record, t, h)
    return cut_short(system, table, record, t, h, part, outcome)


@printed
def copy(code: Procedure, source: Whole, target: Whole, count: Whole) -> None:
    """Copy numbers."""
    with code.count(count) as k:
        floats(target)[k] = floats(source)[k]


@printed
def implicit_steps(
    code: Procedure, system: SystemView, nodes: Nodes, table: TableView, record: Record,
    hook: Hook, start: Real, end: Real, count: Whole, budget: Whole,
) -> Whole:  # fmt: skip
    """Integrate from start to end in `count` steps, of which `budget` may be used.

    Row 0 holds the state. Returns an `Outcome`; the final state is in row 0, its time in
    ``control[NOW]``.
    """
    h = (end - start) / count.real
    counters, control = integers(record.counters), floats(record.control)
    slack = SNAP * abs(h)
    outcome = code.variable(begin(system, record, start, slack))
    with code.when(start == end):
        code.leave(outcome)
    with code.count(count) as i:
        with code.when(outcome != DONE):
            code.leave(outcome)
        with code.when(control[STOP] != 0.0):
            code.leave(INTERRUPTED)
        with code.when(i == budget):
            code.leave(STEP_BUDGET)
        t, t_end = fused(i.real, h, start), fused((i + 1).real, h, start)
        t_end = choose(i == count - 1, end, t_end)
        predict(system, nodes, nodes.first, i)
        status = make_step(system, nodes, record, nodes.first, table.end, t, h)
        with code.when(status != 0):
            code.leave(fail(system, table, record, t, h, t_end))
        evaluations = counters[EVALUATIONS]
        part = check_margins(system, table, record, t, h, t_end)
        with code.when(part < 1.0):
            code.leave(cut_short(system, table, record, t, h, part, SINGULAR))
        with code.when(hook.function != 0):
            part = call_hook(hook.function, hook.context, t, h, t_end)
            with code.when(part <= 1.0):
                code.leave(cut_short(system, table, record, t, h, part, EVENT))
        with code.when(counters[EVALUATIONS] != evaluations):
            # The search has put steps of the explicit method in the place of this one.
            end_step(system, nodes, record, nodes.first, table.end, t_end, h)
        # Samples write other carries.
        copy(nodes.next_carry, nodes.held, 2 * system.n)
        status = sample_step(system, nodes, table, record, t, h, slack)
        with code.when(status != 0):
            code.leave(fail(system, table, record, t, h, t_end))
        copy(nodes.held, nodes.carry, 2 * system.n)
        expect_by_nodes(system, nodes, record, nodes.first, h)
        commit(system, table, record, t_end)
        outcome.set(margin_outcome(system, record))
    return code.value(outcome)
