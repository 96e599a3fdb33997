"""Evaluate a kernel at many times and states with one call from Python."""

from __future__ import annotations

from linkages.kernel.code.operands import Whole, floats, integers
from linkages.kernel.code.printed import printed
from linkages.kernel.code.procedure import Procedure
from linkages.solvers.steps.stages import call_clock, call_rates
from linkages.solvers.steps.views import WORD


@printed
def evaluate_state(code: Procedure, kernel: Whole, work: Whole) -> Whole:
    """Evaluate a kernel once; returns its status.

    Parameters
    ----------
    code
        What is printed.
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
    code
        What is printed.
    clock, rates, parameters, timed
        Addresses of the kernel and of what it needs.
    times, states, found
        Addresses of (count,) seconds, of states, (count, size), and of what is written,
        (count, written).
    count, size, written
        Numbers of states, of their entries, and of what the kernel writes for each.
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
