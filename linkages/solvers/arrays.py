"""Tableau, flows and jobs as the addresses and sizes that the compiled loops take."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.solvers.flow import Flow
from linkages.solvers.job import Job, JobBatch
from linkages.solvers.loops.memory import (
    ACTIVE,
    END,
    FORCE_SCALAR,
    POINTERS,
    RTOL,
    SAMPLE,
    SEVERAL,
    STEPPER_SIZE,
    UNOBSERVED,
    WORD,
    Control,
    Events,
    Record,
    SwitchingView,
    SystemView,
    T,
    TableView,
    Tangents,
)
from linkages.solvers.loops.row_layout import are_compiled, is_compiled
from linkages.solvers.loops.scalar_stages import Loaded
from linkages.solvers.tableau import Collocation, Tableau

WATCH_TANGENTS = Loaded("linkages.solvers.loops.renormalised", "watch_tangents")
PROJECT = Loaded("linkages.solvers.loops.mode_transitions", "project")


class Memory:
    """Makes arrays and keeps them alive while compiled code holds their addresses.

    Parameters
    ----------
    count
        Number of motions that are set up together. What is the same for all of them has one
        address; of what is not there is an array of addresses, one for each motion, which stands
        where a single motion has an integer.

    Attributes
    ----------
    copies
        Addresses at which what motions hold is needed beside their kernels, and how much of it.
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

    def table(self, entries: Sequence[Any]) -> NDArray[np.int64]:
        """Rows of integers, one for each motion, of which any may differ from motion to motion."""
        table = np.empty((self.count, len(entries)), dtype=np.int64)
        for column, entry in enumerate(entries):
            table[:, column] = entry
        return table

    def words(self, entries: Sequence[Any]) -> Any:
        """Their addresses."""
        return self.integers(entries) if self.count == 1 else self.rows(self.table(entries))

    def keep(self, code: object) -> None:
        """Keep functions alive as well."""
        self.codes.append(code)

    def _keep(self, array: NDArray) -> int:
        self.arrays.append(array)
        if array.size and array.flags.writeable:  # several times faster than what serves all
            return ctypes.addressof(ctypes.c_char.from_buffer(array.data))
        address: int = array.__array_interface__["data"][0]
        return address


def stepper(jobs: Sequence[Job]) -> NDArray[np.float64]:
    """States of step control before the start, shape (motions, `STEPPER_SIZE`)."""
    result = np.zeros((len(jobs), STEPPER_SIZE))
    begin = [(job.start, job.end, job.rtol, job.times[0]) for job in jobs]
    result[:, [T, END, RTOL, SAMPLE]] = begin
    result[:, ACTIVE] = 1.0
    result[:, FORCE_SCALAR] = [is_watched(job) for job in jobs]
    result[:, UNOBSERVED] = [is_unobserved(job) for job in jobs]
    return result


def is_watched(job: Job) -> bool:
    """Whether something has to look at every step of a motion that generated code does not see."""
    own = job.tangents
    return not (are_compiled(job.events) and (own is None or is_compiled(own)))


def is_unobserved(job: Job) -> bool:
    """Whether nothing looks at a motion, so that generated code takes its samples."""
    return not job.events and job.tangents is None and job.flow.switching is None


def system(
    memory: Memory,
    batch: JobBatch,
    rows: NDArray[np.float64],
    stepper: NDArray[np.float64],
    functions: Mapping[str, int],
    record: Record,
    events: Events | None = None,
    collocation: Any = 0,
) -> SystemView:
    """Addresses and numbers of the flows of jobs, with room for what their clocks write.

    Workspaces have shape (motions, rows, width); `functions` are addresses of those of a step.
    """
    jobs, first = batch.jobs, batch.jobs[0]
    flow, parameters = first.flow, memory.each([job.parameters for job in jobs])
    least = np.array([job.flow.least_margin for job in jobs])
    scale = np.array([job.flow.margin_scale for job in jobs])
    pointers = {
        "clock": flow.clock,
        "rates": flow.rates,
        "parameters": parameters,
        # what is held stands behind the parameters proper
        "held": parameters + WORD * (len(first.parameters) - flow.held),
        "timed": memory.zeros(flow.timed_size),
        "rows": memory.rows(rows),
        "stepper": memory.rows(stepper),
        "atol": memory.rows(np.array([job.atol for job in jobs])),
        "scale": memory.rows(scale),
        "smallest": memory.rows(least * scale),
        "turns": record.final_turns,
        "functions": 0 if events is None else events.functions,
        "values": 0 if events is None else events.values,
        "levels": 0 if events is None else events.level,
        "counters": record.counters,
        "times": record.time,
        "states": record.state,
        "sampled_turns": record.turns,
        "accelerations": record.acceleration,
        "angles": record.angles,
        "ahead": memory.zeros(flow.counted),
        "sampled": record.sampled,
        "collocation": collocation,
        **dict.fromkeys(SEVERAL, 0),
    }
    return SystemView(
        clock=flow.clock,
        rates=flow.rates,
        parameters=parameters,
        timed=pointers["timed"],
        rotates=memory.integers(flow.rotates),
        margin_scale=pointers["scale"],
        smallest_margins=pointers["smallest"],
        n=flow.coordinates,
        blocks=len(flow.margin_scale),
        first_carried=flow.first_carried,
        carried=flow.carried,
        counted=flow.counted,
        backward=memory.own([job.end < job.start for job in jobs]),
        holding=flow.held,
        held=pointers["held"],
        rows=pointers["rows"],
        width=rows.shape[-1],
        pointers=memory.words([pointers[name] for name in POINTERS]),
        stepper=pointers["stepper"],
        attempt=functions["attempt"],
        further=functions["further"],
        interpolate=functions["interpolate"],
        between=functions["between"],
        first=functions["first"],
        sample=functions["sample"],
    )


def control(memory: Memory, batch: JobBatch, functions: Mapping[str, int]) -> Control:
    """How long the steps of jobs are."""
    jobs = batch.jobs
    counts = [job.equal_steps for job in jobs]
    spans = [(job.end - job.start) / max(1, count) for job, count in zip(jobs, counts, strict=True)]
    grid = [(job.start, span, 0.0) for job, span in zip(jobs, spans, strict=True)]
    return Control(
        advance=functions["advance"],
        start=functions["begin"] if jobs[0].step is None else 0,
        atol=memory.rows(np.array([job.atol for job in jobs])),
        budget=memory.own([job.max_steps for job in jobs]),
        equal=memory.own(counts),
        grid=memory.rows(np.array(grid)),
    )


def workspace_width(flow: Flow) -> int:
    """Length of a row: coordinates, speeds and what a kernel writes."""
    return 2 * flow.coordinates + flow.written


def workspace(rows: int, jobs: Sequence[Job]) -> NDArray[np.float64]:
    """Rows as described in `loops.memory.SystemView`, for each job, with its state in row 0."""
    flow = jobs[0].flow
    result = np.zeros((len(jobs), rows, workspace_width(flow)))
    result[:, 0, : 2 * flow.coordinates] = [job.state for job in jobs]
    return result


def table(memory: Memory, tableau: Tableau | Collocation, flow: Flow) -> TableView:
    """Coefficients of a method for the workspace of a flow."""
    result, own = _table(tableau, flow.coordinates, workspace_width(flow))
    memory.keep(own)
    return result


@lru_cache(maxsize=256)
def _table(tableau: Tableau | Collocation, n: int, width: int) -> tuple[TableView, Memory]:
    """The same, which only reads it, for all flows of a size."""
    memory, A = Memory(), tableau.extended_A
    rows, columns = np.nonzero(A)
    result = TableView(
        starts=memory.integers(np.searchsorted(rows, np.arange(len(A) + 1))),
        places=memory.integers(columns * width + n),
        weights=memory.floats(A[rows, columns]),
        c=memory.floats(tableau.extended_c),
        dense=memory.floats(tableau.dense),
        rows=len(A),
        end=tableau.end,
        degree=tableau.dense.shape[1],
        cost=tableau.cost,
    )
    return result, memory


def record(memory: Memory, batch: JobBatch) -> Record:
    """Where the results of jobs go."""
    jobs, own = batch.jobs, {name: memory.rows(array) for name, array in batch.arrays.items()}
    samples = len(jobs[0].times)
    times = np.empty((len(jobs), samples + 1))
    times[:, :-1] = [job.times for job in jobs]
    # generated code reads the time of the next sample behind the last one, too
    times[:, -1] = [math.copysign(math.inf, job.end - job.start) for job in jobs]
    return Record(
        samples=samples,
        time=memory.rows(times),
        state=own["states"],
        turns=own["turns"],
        acceleration=own["accelerations"],
        final_turns=own["final_turns"],
        angles=own["final_angles"],
        ahead=memory.zeros(jobs[0].flow.counted),
        sampled=own["angles"],
        sampled_held=own["held"],
        counters=own["counters"],
        control=own["control"],
        observer=0,
        observed=0,
    )


def observed(
    memory: Memory,
    batch: JobBatch,
    system: SystemView,
    record: Record,
    switching: SwitchingView | None = None,
) -> Record:
    """A record with what renormalises the tangents of jobs, if they have any."""
    first = batch.jobs[0]
    if first.tangents is None:
        return record
    own, plans = first.flow.switching, [job.tangents for job in batch.jobs]
    size, columns = first.tangents.size, first.tangents.columns
    tangents = Tangents(
        size=size,
        placed=first.tangents.placed,
        columns=columns,
        every=memory.own([plan.every for plan in plans if plan]),
        offset=memory.own([plan.offset for plan in plans if plan]),
        orthogonal=int(first.tangents.orthogonal),
        project=PROJECT.address if own is not None and own.constraints else 0,
        context=0 if switching is None else switching.context,
        seen=memory.zeros(1),
        lengths=memory.rows(batch.arrays["lengths"]),
        grown=memory.rows(batch.arrays["grown"]),
        copy=memory.zeros(2 * columns * size),
        tolerances=memory.rows(np.array([(job.rtol, job.atol[-1]) for job in batch.jobs])),
        memories=0 if own is None else len(own.owners),
        moved=system.held + (0 if own is None else WORD * (len(own.names) + len(own.owners))),
    )
    context = memory.words([*system, *record, *tangents])
    return record._replace(observer=WATCH_TANGENTS.address, observed=context)
