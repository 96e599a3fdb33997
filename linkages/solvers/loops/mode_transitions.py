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
    Real,
    Truth,
    Whole,
    choose,
    choose_of,
    floats,
    integers,
    root_of,
)
from linkages.kernel.code.procedure import Procedure, printed
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


@printed
def spread(code: Procedure, system: SystemView, switches: SwitchesView) -> None:
    """Write what is held now wherever it is needed beside the kernel itself."""
    copies, held = integers(switches.copies), floats(system.held)
    with code.count(switches.copied) as k:
        target = floats(copies[2 * k])
        with code.count(copies[2 * k + 1]) as i:
            target[i] = held[i]


@printed
def arrive_at(
    _code: Procedure, system: SystemView, switches: SwitchesView, record: Record, t: Real
) -> Whole:
    """Evaluate row 0 with what is held now; returns the status of the kernel."""
    spread(system, switches)
    integers(record.counters)[EVALUATIONS] += 1
    return evaluate_at(system, t, 0)


@printed
def new_values(code: Procedure, system: SystemView, switches: SwitchesView, t: Real) -> Whole:
    """Compute what becomes of the state in row 0."""
    spread(system, switches)
    functions = integers(switches.transition)
    status = call_clock(functions[0], t, functions[2], functions[3])
    with code.when(status != 0):
        code.leave(status)
    return call_rates(functions[1], system.rows, functions[2], functions[3], switches.written)


@printed
def shift(
    code: Procedure, switches: SwitchesView, switch: Whole, column: Whole, rate: Real
) -> Real:
    """How much later a neighbour in the direction of a tangent meets the change."""
    with code.when(rate == 0.0):
        code.leave(0.0)
    first = switches.values * (2 + switches.tangents)
    moved = floats(switches.written)[first + switch * switches.tangents + column]
    return -moved / rate


@printed
def remember(
    code: Procedure, system: SystemView, switches: SwitchesView, switch: Whole, rate: Real
) -> None:
    """Renew what is remembered from a rise, with its tangents."""
    held, written = floats(system.held), floats(switches.written)
    owners, first = integers(switches.owners), switches.modes
    count, columns = switches.memories, switches.tangents
    with code.count(count) as r, code.when(owners[r] == switch):
        held[first + r] = written[r]
        with code.count(columns) as c:
            moved = written[2 * switches.values + r * columns + c]
            moved += written[switches.values + r] * shift(switches, switch, c, rate)
            held[first + count + c * count + r] = moved


@printed
def wake(
    code: Procedure, system: SystemView, switches: SwitchesView, switch: Whole, forward: Real
) -> Truth:
    """Set modes that are watched only while another one is +1, in the end this one; whether any.

    Row 0 has been evaluated with the other one. A mode stands behind the one that it depends on.
    """
    held, active = floats(system.held), integers(switches.active)
    functions = floats(functions_of(system, switches.modes, 0))
    any_of_them = code.variable(False)
    with code.count(switches.modes) as k:
        owner = code.variable(active[k])
        with code.during(lambda: (owner >= 0) & (owner != switch)):
            owner.set(active[owner])
        with code.when(owner == switch):
            any_of_them.set(True)
            value, rate = functions[k], forward * functions[switches.modes + k]
            on = (value > 0.0) | ((value == 0.0) & (rate >= 0.0))
            held[k] = choose_of(Real, (held[active[k]] > 0.0) & on, 1.0, -1.0)
    return any_of_them


@printed
def take_side(
    code: Procedure, system: SystemView, switches: SwitchesView, record: Record,
    switch: Whole, forward: Real, t: Real,
) -> Whole:  # fmt: skip
    """Give a mode that stuck the side to which its function leaves; returns the kernel's status."""
    held = floats(system.held)
    functions = floats(functions_of(system, switches.modes, 0))
    held[switch] = -1.0
    status = code.variable(arrive_at(system, switches, record, t))
    down = -forward * functions[switches.modes + switch]
    held[switch] = 1.0
    with code.when(status == 0):
        status.set(arrive_at(system, switches, record, t))
    up = forward * functions[switches.modes + switch]
    with code.when((status == 0) & (up < down)):
        held[switch] = -1.0
        status.set(arrive_at(system, switches, record, t))
    return code.value(status)


@printed
def rethink(
    code: Procedure, system: SystemView, switches: SwitchesView, record: Record,
    switch: Whole, forward: Real, jumped: Truth, t: Real,
) -> Whole:  # fmt: skip
    """Set the modes of functions whose values have jumped; returns the kernel's status.

    One mode after the other, for other functions may depend on it. Those that stuck stick no more
    if rates have jumped, or if that would take more than there is. Modes with jumps of their own
    wait for their functions to rise.
    """
    held = floats(system.held)
    functions = floats(functions_of(system, switches.modes, 0))
    status = code.variable(0)
    with code.count(2 * switches.modes):
        found = code.variable(-1)
        with code.count(switches.modes) as k:
            passed = (k == switch) | (integers(switches.jumps)[k] >= 0)
            with code.when(passed | ~is_watched(system, switches, k)):
                code.again()
            with code.when((held[k] == 0.0) & ~jumped):
                with code.when(functions[k] < -GRAZING):
                    status.set(take_side(system, switches, record, k, forward, t))
                code.again()
            with code.when(held[k] == 0.0):
                held[k] = 1.0
                status.set(arrive_at(system, switches, record, t))
            value, rate = functions[k], forward * functions[switches.modes + k]
            wrong = (held[k] * value < 0.0) | ((value == 0.0) & (held[k] * rate < 0.0))
            with code.when(wrong):
                found.set(k)
                code.stop()
        with code.when((found < 0) | (status != 0)):
            code.leave(status)
        held[found] = -held[found]
        status.set(arrive_at(system, switches, record, t))
        with code.when(status == 0), code.when(wake(system, switches, found, forward)):
            status.set(arrive_at(system, switches, record, t))
        with code.when(status != 0):
            code.leave(status)
    return code.value(status)


@printed
def cross_tangents(
    code: Procedure, system: SystemView, switches: SwitchesView,
    switch: Whole, rate: Real, jumped: Whole,
) -> None:  # fmt: skip
    """Lead tangents across the change, from the state before to that in row 0."""
    n, free, columns = system.n, switches.free, switches.tangents
    rows, before, written = floats(system.rows), floats(switches.before), floats(switches.written)
    values = switches.values
    with code.count(columns) as c:
        later = shift(switches, switch, c, rate)
        first = n - (columns - c) * free
        with code.count(free) as i:
            rows[first + i] += (before[n + i] - rows[n + i]) * later
            with code.when(jumped >= 0) as case:
                value = jumped + i
                moved = written[2 * values + value * columns + c]
                moved += written[values + value] * later
                rows[n + first + i] = moved - rows[2 * n + i] * later
            with case.otherwise():
                rows[n + first + i] += (before[2 * n + i] - rows[2 * n + i]) * later


@printed
def is_in_force(
    code: Procedure, system: SystemView, switches: SwitchesView, place: Whole, own: Whole
) -> Truth:
    """Whether modes keep a function constant, or the change of a switch has just brought it to 0.

    A contact that closes without pressing is about to open, but has taken all neighbours along.
    """
    holders, held = integers(switches.holders), floats(system.held)
    mode, touch = holders[2 * place], holders[2 * place + 1]
    with code.when(touch < 0):
        code.leave(held[mode] == 0.0)
    return (held[mode] > 0.0) | ((touch == own) & (held[touch] > 0.0))


@printed
def scalar_product(code: Procedure, count: Whole, one: Whole, other: Whole) -> Real:
    """Of so many numbers."""
    total = code.variable(0.0)
    with code.count(count) as i:
        total.set(total + floats(one)[i] * floats(other)[i])
    return code.value(total)


@printed
def take_part(code: Procedure, count: Whole, factor: Real, one: Whole, other: Whole) -> None:
    """Subtract a multiple of some numbers from others."""
    with code.count(count) as i:
        floats(other)[i] -= factor * floats(one)[i]


@printed
def project_along(
    code: Procedure, system: SystemView, switches: SwitchesView, normal: Whole
) -> None:
    """Take from all tangents in row 0 their parts along a direction of length one."""
    free, half = switches.free, WORD * switches.free
    with code.count(switches.tangents) as column:
        places = system.rows + WORD * (system.n - (switches.tangents - column) * free)
        rates = places + WORD * system.n
        with code.count(2):
            along = scalar_product(free, normal, places)
            along += scalar_product(free, normal + half, rates)
            take_part(free, along, normal, places)
            take_part(free, along, normal + half, rates)


@printed
def project(code: Procedure, context: Whole, t: Real, h: Real, t_end: Real) -> Real:  # noqa: ARG001
    """Take from tangents in row 0 what modes do not let neighbours differ by.

    Without, round-off in these directions would grow beside tangents that shrink. h is 1 behind a
    change of a mode, otherwise 0. Returns the number of directions in which there are no
    neighbours.
    """
    system, switches = system_at(context), switches_at(context)
    own = choose(h > 0.0, integers(switches.kind)[0] >> 1, -1)
    rank, size = code.variable(0), 2 * switches.free
    with code.count(switches.constraints) as k:
        rank.set(rank + is_in_force(system, switches, k, own).whole)
    with code.when(rank == 0):
        code.leave(0.0)
    rank.set(0)
    with code.when(new_values(system, switches, t) != 0):
        code.leave(0.0)
    behind = switches.values * (2 + switches.tangents) + switches.modes * switches.tangents
    first = switches.written + WORD * behind
    with code.count(switches.constraints) as k, code.when(is_in_force(system, switches, k, own)):
        gradient, normal = first + WORD * k * size, first + WORD * rank * size
        whole = scalar_product(size, gradient, gradient)
        with code.count(2), code.count(rank) as before:
            other = first + WORD * before * size
            take_part(size, scalar_product(size, other, gradient), other, gradient)
        left = scalar_product(size, gradient, gradient)
        with code.when(left > DEPENDENT * whole):
            length = root_of(left)
            with code.count(size) as i:
                floats(normal)[i] = floats(gradient)[i] / length
            project_along(system, switches, normal)
            rank.set(rank + 1)
    return rank.real


@printed
def note_change(
    code: Procedure, system: SystemView, switches: SwitchesView, record: Record,
    switch: Whole, rises: Truth, t: Real,
) -> None:  # fmt: skip
    """Record a change with the state before it."""
    n, noted = system.n, integers(switches.noted)
    integers(switches.found)[switch] += 1
    place = noted[0]
    noted[0] += 1
    with code.when(place >= switches.capacity):
        code.leave()
    floats(switches.time)[place] = t
    integers(switches.which)[place] = switch
    integers(switches.rises)[place] = rises.whole
    state = switches.state + WORD * place * 2 * n
    with code.count(2 * n) as i:
        floats(state)[i] = floats(switches.before)[i]
    wrap_angles(system, state, record.final_turns, switches.turns + WORD * place * n)
    with code.count(system.holding) as i:
        floats(switches.held)[place * system.holding + i] = floats(system.held)[i]


@printed
def chatters(code: Procedure, switches: SwitchesView, t: Real) -> Truth:
    """Whether modes change all the time while time hardly goes on."""
    row, since = integers(switches.pending), floats(switches.since)
    with code.when(abs(t - since[0]) > SPAN * abs(t)):
        since[0] = t
        row[1] = 0
    row[1] += 1
    return row[1] > CHANGES


@printed
def release(
    code: Procedure, system: SystemView, switches: SwitchesView, record: Record,
    switch: Whole, forward: Real, t: Real,
) -> Whole:  # fmt: skip
    """Leave the zero of a function on which the motion has stuck; returns an `Outcome`."""
    held = floats(system.held)
    status = take_side(system, switches, record, switch, forward, t)
    with code.when(status != 0):
        code.leave(outcome_of(record, status))
    settle(system)
    return noted(code, system, switches, record, switch, held[switch] > 0.0, t)


def noted(
    code: Procedure, system: Any, switches: Any, record: Any, switch: Whole, rises: Any, t: Real
) -> Whole:
    """Record a change; returns from the function unless time goes on behind it."""
    note_change(system, switches, record, switch, rises, t)
    with code.when(chatters(switches, t)):
        code.leave(CHATTER)
    integers(record.counters)[SWITCH] = -1
    return code.value(DONE)


@printed
def change(_code: Procedure, context: Whole, t: Real, h: Real, t_end: Real) -> Real:  # noqa: ARG001
    """Change the mode that `look` has found, at the state in row 0; returns an `Outcome`."""
    system, record, switches = system_at(context), record_at(context), switches_at(context)
    return change_at(system, switches, record, choose_of(Real, h >= 0.0, 1.0, -1.0), t_end).real


@printed
def change_at(
    code: Procedure, system: SystemView, switches: SwitchesView, record: Record,
    forward: Real, t: Real,
) -> Whole:  # fmt: skip
    """See `change`; `forward` is the sign of the direction of time."""
    n, rows, held = system.n, floats(system.rows), floats(system.held)
    switch = integers(switches.pending)[0]
    functions = floats(functions_of(system, switches.modes, 0))
    rate = functions[switches.modes + switch]
    rises = held[switch] < 0.0
    integers(switches.kind)[0] = 2 * switch + rises.whole
    jumped = code.variable(choose(rises, integers(switches.jumps)[switch], -1))
    with code.count(3 * n) as i:
        floats(switches.before)[i] = rows[i]
    integers(record.counters)[SWITCH] = switch
    with code.when(integers(switches.transition)[0] != 0):
        status = new_values(system, switches, t)
        with code.when(status != 0):
            code.leave(outcome_of(record, status))
    with code.when(held[switch] == 0.0):
        code.leave(release(system, switches, record, switch, forward, t))
    with code.when((jumped >= 0) & (forward * rate <= 0.0)) as case:
        jumped.set(-1)  # round-off: it moves away already
    with case.otherwise():
        held[switch] = -held[switch]
    with code.when(rises):
        remember(system, switches, switch, rate)
    with code.when(jumped >= 0), code.count(switches.free) as i:
        rows[n + i] = floats(switches.written)[jumped + i]
    status = follow(system, switches, record, switch, forward, jumped >= 0, t)
    with code.when(status != 0):
        code.leave(outcome_of(record, status))
    with code.when(~finite(system, 0, 3 * n)):
        code.leave(DIVERGED)
    behind = forward * held[switch] * functions[switches.modes + switch]
    with code.when(behind < -GRAZING * abs(rate)):
        with code.when(integers(switches.sticks)[switch] == 0):
            code.leave(SLIDING)
        held[switch] = 0.0
        status = code.variable(arrive_at(system, switches, record, t))
        with code.when((status == 0) & (integers(switches.shakes)[switch] != 0)):
            status.set(rethink(system, switches, record, switch, forward, False, t))
        with code.when(status != 0):
            code.leave(outcome_of(record, status))
        # round-off alone may ask for a little more than holds
        with code.when(functions[switch] < -GRAZING):
            code.leave(SLIDING)
    outcome = noted(code, system, switches, record, switch, rises, t)
    with code.when(switches.tangents > 0):
        cross_tangents(system, switches, switch, rate, jumped)
        arrive_at(system, switches, record, t)
    settle(system)
    with code.count(switches.events) as event:
        floats(switches.values_of_events)[5 * event + 2] = math.nan
    return outcome


@printed
def follow(
    code: Procedure, system: SystemView, switches: SwitchesView, record: Record,
    switch: Whole, forward: Real, jumps: Truth, t: Real,
) -> Whole:  # fmt: skip
    """Set the other modes as the state behind a change asks for; returns the kernel's status."""
    held, functions = floats(system.held), floats(functions_of(system, switches.modes, 0))
    status = code.variable(arrive_at(system, switches, record, t))
    thrown_back = forward * functions[switches.modes + switch] < 0.0
    with code.when((status == 0) & jumps & thrown_back):
        held[switch] = -1.0
        status.set(arrive_at(system, switches, record, t))
    with code.when(status == 0), code.when(wake(system, switches, switch, forward)):
        status.set(arrive_at(system, switches, record, t))
    shakes = integers(switches.shakes)[switch] != 0
    with code.when((status == 0) & (jumps | shakes)):
        status.set(rethink(system, switches, record, switch, forward, jumps, t))
    return code.value(status)
