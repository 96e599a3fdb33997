"""Tableau, flow and job as the addresses and sizes that the compiled loops take."""

from __future__ import annotations

import ctypes
import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.machine import MachineCode
from linkages.solvers.coefficients.collocation import Collocation
from linkages.solvers.coefficients.tableau import Tableau
from linkages.solvers.flow import Flow
from linkages.solvers.job import Job
from linkages.solvers.printed.shape import are_printed, is_printed
from linkages.solvers.steps.loaded import Loaded
from linkages.solvers.steps.views import (
    ACTIVE,
    ALWAYS,
    END,
    FRAME,
    PACE,
    PLAIN,
    RTOL,
    SAMPLE,
    WORD,
    Control,
    Events,
    Nodes,
    Record,
    SystemView,
    T,
    TableView,
    Tangents,
)

WATCH_TANGENTS = Loaded("linkages.solvers.watched.tangents", "watch_tangents")


class Memory:
    """Makes arrays and keeps them alive while compiled code holds their addresses.

    Attributes
    ----------
    copies
        Addresses at which what a motion holds is needed beside its kernel, and how much of it.
    """

    def __init__(self) -> None:
        self.arrays: list[NDArray] = []
        self.copies: list[tuple[int, int]] = []
        self.codes: list[object] = []

    def floats(self, values: object) -> int:
        """Address of numbers as float64."""
        return self._keep(np.ascontiguousarray(values, dtype=np.float64))

    def integers(self, values: object) -> int:
        """Address of numbers as int64."""
        return self._keep(np.ascontiguousarray(values, dtype=np.int64))

    def keep(self, code: object) -> None:
        """Keep functions alive as well."""
        self.codes.append(code)

    def _keep(self, array: NDArray) -> int:
        self.arrays.append(array)
        if array.size and array.flags.writeable:  # several times faster than what serves all
            return ctypes.addressof(ctypes.c_char.from_buffer(array.data))
        address: int = array.__array_interface__["data"][0]
        return address


def pace(job: Job) -> NDArray[np.float64]:
    """How a motion goes on, before it has begun; see `views`."""
    found = np.zeros(PACE)
    found[T], found[END], found[RTOL], found[ACTIVE] = job.start, job.end, job.rtol, 1.0
    found[SAMPLE] = job.times[0]
    found[ALWAYS], found[PLAIN] = is_watched(job), is_plain(job)
    return found


def is_watched(job: Job) -> bool:
    """Whether something has to look at every step of a motion that printed code does not see."""
    own = job.tangents
    return not (are_printed(job.events) and (own is None or is_printed(own)))


def is_plain(job: Job) -> bool:
    """Whether nothing looks at a motion, so that printed code takes its samples."""
    return not job.events and job.tangents is None and job.flow.switching is None


def system(
    memory: Memory,
    job: Job,
    rows: NDArray[np.float64],
    pace: NDArray[np.float64],
    code: MachineCode,
    record: Record,
    events: Events | None = None,
) -> SystemView:
    """Addresses and numbers of a job's flow and its record, with room for what its clock writes."""
    flow = job.flow
    memory.keep(code)
    # what is held stands behind the parameters proper
    parameters = memory.floats(job.parameters)
    frame = {
        "clock": flow.clock,
        "rates": flow.rates,
        "parameters": parameters,
        "held": parameters + WORD * (len(job.parameters) - flow.held),
        "timed": memory.floats(np.zeros(flow.timed_size)),
        "rows": memory.floats(rows),
        "pace": memory.floats(pace),
        "atol": memory.floats(job.atol),
        "scale": memory.floats(flow.margin_scale),
        "smallest": memory.floats(flow.smallest_margins),
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
        "ahead": memory.floats(np.zeros(flow.counted)),
        "sampled": record.sampled,
    }
    return SystemView(
        clock=flow.clock,
        rates=flow.rates,
        parameters=parameters,
        timed=frame["timed"],
        rotates=memory.integers(flow.rotates),
        margin_scale=frame["scale"],
        smallest_margins=frame["smallest"],
        n=flow.coordinates,
        blocks=len(flow.margin_scale),
        first_carried=flow.first_carried,
        carried=flow.carried,
        counted=flow.counted,
        backward=int(job.end < job.start),
        holding=flow.held,
        held=frame["held"],
        rows=frame["rows"],
        width=rows.shape[1],
        frame=memory.integers([frame[name] for name in FRAME]),
        pace=frame["pace"],
        attempt=code.address("attempt"),
        further=code.address("further"),
        interpolate=code.address("interpolate"),
        first=code.address("first"),
    )


def control(memory: Memory, job: Job, code: MachineCode) -> Control:
    """What an adaptive loop needs beside the rest."""
    return Control(
        advance=code.address("advance"),
        start=code.address("begin"),
        atol=memory.floats(job.atol),
        budget=job.max_steps,
    )


def workspace_width(flow: Flow) -> int:
    """Length of a row: coordinates, speeds and what a kernel writes."""
    return 2 * flow.coordinates + flow.written


def workspace(tableau: Tableau, flow: Flow, state: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows as described in `views.System`, with a state in row 0."""
    rows = np.zeros((len(tableau.extended_c) + 1, workspace_width(flow)))
    rows[0, : len(state)] = state
    return rows


def table(memory: Memory, tableau: Tableau, flow: Flow) -> TableView:
    """Coefficients of a tableau for the workspace of a flow."""
    found, own = _table(tableau, flow.coordinates, workspace_width(flow))
    memory.keep(own)
    return found


@lru_cache(maxsize=256)
def _table(tableau: Tableau, n: int, width: int) -> tuple[TableView, Memory]:
    """The same, which only reads it, for all flows of a size."""
    memory, A, end = Memory(), tableau.extended_A, tableau.stages
    rows, columns = np.nonzero(A)
    found = TableView(
        starts=memory.integers(np.searchsorted(rows, np.arange(len(A) + 1))),
        places=memory.integers(columns * width + n),
        weights=memory.floats(A[rows, columns]),
        c=memory.floats(tableau.extended_c),
        dense=memory.floats(tableau.dense),
        rows=len(A),
        end=end,
        degree=tableau.dense.shape[1],
    )
    return found, memory


def nodes(memory: Memory, method: Collocation, flow: Flow, first: int) -> Nodes:
    """Coefficients of a collocation method, with its stages from a row `first` on."""
    s, n = method.stages, flow.coordinates
    return Nodes(
        stages=s,
        first=first,
        c=memory.floats(method.c),
        A=memory.floats(method.A),
        AA=memory.floats(method.A @ method.A),
        b=memory.floats(method.b),
        bA=memory.floats(method.b @ method.A),
        ahead=memory.floats(method.ahead),
        timed=memory.floats(np.zeros((s, flow.timed_size))),
        timed_size=flow.timed_size,
        kept=memory.floats(np.zeros(max(n, s))),
        changes=memory.floats(np.zeros(2)),
        carry=memory.floats(np.zeros(2 * n)),
        next_carry=memory.floats(np.zeros(2 * n)),
        held=memory.floats(np.zeros(2 * n)),
    )


def record(memory: Memory, job: Job) -> Record:
    """Where the results of a job go; its arrays are contiguous and are written in place."""
    # printed code reads the time of the next sample behind the last one, too
    never = math.copysign(math.inf, job.end - job.start)
    return Record(
        samples=len(job.times),
        time=memory.floats(np.append(job.times, never)),
        state=memory.floats(job.states),
        turns=memory.integers(job.turns),
        acceleration=memory.floats(job.accelerations),
        final_turns=memory.integers(job.final_turns),
        angles=memory.floats(job.final_angles),
        ahead=memory.floats(np.zeros(job.flow.counted)),
        sampled=memory.floats(job.angles),
        sampled_held=memory.floats(job.held),
        counters=memory.integers(job.counters),
        control=memory.floats(job.control),
        observer=0,
        observed=0,
    )


def observed(memory: Memory, job: Job, system: SystemView, record: Record) -> Record:
    """A record with what renormalises the tangents of a job, if it has any."""
    if job.tangents is None:
        return record
    own = job.flow.switching
    tangents = Tangents(
        size=job.tangents.size,
        placed=job.tangents.placed,
        columns=job.tangents.columns,
        every=job.tangents.every,
        offset=job.tangents.offset,
        orthogonal=int(job.tangents.orthogonal),
        loses=int(own is not None and own.closes),
        seen=memory.integers(np.zeros(1)),
        lengths=memory.floats(job.lengths),
        grown=memory.floats(job.grown),
        copy=memory.floats(np.zeros(2 * job.tangents.columns * job.tangents.size)),
        tolerances=memory.floats([job.rtol, job.atol[-1]]),
        memories=0 if own is None else len(own.owners),
        moved=system.held + (0 if own is None else WORD * (len(own.names) + len(own.owners))),
    )
    context = memory.integers([*system, *record, *tangents])
    return record._replace(observer=WATCH_TANGENTS.address, observed=context)
