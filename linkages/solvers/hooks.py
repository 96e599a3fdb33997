"""What watches the steps of a job: its events, and its modes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from linkages.solvers.arrays import Memory
from linkages.solvers.flow import Companion
from linkages.solvers.job import Job
from linkages.solvers.steps.loaded import Loaded
from linkages.solvers.steps.views import (
    HALVED,
    WORD,
    Events,
    Hook,
    Record,
    SwitchesView,
    SwitchingView,
    SystemView,
    TableView,
)

WATCH_STEP = Loaded("linkages.solvers.watched.crossings", "watch_step")
LOOK = Loaded("linkages.solvers.watched.switches", "look")
GUESS = Loaded("linkages.solvers.watched.switches", "guess")
CHANGE = Loaded("linkages.solvers.loops.transitions", "change")


def events(memory: Memory, job: Job) -> Events | None:
    """The events of a job, if it has any."""
    log = job.log
    if not log.events:
        return None
    return Events(
        events=len(log.events),
        weights=memory.floats(log.weights),
        functions=memory.integers([_function(memory, job, event.function) for event in log.events]),
        values=memory.floats(np.full((len(log.events), 5), np.nan)),
        level=memory.floats([event.level for event in log.events]),
        period=memory.floats(log.periods),
        direction=memory.integers([event.direction for event in log.events]),
        terminal=memory.integers([event.terminal for event in log.events]),
        first=memory.integers(log.first),
        found=memory.integers(log.found),
        time=memory.floats(log.time),
        state=memory.floats(log.state),
        turns=memory.integers(log.turns),
        angles=memory.floats(log.angles),
        held=memory.floats(log.held),
    )


def hook(
    memory: Memory, found: Events | None, system: SystemView, table: TableView, record: Record
) -> Hook:
    """What watches the steps of a job for its events; nothing where it has none."""
    if found is None:
        return Hook(0, 0)
    context = memory.integers([*system, *table, *record, *found])
    return Hook(WATCH_STEP.address, context)


def _function(memory: Memory, job: Job, function: Companion | None) -> list[int]:
    """Addresses of what an event watches."""
    if function is None:
        return [0, 0, 0, 0]
    parameters = memory.floats(job.holding(function))
    if function.held:
        first = WORD * (len(function.parameters) - function.held)
        memory.copies.append((parameters + first, function.held))
    timed = memory.floats(np.zeros(function.timed_size))
    return [function.clock, function.rates, parameters, timed]


def switching(
    memory: Memory,
    job: Job,
    found: Events | None,
    system: SystemView,
    table: TableView,
    record: Record,
    compared: Sequence[int],
) -> SwitchingView:
    """What finds and makes changes of modes; nothing where there are none."""
    own = job.flow.switching
    if own is None:
        return SwitchingView(0, 0, 0, 0, 0, 0)
    changes, n = job.changes, job.flow.coordinates
    # events have left their copies there
    transition = _function(memory, job, own.transition)
    switches = SwitchesView(
        modes=len(own.names),
        memories=len(own.owners),
        tangents=own.tangents,
        free=own.free,
        values=own.values,
        active=memory.integers(own.active),
        owners=memory.integers(own.owners),
        jumps=memory.integers(own.jumps),
        sticks=memory.integers(own.sticks),
        shakes=memory.integers(own.shakes),
        transition=memory.integers(transition),
        written=memory.floats(np.zeros(own.written)),
        before=memory.floats(np.zeros(3 * n)),
        copies=memory.integers(memory.copies),
        copied=len(memory.copies),
        events=0 if found is None else found.events,
        values_of_events=0 if found is None else found.values,
        pending=memory.integers(np.zeros(2)),
        kind=memory.integers(np.zeros(1)),
        halved=system.pace + WORD * HALVED,
        rows=memory.integers(compared),
        compared=len(compared),
        since=memory.floats([job.start]),
        capacity=len(changes.time),
        found=memory.integers(changes.found),
        noted=memory.integers(changes.noted),
        time=memory.floats(changes.time),
        which=memory.integers(changes.which),
        rises=memory.integers(changes.rises),
        state=memory.floats(changes.state),
        turns=memory.integers(changes.turns),
        held=memory.floats(changes.held),
    )
    context = memory.integers([*system, *table, *record, *switches])
    first_steps = memory.floats(np.zeros(2 * len(own.names)))
    return SwitchingView(
        LOOK.address, GUESS.address, CHANGE.address, context, switches.kind, first_steps
    )
