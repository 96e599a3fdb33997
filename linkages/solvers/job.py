"""One integration: its request, its method, and the arrays of its results."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.solvers.flow import Flow, Kernel, Renormalisation
from linkages.solvers.loops.row_layout import RowLayout
from linkages.solvers.trajectory import ChangeLog, Event, EventLog, Outcome, Trajectory

AUTO = "auto"
# Where the work–precision curves of tsit5 and vern9 cross, on pendulums, Arenstorf's orbit and
# the nine-bar: at rtol 3e-6 to 1e-4.
LOOSE = 1e-5


class Choice(NamedTuple):
    """A method's name, and why it is the one."""

    name: str
    reason: str


def choose(rtol: float, *, stiff: bool = False) -> Choice:
    """Pick an adaptive method by tolerance, or for stiff equations, as with oil films."""
    if stiff:
        return Choice(
            "radau", "an oil film is stiff: stability would bound the steps of explicit methods"
        )
    if rtol >= LOOSE:
        return Choice(
            "tsit5",
            f"rtol {rtol:g} is loose: short steps of order 5 waste less than long ones of order 9",
        )
    return Choice(
        "vern9",
        f"rtol {rtol:g} is tight: for the same error on the nine-bar, order 9 takes 10 to 40 % "
        "fewer evaluations than order 8, and ever fewer than order 5",
    )


NOTHING_YET = (0, 0, 0, 0, -1, -1)
"""Of `linkages.solvers.loops.memory.Counters`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Job:
    """Arguments of an integration after their validation, and its row of the arrays of a batch."""

    flow: Flow
    start: float
    times: NDArray[np.float64]
    state: NDArray[np.float64]  # (2n,): overwritten with the final one
    rtol: float
    atol: NDArray[np.float64]  # (2n,)
    step: float | None  # length of a fixed step
    max_steps: int
    events: Sequence[Event] = ()
    begun: NDArray[np.float64] | None = None  # (d,): dependent angles at the start, roughly
    tangents: Renormalisation | None = None
    holds: NDArray[np.float64] | None = None  # (h,): modes and latched values at the start

    batch: JobBatch = field(init=False)
    row: int = field(init=False)
    log: EventLog = field(init=False)
    changes: ChangeLog = field(init=False)
    states: NDArray[np.float64] = field(init=False)
    turns: NDArray[np.int64] = field(init=False)
    accelerations: NDArray[np.float64] = field(init=False)
    final_turns: NDArray[np.int64] = field(init=False)
    angles: NDArray[np.float64] = field(init=False)
    final_angles: NDArray[np.float64] = field(init=False)
    lengths: NDArray[np.float64] = field(init=False)
    grown: NDArray[np.float64] = field(init=False)
    held: NDArray[np.float64] = field(init=False)
    parameters: NDArray[np.float64] = field(init=False)
    counters: NDArray[np.int64] = field(init=False)
    control: NDArray[np.float64] = field(init=False)

    def __getattr__(self, name: str) -> Any:
        """What a batch has for it; a job that is in none makes its own."""
        if name not in self.__dataclass_fields__:
            raise AttributeError(name)
        JobBatch([self])
        return vars(self)[name]

    @property
    def sizes(self) -> tuple[Hashable, ...]:
        """Equal for jobs that may share a batch, if their functions are the same."""
        own, samples = self.tangents, len(self.times)
        grows = own and (own.columns, own.size, own.placed, own.orthogonal, own.count(samples))
        return (samples, grows, *(event.capacity for event in self.events))

    def holding(self, kernel: Kernel) -> NDArray[np.float64]:
        """The parameters of a kernel with the modes and memories at the start; shared without."""
        if not kernel.held:
            return kernel.parameters
        assert self.holds is not None
        result = kernel.parameters.copy()
        result[len(result) - kernel.held :] = self.holds[: kernel.held]
        return result

    def renormalised(self, samples: int) -> tuple[int, int]:
        """How often, and how many tangents."""
        tangents = self.tangents
        return (tangents.count(samples), tangents.columns) if tangents else (0, 0)

    @cached_property
    def layout(self) -> RowLayout:
        """What the text of its steps depends on."""
        return RowLayout.of(self.flow, self.tangents, self.events)

    @property
    def end(self) -> float:
        """Time at which the integration ends."""
        return float(self.times[-1])

    @property
    def equal_steps(self) -> int:
        """Number of equal steps, none longer than `step`, that reach the end; 0 without a step."""
        if self.step is None:
            return 0
        # The allowance keeps a span of a whole number of steps from getting one more.
        return max(1, math.ceil(abs(self.end - self.start) / self.step - 1e-9))

    @property
    def fraction(self) -> float:
        """Part of the simulated time that is done, 0 to 1."""
        span = self.end - self.start
        return float((self.control[0] - self.start) / span) if span else 1.0

    def stop(self) -> None:
        """Ask a running loop to stop after its present step."""
        self.control[1] = 1.0

    def trajectory(self, outcome: Outcome, choice: Choice) -> Trajectory:
        """Collect the results once the loop has returned."""
        vars(self).pop("batch", None)  # which refers to it: arrays would wait for the collector
        samples, steps, rejected, evaluations, block, switch = map(int, self.counters)
        return Trajectory(
            time=self.times[:samples],
            state=self.states[:samples],
            turns=self.turns[:samples],
            acceleration=self.accelerations[:samples],
            outcome=outcome,
            stop_time=float(self.control[0]),
            block=block,
            steps=steps,
            rejected=rejected,
            evaluations=evaluations,
            final_state=self.state,
            final_turns=self.final_turns,
            angles=self.angles[:samples],
            final_angles=self.final_angles,
            crossings=self.log.crossings,
            lengths=self.lengths[: self.renormalised(samples)[0]],
            grown=self.grown,
            held=self.held[:samples],
            final_held=self.parameters[len(self.parameters) - self.flow.held :].copy(),
            changes=self.changes.changes,
            switch=switch,
            method=choice.name,
            reason=choice.reason,
        )


class JobBatch:
    """Arrays, by names of attributes of a `Job`, for jobs of the same functions and equal sizes."""

    def __init__(self, jobs: Sequence[Job]) -> None:
        first = jobs[0]
        flow, count, m = first.flow, len(jobs), len(first.times)
        n, d = flow.coordinates, flow.counted
        self.jobs = jobs
        self.arrays: dict[str, NDArray] = {
            "states": np.zeros((count, m, 2 * n)),
            "turns": np.zeros((count, m, n), dtype=np.int64),
            "accelerations": np.zeros((count, m, n)),
            "final_turns": np.zeros((count, n), dtype=np.int64),
            "angles": np.zeros((count, m, d)),
            "final_angles": _stacked((job.begun for job in jobs), (count, d)),
            "lengths": np.zeros((count, *first.renormalised(m))),
            "grown": _stacked(
                (None if job.tangents is None else job.tangents.grown for job in jobs),
                (count, first.renormalised(m)[1]),
            ),
            "held": np.zeros((count, m, flow.held)),
            "counters": np.tile(np.array(NOTHING_YET, dtype=np.int64), (count, 1)),
            # time reached, and whether to stop
            "control": np.array([(job.start, 0.0) for job in jobs]),
        }
        log, changes = EventLog((), flow), ChangeLog(flow)
        for row, (job, *own) in enumerate(zip(self.jobs, *self.arrays.values(), strict=True)):
            vars(job).update(zip(self.arrays, own, strict=True))
            met = EventLog(job.events, flow) if job.events else log
            seen = ChangeLog(flow) if flow.switches else changes
            numbers = job.holding(job.flow)
            vars(job).update(batch=self, row=row, log=met, changes=seen, parameters=numbers)


def make_batches(jobs: Sequence[Job]) -> None:
    """Give jobs of the same functions what they need to be carried out."""
    equal: dict[tuple[Hashable, ...], list[Job]] = {}
    for job in jobs:
        equal.setdefault(job.sizes, []).append(job)
    for own in equal.values():
        JobBatch(own)


def _stacked(
    rows: Iterable[NDArray[np.float64] | None], shape: tuple[int, int]
) -> NDArray[np.float64]:
    """What jobs begin with; zeros where they do not say."""
    result = np.zeros(shape)
    for row, own in zip(result, rows, strict=True):
        if own is not None:
            row[:] = own
    return result
