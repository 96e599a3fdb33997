"""Integrate many flows: those with the same functions side by side."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from typing import TypeGuard

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.machine import has_wide_registers
from linkages.solvers import arrays
from linkages.solvers.device_motions import accelerator
from linkages.solvers.integration import IntegrationRequest, supervise
from linkages.solvers.job import Job, make_batches
from linkages.solvers.loops.explicit_steps import compiled_step
from linkages.solvers.loops.memory import WORD, Counters, Lanes, Progress, Sampling
from linkages.solvers.loops.row_layout import entries_of_motion
from linkages.solvers.loops.scalar_stages import Loaded
from linkages.solvers.method import BEGIN_MOTION, CONCLUDE_STEP, Method, RungeKutta
from linkages.solvers.trajectory import Event, Outcome, Trajectory

LOGGER = logging.getLogger(__name__)

LANES = 8
"""Motions side by side: two registers of 256 bits, or one of 512. No bit depends on it."""

MORE_LANES = 16
"""The same where registers have 512 bits, the motions are many, and no tangents go along: more
instructions are under way at a time, which gains a tenth. With tangents registers run short."""

LINE = 64
"""Bytes; arrays of lanes begin at multiples of it."""

ADVANCE_LANES = Loaded("linkages.solvers.loops.lane_loop", "advance_lanes")
SAMPLE_LANES = Loaded("linkages.solvers.loops.lane_loop", "sample_lanes")


def integrate_many(
    requests: Sequence[IntegrationRequest],
    lanes: int | None = None,
    watch: Callable[[float], None] | None = None,
) -> list[Trajectory]:
    """Integrate what is asked for; each trajectory is equal, in all bits, to that of it alone.

    `lanes` are motions side by side. `watch` is called about 20 times a second with the fraction of
    the motions that have ended.
    """
    groups: dict[tuple[object, ...], list[int]] = {}
    for index, asked in enumerate(requests):
        alone = () if _is_wide(asked.method, asked.job) and lanes != 1 else (index,)
        key = (
            asked.method.name,
            asked.job.flow.clock,
            asked.job.layout,
            *(event.function and event.function.clock for event in asked.job.events),
        )
        groups.setdefault((*key, *alone), []).append(index)
    outcomes = [Outcome.INTERRUPTED] * len(requests)
    ended = 0
    for group in groups.values():
        method, jobs = requests[group[0]].method, [requests[index].job for index in group]

        def look(running: float, ended: int = ended) -> None:
            if watch is not None:
                watch((ended + running) / len(requests))

        card = accelerator()
        if card is not None and isinstance(method, RungeKutta) and card.takes(method, jobs):
            result, interrupted = card.run(method, jobs, look)
        else:
            make_batches(jobs)
            result, interrupted = _run(method, jobs, lanes or _suitable(jobs), look)
        ended += len(group)
        for index, outcome in zip(group, result, strict=True):
            outcomes[index] = outcome
        if interrupted:
            break
    return [a.trajectory(outcome) for a, outcome in zip(requests, outcomes, strict=True)]


def _is_wide(method: Method, job: Job) -> TypeGuard[RungeKutta]:
    """Whether a job can be integrated beside others."""
    events = all(event.function is None or event.function.wide for event in job.events)
    return isinstance(method, RungeKutta) and job.step is None and bool(job.flow.wide) and events


def _suitable(jobs: Sequence[Job]) -> int:
    """Number of lanes for jobs of the same functions."""
    many = len(jobs) >= MORE_LANES * LANES
    return MORE_LANES if many and jobs[0].tangents is None and has_wide_registers() else LANES


def _run(
    method: Method, jobs: Sequence[Job], lanes: int, look: Callable[[float], None]
) -> tuple[list[Outcome], bool]:
    """Run jobs of the same functions; returns also whether Ctrl-C was pressed."""
    if len(jobs) == 1 or not isinstance(method, RungeKutta):
        job = jobs[0]
        result, interrupted = supervise(method.prepare(job), job.stop, lambda: look(job.fraction))
        return [Outcome.INTERRUPTED if interrupted else Outcome(result)], interrupted
    memory = arrays.Memory()
    batches = {batch: method.motions(batch) for batch in dict.fromkeys(job.batch for job in jobs)}
    motions = [batches[job.batch][job.row] for job in jobs]
    outcomes = np.full(len(jobs), Outcome.INTERRUPTED, dtype=np.int64)
    control = np.zeros(3)
    addresses = [motion.address for motion in motions]
    view = _lanes(memory, method, jobs, addresses, lanes, outcomes, control)

    def stop() -> None:
        control[Progress.stop] = 1.0

    spent, interrupted = supervise(
        lambda: ADVANCE_LANES(view), stop, lambda: look(control[Progress.now])
    )
    made = sum(int(job.counters[Counters.steps] + job.counters[Counters.rejected]) for job in jobs)
    LOGGER.info(
        "%d motions in %d lanes: %d steps tried, %.3f of the lanes in use, %d steps alone",
        len(jobs), lanes, made, made / max(1, spent), control[Progress.scalar_steps],
    )  # fmt: skip
    for job, motion in zip(jobs, motions, strict=True):
        np.copyto(job.state, motion.rows[0, : len(job.state)])
    return [Outcome(int(outcome)) for outcome in outcomes], interrupted


def _lanes(
    memory: arrays.Memory,
    method: RungeKutta,
    jobs: Sequence[Job],
    motions: Sequence[int],
    lanes: int,
    outcomes: NDArray[np.int64],
    control: NDArray[np.float64],
) -> int:
    """Address of `Lanes`: room for motions side by side, and what steps in it."""
    flow, tableau = jobs[0].flow, method.tableau
    layout = jobs[0].layout
    assert flow.wide is not None
    wide = flow.wide(lanes)
    code = compiled_step(tableau, layout, method.memory, lanes)
    memory.keep(code)
    memory.keep(wide)
    sizes = {
        "parameters": len(jobs[0].parameters),
        "timed": flow.timed_size,
        "rows": (len(tableau.extended_c) + 1) * layout.width,
        **entries_of_motion(layout),
    }
    room = {name: memory.floats(_aligned(size * lanes)) for name, size in sizes.items()}
    functions = [_function(memory, event, lanes) for event in jobs[0].events[: layout.events]]
    entries = {
        "clock": wide.clock,
        "rates": wide.rates,
        **room,
        "held": room["parameters"] + WORD * lanes * (sizes["parameters"] - flow.held),
        "functions": memory.integers([places for places, _ in functions]),
        "sampler": SAMPLE_LANES.address,
        "lanes": lanes,
        "size": sizes["parameters"],
        "events": layout.events,
        "function_sizes": memory.integers([size for _, size in functions]),
        **{name: code.address(name) for name in ("advance", "further", "between")},
        "sampling": memory.integers(np.zeros(len(Sampling.entries()) * lanes)),
        "begin": BEGIN_MOTION.address,
        "conclude": CONCLUDE_STEP.address,
        "motions": memory.integers(motions),
        "number": len(jobs),
        "outcomes": memory.integers(outcomes),
        "occupants": memory.integers(np.full(lanes, -1)),
        "control": memory.floats(control),
    }
    return int(memory.table(Lanes, entries))


def _function(memory: arrays.Memory, event: Event, lanes: int) -> tuple[list[int], int]:
    """Addresses of what an event of some lanes watches, and how many parameters it has."""
    assert event.function is not None
    assert event.function.wide is not None
    wide = event.function.wide(lanes)
    memory.keep(wide)
    size = len(wide.parameters)
    room = [memory.floats(_aligned(n * lanes)) for n in (size, wide.timed_size)]
    return [wide.clock, wide.rates, *room], size


def _aligned(size: int) -> NDArray[np.float64]:
    """Zeros from the begin of a line of the cache on."""
    room = np.zeros(size + LINE // 8)
    first = (-room.ctypes.data % LINE) // 8
    return room[first : first + size]
