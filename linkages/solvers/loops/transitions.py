"""Make the change of a mode at the time at which it was located; compiled with the first of them.

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

from linkages.solvers.loops.commit import CHATTER, DIVERGED, DONE, SLIDING, outcome_of, settle
from linkages.solvers.steps.compiled import (
    call_clock,
    call_rates,
    compiled,
    floats,
    integers,
)
from linkages.solvers.steps.stages import evaluate, finite, set_clock
from linkages.solvers.steps.turns import wrap_angles
from linkages.solvers.steps.views import EVALUATIONS, SWITCH, WORD, Record, SwitchesView, SystemView
from linkages.solvers.watched.switches import (
    RECORD_WORDS,
    SYSTEM_WORDS,
    TABLE_WORDS,
    functions_of,
    record_at,
    switches_at,
    system_at,
)

# A rate behind a change that is this small beside that before is zero: the motion touches.
GRAZING = 1e-9
# So many changes within this part of the time until then, and time goes on no more.
CHANGES, SPAN = 100, 1e-10


@compiled
def spread(system: SystemView, switches: SwitchesView) -> None:
    """Write what is held now wherever it is needed beside the kernel itself."""
    copies, held = integers(switches.copies), floats(system.held)
    for k in range(switches.copied):
        target = floats(copies[2 * k])
        for i in range(copies[2 * k + 1]):
            target[i] = held[i]


@compiled
def arrive_at(system: SystemView, switches: SwitchesView, record: Record, t: float) -> int:
    """Evaluate row 0 with what is held now; returns the status of the kernel."""
    spread(system, switches)
    integers(record.counters)[EVALUATIONS] += 1
    status = set_clock(system, t)
    return evaluate(system, 0) if status == 0 else status


@compiled
def new_values(system: SystemView, switches: SwitchesView, t: float) -> int:
    """Compute what becomes of the state in row 0."""
    spread(system, switches)
    functions = integers(switches.transition)
    status = call_clock(functions[0], t, functions[2], functions[3])
    if status == 0:
        status = call_rates(functions[1], system.rows, functions[2], functions[3], switches.written)
    return status


@compiled
def shift(switches: SwitchesView, switch: int, column: int, rate: float) -> float:
    """How much later a neighbour in the direction of a tangent meets the change."""
    if rate == 0.0:
        return 0.0
    first = switches.values * (2 + switches.tangents)
    moved = floats(switches.written)[first + switch * switches.tangents + column]
    return -moved / rate


@compiled
def remember(system: SystemView, switches: SwitchesView, switch: int, rate: float) -> None:
    """Renew what is remembered from a rise, with its tangents."""
    held, written = floats(system.held), floats(switches.written)
    owners, first = integers(switches.owners), switches.modes
    count, columns = switches.memories, switches.tangents
    for r in range(count):
        if owners[r] != switch:
            continue
        held[first + r] = written[r]
        for c in range(columns):
            moved = written[2 * switches.values + r * columns + c]
            moved += written[switches.values + r] * shift(switches, switch, c, rate)
            held[first + count + c * count + r] = moved


@compiled
def wake(system: SystemView, switches: SwitchesView, switch: int, forward: float) -> bool:
    """Set modes that are watched only while another one is +1, in the end this one; whether any.

    Row 0 has been evaluated with the other one. A mode stands behind the one that it depends on.
    """
    held, active = floats(system.held), integers(switches.active)
    functions = floats(functions_of(system, switches.modes, 0))
    any_of_them = False
    for k in range(switches.modes):
        owner = active[k]
        while owner >= 0 and owner != switch:
            owner = active[owner]
        if owner == switch:
            any_of_them = True
            value, rate = functions[k], forward * functions[switches.modes + k]
            on = value > 0.0 or (value == 0.0 and rate >= 0.0)
            held[k] = 1.0 if held[active[k]] > 0.0 and on else -1.0
    return any_of_them


@compiled
def rethink(
    system: SystemView,
    switches: SwitchesView,
    record: Record,
    switch: int,
    forward: float,
    t: float,
    jumped: bool,
) -> int:
    """Set the modes of functions whose values have jumped; returns the kernel's status.

    One mode after the other, for other functions may depend on it; those that stuck stick no more
    if rates have jumped. Modes with jumps of their own wait for their functions to rise.
    """
    held, active = floats(system.held), integers(switches.active)
    functions, status = floats(functions_of(system, switches.modes, 0)), 0
    for _ in range(2 * switches.modes):
        found = -1
        for k in range(switches.modes):
            watched = active[k] < 0 or held[active[k]] > 0.0
            if k == switch or integers(switches.jumps)[k] >= 0 or not watched:
                continue
            if held[k] == 0.0 and not jumped:
                continue
            if held[k] == 0.0:
                held[k] = 1.0
                status = arrive_at(system, switches, record, t)
            value, rate = functions[k], forward * functions[switches.modes + k]
            if held[k] * value < 0.0 or (value == 0.0 and held[k] * rate < 0.0):
                found = k
                break
        if found < 0 or status != 0:
            return status
        held[found] = -held[found]
        status = arrive_at(system, switches, record, t)
        if status == 0 and wake(system, switches, found, forward):
            status = arrive_at(system, switches, record, t)
        if status != 0:
            return status
    return status


@compiled
def cross_tangents(
    system: SystemView, switches: SwitchesView, switch: int, rate: float, jumped: int
) -> None:
    """Lead tangents across the change, from the state before to that in row 0."""
    n, free, columns = system.n, switches.free, switches.tangents
    rows, before, written = floats(system.rows), floats(switches.before), floats(switches.written)
    values = switches.values
    for c in range(columns):
        later = shift(switches, switch, c, rate)
        first = n - (columns - c) * free
        for i in range(free):
            rows[first + i] += (before[n + i] - rows[n + i]) * later
            if jumped >= 0:
                value = jumped + i
                moved = written[2 * values + value * columns + c]
                moved += written[values + value] * later
                rows[n + first + i] = moved - rows[2 * n + i] * later
            else:
                rows[n + first + i] += (before[2 * n + i] - rows[2 * n + i]) * later


@compiled
def note_change(
    system: SystemView, switches: SwitchesView, record: Record, switch: int, rises: bool, t: float
) -> None:
    """Record a change with the state before it."""
    n, noted = system.n, integers(switches.noted)
    integers(switches.found)[switch] += 1
    place = noted[0]
    noted[0] += 1
    if place >= switches.capacity:
        return
    floats(switches.time)[place] = t
    integers(switches.which)[place] = switch
    integers(switches.rises)[place] = int(rises)
    state = switches.state + WORD * place * 2 * n
    for i in range(2 * n):
        floats(state)[i] = floats(switches.before)[i]
    wrap_angles(system, state, record.final_turns, switches.turns + WORD * place * n)
    for i in range(system.holding):
        floats(switches.held)[place * system.holding + i] = floats(system.held)[i]


@compiled
def chatters(switches: SwitchesView, t: float) -> bool:
    """Whether modes change all the time while time hardly goes on."""
    row, since = integers(switches.pending), floats(switches.since)
    if abs(t - since[0]) > SPAN * abs(t):
        since[0] = t
        row[1] = 0
    row[1] += 1
    return row[1] > CHANGES


@compiled
def release(
    system: SystemView,
    switches: SwitchesView,
    record: Record,
    switch: int,
    forward: float,
    t: float,
) -> int:
    """Leave the zero of a function on which the motion has stuck; returns an `Outcome`."""
    held = floats(system.held)
    functions = floats(functions_of(system, switches.modes, 0))
    held[switch] = -1.0
    status = arrive_at(system, switches, record, t)
    down = -forward * functions[switches.modes + switch]
    held[switch] = 1.0
    if status == 0:
        status = arrive_at(system, switches, record, t)
    if status == 0 and forward * functions[switches.modes + switch] < down:
        held[switch] = -1.0
        status = arrive_at(system, switches, record, t)
    if status != 0:
        return outcome_of(record, status)
    settle(system)
    note_change(system, switches, record, switch, held[switch] > 0.0, t)
    if chatters(switches, t):
        return CHATTER
    integers(record.counters)[SWITCH] = -1
    return DONE


@compiled
def change(context: int, t: float, h: float, t_end: float) -> float:  # noqa: ARG001
    """Change the mode that `look` has found, at the state in row 0; returns an `Outcome`."""
    system = system_at(context)
    record = record_at(context + WORD * (SYSTEM_WORDS + TABLE_WORDS))
    switches = switches_at(context + WORD * (SYSTEM_WORDS + TABLE_WORDS + RECORD_WORDS))
    n, rows, held = system.n, floats(system.rows), floats(system.held)
    switch = integers(switches.pending)[0]
    forward = 1.0 if h >= 0.0 else -1.0
    functions = floats(functions_of(system, switches.modes, 0))
    rate = functions[switches.modes + switch]
    rises = held[switch] < 0.0
    integers(switches.kind)[0] = 2 * switch + int(rises)
    jumped = integers(switches.jumps)[switch] if rises else -1
    for i in range(3 * n):
        floats(switches.before)[i] = rows[i]
    integers(record.counters)[SWITCH] = switch
    if integers(switches.transition)[0] != 0:
        status = new_values(system, switches, t_end)
        if status != 0:
            return outcome_of(record, status)
    if held[switch] == 0.0:
        return release(system, switches, record, switch, forward, t_end)
    if jumped >= 0 and forward * rate <= 0.0:
        jumped = -1  # round-off: it moves away already
    else:
        held[switch] = -held[switch]
    if rises:
        remember(system, switches, switch, rate)
    if jumped >= 0:
        for i in range(switches.free):
            rows[n + i] = floats(switches.written)[jumped + i]
    status = arrive_at(system, switches, record, t_end)
    if status == 0 and jumped >= 0 and forward * functions[switches.modes + switch] < 0.0:
        # thrown back
        held[switch] = -1.0
        status = arrive_at(system, switches, record, t_end)
    if status == 0 and wake(system, switches, switch, forward):
        status = arrive_at(system, switches, record, t_end)
    shakes = integers(switches.shakes)[switch] != 0
    if status == 0 and (jumped >= 0 or shakes):
        status = rethink(system, switches, record, switch, forward, t_end, jumped >= 0)
    if status != 0:
        return outcome_of(record, status)
    if not finite(system, 0, 3 * n):
        return DIVERGED
    behind = forward * held[switch] * functions[switches.modes + switch]
    if behind < -GRAZING * abs(rate):
        if integers(switches.sticks)[switch] == 0:
            return SLIDING
        held[switch] = 0.0
        status = arrive_at(system, switches, record, t_end)
        if status == 0 and shakes:
            status = rethink(system, switches, record, switch, forward, t_end, False)
        if status != 0:
            return outcome_of(record, status)
        if functions[switch] < -GRAZING:  # round-off alone may ask for a little more than holds
            return SLIDING
    note_change(system, switches, record, switch, rises, t_end)
    if chatters(switches, t_end):
        return CHATTER
    if switches.tangents > 0:
        cross_tangents(system, switches, switch, rate, jumped)
        arrive_at(system, switches, record, t_end)
    settle(system)
    for event in range(switches.events):
        floats(switches.values_of_events)[5 * event + 2] = math.nan
    integers(record.counters)[SWITCH] = -1
    return 0.0
