"""Jobs as the tables that compiled code reads; see `linkages.solvers.loops.memory`."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.operands import Table
from linkages.solvers.flow import Kernel
from linkages.solvers.job import Job, JobBatch
from linkages.solvers.loops.memory import STEPPER_SIZE, VALUES, WORD, Stepper
from linkages.solvers.loops.row_layout import are_compiled, is_compiled
from linkages.solvers.loops.scalar_stages import Loaded

WATCH_STEP = Loaded("linkages.solvers.loops.crossings", "watch_step")
FIND_SWITCH = Loaded("linkages.solvers.loops.mode_changes", "find_switch")
ESTIMATE_SWITCH = Loaded("linkages.solvers.loops.mode_changes", "estimate_switch")
APPLY_SWITCH = Loaded("linkages.solvers.loops.mode_transitions", "apply_switch")
WATCH_TANGENTS = Loaded("linkages.solvers.loops.renormalised", "watch_tangents")
PROJECT = Loaded("linkages.solvers.loops.mode_transitions", "project")

Entries = dict[str, Any]
"""Entries of a `Table` by their names; of a table that is a part, such a dictionary."""


class Memory:
    """Makes arrays and keeps them alive while compiled code holds their addresses.

    Of `count` motions that are set up together, what is the same for all has one address; of the
    rest there is an array of addresses, one for each motion, in place of an integer. `copies` are
    addresses at which what motions hold is needed beside their kernels, and how much of it.
    """

    def __init__(self, count: int = 1) -> None:
        self.count = count
        self.arrays: list[NDArray] = []
        self.copies: list[tuple[Any, int]] = []
        self.codes: list[object] = []

    def floats(self, values: object) -> int:
        """Address of numbers as float64."""
        return self._keep(np.ascontiguousarray(values, dtype=np.float64))

    def integers(self, values: object) -> int:
        """Address of numbers as int64."""
        return self._keep(np.ascontiguousarray(values, dtype=np.int64))

    def rows(self, array: NDArray) -> Any:
        """Addresses of the rows of an array of 8-byte entries, one for each motion."""
        array = np.ascontiguousarray(array)
        first = self._keep(array)
        return first if self.count == 1 else first + array.strides[0] * np.arange(self.count)

    def zeros(self, *shape: int) -> Any:
        """Addresses of as many zeros for each motion."""
        return self.rows(np.zeros((self.count, *shape)))

    def each(self, arrays: Sequence[NDArray]) -> Any:
        """Addresses of arrays, one for each motion, where they are."""
        return self.own([self._keep(array) for array in arrays])

    def own(self, numbers: Sequence[int]) -> Any:
        """Integers, one for each motion."""
        return numbers[0] if self.count == 1 else np.array(numbers, dtype=np.int64)

    def words(self, entries: Sequence[Any]) -> Any:
        """Addresses of integers, one row of them for each motion, where any may differ."""
        if self.count == 1:
            return self._keep(np.array(entries, dtype=np.int64))
        result = np.empty((self.count, len(entries)), dtype=np.int64)
        for column, entry in enumerate(entries):
            result[:, column] = entry
        return self.rows(result)

    def table(self, kind: type[Table], entries: Entries) -> Any:
        """Addresses of tables, one for each motion; entries that are not given are 0."""
        words: list[Any] = [0] * kind.words()
        for place, entry in _placed(kind, entries):
            words[place] = entry
        return self.words(words)

    def keep(self, code: object) -> None:
        """Keep functions alive as well."""
        self.codes.append(code)

    def _keep(self, array: NDArray) -> int:
        self.arrays.append(array)
        if array.size and array.flags.writeable:  # several times faster than what serves all
            return ctypes.addressof(ctypes.c_char.from_buffer(array.data))
        address: int = array.__array_interface__["data"][0]
        return address


def _placed(kind: type[Table], entries: Entries, first: int = 0) -> Iterator[tuple[int, Any]]:
    for name, entry in entries.items():
        place = first + kind.places()[name]
        if isinstance(entry, dict):
            yield from _placed(kind.kinds()[name], entry, place)
        else:
            yield place, entry


def stepper(jobs: Sequence[Job]) -> NDArray[np.float64]:
    """States of step control before the start, shape (motions, `STEPPER_SIZE`)."""
    result = np.zeros((len(jobs), STEPPER_SIZE))
    begin = [(job.start, job.end, job.rtol, job.times[0]) for job in jobs]
    result[:, [Stepper.t, Stepper.end, Stepper.rtol, Stepper.sample]] = begin
    result[:, Stepper.active] = 1.0
    result[:, Stepper.longest] = [job.flow.longest_step for job in jobs]
    result[:, Stepper.force_scalar] = [is_watched(job) for job in jobs]
    result[:, Stepper.unobserved] = [is_unobserved(job) for job in jobs]
    return result


def is_watched(job: Job) -> bool:
    """Whether something has to look at every step of a motion that generated code does not see."""
    own = job.tangents
    return not (are_compiled(job.events) and (own is None or is_compiled(own)))


def is_unobserved(job: Job) -> bool:
    """Whether nothing looks at a motion, so that generated code takes its samples."""
    return not job.events and job.tangents is None and job.flow.switching is None


def workspace(rows: int, jobs: Sequence[Job]) -> NDArray[np.float64]:
    """Rows as described in `loops.memory.Pointers`, for each job, with its state in row 0."""
    flow = jobs[0].flow
    result = np.zeros((len(jobs), rows, 2 * flow.coordinates + flow.written))
    result[:, 0, : 2 * flow.coordinates] = [job.state for job in jobs]
    return result


def flow_entries(memory: Memory, batch: JobBatch) -> dict[str, Any]:
    """The flows of jobs, with room for what their clocks write."""
    jobs, first = batch.jobs, batch.jobs[0]
    flow, parameters = first.flow, memory.each([job.parameters for job in jobs])
    return {
        "clock": flow.clock,
        "rates": flow.rates,
        "parameters": parameters,
        "timed": memory.zeros(flow.timed_size),
        # what is held stands behind the parameters proper
        "held": parameters + WORD * (len(first.parameters) - flow.held),
        "scale": memory.rows(np.array([job.flow.margin_scale for job in jobs])),
        "smallest": memory.rows(np.array([job.flow.smallest_margins for job in jobs])),
        "ahead": memory.zeros(flow.counted),
        "rotates": memory.integers(flow.rotates),
        "n": flow.coordinates,
        "blocks": len(flow.margin_scale),
        "first_carried": flow.first_carried,
        "carried": flow.carried,
        "counted": flow.counted,
        "holding": flow.held,
    }


def control_entries(memory: Memory, batch: JobBatch) -> dict[str, Any]:
    """How long the steps of jobs are, and for how many of them they go on."""
    jobs = batch.jobs
    counts = [job.equal_steps for job in jobs]
    spans = [(job.end - job.start) / max(1, count) for job, count in zip(jobs, counts, strict=True)]
    grid = [(job.start, span, 0.0) for job, span in zip(jobs, spans, strict=True)]
    return {
        "atol": memory.rows(np.array([job.atol for job in jobs])),
        "backward": memory.own([job.end < job.start for job in jobs]),
        "budget": memory.own([job.max_steps for job in jobs]),
        "equal": memory.own(counts),
        "grid": memory.rows(np.array(grid)),
    }


def record_entries(memory: Memory, batch: JobBatch) -> dict[str, Any]:
    """Where the results of jobs go."""
    jobs, samples = batch.jobs, len(batch.jobs[0].times)
    times = np.empty((len(jobs), samples + 1))
    times[:, :-1] = [job.times for job in jobs]
    # generated code reads the time of the next sample behind the last one, too
    times[:, -1] = [math.copysign(math.inf, job.end - job.start) for job in jobs]
    names = {
        "states": "states",
        "sampled_turns": "turns",
        "accelerations": "accelerations",
        "sampled": "angles",
        "sampled_held": "held",
        "turns": "final_turns",
        "angles": "final_angles",
        "counters": "counters",
        "control": "control",
    }
    own = {entry: memory.rows(batch.arrays[name]) for entry, name in names.items()}
    return {"samples": samples, "times": memory.rows(times), **own}


def kernel_entries(
    memory: Memory, jobs: Sequence[Job], kernels: Sequence[Kernel | None]
) -> dict[str, Any]:
    """What each job watches, and where that has its numbers."""
    first = kernels[0]
    if first is None:
        return dict.fromkeys(("clock", "rates", "parameters", "timed"), 0)
    own = [job.holding(f) for job, f in zip(jobs, kernels, strict=True) if f is not None]
    parameters = memory.each(own)
    if first.held:
        held = parameters + WORD * (len(first.parameters) - first.held)
        memory.copies.append((held, first.held))
    timed = memory.zeros(first.timed_size)
    return {"clock": first.clock, "rates": first.rates, "parameters": parameters, "timed": timed}


def event_entries(memory: Memory, batch: JobBatch) -> dict[str, Any]:
    """The events of jobs."""
    jobs, logs = batch.jobs, [job.log for job in batch.jobs]
    count = len(logs[0].events)
    if not count:
        return {}
    watched = [[job.events[event].function for job in jobs] for event in range(count)]
    functions = [place for own in watched for place in kernel_entries(memory, jobs, own).values()]
    levels, directions, terminals = (
        memory.rows(
            np.array([[kind(getattr(event, name)) for event in log.events] for log in logs])
        )
        for name, kind in (("level", float), ("direction", int), ("terminal", int))
    )
    written = ("found", "time", "state", "turns", "angles", "held")
    own = {
        "watch": WATCH_STEP.address,
        "number": count,
        "weights": memory.rows(np.array([log.weights for log in logs])),
        "period": memory.rows(np.array([log.periods for log in logs])),
        "direction": directions,
        "terminal": terminals,
        "first": memory.integers(logs[0].first),
        **{name: memory.each([getattr(log, name) for log in logs]) for name in written},
    }
    values = memory.rows(np.full((len(jobs), count, VALUES), np.nan))
    return {
        "functions": memory.words(functions), "values": values, "levels": levels, "events": own,
    }  # fmt: skip


def switch_entries(memory: Memory, batch: JobBatch, compared: Sequence[int]) -> dict[str, Any]:
    """What finds and makes changes of modes, behind `event_entries`, which leaves its copies."""
    jobs, flow = batch.jobs, batch.jobs[0].flow
    own = flow.switching
    if own is None:
        return {}
    logs = [job.changes for job in jobs]
    switchings = [job.flow.switching for job in jobs]
    becoming = [None if each is None else each.transition for each in switchings]
    transition = kernel_entries(memory, jobs, becoming)
    written = ("found", "noted", "time", "which", "rises", "state", "turns", "held")
    listed = ("active", "owners", "jumps", "sticks", "couples_others")
    switches = {
        "find": FIND_SWITCH.address,
        "estimate": ESTIMATE_SWITCH.address,
        "apply": APPLY_SWITCH.address,
        "modes": len(own.names),
        "memories": len(own.owners),
        "tangents": own.tangents,
        "free": own.free,
        "values": own.values,
        **{name: memory.integers(getattr(own, name)) for name in listed},
        "transition": transition,
        "written": memory.zeros(own.written),
        "before": memory.zeros(3 * flow.coordinates),
        "copies": memory.words([word for copy in memory.copies for word in copy]),
        "copied": len(memory.copies),
        "pending": memory.zeros(2),
        "last": memory.zeros(1),
        "first_steps": memory.zeros(2 * len(own.names)),
        "rows": memory.integers(compared),
        "compared": len(compared),
        "since": memory.rows(np.array([[job.start] for job in jobs])),
        "capacity": len(logs[0].time),
        **{name: memory.each([getattr(log, name) for log in logs]) for name in written},
        "constraints": len(own.constraints),
        "holders": memory.integers(own.constraints),
    }
    return {"switches": switches}


def tangent_entries(memory: Memory, batch: JobBatch, held: Any) -> dict[str, Any]:
    """What renormalises the tangents of jobs; `held` is the address of what these hold."""
    first, plans = batch.jobs[0], [job.tangents for job in batch.jobs]
    if first.tangents is None:
        return {}
    own, size, columns = first.flow.switching, first.tangents.size, first.tangents.columns
    tangents = {
        "watch": WATCH_TANGENTS.address,
        "project": PROJECT.address if own is not None and own.constrains else 0,
        "size": size,
        "placed": first.tangents.placed,
        "columns": columns,
        "every": memory.own([plan.every for plan in plans if plan]),
        "offset": memory.own([plan.offset for plan in plans if plan]),
        "orthogonal": int(first.tangents.orthogonal),
        "seen": memory.zeros(1),
        "lengths": memory.rows(batch.arrays["lengths"]),
        "grown": memory.rows(batch.arrays["grown"]),
        "copy": memory.zeros(2 * columns * size),
        "tolerances": memory.rows(np.array([(job.rtol, job.atol[-1]) for job in batch.jobs])),
        "memories": 0 if own is None else len(own.owners),
        "moved": held + (0 if own is None else WORD * (len(own.names) + len(own.owners))),
    }
    return {"tangents": tangents}
