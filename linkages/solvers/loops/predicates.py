"""Whether events, mode changes, whole turns or singular positions may lie within a step.

Where none of these comparisons holds, what looks for them (`crossings`, `mode_changes`, `margins`)
would find nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from linkages.kernel.code.elementary_functions import elementary
from linkages.kernel.code.operands import (
    Bool,
    Real,
    RealArray,
    copysign,
    fma,
    maximum,
    minimum,
    rint,
    select,
)
from linkages.kernel.dyads import LEAST_MARGIN
from linkages.solvers.loops.memory import TWO_PI, EventValues
from linkages.solvers.loops.row_layout import RowLayout, StepMemory, combined
from linkages.solvers.tableau import Tableau

# The sine is concave on both sides of zero: over MOST_CHANGE, tan(x)/x stays below this.
CONCAVITY = 1.1


def passes_zero(before: Real, fall: Real, after: Real, rise: Real) -> Bool:
    """Whether a margin, extrapolated with its changes from both ends of a step, crosses zero."""
    side = before >= 0.0
    ahead, behind = fma(fall, CONCAVITY, before), fma(rise, -CONCAVITY, after)
    return (select(side, ahead, -ahead) < 0.0) & (select(side, behind, -behind) < 0.0)


def is_small(margin: Real, change: Real, scale: Real, smallest: Real) -> Bool:
    """Whether a margin is singular, or smaller than a run allows and still falling."""
    early = (margin * change < 0.0) & (abs(margin) < smallest)
    return (abs(margin) < LEAST_MARGIN * scale) | early


def write_expected(layout: RowLayout, memory: StepMemory, h: Real, weights: Sequence[Any]) -> None:
    """Write where dependent angles are after a time h, from weights of their speeds in rows."""
    place = layout.cosines + 2 * layout.counted
    speeds = [memory.row(row, place) for row in range(len(weights))]
    for i in range(layout.counted):
        memory.ahead[i] = fma(h, combined(weights, speeds, i), memory.angles[i])


def nearest_turn(sine: Real, cosine: Real, expected: Real) -> Real:
    """The angle of a unit vector, with the turns that bring it closest to where it should be."""
    angle = elementary("atan2", sine, cosine)
    return fma(rint((expected - angle) / TWO_PI), TWO_PI, angle)


def write_counted(
    layout: RowLayout,
    memory: StepMemory,
    row: RealArray,
    into: RealArray,
    where: Bool | None = None,
) -> None:
    """Write the dependent angles in a row, in some lanes, close to where they are expected."""
    cosines = row.after(layout.cosines)
    for i in range(layout.counted):
        result = nearest_turn(cosines[layout.counted + i], cosines[i], memory.ahead[i])
        into[i] = result if where is None else select(where, result, into[i])


# A state on a level, as a run from a located crossing starts with, lies beyond it.
SLACK = 1e-12


def meeting(start: Real, rise: Real, end: Real, fall: Real) -> Real:
    """Value at which the tangents at both ends of a step, with these changes, meet."""
    return start + rise * (end - fall - start) / (rise - fall)


def level_crossed(start: Real, rise: Real, end: Real, fall: Real, level: Real) -> Bool:
    """Whether a function, less its level, with these values and changes may cross zero."""
    slack = SLACK * maximum(abs(level), 1.0)

    def beyond(side: Real, low: Real, high: Real) -> Bool:
        return (fma(side, low, slack) < 0.0) & (fma(side, high, slack) >= 0.0)

    steady = beyond(copysign(1.0, end - start), start, end)
    bound, side = meeting(start, rise, end, fall), copysign(1.0, fall)
    turned = beyond(side, bound, start) | beyond(side, bound, end)
    return steady | ((rise * fall < 0.0) & turned)


class CrossedLevels:
    """Watches the events of a trial."""

    def __init__(self, tableau: Tableau, layout: RowLayout, memory: StepMemory) -> None:
        self._end, self._memory = tableau.stages, memory
        self._events = [memory.event_values(event) for event in range(layout.events)]

    def need_more(self, h: Real, end: Real) -> Bool:
        """Evaluate all events at the end of a step, of length h; where it is to be looked at."""
        memory, result = self._memory, self._memory.code.value(False)
        for event, kept in enumerate(self._events):
            self._evaluate(event, kept, end)
            level = memory.levels[event]
            crossed = level_crossed(
                kept.value_before - level, h * kept.rate_before,
                kept.value - level, h * kept.rate, level,
            )  # fmt: skip
            result = result | crossed | (kept.before != memory.stepper.t)
        return result

    def keep(self, where: Bool, end: Real) -> None:
        """Make values at the end of a step those at the start of the next one, in some lanes."""
        for kept in self._events:
            kept.before = select(where, end, kept.before)
            kept.value_before = select(where, kept.value, kept.value_before)
            kept.rate_before = select(where, kept.rate, kept.rate_before)

    def _evaluate(self, event: int, kept: EventValues, end: Real) -> None:
        """Evaluate a function and its rate at the end; nan where that is not possible."""
        memory, functions = self._memory, self._memory.event(event)
        timed = memory.call_clock(end, functions)
        sound = (timed == 0) & (memory.call_rates(memory.row(self._end), kept, functions) == 0)
        kept.value, kept.rate = (select(sound, each, math.nan) for each in (kept.value, kept.rate))


# Value of a function that is no more than round-off, beside its change in a step.
ROUND_OFF = 1e-9
# How far from a cubic a function may be at a stage beside its variation, and how far from zero,
# beside that, it does not matter. Measured on 260 random motions between two walls with friction:
# 0.1 missed releases of a tenth of a period.
UNLIKE, FAR = 0.03, 10.0
# How often a step is halved to see what functions do: more is round-off.
HALVINGS = 8
# A stage is this far below zero, beside the ends of its step, before it is looked at.
BELOW = 1e-9


def with_sign_of_mode(mode: Real, value: Real) -> Real:
    """Function of a switch, or its rate: it is not negative as long as its mode is right."""
    return select(mode == 0.0, 1.0, mode) * value  # 0 is a mode that sticks


def cubic_through(start: Real, rise: Real, end: Real, fall: Real) -> tuple[Real, Real]:
    """Coefficients of x² and x³ of the cubic with these values and rates at 0 and 1."""
    change = end - start
    return 3.0 * change - 2.0 * rise - fall, rise + fall - 2.0 * change


def round_off_of(start: Real, rise: Real) -> Real:
    """How far below zero a function may be that a change has just made right."""
    return maximum(ROUND_OFF * rise, -2.0 * start)


def least_of_stages(start: Real, rise: Real, end: Real) -> Real:
    """Value below which a stage is looked at."""
    return -maximum(round_off_of(start, rise), BELOW * (abs(start) + end))


def dips(start: Real, rise: Real, end: Real, fall: Real) -> Bool:
    """Whether a function may be below zero between the ends of a step."""
    turns = (start > 0.0) & (rise < 0.0) & (fall > 0.0)
    return turns & (meeting(start, rise, end, fall) < 0.0)


def unlike_cubic(
    start: Real, rise: Real, end: Real, fall: Real, stages: Iterable[tuple[Any, Real]]
) -> Bool:
    """Whether values at some fractions of a step are so far from the cubic that it says nothing."""
    c2, c3 = cubic_through(start, rise, end, fall)
    code, low, high = start.code, minimum(start, end), maximum(start, end)
    low, high, apart = code.variable(low), code.variable(high), code.variable(0.0)
    for x, here in stages:
        cubic = fma(fma(fma(c3, x, c2), x, rise), x, start)
        apart.set(maximum(apart, abs(here - cubic)))
        low.set(minimum(low, here))
        high.set(maximum(high, here))
    return (apart > UNLIKE * (high - low)) & (low < FAR * apart)


class Modes:
    """Watches the modes of a trial of length `h`."""

    def __init__(self, tableau: Tableau, layout: RowLayout, memory: StepMemory, h: Real) -> None:
        self._tableau, self._layout, self._memory, self._h = tableau, layout, memory, h
        self._stepper = memory.stepper

    def need_more(self, accepted: Bool) -> tuple[Bool, Bool]:
        """In which lanes a step, accepted or not, is to be looked at; in which it is too long.

        One that follows a switch is also looked at where it is rejected. One that is too long to
        say what functions do is halved, unless a change ahead says where to end it.
        """
        no = changes = ahead = unresolved = self._memory.code.value(False)
        if not self._layout.active:
            return no, no
        for switch, owner in enumerate(self._layout.active):
            here = self._switch(switch)
            if owner >= 0:  # it is watched where another mode is +1
                watched = self._memory.held[owner] > 0.0
                here = tuple(watched & where for where in here)
            changes, ahead, unresolved = changes | here[0], ahead | here[1], unresolved | here[2]
        fresh, again = self._stepper.after_switch > 0.0, self._stepper.rejected_before > 0.0
        ahead = ahead & ~again
        plain = (self._stepper.halved < HALVINGS) & ~(ahead | fresh)
        result = select(accepted, changes | unresolved, ahead | fresh)
        return result, accepted & unresolved & plain

    def halve(self, where: Bool, commits: Bool) -> None:
        """Count how often steps are halved, in some lanes; it ends with a step that counts."""
        if self._layout.active:
            before = self._stepper.halved
            self._stepper.halved = select(commits, 0, select(where, before + 1, before))

    def _switch(self, switch: int) -> tuple[Bool, Bool, Bool]:
        """Where it may change within an accepted step, crosses its zero, or cannot be told of."""
        memory, end, mode = self._memory, self._tableau.stages, self._memory.held[switch]
        values = [memory.row(row, self._layout.functions + switch) for row in range(end + 1)]
        seen = [with_sign_of_mode(mode, value[0]) for value in values]
        modes = len(self._layout.active)
        rise, fall = (with_sign_of_mode(mode, values[row][modes]) * self._h for row in (0, end))
        start, stop = seen[0], seen[end]
        depth = self._memory.code.value(math.inf)
        for here in seen[1:end]:
            depth = minimum(depth, here)
        changes = (stop < 0.0) | dips(start, rise, stop, fall)
        changes = changes | (depth < least_of_stages(start, rise, stop))
        stages = [(float(self._tableau.c[row]), seen[row]) for row in self._tableau.quarters]
        unresolved = unlike_cubic(start, rise, stop, fall, stages)
        return changes, (start > 0.0) & (stop < 0.0), unresolved
