"""Loop of steps of equal length."""

from __future__ import annotations

from linkages.kernel.code.operands import Real, Whole, choose, floats, fused, integers
from linkages.kernel.code.printed import printed
from linkages.kernel.code.procedure import Procedure
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
    observe,
    outcome_of,
)
from linkages.solvers.steps.stages import NOT_FINITE, call_hook, try_step
from linkages.solvers.steps.views import (
    BEFORE_CHANGE,
    BEHIND_CHANGE,
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
