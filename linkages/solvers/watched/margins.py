"""Watch for singular positions, where a step could come out in the wrong assembly mode.

A block's margin goes to zero where its two links are aligned. Positions are closed forms with a
fixed sign, so that a margin never changes sign: it passes through zero like ``|t|``, and between
two accepted steps that can be overlooked. A step is suspicious if the margin, extrapolated from
both of its ends, crosses zero within it. It is then repeated in part, to find the least margin.

Below a least margin (`LEAST_MARGIN` of its scale, unless a run asks for more) accelerations lose
their last digits to round-off, and the motion beyond is arbitrary: the integration stops there.
"""

from __future__ import annotations

from typing import Any

from linkages.kernel.closure.dyads import LEAST_MARGIN
from linkages.kernel.code.operands import (
    Real,
    Truth,
    Whole,
    choose_of,
    floats,
    integers,
    smaller_of,
)
from linkages.kernel.code.printed import printed
from linkages.kernel.code.procedure import Procedure
from linkages.solvers.printed.advance import CONCAVITY
from linkages.solvers.steps.stages import address_of, try_step
from linkages.solvers.steps.views import BLOCK, EVALUATIONS, WORD, Record, SystemView, TableView

# Enough to halve a step down to its last digit.
BISECTIONS = 60
# Enough to find the first margin that is too small within a few thousandths of a step.
EARLY_BISECTIONS = 12


def margins_of(system: SystemView, row: Whole | int) -> Any:
    """Address of the margins of a row; their rates follow."""
    return address_of(system, row) + WORD * 3 * system.n


def side_of(margin: Real) -> Real:
    """1 or -1, as a margin is positive or negative."""
    return choose_of(Real, margin >= 0.0, 1.0, -1.0)


@printed
def is_suspicious(_code: Procedure, system: SystemView, end: Whole, block: Whole, h: Real) -> Truth:
    """Whether a block's margin, extrapolated from both ends of a step, crosses zero within."""
    first, last = floats(margins_of(system, 0)), floats(margins_of(system, end))
    rate = block + system.blocks
    side = side_of(first[block])
    ahead = side * (first[block] + CONCAVITY * h * first[rate])
    behind = side * (last[block] - CONCAVITY * h * last[rate])
    return (ahead < 0.0) & (behind < 0.0)


def least_margin(
    code: Procedure, system: Any, table: Any, record: Any, block: Whole, t: Real, h: Real
) -> tuple[Any, Any]:
    """Least margin of a block within a step, and the fraction of the step before it.

    Bisects on the sign of the margin's rate, repeating the step from its start.
    """
    start, end = floats(margins_of(system, 0)), floats(margins_of(system, table.end))
    side = side_of(start[block])
    least = code.variable(smaller_of(abs(start[block]), abs(end[block])))
    before, after = code.variable(0.0), code.variable(1.0)
    with code.count(BISECTIONS):
        middle = 0.5 * (before + after)
        integers(record.counters)[EVALUATIONS] += table.end
        with code.when(try_step(system, t, middle * h, t + middle * h) != 0):
            # Round-off puts aligned links out of reach.
            least.set(0.0)
            after.set(middle)
            code.again()
        least.set(smaller_of(least, abs(end[block])))
        with code.when(side * h * end[block + system.blocks] < 0.0) as case:
            before.set(middle)
        with case.otherwise():
            after.set(middle)
    return least, before


@printed
def is_too_small(code: Procedure, system: SystemView, row: Whole, block: Whole) -> Truth:
    """Whether a margin is singular, or smaller than a run allows and still falling."""
    margins = floats(margins_of(system, row))
    margin, rate = margins[block], margins[block + system.blocks]
    with code.when(abs(margin) < LEAST_MARGIN * floats(system.margin_scale)[block]):
        code.leave(True)
    product, backward = margin * rate, system.backward != 0
    falling = choose_of(Truth, backward, product > 0.0, product < 0.0)
    return falling & (abs(margin) < floats(system.smallest_margins)[block])


def stops_early(system: Any, block: Whole) -> Any:
    """Whether a run stops at larger margins than it must."""
    smallest, scale = floats(system.smallest_margins)[block], floats(system.margin_scale)[block]
    return smallest > 2.0 * LEAST_MARGIN * scale


@printed
def ends_early(_code: Procedure, system: SystemView, end: Whole, block: Whole) -> Truth:
    """Whether a run stops at larger margins than it must, and this one is too small at the end."""
    return stops_early(system, block) & is_too_small(system, end, block)


@printed
def early_fraction(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    block: Whole, t: Real, h: Real, last: Real,
) -> Real:  # fmt: skip
    """Fraction of a step before a margin is the smallest that is allowed; it is so at `last`."""
    before, after = code.variable(0.0), code.variable(last)
    with code.count(EARLY_BISECTIONS):
        middle = 0.5 * (before + after)
        integers(record.counters)[EVALUATIONS] += table.end
        status = try_step(system, t, middle * h, t + middle * h)
        with code.when((status == 0) & ~is_too_small(system, table.end, block)) as case:
            before.set(middle)
        with case.otherwise():
            after.set(middle)
    return code.value(before)


@printed
def singular_fraction(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    t: Real, h: Real, t_end: Real,
) -> Real:  # fmt: skip
    """Find the first singular position within a step that has suspicious blocks.

    Returns the fraction of the step that lies before it, with the workspace holding the step of
    that length and its block noted; or 1 if there is none, with the workspace as it was.
    """
    counters, fraction = integers(record.counters), code.variable(1.0)
    with code.count(system.blocks) as block:
        with code.when(ends_early(system, table.end, block)):
            early = early_fraction(system, table, record, block, t, h, 1.0)
            fraction.set(smaller_of(fraction, early))
            counters[BLOCK] = block
            try_step(system, t, h, t_end)
            code.again()
        with code.when(is_suspicious(system, table.end, block, h)):
            least, before = least_margin(code, system, table, record, block, t, h)
            with code.when(least < floats(system.smallest_margins)[block]):
                with code.when(stops_early(system, block)):
                    before.set(early_fraction(system, table, record, block, t, h, before))
                with code.when(before < fraction):
                    fraction.set(before)
                    counters[BLOCK] = block
            counters[EVALUATIONS] += table.end
            try_step(system, t, h, t_end)
    with code.when(fraction < 1.0):
        counters[EVALUATIONS] += table.end
        try_step(system, t, fraction * h, t + fraction * h)
    return code.value(fraction)


@printed
def check_margins(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    t: Real, h: Real, t_end: Real,
) -> Real:  # fmt: skip
    """Fraction of an accepted step before a singular position; see `singular_fraction`."""
    with code.count(system.blocks) as block:
        early = ends_early(system, table.end, block)
        with code.when(early | is_suspicious(system, table.end, block, h)):
            code.leave(singular_fraction(system, table, record, t, h, t_end))
    return code.value(1.0)
