"""Samples and start of a motion, and the module of functions of a method."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.operands import (
    Bool,
    Int,
    Real,
    RealArray,
    copysign,
    fma,
    maximum,
    minimum,
    select,
    sqrt,
)
from linkages.kernel.code.writer import Module
from linkages.solvers.loops.advance import Advance, commit, expect_end
from linkages.solvers.loops.control import (
    binary_logarithm,
    binary_power,
    is_small,
    write_counted,
    write_expected,
)
from linkages.solvers.loops.row_layout import (
    RowLayout,
    StepMemory,
    combined,
    is_sound,
    wrap,
    write_stages,
)
from linkages.solvers.tableau import Collocation, Tableau

ELSEWHERE = 1
"""Returned where the rest is for the loop of the motion itself."""


def _interpolate(tableau: Tableau, layout: RowLayout, memory: StepMemory) -> None:
    code, stepper, rows = memory.code, memory.stepper, len(tableau.extended_c)
    theta, h = stepper.theta, stepper.length
    begun, target = memory.row(0), memory.row(rows)
    weights = _dense_weights(tableau, theta)
    slopes = [memory.row(row, layout.n) for row in range(rows)]
    for i in code.for_entries(2 * layout.n):
        target[i] = fma(h, combined(weights, slopes, i), begun[i])


def _dense_weights(tableau: Tableau | Collocation, theta: Real) -> list[Any]:
    """Weights of the rows at a fraction of a step, by the dense output; 0.0 of those without."""
    result: list[Any] = []
    for coefficients in tableau.dense.tolist():
        if not any(coefficients):
            result.append(0.0)
            continue
        weight = theta.code.value(coefficients[-1])
        for coefficient in reversed(coefficients[:-1]):
            weight = fma(weight, theta, coefficient)
        result.append(weight * theta)
    return result


def write_sample(memory: StepMemory, layout: RowLayout) -> None:
    """Write ``%row`` as the next sample, where dependent angles are expected."""
    code, n, row = memory.code, layout.n, RealArray(memory.code, "%row")
    taken = memory.counters.samples
    states, turns = memory.states.after(taken * (2 * n)), memory.sampled_turns.after(taken * n)
    accelerations = memory.accelerations.after(taken * n)
    for i in code.for_entries(2 * n):
        states[i] = row[i]
    result, before = row.after(2 * n), memory.turns
    for i in code.for_entries(n):
        accelerations[i] = result[i]
        turns[i] = before[i]
    for i in layout.turning(code):
        wrap(states, turns, i)
    if layout.counted:
        into = memory.sampled.after(taken * layout.counted)
        write_counted(layout, memory, row, into)
    memory.counters.samples = taken + 1
    memory.stepper.sample = memory.times[taken + 1]


def write_samples(memory: StepMemory, tableau: Tableau, layout: RowLayout) -> None:
    """Write all samples within a step that has one; returns `ELSEWHERE` where one fails."""
    code, rows = memory.code, len(tableau.extended_c)
    stepper, counters = memory.stepper, memory.counters
    t, h, end = stepper.start, stepper.length, stepper.stop
    counted, taken, first = counters.evaluations, counters.samples, stepper.sample

    def require_zero(status: Int) -> None:
        with code.if_(status != 0):
            counters.evaluations, counters.samples, stepper.sample = counted, taken, first
            code.return_(ELSEWHERE)

    known, running = code.variable(False), code.variable(True)
    with code.while_(lambda: running):
        time = stepper.sample
        with code.if_(time == end) as case:
            expect_end(tableau, layout, memory)
            _call_sample(memory.row(tableau.stages))
        with case.else_():
            with code.if_(~known):
                require_zero(Int(code, code.assign("call i64 @further(ptr %motion)")))
                counters.evaluations += rows - 1 - tableau.stages
                known.set(True)
            stepper.theta = minimum((time - t) / h, 1.0)
            code.emit("call i64 @interpolate(ptr %motion)")
            counters.evaluations += 1
            require_zero(memory.call_clock(time))
            require_zero(memory.call_rates(memory.row(rows)))
            _expect_between(tableau, layout, memory)
            _call_sample(memory.row(rows))
        left = end - stepper.sample
        running.set(select(h >= 0.0, left, -left) >= 0.0)


def _expect_between(
    coefficients: Tableau | Collocation, layout: RowLayout, memory: StepMemory
) -> None:
    if layout.counted:
        weights = _dense_weights(coefficients, memory.stepper.theta)
        write_expected(layout, memory, memory.stepper.length, weights)


def _call_sample(row: RealArray) -> None:
    row.code.emit(f"call i64 @sample(ptr %motion, ptr {row.pointer})")


def write_begin(memory: StepMemory, layout: RowLayout) -> None:
    """Write the start of a motion; returns `ELSEWHERE` where anything is not as it should be."""
    code, stepper, counters = memory.code, memory.stepper, memory.counters
    row = memory.row(0)
    angles, ahead = memory.angles, memory.ahead

    def require(condition: Bool) -> None:
        code.return_if(~condition, ELSEWHERE)

    require(is_sound(layout, row, 2 * layout.n))
    for i in layout.turning(code):
        wrap(row, memory.turns, i)
    t, end = stepper.t, stepper.end
    require(memory.call_clock(t) == 0)
    require(memory.call_rates(row) == 0)
    require(is_sound(layout, row, 3 * layout.n))
    margins, rates = (row.after(layout.margins + after) for after in (0, layout.blocks))
    scale, smallest = memory.scale, memory.smallest
    for i in code.for_entries(layout.blocks):
        require(~is_small(margins[i], rates[i] * (end - t), scale[i], smallest[i]))
    counters.evaluations += 1
    for i in code.for_entries(layout.counted):
        ahead[i] = angles[i]
    write_counted(layout, memory, row, angles)
    with code.if_(stepper.sample == t):
        _call_sample(row)
    code.return_if(t == end, 0)
    counters.evaluations += 1
    code.emit("call i64 @first(ptr %motion)")
    stepper.first, stepper.before = abs(stepper.h), 1.0


def write_first(memory: StepMemory, layout: RowLayout, order: int) -> None:
    """Write the length of the first step to the last time, by Hairer, Nørsett & Wanner, II.4.

    Row 0 has been evaluated; row 1 is written. `order` is that of the error estimate.
    """
    code, n, stepper = memory.code, layout.n, memory.stepper
    begun, slopes, target = memory.row(0), memory.row(0, n), memory.row(1)
    t, span = stepper.t, stepper.end - stepper.t
    most = abs(span)
    stepper.h = span
    if not n:
        code.return_(0)
        return
    d0, d1 = _norm(layout, memory, begun.__getitem__), _norm(layout, memory, slopes.__getitem__)
    tiny = (d0 < 1e-5) | (d1 < 1e-5)
    length = minimum(select(tiny, 1e-6, 0.01 * d0 / d1), most)
    h = copysign(length, span)
    for i in code.for_entries(2 * n):
        target[i] = fma(h, slopes[i], begun[i])
    stepper.h = 0.1 * h
    for status in (lambda: memory.call_clock(t + h), lambda: memory.call_rates(target)):
        code.return_if(status() != 0, 0)
    code.return_if(~is_sound(layout, target, 3 * n), 0)
    beyond = memory.row(1, n)
    d2 = _norm(layout, memory, lambda i: beyond[i] - slopes[i])
    largest = maximum(d1, d2 / length)
    root = binary_power(1.0 / (order + 1) * binary_logarithm(0.01 / largest))
    other = select(largest > 1e-15, root, maximum(1e-3 * length, 1e-6))
    other = minimum(100.0 * length, minimum(other, most))
    stepper.h = copysign(other, span)


def _norm(layout: RowLayout, memory: StepMemory, value: Callable[[Any], Real]) -> Real:
    """Root mean square of some numbers in units of the tolerance at row 0."""
    begun, atol, rtol = memory.row(0), memory.atol, memory.stepper.rtol
    total = memory.code.variable(0.0)
    for i in memory.code.for_entries(2 * layout.n):
        scaled = value(i) / fma(rtol, abs(begun[i]), atol[i])
        total.set(fma(scaled, scaled, total))
    return sqrt(total / (2.0 * layout.n))


@contextmanager
def _function(
    module: Module, layout: RowLayout, name: str, *arguments: str, kind: str = ""
) -> Iterator[StepMemory]:
    """Define a function of the address of a motion, which is written within and returns 0."""
    code = module.instructions()
    yield StepMemory(code, layout)
    code.return_(0)
    module.define(f"{kind}i64 @{name}({', '.join(['ptr %motion', *arguments])})", code)


def write_step(tableau: Tableau, layout: RowLayout, gain: float = 0.0, lanes: int = 1) -> str:
    """The text of a module with the functions of a step, which take the address of `Pointers`.

    ``int64 attempt(motion)`` steps from row 0 to the end, over the time in the stepper, and returns
    a status. ``int64 further(motion)`` computes the further rows of the dense output. Tableaus with
    an error estimate have ``int64 advance(motion, ticks)``, see `Advance.write`. Several lanes have
    their statuses in the stepper; ``int64 between(motion)`` evaluates states within their steps.
    """
    module = Module(lanes)
    rows, last = len(tableau.extended_c) - 1, tableau.stages
    for name, first, end in (("attempt", 1, last), ("further", last + 1, rows)):
        with _function(module, layout, name) as memory:
            status = write_stages(tableau, layout, memory, first, end)
            if lanes > 1:
                memory.stepper.status = status
    if lanes == 1:
        with _function(module, layout, "interpolate") as memory:
            _interpolate(tableau, layout, memory)
        with _function(module, layout, "samples", kind="internal ") as memory:
            write_samples(memory, tableau, layout)
        with _function(module, layout, "begin") as memory:
            write_begin(memory, layout)
        _write_common(module, tableau, layout, tableau.error_order)
    else:
        with _function(module, layout, "between") as memory:
            _interpolate(tableau, layout, memory)
            timed = memory.call_clock(memory.stepper.evaluation_time)
            result = memory.call_rates(memory.row(rows + 1))
            memory.stepper.status = select(timed == 0, result, timed)
    if tableau.error.size:
        with _function(module, layout, "advance", "i64 %ticks") as memory:
            Advance(memory, tableau, layout, gain).write()
    return module.text


COMMON = ("first", "sample", "commit", "expect_end", "expect_between", "count")
"""Functions of a single motion by any method."""


def _write_common(
    module: Module, coefficients: Tableau | Collocation, layout: RowLayout, order: int
) -> None:
    with _function(module, layout, "first") as memory:
        write_first(memory, layout, order)
    with _function(module, layout, "sample", "ptr %row") as memory:
        write_sample(memory, layout)
    with _function(module, layout, "commit") as memory:
        commit(coefficients, layout, memory, memory.code.value(True))
    with _function(module, layout, "expect_end") as memory:
        expect_end(coefficients, layout, memory)
    with _function(module, layout, "expect_between") as memory:
        _expect_between(coefficients, layout, memory)
    with _function(module, layout, "count", "ptr %row", "ptr %into") as memory:
        row, into = (RealArray(memory.code, name) for name in ("%row", "%into"))
        write_counted(layout, memory, row, into)


@lru_cache(maxsize=256)
def compiled_common(collocation: Collocation, layout: RowLayout) -> MachineCode:
    """These functions of a method that brings its own steps, as machine code."""
    module = Module(1)
    _write_common(module, collocation, layout, collocation.stages)
    return MachineCode(module.text)


@lru_cache(maxsize=256)
def compiled_step(
    tableau: Tableau, layout: RowLayout, gain: float = 0.0, lanes: int = 1
) -> MachineCode:
    """The functions of a step as machine code; see `write_step`."""
    return MachineCode(write_step(tableau, layout, gain, lanes))
