"""Kernels called by address, stages of a step and their statuses, and machine code of the loops.

Machine code is kept under the hash of its text, which has all constants that it was traced with.
Angles are kept within one turn: thousands of radians cost digits that exponents and sections need.
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
    Int,
    Real,
    floats,
    fma,
    integers,
    rint,
    select,
)
from linkages.kernel.code.procedure import Procedure, traced
from linkages.solvers.loops.memory import (
    FROM,
    HALF,
    LARGEST_ANGLE,
    LARGEST_STATE,
    LENGTH,
    LOWER,
    NOT_FINITE,
    TO,
    TWO_PI,
    TWO_PI_TAIL,
    WORD,
    SystemView,
)


def address_of(system: SystemView, row: Int | int) -> Any:
    """Address of a row of the workspace."""
    return system.rows + WORD * row * system.width


@traced
def finite(code: Procedure, system: SystemView, row: Int, columns: Int) -> Bool:
    """Whether the first columns of a row are numbers that a motion can have."""
    values, rotates = floats(address_of(system, row)), integers(system.rotates)
    # Written so that nan, which compares false with everything, is caught.
    with code.for_range(columns) as i, code.if_(~(abs(values[i]) < LARGEST_STATE)):
        code.return_(False)
    with code.for_range(system.n) as i:
        far = abs(values[i]) > LARGEST_ANGLE
        with code.if_((rotates[i] != 0) & far):
            code.return_(False)
    return code.value(True)


def call_clock(address: Any, t: Any, parameters: Any, timed: Any) -> Int:
    """Evaluate what depends on time alone; returns the status of a kernel."""
    return address.code.call_at(address, Int, t, parameters, timed)


def call_rates(address: Any, state: Any, parameters: Any, timed: Any, out: Any) -> Int:
    """Evaluate a kernel; returns its status."""
    return address.code.call_at(address, Int, state, parameters, timed, out)


def call_hook(address: Any, context: Any, t: Any, h: Any, t_end: Any) -> Real:
    """Call what watches steps."""
    return address.code.call_at(address, Real, context, t, h, t_end)


def set_clock(system: Any, t: Real) -> Int:
    """Evaluate what depends on time alone; returns the status of the kernel."""
    return call_clock(system.clock, t, system.parameters, system.timed)


@traced
def evaluate(code: Procedure, system: SystemView, row: Int) -> Int:
    """Evaluate the kernel at the state in a row; 0, 1 + block, or NOT_FINITE."""
    state = address_of(system, row)
    out = state + WORD * 2 * system.n
    status = call_rates(system.rates, state, system.parameters, system.timed, out)
    # A kernel fed with infinities finds its blocks out of reach, which is not what went wrong.
    with code.if_(status != 0), code.if_(~finite(system, row, 2 * system.n)):
        code.return_(NOT_FINITE)
    return status


@traced
def evaluate_at(code: Procedure, system: SystemView, t: Real, row: Int) -> Int:
    """Evaluate a row at a time; returns as `evaluate`."""
    status = set_clock(system, t)
    with code.if_(status != 0):
        code.return_(status)
    return evaluate(system, row)


def try_step(system: SystemView, t: Any, h: Any, t_end: Any) -> Any:
    """Step from row 0 to row `TableView.end`; 0, 1 + block, or NOT_FINITE."""
    return run(system, system.attempt, t, h, t_end)


def further_stages(system: SystemView, t: Any, h: Any, t_end: Any) -> Any:
    """Compute the rows behind the end of a step, which its dense output needs; as `try_step`."""
    return run(system, system.further, t, h, t_end)


@traced
def run(code: Procedure, system: SystemView, function: Int, t: Real, h: Real, t_end: Real) -> Int:
    """Run a traced function over a time."""
    stepper = floats(system.stepper)
    stepper[FROM], stepper[LENGTH], stepper[TO] = t, h, t_end
    return status_of(system, call_step(code, function, system.pointers))


def call_step(code: Procedure, function: Any, pointers: Any) -> Int:
    """Call a function that takes an address."""
    return code.call_at(function, Int, pointers)


@traced
def status_of(code: Procedure, system: SystemView, found: Int) -> Int:
    """Status of a traced function, which returns the row as well."""
    with code.if_(found <= 0):
        code.return_(found)
    # A kernel fed with infinities finds its blocks out of reach, which is not what went wrong.
    fine = finite(system, found >> HALF, 2 * system.n)
    return select(fine, found & LOWER, NOT_FINITE)


@traced
def wrap_angles(code: Procedure, system: SystemView, angles: Int, turns: Int, into: Int) -> None:
    """Bring rotating coordinates into [-π, π]; writes ``into = turns + turns taken away``.

    All three are addresses: of the coordinates and of turns to start from and to write.
    """
    rotates, q = integers(system.rotates), floats(angles)
    before, after = integers(turns), integers(into)
    with code.for_range(system.n) as i:
        after[i] = before[i]
        with code.if_((rotates[i] != 0) & (abs(q[i]) > math.pi)):
            whole = rint(q[i] / TWO_PI)
            q[i] = fma(-whole, TWO_PI_TAIL, fma(-whole, TWO_PI, q[i]))
            after[i] += whole.to_int


_LOADING = RLock()


class Loaded:
    """A traced function that Python calls, or whose address it hands on.

    Parameters
    ----------
    module, name
        Where it stands.
    """

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
        """It, with addresses in place of named tuples; other threads run meanwhile."""
        return self._code.function(self._name)

    def __call__(self, *arguments: Any) -> int:
        """Call it."""
        return int(self.function(*arguments))


EVALUATE_STATE = Loaded("linkages.solvers.loops.scalar_stages", "evaluate_state")
EVALUATE_STATES = Loaded("linkages.solvers.loops.scalar_stages", "evaluate_states")
REPEAT = Loaded("linkages.solvers.loops.scalar_stages", "repeat")


@traced
def evaluate_state(code: Procedure, kernel: Int, work: Int) -> Int:
    """Evaluate a kernel once; returns its status.

    Parameters
    ----------
    kernel
        Address of the addresses of `clock`, `rates` and the parameters, the number of entries of a
        state, and of what the kernel writes.
    work
        Address of the time in seconds, the state, and room for what `rates` and `clock` write.
    """
    words = integers(kernel)
    state = work + WORD
    out = state + WORD * words[3]
    timed = out + WORD * words[4]
    status = call_clock(words[0], floats(work)[0], words[2], timed)
    with code.if_(status != 0):
        code.return_(status)
    return call_rates(words[1], state, words[2], timed, out)


@traced
def evaluate_states(
    code: Procedure, clock: Int, rates: Int, parameters: Int, timed: Int, times: Int,
    states: Int, found: Int, count: Int, size: Int, written: Int, refused: Int,
) -> Int:  # fmt: skip
    """Evaluate a kernel at one state after the other; returns the status of the last one.

    Parameters
    ----------
    times, states, found
        Addresses of (count,) seconds, of states, (count, size), and of what is written,
        (count, written).
    refused
        Address of an integer that takes the number of the first state that the kernel refuses, with
        a status other than 0; it is the last one that is evaluated.
    """
    before, status = code.variable(0.0), code.variable(0)
    with code.for_range(count) as k:
        time = floats(times)[k]
        with code.if_((k == 0) | (time != before)):
            status.set(call_clock(clock, time, parameters, timed))
            before.set(time)
        with code.if_(status == 0):
            state, out = states + WORD * k * size, found + WORD * k * written
            status.set(call_rates(rates, state, parameters, timed, out))
        with code.if_(status != 0):
            integers(refused)[0] = k
            code.return_(status)
    return code.value(0)


@traced
def repeat(
    code: Procedure, clock: Int, rates: Int, state: Int, parameters: Int, timed: Int,
    out: Int, count: Int,
) -> Int:  # fmt: skip
    """Evaluate many times at times 1 µs apart."""
    status = code.variable(0)
    with code.for_range(count) as i:
        status.set(status + call_clock(clock, 1e-6 * i.to_real, parameters, timed))
        status.set(status + call_rates(rates, state, parameters, timed, out))
    return code.value(status)
