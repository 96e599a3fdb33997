"""Evaluate a kernel at many times and states with one call from Python."""

from __future__ import annotations

from linkages.solvers.steps.compiled import call_clock, call_rates, compiled, floats, integers


@compiled
def evaluate_state(kernel: int, work: int) -> int:
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
    state = work + 8
    out = state + 8 * words[3]
    timed = out + 8 * words[4]
    status = call_clock(words[0], floats(work)[0], words[2], timed)
    if status == 0:
        status = call_rates(words[1], state, words[2], timed, out)
    return status


@compiled
def evaluate_states(
    clock: int, rates: int, parameters: int, timed: int, times: int, states: int, found: int,
    count: int, size: int, written: int, refused: int,
) -> int:  # fmt: skip
    """Evaluate a kernel at one state after the other; returns the status of the last one.

    Parameters
    ----------
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
    before = 0.0
    for k in range(count):
        time = floats(times)[k]
        status = 0
        if k == 0 or time != before:
            status = call_clock(clock, time, parameters, timed)
            before = time
        if status == 0:
            state, out = states + 8 * k * size, found + 8 * k * written
            status = call_rates(rates, state, parameters, timed, out)
        if status != 0:
            integers(refused)[0] = k
            return status
    return 0


@compiled
def repeat(
    clock: int, rates: int, state: int, parameters: int, timed: int, out: int, count: int
) -> int:
    """Evaluate many times at times 1 µs apart."""
    status = 0
    for i in range(count):
        status |= call_clock(clock, 1e-6 * i, parameters, timed)
        status |= call_rates(rates, state, parameters, timed, out)
    return status
