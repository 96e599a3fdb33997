"""Step loops with a fixed step length: explicit and collocation.

References
----------
.. [1] E. Hairer, R. I. McLachlan, A. Razakarivony, "Achieving Brouwer's law with implicit
       Runge–Kutta methods", BIT 48 (2008), 231–243.

What is off the regular course (the end of reach, singular positions) is located by steps of an
explicit method from the same start: a table of it comes along.
"""

from __future__ import annotations

import math

from linkages.kernel.code.operands import (
    Real,
    Whole,
    choose,
    floats,
    fused,
    integers,
    larger_of,
)
from linkages.kernel.code.procedure import Procedure, printed
from linkages.solvers.loops.adaptive_steps import (
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
    observe,
    outcome_of,
)
from linkages.solvers.steps.memory import (
    BEFORE_CHANGE,
    BEHIND_CHANGE,
    EVALUATIONS,
    SAMPLES,
    STOP,
    WORD,
    Hook,
    Nodes,
    Record,
    SwitchingView,
    SystemView,
    TableView,
)
from linkages.solvers.steps.scalar_stages import (
    NOT_FINITE,
    address_of,
    call_clock,
    call_hook,
    call_rates,
    evaluate_at,
    finite,
    try_step,
)
from linkages.solvers.watched.margins import (
    SNAP,
    check_margins,
    expect_by_nodes,
    expect_end,
    left_of,
    reachable_part,
    take_samples,
    write_sample,
)


@printed
def fixed_steps(
    code: Procedure, system: SystemView, table: TableView, record: Record, hook: Hook,
    switching: SwitchingView, start: Real, end: Real, count: Whole, budget: Whole,
) -> Whole:  # fmt: skip
    """Integrate from start to end in `count` steps, of which `budget` may be used.

    Row 0 holds the state. Returns an `Outcome`; the final state is in row 0, its time in
    ``control[NOW]``.
    """
    h = (end - start) / count.real
    slack = SNAP * abs(h)
    outcome = code.variable(begin(system, record, start, slack))
    with code.when(start == end):
        code.leave(outcome)
    with code.count(count) as i:
        with code.when(outcome != DONE):
            code.leave(outcome)
        with code.when(floats(record.control)[STOP] != 0.0):
            code.leave(INTERRUPTED)
        with code.when(i == budget):
            code.leave(STEP_BUDGET)
        # Multiplied rather than added up: t is right to its last digit after any number of steps.
        t, t_end = fused(i.real, h, start), fused((i + 1).real, h, start)
        t_end = choose(i == count - 1, end, t_end)
        outcome.set(step_to(system, table, record, hook, switching, t, h, t_end))
    return code.value(outcome)


@printed
def step_to(
    code: Procedure, system: SystemView, table: TableView, record: Record, hook: Hook,
    switching: SwitchingView, begun: Real, h: Real, t_end: Real,
) -> Whole:  # fmt: skip
    """Make a step, in pieces where modes change on the way; returns an `Outcome`."""
    slack = SNAP * abs(h)
    t, made, reached = code.variable(begun), code.variable(h), code.variable(t_end)
    outcome = code.variable(DONE)
    with code.during(lambda: code.value(True)):
        integers(record.counters)[EVALUATIONS] += table.end
        status = try_step(system, t, made, reached)
        with code.when(status == NOT_FINITE):
            code.leave(DIVERGED)
        with code.when(status != 0):
            failed = outcome_of(record, status)
            part = reachable_part(system, table, record, t, made)
            code.leave(cut_short(system, table, record, t, made, part, failed))
        changing = code.variable(False)
        with code.when(switching.look != 0):
            part = call_hook(switching.look, switching.context, t, made, reached)
            changing.set((part >= 0.0) & (part < 1.0))
            with code.when(changing):
                made.set(made * part)
                reached.set(t + made)
        with code.when(made != 0.0):
            part = check_margins(system, table, record, t, made, reached)
            with code.when(part < 1.0):
                code.leave(cut_short(system, table, record, t, made, part, SINGULAR))
            with code.when(hook.function != 0):
                part = call_hook(hook.function, hook.context, t, made, reached)
                with code.when(part <= 1.0):
                    code.leave(cut_short(system, table, record, t, made, part, EVENT))
            near = choose(reached == t_end, slack, 0.0)
            status = take_samples(system, table, record, t, made, reached, near)
            with code.when(status != 0):
                code.leave(outcome_of(record, status))
        expect_end(system, table, record, made)
        commit(system, table, record, reached)
        outcome.set(margin_outcome(system, record))
        with code.when(changing & (outcome == DONE)):
            observe(code, record, reached, BEFORE_CHANGE)
            found = call_hook(switching.change, switching.context, t, h, reached)
            outcome.set(found.whole)
            with code.when(outcome == DONE):
                observe(code, record, reached, BEHIND_CHANGE)
        with code.when((reached == t_end) | (outcome != DONE)):
            code.stop()
        # what is left of the step behind a change
        t.set(reached)
        made.set(t_end - reached)
        reached.set(t_end)
    return code.value(outcome)


NOT_SETTLED = -2
ITERATIONS = 50
# Iterations end where changes cease to shrink [1]_. A change that does so above this fraction of
# the accelerations is no round-off: the iteration does not converge.
SETTLED = 1e-9


@printed
def set_clocks(code: Procedure, system: SystemView, nodes: Nodes, t: Real, h: Real) -> Whole:
    """Evaluate what depends on time alone at every stage; iterations do not change it."""
    with code.count(nodes.stages) as i:
        timed = nodes.timed + WORD * i * nodes.timed_size
        time = fused(floats(nodes.c)[i], h, t)
        status = call_clock(system.clock, time, system.parameters, timed)
        with code.when(status != 0):
            code.leave(status)
    return code.value(0)


@printed
def place_stages(code: Procedure, system: SystemView, nodes: Nodes, first: Whole, h: Real) -> None:
    """Write the coordinates and speeds of all stages, from their accelerations."""
    n, s, width = system.n, nodes.stages, system.width
    rows, A, AA, c = floats(system.rows), floats(nodes.A), floats(nodes.AA), floats(nodes.c)
    with code.count(s) as i:
        row = (first + i) * width
        with code.count(n) as k:
            single, double = code.variable(0.0), code.variable(0.0)
            with code.count(s) as j:
                acceleration = rows[(first + j) * width + 2 * n + k]
                single.set(fused(A[i * s + j], acceleration, single))
                double.set(fused(AA[i * s + j], acceleration, double))
            moved = fused(h, double, c[i] * rows[n + k])
            rows[row + k] = fused(h, moved, rows[k])
            rows[row + n + k] = fused(h, single, rows[n + k])


@printed
def evaluate_stages(
    code: Procedure, system: SystemView, nodes: Nodes, record: Record, first: Whole, changes: Whole
) -> Whole:
    """Evaluate all stages; returns the status.

    Writes the largest change of an acceleration and the largest acceleration to `changes`.
    """
    n, width = system.n, system.width
    rows, kept = floats(system.rows), floats(nodes.kept)
    change, largest = code.variable(0.0), code.variable(0.0)
    with code.count(nodes.stages) as i:
        state = address_of(system, first + i)
        base = (first + i) * width + 2 * n
        with code.count(n) as k:
            kept[k] = rows[base + k]
        integers(record.counters)[EVALUATIONS] += 1
        timed = nodes.timed + WORD * i * nodes.timed_size
        out = state + WORD * 2 * n
        status = call_rates(system.rates, state, system.parameters, timed, out)
        with code.when(status != 0):
            code.leave(status)
        with code.when(~finite(system, first + i, 3 * n)):
            code.leave(NOT_FINITE)
        with code.count(n) as k:
            change.set(larger_of(change, abs(rows[base + k] - kept[k])))
            largest.set(larger_of(largest, abs(rows[base + k])))
    found = floats(changes)
    found[0], found[1] = change, largest
    return code.value(0)


@printed
def solve_stages(
    code: Procedure, system: SystemView, nodes: Nodes, record: Record,
    first: Whole, t: Real, h: Real,
) -> Whole:  # fmt: skip
    """Solve the stages in rows first, first + 1, … of a step from row 0.

    The accelerations in these rows are the starting values. Returns 0, 1 + block, NOT_FINITE, or
    NOT_SETTLED.
    """
    status = set_clocks(system, nodes, t, h)
    with code.when(status != 0):
        code.leave(status)
    before = code.variable(math.inf)
    with code.count(ITERATIONS):
        place_stages(system, nodes, first, h)
        status = evaluate_stages(system, nodes, record, first, nodes.changes)
        with code.when(status != 0):
            code.leave(status)
        change, largest = floats(nodes.changes)[0], floats(nodes.changes)[1]
        settled = ~(change < before) & (change <= SETTLED * largest)
        with code.when((change == 0.0) | settled):
            code.leave(0)
        before.set(change)
    return code.value(NOT_SETTLED)


@printed
def finish_step(
    code: Procedure, system: SystemView, nodes: Nodes, first: Whole, row: Whole, h: Real
) -> None:
    """Write the end of a step to a row, summed with compensation.

    ``nodes.carry`` holds what row 0 is too small by, ``nodes.next_carry`` becomes that of the row.
    """
    n, width = system.n, system.width
    rows, b, bA = floats(system.rows), floats(nodes.b), floats(nodes.bA)
    carry, following = floats(nodes.carry), floats(nodes.next_carry)
    with code.count(n) as k:
        single, double = code.variable(0.0), code.variable(0.0)
        with code.count(nodes.stages) as j:
            acceleration = rows[(first + j) * width + 2 * n + k]
            single.set(fused(b[j], acceleration, single))
            double.set(fused(bA[j], acceleration, double))
        # The carry of the speed moves the coordinate as well.
        speed = rows[n + k] + fused(h, double, carry[n + k])
        moved, gained = fused(h, speed, carry[k]), fused(h, single, carry[n + k])
        rows[row * width + k] = rows[k] + moved
        rows[row * width + n + k] = rows[n + k] + gained
        following[k] = (rows[k] - rows[row * width + k]) + moved
        following[n + k] = (rows[n + k] - rows[row * width + n + k]) + gained


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
