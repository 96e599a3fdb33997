"""Within a step: singularity margins, whole turns and samples.

A block's margin goes to zero where its two links are aligned. Positions are closed forms with a
fixed sign, so that a margin passes through zero like ``|t|``, which can be overlooked between two
accepted steps. A step is suspicious if the margin, extrapolated from both of its ends, crosses zero
within it. It is then repeated in part, to find the least margin. Below `LEAST_MARGIN` of its scale,
unless a run asks for more, accelerations lose their last digits to round-off: the integration
stops.

The kernel writes the unit vector and the speed of each counted angle. The speeds, added up with the
weights of a step, say to much less than half a turn where it is; the unit vector says where exactly
within the turn, so that errors do not add up over the steps.
"""

from __future__ import annotations

from typing import Any

from linkages.kernel.code.operands import (
    Bool,
    Function,
    Int,
    Real,
    RealArray,
    minimum,
    select,
    select_of,
)
from linkages.kernel.code.procedure import Procedure, traced
from linkages.kernel.dyads import LEAST_MARGIN
from linkages.solvers.loops.control import is_small, passes_zero
from linkages.solvers.loops.memory import Motion
from linkages.solvers.loops.scalar_stages import bisect, evaluate_at, further_stages, try_step

# Enough to halve a step down to its last digit.
BISECTIONS = 60
# Enough to find the first margin that is too small within a few thousandths of a step.
EARLY_BISECTIONS = 12


def margins_of(motion: Motion, row: Int | int) -> RealArray:
    """The margins of a row; their rates follow."""
    return motion.row(row, 3 * motion.n)


def side_of(margin: Real) -> Real:
    """1 or -1, as a margin is positive or negative."""
    return select_of(Real, margin >= 0.0, 1.0, -1.0)


@traced
def is_suspicious(_code: Procedure, motion: Motion, end: Int, block: Int, h: Real) -> Bool:
    """Whether a block's margin, extrapolated from both ends of a step, crosses zero within."""
    first, last = margins_of(motion, 0), margins_of(motion, end)
    rate = block + motion.blocks
    return passes_zero(first[block], first[rate] * h, last[block], last[rate] * h)


def least_margin(code: Procedure, motion: Motion, block: Int, t: Real, h: Real) -> tuple[Any, Any]:
    """Least margin of a block within a step, and the fraction before it, by bisection."""
    start, end = margins_of(motion, 0), margins_of(motion, motion.end)
    side = side_of(start[block])
    least = code.variable(minimum(abs(start[block]), abs(end[block])))
    before, after = code.variable(0.0), code.variable(1.0)
    with code.for_range(BISECTIONS):
        middle = 0.5 * (before + after)
        motion.counters.evaluations += motion.cost
        with code.if_(try_step(motion, t, middle * h, t + middle * h) != 0):
            # Round-off puts aligned links out of reach.
            least.set(0.0)
            after.set(middle)
            code.continue_()
        least.set(minimum(least, abs(end[block])))
        with code.if_(side * h * end[block + motion.blocks] < 0.0) as case:
            before.set(middle)
        with case.else_():
            after.set(middle)
    return least, before


@traced
def is_too_small(_code: Procedure, motion: Motion, row: Int, block: Int) -> Bool:
    """Whether a margin is singular, or smaller than a run allows and still falling."""
    margins = margins_of(motion, row)
    rate = margins[block + motion.blocks]
    forward_rate = select(motion.backward != 0, -rate, rate)
    scale, smallest = motion.scale[block], motion.smallest[block]
    return is_small(margins[block], forward_rate, scale, smallest)


def stops_early(motion: Motion, block: Int) -> Any:
    """Whether a run stops at larger margins than it must."""
    smallest, scale = motion.smallest[block], motion.scale[block]
    return smallest > 2.0 * LEAST_MARGIN * scale


@traced
def ends_early(_code: Procedure, motion: Motion, end: Int, block: Int) -> Bool:
    """Whether a run stops at larger margins than it must, and this one is too small at the end."""
    return stops_early(motion, block) & is_too_small(motion, end, block)


@traced
def early_fraction(
    code: Procedure, motion: Motion, block: Int, t: Real, h: Real, last: Real
) -> Real:
    """Fraction of a step before a margin is the smallest that is allowed; it is so at `last`."""

    def is_allowed(part: Real) -> Bool:
        motion.counters.evaluations += motion.cost
        status = try_step(motion, t, part * h, t + part * h)
        return (status == 0) & ~is_too_small(motion, motion.end, block)

    return code.value(bisect(code, EARLY_BISECTIONS, is_allowed, last)[0])


@traced
def singular_fraction(code: Procedure, motion: Motion, t: Real, h: Real, t_end: Real) -> Real:
    """Find the first singular position within a step that has suspicious blocks.

    Returns the fraction of the step that lies before it, with the workspace holding the step of
    that length and its block noted; or 1, with the workspace as it was.
    """
    counters, fraction = motion.counters, code.variable(1.0)
    with code.for_range(motion.blocks) as block:
        with code.if_(ends_early(motion, motion.end, block)):
            early = early_fraction(motion, block, t, h, 1.0)
            fraction.set(minimum(fraction, early))
            counters.block = block
            try_step(motion, t, h, t_end)
            code.continue_()
        with code.if_(is_suspicious(motion, motion.end, block, h)):
            least, before = least_margin(code, motion, block, t, h)
            with code.if_(least < motion.smallest[block]):
                with code.if_(stops_early(motion, block)):
                    before.set(early_fraction(motion, block, t, h, before))
                with code.if_(before < fraction):
                    fraction.set(before)
                    counters.block = block
            counters.evaluations += motion.cost
            try_step(motion, t, h, t_end)
    with code.if_(fraction < 1.0):
        counters.evaluations += motion.cost
        try_step(motion, t, fraction * h, t + fraction * h)
    return code.value(fraction)


@traced
def check_margins(code: Procedure, motion: Motion, t: Real, h: Real, t_end: Real) -> Real:
    """Fraction of an accepted step before a singular position; see `singular_fraction`."""
    with code.for_range(motion.blocks) as block:
        early = ends_early(motion, motion.end, block)
        with code.if_(early | is_suspicious(motion, motion.end, block, h)):
            code.return_(singular_fraction(motion, t, h, t_end))
    return code.value(1.0)


@traced
def reachable_part(code: Procedure, motion: Motion, t: Real, h: Real) -> Real:
    """Longest fraction of a failed step that can be made, left in the workspace."""
    made, _ = bisect(code, BISECTIONS, lambda x: try_step(motion, t, x * h, t + x * h) == 0)
    motion.counters.evaluations += (BISECTIONS + 1) * motion.cost
    with code.if_(made > 0.0):
        try_step(motion, t, made * h, t + made * h)
    return code.value(made)


@traced
def start_angles(_code: Procedure, motion: Motion) -> None:
    """Begin with the angles in row 0, closest to where a run says that they are."""
    motion.ahead.take(motion.angles, motion.counted)
    motion.count(Int, motion, motion.row(0), motion.angles)


# Relative to a fixed step, below this distance a sample time is meant to be the step's end.
SNAP = 1e-9


@traced
def write_held(_code: Procedure, motion: Motion, sample: Int) -> None:
    """Write modes and memories beside a sample."""
    motion.sampled_held.after(sample * motion.holding).take(motion.held, motion.holding)


@traced
def write_sample(_code: Procedure, motion: Motion, row: Int) -> None:
    """Write the state and the accelerations in a row as the next sample."""
    write_held(motion, motion.counters.samples)
    motion.sample(Int, motion, motion.row(row))


def interpolate(motion: Motion, function: Function, h: Real, theta: Real) -> Int:
    """Write the state at the fraction theta of a step into the last row; returns a status."""
    motion.stepper.length, motion.stepper.theta = h, theta
    return function(Int, motion)


def left_of(h: Real, t_end: Real, time: Any) -> Any:
    """How much of a step lies behind a time."""
    return select(h > 0.0, t_end - time, time - t_end)


@traced
def sample_between(
    code: Procedure, motion: Motion, t: Real, h: Real, t_end: Real, slack: Real
) -> Int:
    """Take the samples within a step from t to t_end, of which there is one at least.

    Sample times within `slack` of the end take the state at the end as it is; others need the
    further stages of the dense output. Returns 0, or the status of the kernel where it cannot be
    evaluated.
    """
    counters = motion.counters
    more = code.variable(motion.scratch - 1 - motion.end)
    with code.while_(lambda: counters.samples < motion.samples):
        time = motion.times[counters.samples]
        left = left_of(h, t_end, time)
        code.break_if(left < -slack)
        with code.if_(left <= slack):
            motion.expect_end(Int, motion)
            write_sample(motion, motion.end)
            code.continue_()
        with code.if_(more > 0):
            counters.evaluations += more
            status = further_stages(motion, t, h, t_end)
            code.return_if(status != 0, status)
            more.set(0)
        theta = minimum((time - t) / h, 1.0)
        status = interpolate(motion, motion.between, h, theta)
        code.return_if(status != 0, status)
        counters.evaluations += 1
        status = evaluate_at(motion, time, motion.scratch)
        code.return_if(status != 0, status)
        motion.expect_between(Int, motion)
        write_sample(motion, motion.scratch)
    return code.value(0)


@traced
def take_samples(
    code: Procedure, motion: Motion, t: Real, h: Real, t_end: Real, slack: Real
) -> Int:
    """Take all samples that fall within an accepted step; see `sample_between`."""
    k = motion.counters.samples
    code.return_if(k == motion.samples, 0)
    code.return_if(left_of(h, t_end, motion.times[k]) < -slack, 0)
    return sample_between(motion, t, h, t_end, slack)
