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
    RealArray,
    floats,
    select,
    select_of,
    sqrt,
)
from linkages.kernel.code.procedure import Procedure, traced
from linkages.solvers.flow import UPDATES
from linkages.solvers.loops.memory import Motion
from linkages.solvers.loops.mode_changes import functions_of, is_watched
from linkages.solvers.loops.scalar_stages import (
    call_clock,
    call_rates,
    evaluate_at,
    finite,
    wrap_angles,
)
from linkages.solvers.loops.step_loop import outcome_of, settle
from linkages.solvers.trajectory import Outcome

# A rate behind a change that is this small beside that before is zero: the motion touches.
GRAZING = 1e-9
# Part of the square of a gradient that is left of one that depends on others.
DEPENDENT = 1e-16
# So many changes within this part of the time until then, and time goes on no more.
CHANGES, SPAN = 100, 1e-10


@traced
def broadcast_modes(code: Procedure, motion: Motion) -> None:
    """Write what is held now wherever it is needed beside the kernel itself."""
    switches = motion.switches
    copies, held = switches.copies, motion.held
    with code.for_range(switches.copied) as k:
        floats(copies[2 * k]).take(held, copies[2 * k + 1])


@traced
def reevaluate(_code: Procedure, motion: Motion, t: Real) -> Int:
    """Evaluate row 0 with what is held now; returns the status of the kernel."""
    broadcast_modes(motion)
    motion.counters.evaluations += 1
    return evaluate_at(motion, t, 0)


@traced
def evaluate_jump(code: Procedure, motion: Motion, t: Real) -> Int:
    """Compute what becomes of the state in row 0."""
    broadcast_modes(motion)
    transition = motion.switches.transition
    status = call_clock(transition, t)
    code.return_if(status != 0, status)
    return call_rates(transition, motion.row(0), motion.switches.written)


@traced
def event_time_shift(code: Procedure, motion: Motion, switch: Int, column: Int, rate: Real) -> Real:
    """How much later a neighbour in the direction of a tangent meets the change."""
    switches = motion.switches
    code.return_if(rate == 0.0, 0.0)
    first = switches.values * (2 + switches.tangents)
    moved = switches.written[first + switch * switches.tangents + column]
    return -moved / rate


@traced
def latch_values(code: Procedure, motion: Motion, switch: Int, rate: Real) -> None:
    """Renew what is remembered from a rise, with its tangents."""
    switches = motion.switches
    held, written = motion.held, switches.written
    owners, first = switches.owners, switches.modes
    count, columns = switches.memories, switches.tangents
    with code.for_range(count) as r, code.if_(owners[r] == switch):
        held[first + r] = written[r]
        with code.for_range(columns) as c:
            moved = written[2 * switches.values + r * columns + c]
            moved += written[switches.values + r] * event_time_shift(motion, switch, c, rate)
            held[first + count + c * count + r] = moved


def ahead(motion: Motion, switch: Int) -> tuple[Real, Real]:
    """Function of a switch in row 0, and its rate in the direction of the motion."""
    functions = functions_of(motion, 0)
    value, rate = functions[switch], functions[motion.switches.modes + switch]
    return value, select(motion.backward != 0, -rate, rate)


@traced
def activate_dependents(code: Procedure, motion: Motion, switch: Int) -> Bool:
    """Set modes that are watched only while another one is +1, in the end this one; whether any.

    Row 0 has been evaluated with the other one. A mode stands behind the one that it depends on.
    """
    switches = motion.switches
    held, active = motion.held, switches.active
    any_of_them = code.variable(False)
    with code.for_range(switches.modes) as k:
        owner = code.variable(active[k])
        with code.while_(lambda: (owner >= 0) & (owner != switch)):
            owner.set(active[owner])
        with code.if_(owner == switch):
            any_of_them.set(True)
            value, rate = ahead(motion, k)
            on = (value > 0.0) | ((value == 0.0) & (rate >= 0.0))
            held[k] = select_of(Real, (held[active[k]] > 0.0) & on, 1.0, -1.0)
    return any_of_them


@traced
def choose_side(code: Procedure, motion: Motion, switch: Int, t: Real) -> Int:
    """Give a mode that stuck the side to which its function leaves; returns the kernel's status."""
    held = motion.held
    held[switch] = -1.0
    status = code.variable(reevaluate(motion, t))
    _, below = ahead(motion, switch)
    held[switch] = 1.0
    with code.if_(status == 0):
        status.set(reevaluate(motion, t))
    _, above = ahead(motion, switch)
    with code.if_((status == 0) & (above < -below)):
        held[switch] = -1.0
        status.set(reevaluate(motion, t))
    return code.value(status)


@traced
def resolve_modes(code: Procedure, motion: Motion, switch: Int, jumped: Bool, t: Real) -> Int:
    """Set the modes of functions whose values have jumped; returns the kernel's status.

    One mode after the other, for other functions may depend on it. Those that stuck stick no more
    if rates have jumped, or if that would take more than there is. Modes with jumps of their own
    wait for their functions to rise.
    """
    switches, held, status = motion.switches, motion.held, code.variable(0)
    with code.for_range(2 * switches.modes):
        result = code.variable(-1)
        with code.for_range(switches.modes) as k:
            passed = (k == switch) | (switches.jumps[k] >= 0)
            with code.if_(passed | ~is_watched(motion, k)):
                code.continue_()
            with code.if_((held[k] == 0.0) & ~jumped):
                with code.if_(ahead(motion, k)[0] < -GRAZING):
                    status.set(choose_side(motion, k, t))
                code.continue_()
            with code.if_(held[k] == 0.0):
                held[k] = 1.0
                status.set(reevaluate(motion, t))
            value, rate = ahead(motion, k)
            wrong = (held[k] * value < 0.0) | ((value == 0.0) & (held[k] * rate < 0.0))
            with code.if_(wrong):
                result.set(k)
                code.break_()
        code.return_if((result < 0) | (status != 0), status)
        held[result] = -held[result]
        status.set(reevaluate(motion, t))
        with code.if_(status == 0), code.if_(activate_dependents(motion, result)):
            status.set(reevaluate(motion, t))
        code.return_if(status != 0, status)
    return code.value(status)


@traced
def apply_saltation(code: Procedure, motion: Motion, switch: Int, rate: Real, jumped: Int) -> None:
    """Lead tangents across the change, from the state before to that in row 0."""
    switches = motion.switches
    n, free, columns = motion.n, switches.free, switches.tangents
    rows, before, written = motion.rows, switches.before, switches.written
    values = switches.values
    with code.for_range(columns) as c:
        later = event_time_shift(motion, switch, c, rate)
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
def is_in_force(code: Procedure, motion: Motion, place: Int, own: Int) -> Bool:
    """Whether modes keep a function constant, or the change of a switch has just brought it to 0.

    A contact that closes without pressing is about to open, but has taken all neighbours along.
    """
    holders, held = motion.switches.holders, motion.held
    mode, touch = holders[2 * place], holders[2 * place + 1]
    with code.if_(touch < 0):
        code.return_(held[mode] == 0.0)
    return (held[mode] > 0.0) | ((touch == own) & (held[touch] > 0.0))


@traced
def scalar_product(code: Procedure, count: Int, one: RealArray, other: RealArray) -> Real:
    """Of so many numbers."""
    total = code.variable(0.0)
    with code.for_range(count) as i:
        total.set(total + one[i] * other[i])
    return code.value(total)


@traced
def subtract_multiple(
    code: Procedure, count: Int, factor: Real, one: RealArray, other: RealArray
) -> None:
    """Subtract a multiple of some numbers from others."""
    with code.for_range(count) as i:
        other[i] -= factor * one[i]


@traced
def project_along(code: Procedure, motion: Motion, normal: RealArray) -> None:
    """Take from all tangents in row 0 their parts along a direction of length one."""
    switches = motion.switches
    free = switches.free
    half = normal.after(free)
    with code.for_range(switches.tangents) as column:
        places = motion.rows.after(motion.n - (switches.tangents - column) * free)
        rates = places.after(motion.n)
        with code.for_range(2):
            along = scalar_product(free, normal, places)
            along += scalar_product(free, half, rates)
            subtract_multiple(free, along, normal, places)
            subtract_multiple(free, along, half, rates)


@traced
def project(code: Procedure, motion: Motion, t: Real, behind: Int) -> Int:
    """Take from tangents in row 0 what modes do not let neighbours differ by; returns how many.

    Round-off in these directions would grow beside tangents that shrink. `behind` is 1 behind a
    change of a mode, otherwise 0.
    """
    switches = motion.switches
    own = select(behind > 0, switches.last[0] >> 1, -1)
    rank, size = code.variable(0), 2 * switches.free
    with code.for_range(switches.constraints) as k:
        rank.set(rank + is_in_force(motion, k, own).to_int)
    code.return_if(rank == 0, 0)
    rank.set(0)
    code.return_if(evaluate_jump(motion, t) != 0, 0)
    before = switches.values * (2 + switches.tangents) + switches.modes * switches.tangents
    first = switches.written.after(before)
    with code.for_range(switches.constraints) as k, code.if_(is_in_force(motion, k, own)):
        gradient, normal = first.after(k * size), first.after(rank * size)
        whole = scalar_product(size, gradient, gradient)
        with code.for_range(2), code.for_range(rank) as row:
            other = first.after(row * size)
            subtract_multiple(size, scalar_product(size, other, gradient), other, gradient)
        left = scalar_product(size, gradient, gradient)
        with code.if_(left > DEPENDENT * whole):
            length = sqrt(left)
            with code.for_range(size) as i:
                normal[i] = gradient[i] / length
            project_along(motion, normal)
            rank.set(rank + 1)
    return code.value(rank)


@traced
def log_switch(code: Procedure, motion: Motion, switch: Int, rises: Bool, t: Real) -> None:
    """Record a change with the state before it."""
    switches = motion.switches
    n, noted = motion.n, switches.noted
    switches.found[switch] += 1
    place = noted[0]
    noted[0] += 1
    code.return_if(place >= switches.capacity)
    switches.time[place] = t
    switches.which[place] = switch
    switches.rises[place] = rises.to_int
    state = switches.state.after(place * 2 * n)
    state.take(switches.before, 2 * n)
    wrap_angles(motion, state, switches.turns.after(place * n))
    switches.held.after(place * motion.holding).take(motion.held, motion.holding)


@traced
def chatters(code: Procedure, motion: Motion, t: Real) -> Bool:
    """Whether modes change all the time while time hardly goes on."""
    switches = motion.switches
    row, since = switches.pending, switches.since
    with code.if_(abs(t - since[0]) > SPAN * abs(t)):
        since[0] = t
        row[1] = 0
    row[1] += 1
    return row[1] > CHANGES


@traced
def release_sticking(code: Procedure, motion: Motion, switch: Int, t: Real) -> Int:
    """Leave the zero of a function on which the motion has stuck; returns an `Outcome`."""
    held = motion.held
    status = choose_side(motion, switch, t)
    with code.if_(status != 0):
        code.return_(outcome_of(motion, status))
    settle(motion)
    return record_switch(code, motion, switch, held[switch] > 0.0, t)


def record_switch(code: Procedure, motion: Motion, switch: Int, rises: Any, t: Real) -> Int:
    """Record a change; returns from the function unless time goes on behind it."""
    log_switch(motion, switch, rises, t)
    return behind_switch(code, motion, switch, t)


def behind_switch(code: Procedure, motion: Motion, _switch: Int, t: Real) -> Int:
    """Returns from the function unless time goes on behind the change of a switch."""
    code.return_if(chatters(motion, t), Outcome.CHATTER)
    motion.counters.switch = -1
    return code.value(Outcome.DONE)


@traced
def take_back(code: Procedure, motion: Motion, switch: Int, t: Real) -> Int:
    """Undo a change that round-off made: its function came back before; returns an `Outcome`.

    The indentation of a closed contact dips so, within the errors of steps.
    """
    motion.held[switch] = -motion.held[switch]
    motion.switches.last[0] = -1
    status = propagate_modes(motion, switch, False, t)
    with code.if_(status != 0):
        code.return_(outcome_of(motion, status))
    settle(motion)
    return behind_switch(code, motion, switch, t)


@traced
def apply_switch(code: Procedure, motion: Motion, t: Real) -> Int:
    """Change the mode that `find_switch` has found, at the state in row 0; returns an `Outcome`."""
    n, rows, held, switches = motion.n, motion.rows, motion.held, motion.switches
    switch = switches.pending[0]
    rate = functions_of(motion, 0)[switches.modes + switch]
    _, begun = ahead(motion, switch)
    rises = held[switch] < 0.0
    switches.last[0] = 2 * switch + rises.to_int
    jumped = code.variable(select(rises, switches.jumps[switch], -1))
    switches.before.take(rows, 3 * n)
    motion.counters.switch = switch
    with code.if_(switches.transition.clock.exists):
        status = evaluate_jump(motion, t)
        with code.if_(status != 0):
            code.return_(outcome_of(motion, status))
    with code.if_(held[switch] == 0.0):
        code.return_(release_sticking(motion, switch, t))
    with code.if_((jumped >= 0) & (begun <= 0.0)) as case:
        jumped.set(-1)  # round-off: it moves away already
    with case.else_():
        held[switch] = -held[switch]
    with code.if_(rises):
        latch_values(motion, switch, rate)
    with code.if_(jumped >= 0):
        rows.after(n).take(switches.written.after(jumped), switches.free)
    moves = switches.couples_others[switch] != UPDATES
    status = propagate_modes(motion, switch, (jumped >= 0) & moves, t)
    with code.if_(status != 0):
        code.return_(outcome_of(motion, status))
    code.return_if(~finite(motion, 0, 3 * n), Outcome.NOT_FINITE)
    _, behind = ahead(motion, switch)
    with code.if_(held[switch] * behind < -GRAZING * abs(rate)):
        with code.if_(switches.sticks[switch] == 0):
            code.return_if(held[switch] * begun >= 0.0, Outcome.SLIDING)
            code.return_(take_back(motion, switch, t))
        held[switch] = 0.0
        status = code.variable(reevaluate(motion, t))
        with code.if_((status == 0) & (switches.couples_others[switch] != 0)):
            status.set(resolve_modes(motion, switch, False, t))
        with code.if_(status != 0):
            code.return_(outcome_of(motion, status))
        # round-off alone may ask for a little more than holds
        code.return_if(ahead(motion, switch)[0] < -GRAZING, Outcome.SLIDING)
    outcome = record_switch(code, motion, switch, rises, t)
    with code.if_(switches.tangents > 0):
        apply_saltation(motion, switch, rate, jumped)
        reevaluate(motion, t)
    settle(motion)
    with code.for_range(motion.events.number) as event:
        motion.event_values(event).before = math.nan
    return outcome


@traced
def propagate_modes(code: Procedure, motion: Motion, switch: Int, jumps: Bool, t: Real) -> Int:
    """Set the other modes as the state behind a change asks for; returns the kernel's status."""
    status = code.variable(reevaluate(motion, t))
    _, rate = ahead(motion, switch)
    with code.if_((status == 0) & jumps & (rate < 0.0)):  # thrown back
        motion.held[switch] = -1.0
        status.set(reevaluate(motion, t))
    with code.if_(status == 0), code.if_(activate_dependents(motion, switch)):
        status.set(reevaluate(motion, t))
    couples = motion.switches.couples_others[switch] != 0
    with code.if_((status == 0) & (jumps | couples)):
        status.set(resolve_modes(motion, switch, jumps, t))
    return code.value(status)
