"""Location of mode changes within an accepted step.

The kernel writes the functions of all switches and their rates with every stage. Those at both ends
of a step say whether one crosses zero within, or dips below it and comes back. The step itself,
repeated in part, then gives the time: cubics through both ends converge without dense output.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from linkages.kernel.code.operands import Bool, Int, Real, RealArray, minimum, select
from linkages.kernel.code.procedure import Procedure, traced
from linkages.solvers.loops.control import (
    HALVINGS,
    ROUND_OFF,
    cubic_through,
    least_of_stages,
    meeting,
    round_off_of,
    unlike_cubic,
    with_sign_of_mode,
)
from linkages.solvers.loops.memory import Motion
from linkages.solvers.loops.scalar_stages import bisect, try_step

# What `find_switch` returns where no mode changes.
GO_ON = 2.0
# Of the length of a step: as near to the change as times can be told apart.
EXACT = 1e-14
# Repetitions of a step: far more than cubics need, enough to halve it down to its last digit.
SEARCHES, DIPS = 60, 8
# Where a rejected step is repeated up to a change, so that it lies within.
BEHIND = 1.001


def functions_of(motion: Motion, row: Any) -> RealArray:
    """The functions of all switches in a row; their rates follow."""
    return motion.row(row, motion.width - 2 * motion.switches.modes)


def switch_value(motion: Motion, row: Any, switch: Int) -> tuple[Real, Real]:
    """Function of a switch and its rate, not negative as long as its mode is right."""
    mode, result = motion.held[switch], functions_of(motion, row)
    value, rate = result[switch], result[motion.switches.modes + switch]
    return with_sign_of_mode(mode, value), with_sign_of_mode(mode, rate)


@traced
def is_watched(code: Procedure, motion: Motion, k: Int) -> Bool:
    """Whether a switch is looked at: the mode that it depends on is +1."""
    owner = motion.switches.active[k]
    code.return_if(owner < 0, True)
    return motion.held[owner] > 0.0


@traced
def first_zero(code: Procedure, start: Real, rise: Real, end: Real, fall: Real) -> Real:
    """Where on (0, 1] the cubic with these values and rates at 0 and 1 becomes negative."""
    c2, c3 = cubic_through(start, rise, end, fall)
    low, high = bisect(code, 50, lambda x: start + x * (rise + x * (c2 + x * c3)) > 0.0)
    return 0.5 * (low + high)


@traced
def least_place(code: Procedure, start: Real, rise: Real, end: Real, fall: Real) -> Real:
    """Where on [0, 1] such a cubic, which falls at 0 and rises at 1, is least."""
    c2, c3 = cubic_through(start, rise, end, fall)
    low, high = bisect(code, 30, lambda x: rise + x * (2.0 * c2 + x * 3.0 * c3) < 0.0)
    return 0.5 * (low + high)


def try_part(motion: Motion, t: Real, h: Real, part: Any) -> Bool:
    """Repeat a step in part; whether that is possible."""
    motion.counters.evaluations += motion.cost
    return try_step(motion, t, part * h, t + part * h) == 0


@traced
def locate(code: Procedure, motion: Motion, switch: Int, t: Real, h: Real, part: Real) -> Real:
    """Fraction of a step at which a function crosses zero, which is negative at `part` of it.

    The workspace is left with the step up to there.
    """
    start, rise = map(code.variable, switch_value(motion, 0, switch))
    end, fall = map(code.variable, switch_value(motion, motion.end, switch))
    rise.set(rise * h)
    fall.set(fall * h)
    with code.if_((start <= 0.0) & (rise <= 0.0)):  # as a run begins that ended here
        try_part(motion, t, h, code.value(0.0))
        code.return_(0.0)
    low, high = code.variable(0.0), code.variable(part)
    theta, last = code.variable(part), code.variable(abs(end))
    with code.for_range(SEARCHES) as search:
        width = high - low
        theta.set(low + width * first_zero(start, width * rise, end, width * fall))
        with code.if_(search % 4 == 3):  # in case that cubics say nothing
            theta.set(0.5 * (low + high))
        with code.if_(~try_part(motion, t, h, theta)):
            high.set(theta)
            code.continue_()
        here, rate = switch_value(motion, motion.end, switch)
        rate = rate * h
        code.break_if((here == 0.0) | (abs(here) <= EXACT * abs(rate)))
        with code.if_(here > 0.0) as case:
            low.set(theta)
            start.set(here)
            rise.set(rate)
        with case.else_():
            high.set(theta)
            end.set(here)
            fall.set(rate)
        # where the function is round-off alone it ceases to shrink
        stays = (abs(here) >= 0.5 * last) & (abs(here) < ROUND_OFF * abs(rate))
        code.break_if((high - low < EXACT) | stays)
        last.set(abs(here))
    return code.value(theta)


@traced
def locate_switch(
    code: Procedure, motion: Motion, switch: Int, t: Real, h: Real, part: Real
) -> Real:
    """Fraction of a step at which a mode changes before `part` of it, which is in the workspace.

    If there is one the workspace is left with the step up to there, otherwise with any.
    """
    start, rise = switch_value(motion, 0, switch)
    end, fall = switch_value(motion, motion.end, switch)
    rise, fall = rise * h, fall * h
    with code.if_(end < 0.0):
        # where another change makes the step short, what began it is a round-off below zero
        slack = round_off_of(start, rise)
        begins = (rise > 0.0) & (fall > 0.0) & (start < slack) & (-end < slack)
        # friction that lets go has rates that are round-off as well: it waits until it moves
        waits = (motion.switches.sticks[switch] != 0) & (start < 0.0) & (end >= 2.0 * start)
        code.return_if(begins | waits, GO_ON)
        code.return_(locate(motion, switch, t, h, part))
    with code.if_((start > 0.0) & (rise < 0.0) & (fall > 0.0)):
        code.return_(locate_dip(motion, switch, t, h, part, start, rise, end, fall))
    least = least_of_stages(start, rise, end)
    with code.for_range(motion.end - 1) as before:
        row = before + 1
        here, _ = switch_value(motion, row, switch)
        with code.if_(here < least):
            theta = motion.c[row] * part
            code.return_if(~((theta > 0.0) & (theta < part)), GO_ON)
            code.return_if(~try_part(motion, t, h, theta), GO_ON)
            here, _ = switch_value(motion, motion.end, switch)
            with code.if_(here < 0.0):
                code.return_(locate(motion, switch, t, h, theta))
            code.return_(GO_ON)
    return code.value(GO_ON)


@traced
def locate_dip(
    code: Procedure, motion: Motion,
    switch: Int, t: Real, h: Real, part: Real,
    at_start: Real, falls: Real, at_end: Real, rises: Real,
) -> Real:  # fmt: skip
    """Such a fraction, of a function that falls at the start of a step and rises at its end."""
    start, rise, end, fall = map(code.variable, (at_start, falls, at_end, rises))
    low, high = code.variable(0.0), code.variable(part)
    with code.for_range(DIPS):
        width = high - low
        # it falls no deeper than where the tangents meet
        code.return_if(meeting(start, width * rise, end, width * fall) >= 0.0, GO_ON)
        theta = low + width * least_place(start, width * rise, end, width * fall)
        code.return_if(~try_part(motion, t, h, theta), GO_ON)
        here, rate = switch_value(motion, motion.end, switch)
        with code.if_(here < 0.0):
            code.return_(locate(motion, switch, t, h, theta))
        with code.if_(rate * h < 0.0) as case:
            low.set(theta)
            start.set(here)
            rise.set(rate * h)
        with case.else_():
            high.set(theta)
            end.set(here)
            fall.set(rate * h)
    return code.value(GO_ON)


@traced
def unresolved(code: Procedure, motion: Motion, switch: Int, h: Real) -> Bool:
    """Whether a function varies so much within a step that its ends do not say if it crosses zero.

    At stages it is then far from the cubic through both ends, beside its own variation.
    """
    switches = motion.switches
    start, rise = switch_value(motion, 0, switch)
    end, fall = switch_value(motion, motion.end, switch)
    rows, c = switches.rows, motion.c

    def stages() -> Iterator[tuple[Real, Real]]:
        with code.for_range(switches.compared) as k:
            yield c[rows[k]], switch_value(motion, rows[k], switch)[0]

    return unlike_cubic(start, h * rise, end, h * fall, stages())


@traced
def find_switch(code: Procedure, motion: Motion, t: Real, h: Real, t_end: Real) -> Real:
    """Find the first change of a mode within the accepted step in the workspace.

    Returns the fraction of the step, with the workspace holding the step up to there; or GO_ON,
    with the workspace as it was; or a number below zero where the step is too long to say.
    """
    switches, counters, stepper = motion.switches, motion.counters, motion.stepper
    unclear = code.variable(False)
    with code.for_range(switches.modes) as k:
        watched = is_watched(motion, k)
        with code.if_(watched), code.if_(unresolved(motion, k, h)):
            unclear.set(True)
            code.break_()
    with code.if_(unclear & (stepper.halved < HALVINGS)):
        stepper.halved += 1
        code.return_(-1.0)
    with code.if_(~unclear):  # round-off does not begin anew with every step, or none gets longer
        stepper.halved = 0
    part, last, switch = code.variable(1.0), code.variable(-1), code.variable(0)
    with code.while_(lambda: switch < switches.modes):
        with code.if_(is_watched(motion, switch) & (switch != last)):
            before = counters.evaluations
            result = locate_switch(motion, switch, t, h, part)
            # another one may come before it; one at the same time follows with the next step
            sooner = select(last < 0, result <= part, result < (1.0 - EXACT) * part)
            with code.if_(sooner):
                part.set(result)
                last.set(switch)
                switch.set(0)
                code.continue_()
            with code.if_(counters.evaluations != before):
                counters.evaluations += motion.cost
                until = select(last < 0, t_end, t + part * h)
                try_step(motion, t, part * h, until)
        switch.set(switch + 1)
    code.return_if(last < 0, GO_ON)
    switches.pending[0] = last
    return code.value(part)


@traced
def estimate_switch(code: Procedure, motion: Motion, h: Real) -> Real:
    """Where a rejected step first changes a mode, or a little behind; above 1 if nowhere."""
    part = code.variable(GO_ON)
    with code.for_range(motion.switches.modes) as switch, code.if_(is_watched(motion, switch)):
        start, rise = switch_value(motion, 0, switch)
        end, fall = switch_value(motion, motion.end, switch)
        with code.if_((start > 0.0) & (end < 0.0)):
            zero = first_zero(start, h * rise, end, h * fall)
            part.set(minimum(part, BEHIND * zero))
    return code.value(part)
