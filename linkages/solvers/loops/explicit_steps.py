"""Samples and start of a motion, and the module of steps of a method."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.operands import (
    Real,
    Reals,
    Truth,
    Whole,
    choose,
    fused,
    larger_of,
    root_of,
    smaller_of,
    with_sign_of,
)
from linkages.kernel.code.procedure import Procedure
from linkages.kernel.code.writer import Module
from linkages.solvers.loops.advance import Advance
from linkages.solvers.loops.control import binary_logarithm, binary_power
from linkages.solvers.loops.memory import (
    AT,
    BEFORE,
    END,
    EVALUATIONS,
    FIRST,
    FROM,
    LENGTH,
    RTOL,
    SAMPLE,
    SAMPLES,
    STATUS,
    THETA,
    TO,
    H,
    T,
)
from linkages.solvers.loops.predicates import is_small, write_counted, write_expected
from linkages.solvers.loops.shape import (
    Shape,
    StepMemory,
    combined,
    is_sound,
    wrap,
    write_stages,
)
from linkages.solvers.tableau import Tableau

ELSEWHERE = 1
"""Returned where the rest is for the loop of the motion itself."""


def write_interpolation(code: Procedure, tableau: Tableau, shape: Shape) -> None:
    """Write the state at the fraction `THETA` of a step into the last row, by the dense output."""
    _interpolate(tableau, shape, StepMemory(code, shape))
    code.leave(0)


def write_between(code: Procedure, tableau: Tableau, shape: Shape) -> None:
    """Write the same for several lanes, evaluated at the times `AT`, and statuses into the pace."""
    memory = StepMemory(code, shape)
    _interpolate(tableau, shape, memory)
    timed = memory.call_clock(memory["pace"][AT])
    found = memory.call_rates(memory.row(len(tableau.extended_c)))
    memory.integers("pace")[STATUS] = choose(timed == 0, found, timed)
    code.leave(0)


def _interpolate(tableau: Tableau, shape: Shape, memory: StepMemory) -> None:
    code, pace, rows = memory.code, memory["pace"], len(tableau.extended_c)
    theta, h = pace[THETA], pace[LENGTH]
    begun, target = memory.row(0), memory.row(rows)
    weights = _dense_weights(tableau, theta)
    slopes = [memory.row(row, shape.n) for row in range(rows)]
    for i in code.entries(2 * shape.n):
        target[i] = fused(h, combined(weights, slopes, i), begun[i])


def _dense_weights(tableau: Tableau, theta: Real) -> list[Any]:
    """Weights of the rows at a fraction of a step, by the dense output; 0.0 of those without."""
    found: list[Any] = []
    for coefficients in tableau.dense.tolist():
        if not any(coefficients):
            found.append(0.0)
            continue
        weight = theta.code.value(coefficients[-1])
        for coefficient in reversed(coefficients[:-1]):
            weight = fused(weight, theta, coefficient)
        found.append(weight * theta)
    return found


def write_sample(code: Procedure, shape: Shape) -> None:
    """Write ``%row`` as the next sample; see `linkages.solvers.loops.margins.write_sample`."""
    memory, n, row = StepMemory(code, shape), shape.n, Reals(code, "%row")
    counters, before = memory.integers("counters"), memory.integers("turns")
    taken = counters[SAMPLES]
    states = memory["states"].after(taken * (2 * n))
    accelerations = memory["accelerations"].after(taken * n)
    turns = memory.integers("sampled_turns").after(taken * n)
    for i in code.entries(2 * n):
        states[i] = row[i]
    found = row.after(2 * n)
    for i in code.entries(n):
        accelerations[i] = found[i]
        turns[i] = before[i]
    for i in range(n):
        if shape.rotates[i]:
            wrap(states, turns, i)
    if shape.counted:
        into = memory["sampled"].after(taken * shape.counted)
        write_counted(shape, memory, row, into)
    counters[SAMPLES] = taken + 1
    memory["pace"][SAMPLE] = memory["times"][taken + 1]
    code.leave(0)


def write_samples(code: Procedure, tableau: Tableau, shape: Shape) -> None:
    """Write all samples within the step in the workspace, of which there is one at least.

    Returns `ELSEWHERE` where one of them cannot be evaluated, with all as it was.
    """
    memory, rows = StepMemory(code, shape), len(tableau.extended_c)
    pace, counters = memory["pace"], memory.integers("counters")
    t, h, end = (pace[entry] for entry in (FROM, LENGTH, TO))
    counted, taken, first = counters[EVALUATIONS], counters[SAMPLES], pace[SAMPLE]

    def require_zero(status: Whole) -> None:
        with code.when(status != 0):
            counters[EVALUATIONS], counters[SAMPLES], pace[SAMPLE] = counted, taken, first
            code.leave(ELSEWHERE)

    known, running = code.variable(False), code.variable(True)
    with code.during(lambda: running):
        time = pace[SAMPLE]
        with code.when(time == end) as case:
            write_expected(shape, memory, h, tableau.b.tolist())
            _call_sample(memory.row(tableau.stages))
        with case.otherwise():
            with code.when(~known):
                require_zero(Whole(code, code.give("call i64 @further(ptr %frame)")))
                counters[EVALUATIONS] += rows - 1 - tableau.stages
                known.set(True)
            pace[THETA] = smaller_of((time - t) / h, 1.0)
            code.say("call i64 @interpolate(ptr %frame)")
            counters[EVALUATIONS] += 1
            require_zero(memory.call_clock(time))
            require_zero(memory.call_rates(memory.row(rows)))
            if shape.counted:
                write_expected(shape, memory, h, _dense_weights(tableau, pace[THETA]))
            _call_sample(memory.row(rows))
        left = end - pace[SAMPLE]
        running.set(choose(h >= 0.0, left, -left) >= 0.0)
    code.leave(0)


def _call_sample(row: Reals) -> None:
    row.code.say(f"call i64 @sample(ptr %frame, ptr {row.pointer})")


def write_begin(code: Procedure, shape: Shape) -> None:
    """Write the start of a motion: row 0 is evaluated, and the first step chosen.

    Returns `ELSEWHERE` where anything is not as it should be, with nothing counted.
    """
    memory = StepMemory(code, shape)
    pace, row, counters = memory["pace"], memory.row(0), memory.integers("counters")
    angles, ahead = memory["angles"], memory["ahead"]

    def require(condition: Truth) -> None:
        with code.when(~condition):
            code.leave(ELSEWHERE)

    require(is_sound(shape, row, 2 * shape.n))
    for i in range(shape.n):
        if shape.rotates[i]:
            wrap(row, memory.integers("turns"), i)
    t, end = pace[T], pace[END]
    require(memory.call_clock(t) == 0)
    require(memory.call_rates(row) == 0)
    require(is_sound(shape, row, 3 * shape.n))
    margins, rates = (row.after(shape.margins + after) for after in (0, shape.blocks))
    scale, smallest = memory["scale"], memory["smallest"]
    for i in code.entries(shape.blocks):
        require(~is_small(margins[i], rates[i] * (end - t), scale[i], smallest[i]))
    counters[EVALUATIONS] += 1
    for i in range(shape.counted):
        ahead[i] = angles[i]
    write_counted(shape, memory, row, angles)
    with code.when(pace[SAMPLE] == t):
        _call_sample(row)
    with code.when(t == end):
        code.leave(0)
    counters[EVALUATIONS] += 1
    code.say("call i64 @first(ptr %frame)")
    pace[FIRST], pace[BEFORE] = abs(pace[H]), 1.0
    code.leave(0)


def write_first(code: Procedure, shape: Shape, order: int) -> None:
    """Write the length of the first step to the last time, by Hairer, Nørsett & Wanner, II.4.

    Row 0 has been evaluated; row 1 is written. `order` is that of the error estimate.
    """
    memory, n = StepMemory(code, shape), shape.n
    pace, begun, slopes, target = memory["pace"], memory.row(0), memory.row(0, n), memory.row(1)
    t, span = pace[T], pace[END] - pace[T]
    most = abs(span)
    pace[H] = span
    if not n:
        code.leave(0)
        return
    d0, d1 = _norm(shape, memory, begun.__getitem__), _norm(shape, memory, slopes.__getitem__)
    tiny = (d0 < 1e-5) | (d1 < 1e-5)
    length = smaller_of(choose(tiny, 1e-6, 0.01 * d0 / d1), most)
    h = with_sign_of(length, span)
    for i in code.entries(2 * n):
        target[i] = fused(h, slopes[i], begun[i])
    pace[H] = 0.1 * h
    for status in (lambda: memory.call_clock(t + h), lambda: memory.call_rates(target)):
        with code.when(status() != 0):
            code.leave(0)
    with code.when(~is_sound(shape, target, 3 * n)):
        code.leave(0)
    beyond = memory.row(1, n)
    d2 = _norm(shape, memory, lambda i: beyond[i] - slopes[i])
    largest = larger_of(d1, d2 / length)
    root = binary_power(1.0 / (order + 1) * binary_logarithm(0.01 / largest))
    other = choose(largest > 1e-15, root, larger_of(1e-3 * length, 1e-6))
    other = smaller_of(100.0 * length, smaller_of(other, most))
    pace[H] = with_sign_of(other, span)
    code.leave(0)


def _norm(shape: Shape, memory: StepMemory, value: Callable[[Any], Real]) -> Real:
    """Root mean square of some numbers in units of the tolerance at row 0."""
    begun, atol, rtol = memory.row(0), memory["atol"], memory["pace"][RTOL]
    total = memory.code.variable(0.0)
    for i in memory.code.entries(2 * shape.n):
        scaled = value(i) / fused(rtol, abs(begun[i]), atol[i])
        total.set(fused(scaled, scaled, total))
    return root_of(total / (2.0 * shape.n))


def write_step(tableau: Tableau, shape: Shape, gain: float = 0.0, lanes: int = 1) -> str:
    """The text of a module with the functions of a step, which take the address of a frame.

    ``int64 attempt(frame)`` steps from row 0 to the end, over a time in the pace, and returns a
    status; ``int64 further(frame)`` computes the further rows of the dense output. Tableaus with an
    error estimate have ``int64 advance(frame, ticks)``, which goes on until a step needs more than
    arithmetic, and returns the number of trials in the upper half, below a bit for each lane that
    does. All arrays of several lanes consist of rows of W entries, their statuses stand in the
    pace, and ``int64 between(frame)`` evaluates states within a step.

    Parameters
    ----------
    tableau, shape
        Of the step.
    """
    module = Module(lanes)
    rows, last = len(tableau.extended_c) - 1, tableau.stages
    for name, first, end in (("attempt", 1, last), ("further", last + 1, rows)):
        code = module.instructions()
        memory = StepMemory(code, shape)
        status = write_stages(tableau, shape, memory, first, end)
        if lanes > 1:
            memory.integers("pace")[STATUS] = status
        code.leave(0)
        module.define(f"i64 @{name}(ptr %frame)", code)
    if lanes == 1:
        _single(module, tableau, shape)
    else:
        code = module.instructions()
        write_between(code, tableau, shape)
        module.define("i64 @between(ptr %frame)", code)
    if tableau.error.size:
        code = module.instructions()
        Advance(code, tableau, shape, gain).write()
        module.define("i64 @advance(ptr %frame, i64 %ticks)", code)
    return module.text


def _single(module: Module, tableau: Tableau, shape: Shape) -> None:
    """What a single motion has beside its steps."""
    code = module.instructions()
    write_interpolation(code, tableau, shape)
    module.define("i64 @interpolate(ptr %frame)", code)
    _start(module, shape, tableau.error_order)
    code = module.instructions()
    write_samples(code, tableau, shape)
    module.define("internal i64 @samples(ptr %frame)", code)
    code = module.instructions()
    write_begin(code, shape)
    module.define("i64 @begin(ptr %frame)", code)


def _start(module: Module, shape: Shape, order: int) -> None:
    """The first step and samples, which are those of any method."""
    code = module.instructions()
    write_first(code, shape, order)
    module.define("i64 @first(ptr %frame)", code)
    code = module.instructions()
    write_sample(code, shape)
    module.define("i64 @sample(ptr %frame, ptr %row)", code)


@lru_cache(maxsize=256)
def compiled_start(shape: Shape, order: int) -> MachineCode:
    """The first step and samples of a method that brings its own steps, as machine code."""
    module = Module(1)
    _start(module, shape, order)
    return MachineCode(module.text)


@lru_cache(maxsize=256)
def compiled_step(tableau: Tableau, shape: Shape, gain: float = 0.0, lanes: int = 1) -> MachineCode:
    """The functions of a step as machine code; see `write_step`."""
    return MachineCode(write_step(tableau, shape, gain, lanes))
