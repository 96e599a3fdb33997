"""Kernels called by address, stages of a step and their statuses, and machine code of the loops.

Machine code is kept under the hash of its text, which has all constants that it was traced with.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from importlib import import_module
from threading import RLock
from typing import Any

from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.operands import (
    Bool,
    Function,
    Int,
    IntArray,
    Real,
    RealArray,
    Table,
    fma,
    rint,
    select,
)
from linkages.kernel.code.procedure import Procedure, traced
from linkages.solvers.loops.memory import (
    HALF,
    LARGEST_ANGLE,
    LARGEST_STATE,
    LOWER,
    NOT_FINITE,
    TWO_PI,
    TWO_PI_TAIL,
    KernelTable,
    Motion,
)


@traced
def finite(code: Procedure, motion: Motion, row: Int, columns: Int) -> Bool:
    """Whether the first columns of a row are numbers that a motion can have."""
    values, rotates = motion.row(row), motion.rotates
    # Written so that nan, which compares false with everything, is caught.
    with code.for_range(columns) as i, code.if_(~(abs(values[i]) < LARGEST_STATE)):
        code.return_(False)
    with code.for_range(motion.n) as i:
        far = abs(values[i]) > LARGEST_ANGLE
        code.return_if((rotates[i] != 0) & far, False)
    return code.value(True)


def call_clock(kernel: KernelTable, t: Real) -> Int:
    """Evaluate what depends on time alone; returns the status of a kernel."""
    return kernel.clock(Int, t, kernel.parameters, kernel.timed)


def call_rates(kernel: KernelTable, state: RealArray, out: RealArray) -> Int:
    """Evaluate a kernel; returns its status."""
    return kernel.rates(Int, state, kernel.parameters, kernel.timed, out)


@traced
def evaluate(code: Procedure, motion: Motion, row: Int) -> Int:
    """Evaluate the kernel at the state in a row; 0, 1 + block, or NOT_FINITE."""
    status = call_rates(motion, motion.row(row), motion.row(row, 2 * motion.n))
    # A kernel fed with infinities finds its blocks out of reach, which is not what went wrong.
    with code.if_(status != 0), code.if_(~finite(motion, row, 2 * motion.n)):
        code.return_(NOT_FINITE)
    return status


@traced
def evaluate_at(code: Procedure, motion: Motion, t: Real, row: Int) -> Int:
    """Evaluate a row at a time; returns as `evaluate`."""
    status = call_clock(motion, t)
    code.return_if(status != 0, status)
    return evaluate(motion, row)


def try_step(motion: Motion, t: Any, h: Any, t_end: Any) -> Any:
    """Step from row 0 to row `Motion.end`; 0, 1 + block, or NOT_FINITE."""
    return run(motion, motion.attempt, t, h, t_end)


def further_stages(motion: Motion, t: Any, h: Any, t_end: Any) -> Any:
    """Compute the rows behind the end of a step, which its dense output needs; as `try_step`."""
    return run(motion, motion.further, t, h, t_end)


@traced
def run(_code: Procedure, motion: Motion, function: Function, t: Real, h: Real, t_end: Real) -> Int:
    """Run a function of the step over a time."""
    stepper = motion.stepper
    stepper.start, stepper.length, stepper.stop = t, h, t_end
    return status_of(motion, function(Int, motion))


@traced
def status_of(code: Procedure, motion: Motion, found: Int) -> Int:
    """Status of a function of the step, which returns the row as well."""
    code.return_if(found <= 0, found)
    # A kernel fed with infinities finds its blocks out of reach, which is not what went wrong.
    fine = finite(motion, found >> HALF, 2 * motion.n)
    return select(fine, found & LOWER, NOT_FINITE)


def bisect(
    code: Procedure, rounds: int, holds: Callable[[Real], Any], last: Any = 1.0
) -> tuple[Any, Any]:
    """Between 0, where something holds, and `last`, where not: two numbers that end so near."""
    low, high = code.variable(0.0), code.variable(last)
    with code.for_range(rounds):
        middle = 0.5 * (low + high)
        with code.if_(holds(middle)) as case:
            low.set(middle)
        with case.else_():
            high.set(middle)
    return low, high


@traced
def wrap_angles(code: Procedure, motion: Motion, angles: RealArray, into: IntArray) -> None:
    """Bring rotating coordinates into [-π, π]; writes their turns and those taken away."""
    with code.for_range(motion.n) as i:
        into[i] = motion.turns[i]
        with code.if_((motion.rotates[i] != 0) & (abs(angles[i]) > math.pi)):
            whole = rint(angles[i] / TWO_PI)
            angles[i] = fma(-whole, TWO_PI_TAIL, fma(-whole, TWO_PI, angles[i]))
            into[i] += whole.to_int


_LOADING = RLock()


class Loaded:
    """A traced function that Python calls, or whose address it hands on."""

    def __init__(self, module: str, name: str) -> None:
        self._module, self._name = module, name
        self._kept: MachineCode | None = None

    @property
    def _code(self) -> MachineCode:
        # Loaded once and for all: others have its addresses. From Python 3.12 on two threads may
        # compute a cached property at the same time, and what one of them found is freed.
        with _LOADING:
            if self._kept is None:
                from linkages.kernel.code.procedure import text_of

                text = text_of(getattr(import_module(self._module), self._name))
                self._kept = MachineCode(text)
            return self._kept

    @property
    def address(self) -> int:
        """Where its machine code is."""
        return self._code.address(self._name)

    @cached_property
    def function(self) -> Callable[..., Any]:
        """It, which takes addresses; other threads run meanwhile."""
        return self._code.function(self._name)

    def __call__(self, *arguments: Any) -> int:
        """Call it."""
        return int(self.function(*arguments))


EVALUATE_STATE = Loaded("linkages.solvers.loops.scalar_stages", "evaluate_state")
EVALUATE_STATES = Loaded("linkages.solvers.loops.scalar_stages", "evaluate_states")
REPEAT = Loaded("linkages.solvers.loops.scalar_stages", "repeat")


class EvaluatedKernel(Table):
    """A kernel, the number of entries of a state, and of what it writes."""

    clock: Function
    rates: Function
    parameters: RealArray
    size: Int
    written: Int


@traced
def evaluate_state(code: Procedure, kernel: EvaluatedKernel, work: RealArray) -> Int:
    """Evaluate a kernel once; returns its status. `work` has time, state and room for results."""
    state = work.after(1)
    out = state.after(kernel.size)
    timed = out.after(kernel.written)
    status = kernel.clock(Int, work[0], kernel.parameters, timed)
    code.return_if(status != 0, status)
    return kernel.rates(Int, state, kernel.parameters, timed, out)


@traced
def evaluate_states(
    code: Procedure, clock: Function, rates: Function, parameters: RealArray, timed: RealArray,
    times: RealArray, states: RealArray, found: RealArray, count: Int, size: Int, written: Int,
    refused: IntArray,
) -> Int:  # fmt: skip
    """Evaluate a kernel at (count, size) states, to (count, written); returns the last status.

    It ends at the first state that the kernel refuses, whose number goes to `refused`.
    """
    before, status = code.variable(0.0), code.variable(0)
    with code.for_range(count) as k:
        time = times[k]
        with code.if_((k == 0) | (time != before)):
            status.set(clock(Int, time, parameters, timed))
            before.set(time)
        with code.if_(status == 0):
            state, out = states.after(k * size), found.after(k * written)
            status.set(rates(Int, state, parameters, timed, out))
        with code.if_(status != 0):
            refused[0] = k
            code.return_(status)
    return code.value(0)


@traced
def repeat(
    code: Procedure, clock: Function, rates: Function, state: RealArray, parameters: RealArray,
    timed: RealArray, out: RealArray, count: Int,
) -> Int:  # fmt: skip
    """Evaluate many times at times 1 µs apart."""
    status = code.variable(0)
    with code.for_range(count) as i:
        status.set(status + clock(Int, 1e-6 * i.to_real, parameters, timed))
        status.set(status + rates(Int, state, parameters, timed, out))
    return code.value(status)
