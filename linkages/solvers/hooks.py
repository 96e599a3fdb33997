"""What watches the steps of jobs: their events, and their modes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from linkages.solvers.arrays import Memory
from linkages.solvers.flow import Companion
from linkages.solvers.job import Job, Room
from linkages.solvers.steps.loaded import Loaded
from linkages.solvers.steps.views import (
    HALVED,
    VALUES,
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


def events(memory: Memory, room: Room) -> Events | None:
    """The events of jobs, if they have any."""
    jobs, logs = room.jobs, [job.log for job in room.jobs]
    count = len(logs[0].events)
    if not count:
        return None
    watched = [[job.events[event].function for job in jobs] for event in range(count)]
    functions = [place for own in watched for place in _function(memory, jobs, own)]
    values = np.full((len(jobs), count, VALUES), np.nan)
    levels = np.array([[float(event.level) for event in log.events] for log in logs])
    directions, terminals = (
        np.array([[getattr(event, name) for event in log.events] for log in logs])
        for name in ("direction", "terminal")
    )
    return Events(
        events=count,
        weights=memory.rows(np.array([log.weights for log in logs])),
        functions=memory.words(functions),
        values=memory.rows(values),
        level=memory.rows(levels),
        period=memory.rows(np.array([log.periods for log in logs])),
        direction=memory.rows(directions),
        terminal=memory.rows(terminals),
        first=memory.integers(logs[0].first),
        found=memory.each([log.found for log in logs]),
        time=memory.each([log.time for log in logs]),
        state=memory.each([log.state for log in logs]),
        turns=memory.each([log.turns for log in logs]),
        angles=memory.each([log.angles for log in logs]),
        held=memory.each([log.held for log in logs]),
    )


def hook(
    memory: Memory, found: Events | None, system: SystemView, table: TableView, record: Record
) -> Hook:
    """What watches the steps of jobs for their events; nothing where they have none."""
    if found is None:
        return Hook(0, 0)
    context = memory.words([*system, *table, *record, *found])
    return Hook(WATCH_STEP.address, context)


def _function(
    memory: Memory, jobs: Sequence[Job], functions: Sequence[Companion | None]
) -> list[Any]:
    """Addresses of what each job watches, and where that has its numbers."""
    first = functions[0]
    if first is None:
        return [0, 0, 0, 0]
    own = [job.holding(f) for job, f in zip(jobs, functions, strict=True) if f is not None]
    parameters = memory.each(own)
    if first.held:
        held = parameters + WORD * (len(first.parameters) - first.held)
        memory.copies.append((held, first.held))
    return [first.clock, first.rates, parameters, memory.zeros(first.timed_size)]


def switching(
    memory: Memory,
    room: Room,
    found: Events | None,
    system: SystemView,
    table: TableView,
    record: Record,
    compared: Sequence[int],
) -> SwitchingView:
    """What finds and makes changes of modes; nothing where there are none."""
    jobs, flow = room.jobs, room.jobs[0].flow
    own = flow.switching
    if own is None:
        return SwitchingView(0, 0, 0, 0, 0, 0)
    logs = [job.changes for job in jobs]
    switchings = [job.flow.switching for job in jobs]
    becoming = [None if each is None else each.transition for each in switchings]
    # events have left their copies there
    transition = _function(memory, jobs, becoming)
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
        transition=memory.words(transition),
        written=memory.zeros(own.written),
        before=memory.zeros(3 * flow.coordinates),
        copies=memory.words([word for copy in memory.copies for word in copy]),
        copied=len(memory.copies),
        events=0 if found is None else found.events,
        values_of_events=0 if found is None else found.values,
        pending=memory.zeros(2),
        kind=memory.zeros(1),
        halved=system.pace + WORD * HALVED,
        rows=memory.integers(compared),
        compared=len(compared),
        since=memory.rows(np.array([[job.start] for job in jobs])),
        capacity=len(logs[0].time),
        found=memory.each([log.found for log in logs]),
        noted=memory.each([log.noted for log in logs]),
        time=memory.each([log.time for log in logs]),
        which=memory.each([log.which for log in logs]),
        rises=memory.each([log.rises for log in logs]),
        state=memory.each([log.state for log in logs]),
        turns=memory.each([log.turns for log in logs]),
        held=memory.each([log.held for log in logs]),
        constraints=len(own.constraints),
        holders=memory.integers(own.constraints),
    )
    context = memory.words([*system, *table, *record, *switches])
    first_steps = memory.zeros(2 * len(own.names))
    return SwitchingView(
        LOOK.address, GUESS.address, CHANGE.address, context, switches.kind, first_steps
    )
