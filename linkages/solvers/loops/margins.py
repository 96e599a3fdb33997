"""Within a step: singularity margins, whole turns and samples.

A block's margin goes to zero where its two links are aligned. Positions are closed forms with a
fixed sign, so that a margin never changes sign: it passes through zero like ``|t|``, and between
two accepted steps that can be overlooked. A step is suspicious if the margin, extrapolated from
both of its ends, crosses zero within it. It is then repeated in part, to find the least margin.

Below a least margin (`LEAST_MARGIN` of its scale, unless a run asks for more) accelerations lose
their last digits to round-off, and the motion beyond is arbitrary: the integration stops there.

The kernel writes the unit vector and the speed of each. The speeds, added up with the weights of a
step as if the angle were integrated, say to much less than half a turn where it is; the unit vector
says where exactly within the turn, so that errors do not add up over the steps.
"""

from __future__ import annotations

from typing import Any

from linkages.kernel.code.operands import (
    Bool,
    Int,
    Real,
    floats,
    fma,
    integers,
    minimum,
    select,
    select_of,
)
from linkages.kernel.code.procedure import Procedure, traced
from linkages.kernel.dyads import LEAST_MARGIN
from linkages.solvers.loops.memory import (
    BLOCK,
    EVALUATIONS,
    LENGTH,
    SAMPLES,
    THETA,
    WORD,
    Record,
    SystemView,
    TableView,
)
from linkages.solvers.loops.predicates import is_small, nearest_turn, passes_zero
from linkages.solvers.loops.scalar_stages import (
    address_of,
    call_step,
    evaluate_at,
    further_stages,
    try_step,
    wrap_angles,
)

# Enough to halve a step down to its last digit.
BISECTIONS = 60
# Enough to find the first margin that is too small within a few thousandths of a step.
EARLY_BISECTIONS = 12


def margins_of(system: SystemView, row: Int | int) -> Any:
    """Address of the margins of a row; their rates follow."""
    return address_of(system, row) + WORD * 3 * system.n


def side_of(margin: Real) -> Real:
    """1 or -1, as a margin is positive or negative."""
    return select_of(Real, margin >= 0.0, 1.0, -1.0)


@traced
def is_suspicious(_code: Procedure, system: SystemView, end: Int, block: Int, h: Real) -> Bool:
    """Whether a block's margin, extrapolated from both ends of a step, crosses zero within."""
    first, last = floats(margins_of(system, 0)), floats(margins_of(system, end))
    rate = block + system.blocks
    return passes_zero(first[block], first[rate] * h, last[block], last[rate] * h)


def least_margin(
    code: Procedure, system: Any, table: Any, record: Any, block: Int, t: Real, h: Real
) -> tuple[Any, Any]:
    """Least margin of a block within a step, and the fraction of the step before it.

    Bisects on the sign of the margin's rate, repeating the step from its start.
    """
    start, end = floats(margins_of(system, 0)), floats(margins_of(system, table.end))
    side = side_of(start[block])
    least = code.variable(minimum(abs(start[block]), abs(end[block])))
    before, after = code.variable(0.0), code.variable(1.0)
    with code.for_range(BISECTIONS):
        middle = 0.5 * (before + after)
        integers(record.counters)[EVALUATIONS] += table.cost
        with code.if_(try_step(system, t, middle * h, t + middle * h) != 0):
            # Round-off puts aligned links out of reach.
            least.set(0.0)
            after.set(middle)
            code.continue_()
        least.set(minimum(least, abs(end[block])))
        with code.if_(side * h * end[block + system.blocks] < 0.0) as case:
            before.set(middle)
        with case.else_():
            after.set(middle)
    return least, before


@traced
def is_too_small(_code: Procedure, system: SystemView, row: Int, block: Int) -> Bool:
    """Whether a margin is singular, or smaller than a run allows and still falling."""
    margins = floats(margins_of(system, row))
    rate = margins[block + system.blocks]
    forward_rate = select(system.backward != 0, -rate, rate)
    scale, smallest = floats(system.margin_scale)[block], floats(system.smallest_margins)[block]
    return is_small(margins[block], forward_rate, scale, smallest)


def stops_early(system: Any, block: Int) -> Any:
    """Whether a run stops at larger margins than it must."""
    smallest, scale = floats(system.smallest_margins)[block], floats(system.margin_scale)[block]
    return smallest > 2.0 * LEAST_MARGIN * scale


@traced
def ends_early(_code: Procedure, system: SystemView, end: Int, block: Int) -> Bool:
    """Whether a run stops at larger margins than it must, and this one is too small at the end."""
    return stops_early(system, block) & is_too_small(system, end, block)


@traced
def early_fraction(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    block: Int, t: Real, h: Real, last: Real,
) -> Real:  # fmt: skip
    """Fraction of a step before a margin is the smallest that is allowed; it is so at `last`."""
    before, after = code.variable(0.0), code.variable(last)
    with code.for_range(EARLY_BISECTIONS):
        middle = 0.5 * (before + after)
        integers(record.counters)[EVALUATIONS] += table.cost
        status = try_step(system, t, middle * h, t + middle * h)
        with code.if_((status == 0) & ~is_too_small(system, table.end, block)) as case:
            before.set(middle)
        with case.else_():
            after.set(middle)
    return code.value(before)


@traced
def singular_fraction(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    t: Real, h: Real, t_end: Real,
) -> Real:  # fmt: skip
    """Find the first singular position within a step that has suspicious blocks.

    Returns the fraction of the step that lies before it, with the workspace holding the step of
    that length and its block noted; or 1 if there is none, with the workspace as it was.
    """
    counters, fraction = integers(record.counters), code.variable(1.0)
    with code.for_range(system.blocks) as block:
        with code.if_(ends_early(system, table.end, block)):
            early = early_fraction(system, table, record, block, t, h, 1.0)
            fraction.set(minimum(fraction, early))
            counters[BLOCK] = block
            try_step(system, t, h, t_end)
            code.continue_()
        with code.if_(is_suspicious(system, table.end, block, h)):
            least, before = least_margin(code, system, table, record, block, t, h)
            with code.if_(least < floats(system.smallest_margins)[block]):
                with code.if_(stops_early(system, block)):
                    before.set(early_fraction(system, table, record, block, t, h, before))
                with code.if_(before < fraction):
                    fraction.set(before)
                    counters[BLOCK] = block
            counters[EVALUATIONS] += table.cost
            try_step(system, t, h, t_end)
    with code.if_(fraction < 1.0):
        counters[EVALUATIONS] += table.cost
        try_step(system, t, fraction * h, t + fraction * h)
    return code.value(fraction)


@traced
def check_margins(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    t: Real, h: Real, t_end: Real,
) -> Real:  # fmt: skip
    """Fraction of an accepted step before a singular position; see `singular_fraction`."""
    with code.for_range(system.blocks) as block:
        early = ends_early(system, table.end, block)
        with code.if_(early | is_suspicious(system, table.end, block, h)):
            code.return_(singular_fraction(system, table, record, t, h, t_end))
    return code.value(1.0)


@traced
def reachable_part(
    code: Procedure, system: SystemView, table: TableView, record: Record, t: Real, h: Real
) -> Real:
    """Longest fraction of a failed step that can be made, left in the workspace."""
    made, failed = code.variable(0.0), code.variable(1.0)
    with code.for_range(BISECTIONS):
        middle = 0.5 * (made + failed)
        with code.if_(try_step(system, t, middle * h, t + middle * h) == 0) as case:
            made.set(middle)
        with case.else_():
            failed.set(middle)
    integers(record.counters)[EVALUATIONS] += (BISECTIONS + 1) * table.cost
    with code.if_(made > 0.0):
        try_step(system, t, made * h, t + made * h)
    return code.value(made)


def first_cosine(system: SystemView) -> Any:
    """Place within a row of the unit vectors of dependent angles; their speeds follow."""
    return 3 * system.n + 2 * system.blocks + 2 * system.carried


@traced
def counted_angle(_code: Procedure, system: SystemView, record: Record, row: Int, i: Int) -> Real:
    """A dependent angle in a row, with the turns that bring it closest to where it is expected."""
    values, first = floats(address_of(system, row)), first_cosine(system)
    sine, cosine = values[first + system.counted + i], values[first + i]
    return nearest_turn(sine, cosine, floats(record.ahead)[i])


@traced
def arrive(code: Procedure, system: SystemView, record: Record, row: Int) -> None:
    """Take the angles in a row as those that the next step starts from."""
    with code.for_range(system.counted) as i:
        floats(record.angles)[i] = counted_angle(system, record, row, i)


@traced
def start_angles(code: Procedure, system: SystemView, record: Record) -> None:
    """Begin with the angles in row 0, closest to where a run says that they are."""
    with code.for_range(system.counted) as i:
        floats(record.ahead)[i] = floats(record.angles)[i]
    arrive(system, record, 0)


@traced
def expect_end(
    code: Procedure, system: SystemView, table: TableView, record: Record, h: Real
) -> None:
    """Where dependent angles are at the end of an explicit step of length h."""
    rows, starts, places = floats(system.rows), integers(table.starts), integers(table.places)
    # `places` are those of the speeds that begin at n.
    shift = first_cosine(system) + 2 * system.counted - system.n
    with code.for_range(system.counted) as i:
        mean, first = code.variable(0.0), starts[table.end]
        with code.for_range(starts[table.end + 1] - first) as k:
            j = first + k
            mean.set(fma(floats(table.weights)[j], rows[places[j] + shift + i], mean))
        floats(record.ahead)[i] = fma(h, mean, floats(record.angles)[i])


@traced
def expect_between(
    code: Procedure, system: SystemView, table: TableView, record: Record, h: Real, theta: Real
) -> None:
    """Where dependent angles are at the fraction theta of a step, by its dense output."""
    rows, dense, degree = floats(system.rows), floats(table.dense), table.degree
    first = first_cosine(system) + 2 * system.counted
    with code.for_range(system.counted) as i:
        mean = code.variable(0.0)
        with code.for_range(table.rows) as j:
            weight = code.variable(0.0)
            with code.for_range(degree) as k:
                weight.set((weight + dense[j * degree + (degree - 1 - k)]) * theta)
            mean.set(fma(weight, rows[j * system.width + first + i], mean))
        floats(record.ahead)[i] = fma(h, mean, floats(record.angles)[i])


# Relative to a fixed step, below this distance a sample time is meant to be the step's end.
SNAP = 1e-9


@traced
def write_held(code: Procedure, system: SystemView, record: Record, sample: Int) -> None:
    """Write modes and memories beside a sample."""
    with code.for_range(system.holding) as i:
        floats(record.sampled_held)[sample * system.holding + i] = floats(system.held)[i]


@traced
def write_sample(code: Procedure, system: SystemView, record: Record, row: Int) -> None:
    """Write the state and the accelerations in a row as the next sample."""
    n, counters = system.n, integers(record.counters)
    k = counters[SAMPLES]
    source = floats(address_of(system, row))
    state = record.state + WORD * k * 2 * n
    with code.for_range(2 * n) as i:
        floats(state)[i] = source[i]
    with code.for_range(n) as i:
        floats(record.acceleration)[k * n + i] = source[2 * n + i]
    wrap_angles(system, state, record.final_turns, record.turns + WORD * k * n)
    with code.for_range(system.counted) as i:
        floats(record.sampled)[k * system.counted + i] = counted_angle(system, record, row, i)
    write_held(system, record, k)
    counters[SAMPLES] = k + 1


def interpolate(system: Any, function: Any, h: Real, theta: Real) -> Int:
    """Write the state at the fraction theta of a step into the last row; returns a status."""
    stepper = floats(system.stepper)
    stepper[LENGTH], stepper[THETA] = h, theta
    return call_step(system.code, function, system.pointers)


def left_of(h: Real, t_end: Real, time: Any) -> Any:
    """How much of a step lies behind a time."""
    return select(h > 0.0, t_end - time, time - t_end)


@traced
def sample_between(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    t: Real, h: Real, t_end: Real, slack: Real,
) -> Int:  # fmt: skip
    """Take the samples within a step from t to t_end, of which there is one at least.

    Sample times within `slack` of the end take the state at the end as it is. The further
    stages of the dense output are computed for a step only if it has other samples. Returns 0,
    or the status of the kernel where a sample (or such a stage) cannot be evaluated.
    """
    counters = integers(record.counters)
    more = code.variable(table.rows - 1 - table.end)
    with code.while_(lambda: counters[SAMPLES] < record.samples):
        time = floats(record.time)[counters[SAMPLES]]
        left = left_of(h, t_end, time)
        with code.if_(left < -slack):
            code.break_()
        with code.if_(left <= slack):
            expect_end(system, table, record, h)
            write_sample(system, record, table.end)
            code.continue_()
        with code.if_(more > 0):
            counters[EVALUATIONS] += more
            status = further_stages(system, t, h, t_end)
            with code.if_(status != 0):
                code.return_(status)
            more.set(0)
        theta = minimum((time - t) / h, 1.0)
        status = interpolate(system, system.between, h, theta)
        with code.if_(status != 0):
            code.return_(status)
        counters[EVALUATIONS] += 1
        status = evaluate_at(system, time, table.rows)
        with code.if_(status != 0):
            code.return_(status)
        expect_between(system, table, record, h, theta)
        write_sample(system, record, table.rows)
    return code.value(0)


@traced
def take_samples(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    t: Real, h: Real, t_end: Real, slack: Real,
) -> Int:  # fmt: skip
    """Take all samples that fall within an accepted step; see `sample_between`."""
    k = integers(record.counters)[SAMPLES]
    with code.if_(k == record.samples):
        code.return_(0)
    with code.if_(left_of(h, t_end, floats(record.time)[k]) < -slack):
        code.return_(0)
    return sample_between(system, table, record, t, h, t_end, slack)
