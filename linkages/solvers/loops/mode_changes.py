"""Location of mode changes within an accepted step.

The functions of all switches and their rates are written by the kernel with every stage. Those at
both ends of a step say whether one crosses zero within, or dips below it and comes back. The step
itself, repeated in part, then gives the time: cubics through values and rates at both ends of what
is left converge so fast that no dense output is needed.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from linkages.kernel.code.operands import (
    Real,
    Truth,
    Whole,
    choose,
    floats,
    integers,
    smaller_of,
)
from linkages.kernel.code.procedure import Procedure, printed
from linkages.solvers.loops.memory import (
    EVALUATIONS,
    WORD,
    Record,
    SwitchesView,
    SystemView,
    TableView,
)
from linkages.solvers.loops.predicates import (
    HALVINGS,
    ROUND_OFF,
    cubic_through,
    least_of_stages,
    meeting,
    round_off_of,
    unlike_cubic,
    with_sign_of_mode,
)
from linkages.solvers.loops.scalar_stages import address_of, try_step

SYSTEM_WORDS, TABLE_WORDS = len(SystemView._fields), len(TableView._fields)
RECORD_WORDS = len(Record._fields)
# What `look` returns where no mode changes.
GO_ON = 2.0
# Of the length of a step: as near to the change as times can be told apart.
EXACT = 1e-14
# Repetitions of a step: far more than cubics need, enough to halve it down to its last digit.
SEARCHES, DIPS = 60, 8
# Where a rejected step is repeated up to a change, so that it lies within.
BEHIND = 1.001


def system_at(context: Whole) -> Any:
    """The first part of a context: see `SwitchingView`."""
    return context.code.fields_at(context, SystemView)


def table_at(context: Whole) -> Any:
    """Its tableau."""
    return context.code.fields_at(context, TableView, SYSTEM_WORDS)


def record_at(context: Whole) -> Any:
    """Its record."""
    return context.code.fields_at(context, Record, SYSTEM_WORDS + TABLE_WORDS)


def switches_at(context: Whole) -> Any:
    """Its switches."""
    return context.code.fields_at(context, SwitchesView, SYSTEM_WORDS + TABLE_WORDS + RECORD_WORDS)


def functions_of(system: SystemView, modes: Any, row: Any) -> Any:
    """Address of the functions of all switches in a row; their rates follow."""
    return address_of(system, row) + WORD * (system.width - 2 * modes)


def seen(system: Any, modes: Any, row: Any, switch: Whole) -> tuple[Real, Real]:
    """Function of a switch and its rate, not negative as long as its mode is right."""
    mode, found = floats(system.held)[switch], floats(functions_of(system, modes, row))
    value, rate = found[switch], found[modes + switch]
    return with_sign_of_mode(mode, value), with_sign_of_mode(mode, rate)


@printed
def is_watched(code: Procedure, system: SystemView, switches: SwitchesView, k: Whole) -> Truth:
    """Whether a switch is looked at: the mode that it depends on is +1."""
    owner = integers(switches.active)[k]
    with code.when(owner < 0):
        code.leave(True)
    return floats(system.held)[owner] > 0.0


@printed
def first_zero(code: Procedure, start: Real, rise: Real, end: Real, fall: Real) -> Real:
    """Where on [0, 1] the cubic with these values and rates at 0 and 1 becomes negative.

    The place 0 itself counts as positive.
    """
    c2, c3 = cubic_through(start, rise, end, fall)
    low, high = code.variable(0.0), code.variable(1.0)
    with code.count(50):
        x = 0.5 * (low + high)
        with code.when(start + x * (rise + x * (c2 + x * c3)) > 0.0) as case:
            low.set(x)
        with case.otherwise():
            high.set(x)
    return 0.5 * (low + high)


@printed
def least_place(code: Procedure, start: Real, rise: Real, end: Real, fall: Real) -> Real:
    """Where on [0, 1] such a cubic, which falls at 0 and rises at 1, is least."""
    c2, c3 = cubic_through(start, rise, end, fall)
    low, high = code.variable(0.0), code.variable(1.0)
    with code.count(30):
        x = 0.5 * (low + high)
        with code.when(rise + x * (2.0 * c2 + x * 3.0 * c3) < 0.0) as case:
            low.set(x)
        with case.otherwise():
            high.set(x)
    return 0.5 * (low + high)


def try_part(system: Any, table: Any, record: Any, t: Real, h: Real, part: Any) -> Truth:
    """Repeat a step in part; whether that is possible."""
    integers(record.counters)[EVALUATIONS] += table.cost
    return try_step(system, t, part * h, t + part * h) == 0


@printed
def locate(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    modes: Whole, switch: Whole, t: Real, h: Real, part: Real,
) -> Real:  # fmt: skip
    """Fraction of a step at which a function crosses zero, which is negative at `part` of it.

    The workspace is left with the step up to there.
    """
    start, rise = map(code.variable, seen(system, modes, 0, switch))
    end, fall = map(code.variable, seen(system, modes, table.end, switch))
    rise.set(rise * h)
    fall.set(fall * h)
    with code.when((start <= 0.0) & (rise <= 0.0)):  # as a run begins that ended here
        try_part(system, table, record, t, h, code.value(0.0))
        code.leave(0.0)
    low, high = code.variable(0.0), code.variable(part)
    theta, last = code.variable(part), code.variable(abs(end))
    with code.count(SEARCHES) as search:
        width = high - low
        theta.set(low + width * first_zero(start, width * rise, end, width * fall))
        with code.when(search % 4 == 3):  # in case that cubics say nothing
            theta.set(0.5 * (low + high))
        with code.when(~try_part(system, table, record, t, h, theta)):
            high.set(theta)
            code.again()
        here, rate = seen(system, modes, table.end, switch)
        rate = rate * h
        with code.when((here == 0.0) | (abs(here) <= EXACT * abs(rate))):
            code.stop()
        with code.when(here > 0.0) as case:
            low.set(theta)
            start.set(here)
            rise.set(rate)
        with case.otherwise():
            high.set(theta)
            end.set(here)
            fall.set(rate)
        # where the function is round-off alone it ceases to shrink
        stays = (abs(here) >= 0.5 * last) & (abs(here) < ROUND_OFF * abs(rate))
        with code.when((high - low < EXACT) | stays):
            code.stop()
        last.set(abs(here))
    return code.value(theta)


@printed
def crossing(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    switches: SwitchesView, switch: Whole, t: Real, h: Real, part: Real,
) -> Real:  # fmt: skip
    """Fraction of a step at which a mode changes before `part` of it, which is in the workspace.

    If there is one the workspace is left with the step up to there, otherwise with any.
    """
    modes = switches.modes
    start, rise = seen(system, modes, 0, switch)
    end, fall = seen(system, modes, table.end, switch)
    rise, fall = rise * h, fall * h
    with code.when(end < 0.0):
        # where another change makes the step short, what began it is a round-off below zero
        slack = round_off_of(start, rise)
        begins = (rise > 0.0) & (fall > 0.0) & (start < slack) & (-end < slack)
        # friction that lets go has rates that are round-off as well: it waits until it moves
        waits = (integers(switches.sticks)[switch] != 0) & (start < 0.0) & (end >= 2.0 * start)
        with code.when(begins | waits):
            code.leave(GO_ON)
        code.leave(locate(system, table, record, modes, switch, t, h, part))
    with code.when((start > 0.0) & (rise < 0.0) & (fall > 0.0)):
        code.leave(dip(system, table, record, modes, switch, t, h, part, start, rise, end, fall))
    least = least_of_stages(start, rise, end)
    with code.count(table.end - 1) as before:
        row = before + 1
        here, _ = seen(system, modes, row, switch)
        with code.when(here < least):
            theta = floats(table.c)[row] * part
            with code.when(~((theta > 0.0) & (theta < part))):
                code.leave(GO_ON)
            with code.when(~try_part(system, table, record, t, h, theta)):
                code.leave(GO_ON)
            here, _ = seen(system, modes, table.end, switch)
            with code.when(here < 0.0):
                code.leave(locate(system, table, record, modes, switch, t, h, theta))
            code.leave(GO_ON)
    return code.value(GO_ON)


@printed
def dip(
    code: Procedure, system: SystemView, table: TableView, record: Record,
    modes: Whole, switch: Whole, t: Real, h: Real, part: Real,
    at_start: Real, falls: Real, at_end: Real, rises: Real,
) -> Real:  # fmt: skip
    """Such a fraction, of a function that falls at the start of a step and rises at its end."""
    start, rise, end, fall = map(code.variable, (at_start, falls, at_end, rises))
    low, high = code.variable(0.0), code.variable(part)
    with code.count(DIPS):
        width = high - low
        # it falls no deeper than where the tangents meet
        with code.when(meeting(start, width * rise, end, width * fall) >= 0.0):
            code.leave(GO_ON)
        theta = low + width * least_place(start, width * rise, end, width * fall)
        with code.when(~try_part(system, table, record, t, h, theta)):
            code.leave(GO_ON)
        here, rate = seen(system, modes, table.end, switch)
        with code.when(here < 0.0):
            code.leave(locate(system, table, record, modes, switch, t, h, theta))
        with code.when(rate * h < 0.0) as case:
            low.set(theta)
            start.set(here)
            rise.set(rate * h)
        with case.otherwise():
            high.set(theta)
            end.set(here)
            fall.set(rate * h)
    return code.value(GO_ON)


@printed
def unresolved(
    code: Procedure, system: SystemView, table: TableView, switches: SwitchesView,
    switch: Whole, h: Real,
) -> Truth:  # fmt: skip
    """Whether a function varies so much within a step that its ends do not say if it crosses zero.

    At stages it is then far from the cubic through both ends, beside its own variation.
    """
    start, rise = seen(system, switches.modes, 0, switch)
    end, fall = seen(system, switches.modes, table.end, switch)
    rows, c = integers(switches.rows), floats(table.c)

    def stages() -> Iterator[tuple[Real, Real]]:
        with code.count(switches.compared) as k:
            yield c[rows[k]], seen(system, switches.modes, rows[k], switch)[0]

    return unlike_cubic(start, h * rise, end, h * fall, stages())


@printed
def look(code: Procedure, context: Whole, t: Real, h: Real, t_end: Real) -> Real:
    """Find the first change of a mode within the accepted step in the workspace.

    Returns the fraction of the step, with the workspace holding the step up to there; or GO_ON,
    with the workspace as it was; or a number below zero where the step is too long to say.
    """
    system, table = system_at(context), table_at(context)
    record, switches = record_at(context), switches_at(context)
    evaluations, halved = integers(record.counters), integers(switches.halved)
    with code.when(halved[0] < HALVINGS), code.count(switches.modes) as k:
        watched = is_watched(system, switches, k)
        with code.when(watched), code.when(unresolved(system, table, switches, k, h)):
            halved[0] += 1
            code.leave(-1.0)
    halved[0] = 0
    part, last, switch = code.variable(1.0), code.variable(-1), code.variable(0)
    with code.during(lambda: switch < switches.modes):
        with code.when(is_watched(system, switches, switch) & (switch != last)):
            before = evaluations[EVALUATIONS]
            found = crossing(system, table, record, switches, switch, t, h, part)
            # another one may come before it; one at the same time follows with the next step
            sooner = choose(last < 0, found <= part, found < (1.0 - EXACT) * part)
            with code.when(sooner):
                part.set(found)
                last.set(switch)
                switch.set(0)
                code.again()
            with code.when(evaluations[EVALUATIONS] != before):
                evaluations[EVALUATIONS] += table.cost
                until = choose(last < 0, t_end, t + part * h)
                try_step(system, t, part * h, until)
        switch.set(switch + 1)
    with code.when(last < 0):
        code.leave(GO_ON)
    integers(switches.pending)[0] = last
    return code.value(part)


@printed
def guess(code: Procedure, context: Whole, t: Real, h: Real, t_end: Real) -> Real:  # noqa: ARG001
    """About at which fraction of the rejected step in the workspace the first mode changes.

    A little behind it; more than 1 where none does.
    """
    system, table, switches = system_at(context), table_at(context), switches_at(context)
    part = code.variable(GO_ON)
    with code.count(switches.modes) as switch, code.when(is_watched(system, switches, switch)):
        start, rise = seen(system, switches.modes, 0, switch)
        end, fall = seen(system, switches.modes, table.end, switch)
        with code.when((start > 0.0) & (end < 0.0)):
            zero = first_zero(start, h * rise, end, h * fall)
            part.set(smaller_of(part, BEHIND * zero))
    return code.value(part)
