"""Machine code of the step loops, compiled where it is first used.

Machine code is kept under the hash of its text, which has all constants that it was printed with.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from importlib import import_module
from threading import RLock
from typing import Any

from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.operands import Whole, floats, integers
from linkages.kernel.code.procedure import Procedure, printed
from linkages.solvers.steps.memory import WORD
from linkages.solvers.steps.scalar_stages import call_clock, call_rates

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


EVALUATE_STATE = Loaded("linkages.solvers.steps.compiled_loops", "evaluate_state")
EVALUATE_STATES = Loaded("linkages.solvers.steps.compiled_loops", "evaluate_states")
REPEAT = Loaded("linkages.solvers.steps.compiled_loops", "repeat")


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
