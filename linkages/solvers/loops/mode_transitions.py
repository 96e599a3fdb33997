"""Changes of modes at the times at which they were located.

Tangents cross it with the saltation matrix: a neighbour meets the zero of the function g at another
time, by ``δτ = -∇g·δx/g'``. With new values m(t, x) of rates and of what is remembered, and the
derivatives f of the state before and behind, ``δx⁺ = ∂m·(δx + f⁻ δτ) - f⁺ δτ`` [1]_, where what is
remembered is a part of the state that stands still.

References
----------
.. [1] R. I. Leine, H. Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems,
       Springer 2004, chapter 7; for impacts P. C. Müller, Chaos, Solitons & Fractals 5 (1995) 1671.
"""

from __future__ import annotations

import math
from typing import Any

from linkages.kernel.code.operands import (
    Bool,
    Int,
    Real,
    floats,
    integers,
    select,
    select_of,
    sqrt,
)
from linkages.kernel.code.procedure import Procedure, traced
from linkages.solvers.loops.memory import (
    EVALUATIONS,
    SWITCH,
    WORD,
    Record,
    SwitchesView,
    SystemView,
)
from linkages.solvers.loops.mode_changes import (
    functions_of,
    is_watched,
    record_at,
    switches_at,
    system_at,
)
from linkages.solvers.loops.scalar_stages import (
    call_clock,
    call_rates,
    evaluate_at,
    finite,
    wrap_angles,
)
from linkages.solvers.loops.step_loop import (
    CHATTER,
    DIVERGED,
    DONE,
    SLIDING,
    outcome_of,
    settle,
)

# A rate behind a change that is this small beside that before is zero: the motion touches.
GRAZING = 1e-9
# Part of the square of a gradient that is left of one that depends on others.
DEPENDENT = 1e-16
# So many changes within this part of the time until then, and time goes on no more.
CHANGES, SPAN = 100, 1e-10


@traced
def broadcast_modes(code: Procedure, system: SystemView, switches: SwitchesView) -> None:
    """Write what is held now wherever it is needed beside the kernel itself."""
    copies, held = integers(switches.copies), floats(system.held)
    with code.for_range(switches.copied) as k:
        target = floats(copies[2 * k])
        with code.for_range(copies[2 * k + 1]) as i:
            target[i] = held[i]


@traced
def reevaluate(
    _code: Procedure, system: SystemView, switches: SwitchesView, record: Record, t: Real
) -> Int:
    """Evaluate row 0 with what is held now; returns the status of the kernel."""
    broadcast_modes(system, switches)
    integers(record.counters)[EVALUATIONS] += 1
    return evaluate_at(system, t, 0)


@traced
def evaluate_jump(code: Procedure, system: SystemView, switches: SwitchesView, t: Real) -> Int:
    """Compute what becomes of the state in row 0."""
    broadcast_modes(system, switches)
    functions = integers(switches.transition)
    status = call_clock(functions[0], t, functions[2], functions[3])
    with code.if_(status != 0):
        code.return_(status)
    return call_rates(functions[1], system.rows, functions[2], functions[3], switches.written)


@traced
def event_time_shift(
    code: Procedure, switches: SwitchesView, switch: Int, column: Int, rate: Real
) -> Real:
    """How much later a neighbour in the direction of a tangent meets the change."""
    with code.if_(rate == 0.0):
        code.return_(0.0)
    first = switches.values * (2 + switches.tangents)
    moved = floats(switches.written)[first + switch * switches.tangents + column]
    return -moved / rate


@traced
def latch_values(
    code: Procedure, system: SystemView, switches: SwitchesView, switch: Int, rate: Real
) -> None:
    """Renew what is remembered from a rise, with its tangents."""
    held, written = floats(system.held), floats(switches.written)
    owners, first = integers(switches.owners), switches.modes
    count, columns = switches.memories, switches.tangents
    with code.for_range(count) as r, code.if_(owners[r] == switch):
        held[first + r] = written[r]
        with code.for_range(columns) as c:
            moved = written[2 * switches.values + r * columns + c]
            moved += written[switches.values + r] * event_time_shift(switches, switch, c, rate)
            held[first + count + c * count + r] = moved


@traced
def activate_dependents(
    code: Procedure, system: SystemView, switches: SwitchesView, switch: Int, forward: Real
) -> Bool:
    """Set modes that are watched only while another one is +1, in the end this one; whether any.

    Row 0 has been evaluated with the other one. A mode stands behind the one that it depends on.
    """
    held, active = floats(system.held), integers(switches.active)
    functions = floats(functions_of(system, switches.modes, 0))
    any_of_them = code.variable(False)
    with code.for_range(switches.modes) as k:
        owner = code.variable(active[k])
        with code.while_(lambda: (owner >= 0) & (owner != switch)):
            owner.set(active[owner])
        with code.if_(owner == switch):
            any_of_them.set(True)
            value, rate = functions[k], forward * functions[switches.modes + k]
            on = (value > 0.0) | ((value == 0.0) & (rate >= 0.0))
            held[k] = select_of(Real, (held[active[k]] > 0.0) & on, 1.0, -1.0)
    return any_of_them


@traced
def choose_side(
    code: Procedure, system: SystemView, switches: SwitchesView, record: Record,
    switch: Int, forward: Real, t: Real,
) -> Int:  # fmt: skip
    """Give a mode that stuck the side to which its function leaves; returns the kernel's status."""
    held = floats(system.held)
    functions = floats(functions_of(system, switches.modes, 0))
    held[switch] = -1.0
    status = code.variable(reevaluate(system, switches, record, t))
    down = -forward * functions[switches.modes + switch]
    held[switch] = 1.0
    with code.if_(status == 0):
        status.set(reevaluate(system, switches, record, t))
    up = forward * functions[switches.modes + switch]
    with code.if_((status == 0) & (up < down)):
        held[switch] = -1.0
        status.set(reevaluate(system, switches, record, t))
    return code.value(status)


@traced
def resolve_modes(
    code: Procedure, system: SystemView, switches: SwitchesView, record: Record,
    switch: Int, forward: Real, jumped: Bool, t: Real,
) -> Int:  # fmt: skip
    """Set the modes of functions whose values have jumped; returns the kernel's status.

    One mode after the other, for other functions may depend on it. Those that stuck stick no more
    if rates have jumped, or if that would take more than there is. Modes with jumps of their own
    wait for their functions to rise.
    """
    held = floats(system.held)
    functions = floats(functions_of(system, switches.modes, 0))
    status = code.variable(0)
    with code.for_range(2 * switches.modes):
        result = code.variable(-1)
        with code.for_range(switches.modes) as k:
            passed = (k == switch) | (integers(switches.jumps)[k] >= 0)
            with code.if_(passed | ~is_watched(system, switches, k)):
                code.continue_()
            with code.if_((held[k] == 0.0) & ~jumped):
                with code.if_(functions[k] < -GRAZING):
                    status.set(choose_side(system, switches, record, k, forward, t))
                code.continue_()
            with code.if_(held[k] == 0.0):
                held[k] = 1.0
                status.set(reevaluate(system, switches, record, t))
            value, rate = functions[k], forward * functions[switches.modes + k]
            wrong = (held[k] * value < 0.0) | ((value == 0.0) & (held[k] * rate < 0.0))
            with code.if_(wrong):
                result.set(k)
                code.break_()
        with code.if_((result < 0) | (status != 0)):
            code.return_(status)
        held[result] = -held[result]
        status.set(reevaluate(system, switches, record, t))
        with (
            code.if_(status == 0),
            code.if_(activate_dependents(system, switches, result, forward)),
        ):
            status.set(reevaluate(system, switches, record, t))
        with code.if_(status != 0):
            code.return_(status)
    return code.value(status)


@traced
def apply_saltation(
    code: Procedure, system: SystemView, switches: SwitchesView,
    switch: Int, rate: Real, jumped: Int,
) -> None:  # fmt: skip
    """Lead tangents across the change, from the state before to that in row 0."""
    n, free, columns = system.n, switches.free, switches.tangents
    rows, before, written = floats(system.rows), floats(switches.before), floats(switches.written)
    values = switches.values
    with code.for_range(columns) as c:
        later = event_time_shift(switches, switch, c, rate)
        first = n - (columns - c) * free
        with code.for_range(free) as i:
            rows[first + i] += (before[n + i] - rows[n + i]) * later
            with code.if_(jumped >= 0) as case:
                value = jumped + i
                moved = written[2 * values + value * columns + c]
                moved += written[values + value] * later
                rows[n + first + i] = moved - rows[2 * n + i] * later
            with case.else_():
                rows[n + first + i] += (before[2 * n + i] - rows[2 * n + i]) * later


@traced
def is_in_force(
    code: Procedure, system: SystemView, switches: SwitchesView, place: Int, own: Int
) -> Bool:
    """Whether modes keep a function constant, or the change of a switch has just brought it to 0.

    A contact that closes without pressing is about to open, but has taken all neighbours along.
    """
    holders, held = integers(switches.holders), floats(system.held)
    mode, touch = holders[2 * place], holders[2 * place + 1]
    with code.if_(touch < 0):
        code.return_(held[mode] == 0.0)
    return (held[mode] > 0.0) | ((touch == own) & (held[touch] > 0.0))


@traced
def scalar_product(code: Procedure, count: Int, one: Int, other: Int) -> Real:
    """Of so many numbers."""
    total = code.variable(0.0)
    with code.for_range(count) as i:
        total.set(total + floats(one)[i] * floats(other)[i])
    return code.value(total)


@traced
def subtract_multiple(code: Procedure, count: Int, factor: Real, one: Int, other: Int) -> None:
    """Subtract a multiple of some numbers from others."""
    with code.for_range(count) as i:
        floats(other)[i] -= factor * floats(one)[i]


@traced
def project_along(code: Procedure, system: SystemView, switches: SwitchesView, normal: Int) -> None:
    """Take from all tangents in row 0 their parts along a direction of length one."""
    free, half = switches.free, WORD * switches.free
    with code.for_range(switches.tangents) as column:
        places = system.rows + WORD * (system.n - (switches.tangents - column) * free)
        rates = places + WORD * system.n
        with code.for_range(2):
            along = scalar_product(free, normal, places)
            along += scalar_product(free, normal + half, rates)
            subtract_multiple(free, along, normal, places)
            subtract_multiple(free, along, normal + half, rates)


@traced
def project(code: Procedure, context: Int, t: Real, h: Real, t_end: Real) -> Real:  # noqa: ARG001
    """Take from tangents in row 0 what modes do not let neighbours differ by.

    Without, round-off in these directions would grow beside tangents that shrink. h is 1 behind a
    change of a mode, otherwise 0. Returns the number of directions in which there are no
    neighbours.
    """
    system, switches = system_at(context), switches_at(context)
    own = select(h > 0.0, integers(switches.kind)[0] >> 1, -1)
    rank, size = code.variable(0), 2 * switches.free
    with code.for_range(switches.constraints) as k:
        rank.set(rank + is_in_force(system, switches, k, own).to_int)
    with code.if_(rank == 0):
        code.return_(0.0)
    rank.set(0)
    with code.if_(evaluate_jump(system, switches, t) != 0):
        code.return_(0.0)
    behind = switches.values * (2 + switches.tangents) + switches.modes * switches.tangents
    first = switches.written + WORD * behind
    with code.for_range(switches.constraints) as k, code.if_(is_in_force(system, switches, k, own)):
        gradient, normal = first + WORD * k * size, first + WORD * rank * size
        whole = scalar_product(size, gradient, gradient)
        with code.for_range(2), code.for_range(rank) as before:
            other = first + WORD * before * size
            subtract_multiple(size, scalar_product(size, other, gradient), other, gradient)
        left = scalar_product(size, gradient, gradient)
        with code.if_(left > DEPENDENT * whole):
            length = sqrt(left)
            with code.for_range(size) as i:
                floats(normal)[i] = floats(gradient)[i] / length
            project_along(system, switches, normal)
            rank.set(rank + 1)
    return rank.to_real


@traced
def log_switch(
    code: Procedure, system: SystemView, switches: SwitchesView, record: Record,
    switch: Int, rises: Bool, t: Real,
) -> None:  # fmt: skip
    """Record a change with the state before it."""
    n, noted = system.n, integers(switches.noted)
    integers(switches.found)[switch] += 1
    place = noted[0]
    noted[0] += 1
    with code.if_(place >= switches.capacity):
        code.return_()
    floats(switches.time)[place] = t
    integers(switches.which)[place] = switch
    integers(switches.rises)[place] = rises.to_int
    state = switches.state + WORD * place * 2 * n
    with code.for_range(2 * n) as i:
        floats(state)[i] = floats(switches.before)[i]
    wrap_angles(system, state, record.final_turns, switches.turns + WORD * place * n)
    with code.for_range(system.holding) as i:
        floats(switches.held)[place * system.holding + i] = floats(system.held)[i]


@traced
def chatters(code: Procedure, switches: SwitchesView, t: Real) -> Bool:
    """Whether modes change all the time while time hardly goes on."""
    row, since = integers(switches.pending), floats(switches.since)
    with code.if_(abs(t - since[0]) > SPAN * abs(t)):
        since[0] = t
        row[1] = 0
    row[1] += 1
    return row[1] > CHANGES


@traced
def release_sticking(
    code: Procedure, system: SystemView, switches: SwitchesView, record: Record,
    switch: Int, forward: Real, t: Real,
) -> Int:  # fmt: skip
    """Leave the zero of a function on which the motion has stuck; returns an `Outcome`."""
    held = floats(system.held)
    status = choose_side(system, switches, record, switch, forward, t)
    with code.if_(status != 0):
        code.return_(outcome_of(record, status))
    settle(system)
    return record_switch(code, system, switches, record, switch, held[switch] > 0.0, t)


def record_switch(
    code: Procedure, system: Any, switches: Any, record: Any, switch: Int, rises: Any, t: Real
) -> Int:
    """Record a change; returns from the function unless time goes on behind it."""
    log_switch(system, switches, record, switch, rises, t)
    with code.if_(chatters(switches, t)):
        code.return_(CHATTER)
    integers(record.counters)[SWITCH] = -1
    return code.value(DONE)


@traced
def apply_switch(_code: Procedure, context: Int, t: Real, h: Real, t_end: Real) -> Real:  # noqa: ARG001
    """Change the mode that `find_switch` has found, at the state in row 0; returns an `Outcome`."""
    system, record, switches = system_at(context), record_at(context), switches_at(context)
    return apply_switch_at(
        system, switches, record, select_of(Real, h >= 0.0, 1.0, -1.0), t_end
    ).to_real


@traced
def apply_switch_at(
    code: Procedure, system: SystemView, switches: SwitchesView, record: Record,
    forward: Real, t: Real,
) -> Int:  # fmt: skip
    """See `apply_switch`; `forward` is the sign of the direction of time."""
    n, rows, held = system.n, floats(system.rows), floats(system.held)
    switch = integers(switches.pending)[0]
    functions = floats(functions_of(system, switches.modes, 0))
    rate = functions[switches.modes + switch]
    rises = held[switch] < 0.0
    integers(switches.kind)[0] = 2 * switch + rises.to_int
    jumped = code.variable(select(rises, integers(switches.jumps)[switch], -1))
    with code.for_range(3 * n) as i:
        floats(switches.before)[i] = rows[i]
    integers(record.counters)[SWITCH] = switch
    with code.if_(integers(switches.transition)[0] != 0):
        status = evaluate_jump(system, switches, t)
        with code.if_(status != 0):
            code.return_(outcome_of(record, status))
    with code.if_(held[switch] == 0.0):
        code.return_(release_sticking(system, switches, record, switch, forward, t))
    with code.if_((jumped >= 0) & (forward * rate <= 0.0)) as case:
        jumped.set(-1)  # round-off: it moves away already
    with case.else_():
        held[switch] = -held[switch]
    with code.if_(rises):
        latch_values(system, switches, switch, rate)
    with code.if_(jumped >= 0), code.for_range(switches.free) as i:
        rows[n + i] = floats(switches.written)[jumped + i]
    status = propagate_modes(system, switches, record, switch, forward, jumped >= 0, t)
    with code.if_(status != 0):
        code.return_(outcome_of(record, status))
    with code.if_(~finite(system, 0, 3 * n)):
        code.return_(DIVERGED)
    behind = forward * held[switch] * functions[switches.modes + switch]
    with code.if_(behind < -GRAZING * abs(rate)):
        with code.if_(integers(switches.sticks)[switch] == 0):
            code.return_(SLIDING)
        held[switch] = 0.0
        status = code.variable(reevaluate(system, switches, record, t))
        with code.if_((status == 0) & (integers(switches.couples_others)[switch] != 0)):
            status.set(resolve_modes(system, switches, record, switch, forward, False, t))
        with code.if_(status != 0):
            code.return_(outcome_of(record, status))
        # round-off alone may ask for a little more than holds
        with code.if_(functions[switch] < -GRAZING):
            code.return_(SLIDING)
    outcome = record_switch(code, system, switches, record, switch, rises, t)
    with code.if_(switches.tangents > 0):
        apply_saltation(system, switches, switch, rate, jumped)
        reevaluate(system, switches, record, t)
    settle(system)
    with code.for_range(switches.events) as event:
        floats(switches.values_of_events)[5 * event + 2] = math.nan
    return outcome


@traced
def propagate_modes(
    code: Procedure, system: SystemView, switches: SwitchesView, record: Record,
    switch: Int, forward: Real, jumps: Bool, t: Real,
) -> Int:  # fmt: skip
    """Set the other modes as the state behind a change asks for; returns the kernel's status."""
    held, functions = floats(system.held), floats(functions_of(system, switches.modes, 0))
    status = code.variable(reevaluate(system, switches, record, t))
    thrown_back = forward * functions[switches.modes + switch] < 0.0
    with code.if_((status == 0) & jumps & thrown_back):
        held[switch] = -1.0
        status.set(reevaluate(system, switches, record, t))
    with code.if_(status == 0), code.if_(activate_dependents(system, switches, switch, forward)):
        status.set(reevaluate(system, switches, record, t))
    couples = integers(switches.couples_others)[switch] != 0
    with code.if_((status == 0) & (jumps | couples)):
        status.set(resolve_modes(system, switches, record, switch, forward, jumps, t))
    return code.value(status)
