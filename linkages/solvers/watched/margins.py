"""Watch for singular positions, where a step could come out in the wrong assembly mode.

A block's margin goes to zero where its two links are aligned. Positions are closed forms with a
fixed sign, so that a margin never changes sign: it passes through zero like ``|t|``, and between
two accepted steps that can be overlooked. A step is suspicious if the margin, extrapolated from
both of its ends, crosses zero within it. It is then repeated in part, to find the least margin.

Below a least margin (`LEAST_MARGIN` of its scale, unless a run asks for more) accelerations lose
their last digits to round-off, and the motion beyond is arbitrary: the integration stops there.
"""

from __future__ import annotations

from linkages.kernel.closure.dyads import LEAST_MARGIN
from linkages.solvers.printed.advance import CONCAVITY
from linkages.solvers.steps.compiled import compiled, floats, integers
from linkages.solvers.steps.stages import address_of, try_step
from linkages.solvers.steps.views import BLOCK, EVALUATIONS, WORD, Record, SystemView, TableView

# Enough to halve a step down to its last digit.
BISECTIONS = 60
# Enough to find the first margin that is too small within a few thousandths of a step.
EARLY_BISECTIONS = 12


@compiled
def margins_of(system: SystemView, row: int) -> int:
    """Address of the margins of a row; their rates follow."""
    return address_of(system, row) + WORD * 3 * system.n


@compiled
def is_suspicious(system: SystemView, end: int, block: int, h: float) -> bool:
    """Whether a block's margin, extrapolated from both ends of a step, crosses zero within."""
    first, last = floats(margins_of(system, 0)), floats(margins_of(system, end))
    rate = block + system.blocks
    side = 1.0 if first[block] >= 0.0 else -1.0
    ahead = side * (first[block] + CONCAVITY * h * first[rate])
    behind = side * (last[block] - CONCAVITY * h * last[rate])
    return ahead < 0.0 and behind < 0.0


@compiled
def least_margin(
    system: SystemView, table: TableView, record: Record, block: int, t: float, h: float
) -> tuple[float, float]:
    """Least margin of a block within a step, and the fraction of the step before it.

    Bisects on the sign of the margin's rate, repeating the step from its start.
    """
    start, end = floats(margins_of(system, 0)), floats(margins_of(system, table.end))
    side = 1.0 if start[block] >= 0.0 else -1.0
    least = min(abs(start[block]), abs(end[block]))
    before, after = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (before + after)
        integers(record.counters)[EVALUATIONS] += table.end
        if try_step(system, t, middle * h, t + middle * h) != 0:
            # Round-off puts aligned links out of reach.
            least, after = 0.0, middle
            continue
        least = min(least, abs(end[block]))
        if side * h * end[block + system.blocks] < 0.0:
            before = middle
        else:
            after = middle
    return least, before


@compiled
def is_too_small(system: SystemView, row: int, block: int) -> bool:
    """Whether a margin is singular, or smaller than a run allows and still falling."""
    margins = floats(margins_of(system, row))
    margin, rate = margins[block], margins[block + system.blocks]
    if abs(margin) < LEAST_MARGIN * floats(system.margin_scale)[block]:
        return True
    falling = margin * rate > 0.0 if system.backward != 0 else margin * rate < 0.0
    return falling and abs(margin) < floats(system.smallest_margins)[block]


@compiled
def ends_early(system: SystemView, end: int, block: int) -> bool:
    """Whether a run stops at larger margins than it must, and this one is too small at the end."""
    smallest = floats(system.smallest_margins)[block]
    early = smallest > 2.0 * LEAST_MARGIN * floats(system.margin_scale)[block]
    return early and is_too_small(system, end, block)


@compiled
def early_fraction(
    system: SystemView,
    table: TableView,
    record: Record,
    block: int,
    t: float,
    h: float,
    after: float,
) -> float:
    """Fraction of a step before a margin is the smallest that is allowed; it is so at `after`."""
    before = 0.0
    for _ in range(EARLY_BISECTIONS):
        middle = 0.5 * (before + after)
        integers(record.counters)[EVALUATIONS] += table.end
        status = try_step(system, t, middle * h, t + middle * h)
        if status == 0 and not is_too_small(system, table.end, block):
            before = middle
        else:
            after = middle
    return before


@compiled
def singular_fraction(
    system: SystemView, table: TableView, record: Record, t: float, h: float, t_end: float
) -> float:
    """Find the first singular position within a step that has suspicious blocks.

    Returns the fraction of the step that lies before it, with the workspace holding the step of
    that length and its block noted; or 1 if there is none, with the workspace as it was.
    """
    counters = integers(record.counters)
    fraction = 1.0
    for block in range(system.blocks):
        if ends_early(system, table.end, block):
            fraction = min(fraction, early_fraction(system, table, record, block, t, h, 1.0))
            counters[BLOCK] = block
            try_step(system, t, h, t_end)
        elif is_suspicious(system, table.end, block, h):
            least, before = least_margin(system, table, record, block, t, h)
            smallest = floats(system.smallest_margins)[block]
            if least < smallest:
                if smallest > 2.0 * LEAST_MARGIN * floats(system.margin_scale)[block]:
                    before = early_fraction(system, table, record, block, t, h, before)
                if before < fraction:
                    fraction = before
                    counters[BLOCK] = block
            counters[EVALUATIONS] += table.end
            try_step(system, t, h, t_end)
    if fraction < 1.0:
        counters[EVALUATIONS] += table.end
        try_step(system, t, fraction * h, t + fraction * h)
    return fraction


@compiled
def check_margins(
    system: SystemView, table: TableView, record: Record, t: float, h: float, t_end: float
) -> float:
    """Fraction of an accepted step before a singular position; see `singular_fraction`."""
    for block in range(system.blocks):
        if ends_early(system, table.end, block) or is_suspicious(system, table.end, block, h):
            return singular_fraction(system, table, record, t, h, t_end)
    return 1.0
