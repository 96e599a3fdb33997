"""Kernels called by address, stages of a step and their statuses, and machine code of the loops.

Machine code is kept under the hash of its text, which has all constants that it was printed with.
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
    Real,
    Truth,
    Whole,
    choose,
    floats,
    fused,
    integers,
    rounded,
)
from linkages.kernel.code.procedure import Procedure, printed
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


def address_of(system: SystemView, row: Whole | int) -> Any:
    """Address of a row of the workspace."""
    return system.rows + WORD * row * system.width


@printed
def finite(code: Procedure, system: SystemView, row: Whole, columns: Whole) -> Truth:
    """Whether the first columns of a row are numbers that a motion can have."""
    values, rotates = floats(address_of(system, row)), integers(system.rotates)
    # Written so that nan, which compares false with everything, is caught.
    with code.count(columns) as i, code.when(~(abs(values[i]) < LARGEST_STATE)):
        code.leave(False)
    with code.count(system.n) as i:
        far = abs(values[i]) > LARGEST_ANGLE
        with code.when((rotates[i] != 0) & far):
            code.leave(False)
    return code.value(True)


def call_clock(address: Any, t: Any, parameters: Any, timed: Any) -> Whole:
    """Evaluate what depends on time alone; returns the status of a kernel."""
    return address.code.call_at(address, Whole, t, parameters, timed)


def call_rates(address: Any, state: Any, parameters: Any, timed: Any, out: Any) -> Whole:
    """Evaluate a kernel; returns its status."""
    return address.code.call_at(address, Whole, state, parameters, timed, out)


def call_hook(address: Any, context: Any, t: Any, h: Any, t_end: Any) -> Real:
    """Call what watches steps."""
    return address.code.call_at(address, Real, context, t, h, t_end)


def set_clock(system: Any, t: Real) -> Whole:
    """Evaluate what depends on time alone; returns the status of the kernel."""
    return call_clock(system.clock, t, system.parameters, system.timed)


@printed
def evaluate(code: Procedure, system: SystemView, row: Whole) -> Whole:
    """Evaluate the kernel at the state in a row; 0, 1 + block, or NOT_FINITE."""
    state = address_of(system, row)
    out = state + WORD * 2 * system.n
    status = call_rates(system.rates, state, system.parameters, system.timed, out)
    # A kernel fed with infinities finds its blocks out of reach, which is not what went wrong.
    with code.when(status != 0), code.when(~finite(system, row, 2 * system.n)):
        code.leave(NOT_FINITE)
    return status


@printed
def evaluate_at(code: Procedure, system: SystemView, t: Real, row: Whole) -> Whole:
    """Evaluate a row at a time; returns as `evaluate`."""
    status = set_clock(system, t)
    with code.when(status != 0):
        code.leave(status)
    return evaluate(system, row)


def try_step(system: SystemView, t: Any, h: Any, t_end: Any) -> Any:
    """Step from row 0 to row `TableView.end`; 0, 1 + block, or NOT_FINITE."""
    return run(system, system.attempt, t, h, t_end)


def further_stages(system: SystemView, t: Any, h: Any, t_end: Any) -> Any:
    """Compute the rows behind the end of a step, which its dense output needs; as `try_step`."""
    return run(system, system.further, t, h, t_end)


@printed
def run(
    code: Procedure, system: SystemView, function: Whole, t: Real, h: Real, t_end: Real
) -> Whole:
    """Run a printed function over a time."""
    pace = floats(system.pace)
    pace[FROM], pace[LENGTH], pace[TO] = t, h, t_end
    return status_of(system, call_step(code, function, system.frame))


def call_step(code: Procedure, function: Any, frame: Any) -> Whole:
    """Call a function that takes an address."""
    return code.call_at(function, Whole, frame)


@printed
def status_of(code: Procedure, system: SystemView, found: Whole) -> Whole:
    """Status of a printed function, which returns the row as well."""
    with code.when(found <= 0):
        code.leave(found)
    # A kernel fed with infinities finds its blocks out of reach, which is not what went wrong.
    fine = finite(system, found >> HALF, 2 * system.n)
    return choose(fine, found & LOWER, NOT_FINITE)


@printed
def wrap_angles(
    code: Procedure, system: SystemView, angles: Whole, turns: Whole, into: Whole
) -> None:
    """Bring rotating coordinates into [-π, π]; writes ``into = turns + turns taken away``.

    All three are addresses: of the coordinates and of turns to start from and to write.
    """
    rotates, q = integers(system.rotates), floats(angles)
    before, after = integers(turns), integers(into)
    with code.count(system.n) as i:
        after[i] = before[i]
        with code.when((rotates[i] != 0) & (abs(q[i]) > math.pi)):
            whole = rounded(q[i] / TWO_PI)
            q[i] = fused(-whole, TWO_PI_TAIL, fused(-whole, TWO_PI, q[i]))
            after[i] += whole.whole


_LOADING = RLock()


class Loaded:
    """A printed function that Python calls, or whose address it hands on.

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


@printed
def evaluate_state(code: Procedure, kernel: Whole, work: Whole) -> Whole:
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
    with code.when(status != 0):
        code.leave(status)
    return call_rates(words[1], state, words[2], timed, out)


@printed
def evaluate_states(
    code: Procedure, clock: Whole, rates: Whole, parameters: Whole, timed: Whole, times: Whole,
    states: Whole, found: Whole, count: Whole, size: Whole, written: Whole, refused: Whole,
) -> Whole:  # fmt: skip
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
    with code.count(count) as k:
        time = floats(times)[k]
        with code.when((k == 0) | (time != before)):
            status.set(call_clock(clock, time, parameters, timed))
            before.set(time)
        with code.when(status == 0):
            state, out = states + WORD * k * size, found + WORD * k * written
            status.set(call_rates(rates, state, parameters, timed, out))
        with code.when(status != 0):
            integers(refused)[0] = k
            code.leave(status)
    return code.value(0)


@printed
def repeat(
    code: Procedure, clock: Whole, rates: Whole, state: Whole, parameters: Whole, timed: Whole,
    out: Whole, count: Whole,
) -> Whole:  # fmt: skip
    """Evaluate many times at times 1 µs apart."""
    status = code.variable(0)
    with code.count(count) as i:
        status.set(status + call_clock(clock, 1e-6 * i.real, parameters, timed))
        status.set(status + call_rates(rates, state, parameters, timed, out))
    return code.value(status)
