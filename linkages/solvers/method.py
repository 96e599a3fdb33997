"""Methods of integration, explicit and by collocation, and how they are prepared for jobs.

Of collocation methods Gauss's are for long conservative motions, Radau's for stiff equations [1]_.

References
----------
.. [1] E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996,
       sections IV.5 and IV.8.
"""

from __future__ import annotations

import math
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.machine import MachineCode
from linkages.solvers import arrays
from linkages.solvers.arrays import Memory, kernel_entries
from linkages.solvers.job import Job, JobBatch
from linkages.solvers.loops.explicit_steps import COMMON, compiled_common, compiled_step
from linkages.solvers.loops.memory import (
    BEHIND_STEP,
    FLAGGED_STEP,
    HISTORY,
    PAUSED,
    START_OF_MOTION,
    TICKS,
    Counters,
    Motion,
    Progress,
    Stepper,
)
from linkages.solvers.loops.scalar_stages import Loaded
from linkages.solvers.tableau import Collocation, Tableau
from linkages.solvers.trajectory import Outcome

STEP_LOOP, BEGIN_MOTION, CONCLUDE_STEP = (
    Loaded("linkages.solvers.loops.step_loop", name)
    for name in ("step_loop", "begin_motion", "conclude_step")
)
# Trials of generated code between two looks at whether to stop.
MANY_TICKS = 1024


class Steps(NamedTuple):
    """What the steps of a method consist of.

    `functions` are addresses that a `linkages.solvers.loops.memory.Motion` has; switches are
    compared with cubics at the rows `compared` of the workspace; `code` must live as long as these
    functions.
    """

    functions: Mapping[str, int]
    coefficients: Tableau | Collocation
    rows: int
    compared: Sequence[int]
    code: MachineCode


@dataclass(frozen=True, kw_only=True)
class Method(ABC):
    """A method of integration; `integration.METHODS` lists them.

    It brings its steps. Their length, events, modes, singular positions, samples and deviation
    vectors are matters of `linkages.solvers.loops.step_loop`.
    """

    name: str  # name by which users ask for it
    order: int  # order of the method
    adaptive: bool  # whether steps follow a tolerance unless a step is given
    summary: str  # one line for lists of methods

    @abstractmethod
    def steps(self, job: Job) -> Steps:
        """What its steps consist of, for such jobs."""

    def generated(self, job: Job) -> MachineCode | None:  # noqa: ARG002
        """Steps that go on by themselves, if the method has such for a job."""
        return None

    def collocation_entries(self, memory: Memory, batch: JobBatch) -> arrays.Entries:  # noqa: ARG002
        """What steps need beside the rest."""
        return {}

    def prepare(self, job: Job) -> MotionLoop:
        """Load what a job needs and return its loop."""
        return MotionLoop(job, self.motions(job.batch)[job.row], self.generated(job))

    def motions(self, batch: JobBatch) -> list[PreparedMotion]:
        """The jobs of a batch as compiled loops take them."""
        jobs, store, steps = batch.jobs, Memory(len(batch.jobs)), self.steps(batch.jobs[0])
        store.keep(steps.code)
        rows, stepper = arrays.workspace(steps.rows, jobs), arrays.stepper(jobs)
        flow = arrays.flow_entries(store, batch)
        entries = {
            **flow,
            **arrays.control_entries(store, batch),
            **arrays.record_entries(store, batch),
            "rows": store.rows(rows),
            "stepper": store.rows(stepper),
            "width": rows.shape[-1],
            **steps.functions,
            "c": store.floats(steps.coefficients.extended_c),
            "end": steps.coefficients.end,
            "scratch": len(steps.coefficients.extended_c),
            "cost": steps.coefficients.cost,
            "collocation": self.collocation_entries(store, batch),
            **arrays.event_entries(store, batch),
            **arrays.switch_entries(store, batch, steps.compared),
            **arrays.tangent_entries(store, batch, flow["held"]),
        }
        addresses = np.atleast_1d(store.table(Motion, entries)).tolist()
        return [
            PreparedMotion(*own, steps.coefficients.cost, store)
            for own in zip(rows, stepper, addresses, strict=True)
        ]


@dataclass(frozen=True, kw_only=True)
class RungeKutta(Method):
    """An explicit Runge–Kutta method.

    `memory` is the exponent of the error of the step before in the step control: 0 for control by
    the last error alone, about 0.4/order for PI control.
    """

    build: Callable[[], Tableau]
    memory: float = 0.0

    @cached_property
    def tableau(self) -> Tableau:
        """Coefficients of the method."""
        return self.build()

    def generated(self, job: Job) -> MachineCode | None:
        return self.code(job) if job.step is None else None

    def code(self, job: Job) -> MachineCode:
        """The generated steps."""
        return compiled_step(self.tableau, job.layout, self.memory)

    def steps(self, job: Job) -> Steps:
        return _steps(self.tableau, self.code(job), job.step is None)


@lru_cache(maxsize=256)
def _steps(tableau: Tableau, code: MachineCode, free: bool) -> Steps:
    """Those of a tableau, whose lengths are free to follow a tolerance or not."""
    names = ["attempt", "further", "interpolate", *COMMON]
    names += ["advance"] * bool(tableau.error.size) + ["begin"] * free
    functions = {name: code.address(name) for name in names}
    return Steps(
        functions={**functions, "between": functions["interpolate"]},
        coefficients=tableau,
        rows=len(tableau.extended_c) + 1,
        compared=tableau.quarters,
        code=code,
    )


_COLLOCATION = {
    name: Loaded("linkages.solvers.loops.collocation_steps", name)
    for name in ("attempt", "further", "interpolate", "between", "advance")
}
# Of Newton's iteration, in units of the allowed error: between these, its square root.
LOOSEST, TIGHTEST = 0.03, 10.0 * sys.float_info.epsilon


@dataclass(frozen=True, kw_only=True)
class CollocationMethod(Method):
    """An implicit Runge–Kutta method whose stages are those of a polynomial."""

    # Makes its coefficients; called once, when the method is first used
    build: Callable[[], Collocation]

    @cached_property
    def collocation(self) -> Collocation:
        """Coefficients of the method."""
        return self.build()

    @property
    def newton(self) -> bool:
        """Whether Newton's method solves the stages, as it must for stiff equations."""
        return self.adaptive

    def steps(self, job: Job) -> Steps:
        """What its steps consist of, for such jobs."""
        method = self.collocation
        names = {name: function.address for name, function in _COLLOCATION.items()}
        if self.newton:
            names["between"] = names["interpolate"]
        code = compiled_common(method, job.layout)
        return Steps(
            functions={**names, **{name: code.address(name) for name in COMMON}},
            coefficients=method,
            rows=2 * method.stages + 3,
            compared=tuple(range(1, method.stages + (not method.ends))),
            code=code,
        )

    def collocation_entries(self, memory: Memory, batch: JobBatch) -> arrays.Entries:
        """Its coefficients and memory, for the jobs of a batch."""
        jobs, method, flow = batch.jobs, self.collocation, batch.jobs[0].flow
        s, n = method.stages, flow.coordinates
        history = HISTORY + (3 + s) * n
        linear = [job.flow.linearise() if job.flow.linearise else None for job in jobs]
        memory.keep(linear)
        loose = [min(LOOSEST, max(TIGHTEST / job.rtol, math.sqrt(job.rtol))) for job in jobs]
        return {
            "stages": s,
            "A": memory.floats(method.A),
            "AA": memory.floats(method.A @ method.A),
            "b": memory.floats(method.b),
            "bA": memory.floats(method.b @ method.A),
            "dense": memory.floats(method.integrals),
            "nodes": memory.floats(method.continued),
            "continued": len(method.continued),
            "ahead": memory.rows(np.tile(method.ahead, (memory.count, 1, 1))),
            "ratio": memory.rows(np.ones((memory.count, 1))),
            "weights": memory.zeros(2 * s),
            "timed": memory.zeros(s, flow.timed_size),
            "timed_size": flow.timed_size,
            "kept": memory.zeros(s, n),
            "changes": memory.zeros(2),
            "committed": memory.zeros(history),
            "tried": memory.zeros(history),
            "newton": int(self.newton),
            "linear": kernel_entries(memory, jobs, linear),
            "start": memory.rows(np.full((memory.count, 1 + 3 * n + flow.held), math.nan)),
            "slopes": memory.zeros(2 * n * n + flow.written),
            "matrix": memory.zeros(s * n, s * n),
            "residual": memory.zeros(s * n),
            "pivots": memory.zeros(s * n),
            "scale": memory.zeros(2 * n),
            "error": memory.floats(method.error if self.newton else []),
            "newton_tolerance": memory.rows(np.array([(value, 0.0) for value in loose])),
        }


RADAU = CollocationMethod(
    name="radau",
    order=5,
    adaptive=True,
    summary="Radau IIA of order 5, implicit, adaptive; for stiff springs, dampers and oil films",
    build=partial(Collocation, stages=3, ends=True),
)

GAUSS8 = CollocationMethod(
    name="gauss8",
    order=8,
    adaptive=False,
    summary="Gauss collocation of order 8, symmetric, fixed step; for long conservative motions",
    build=partial(Collocation, stages=4),
)


class MotionLoop:
    """The loop of a job, whose arrays it fills; other threads run meanwhile.

    The step loop is compiled only where generated code cannot finish a motion by itself.
    """

    def __init__(self, job: Job, motion: PreparedMotion, code: MachineCode | None) -> None:
        self._job, self._motion, self._stage = job, motion, START_OF_MOTION
        self._code = code if motion.stepper[Stepper.unobserved] else None

    def __call__(self, rounds: int | None = None) -> int:
        """Go on for some rounds, or to the end; returns an `Outcome`, or PAUSED before the end."""
        job, motion, outcome = self._job, self._motion, PAUSED
        if self._code is not None:
            outcome = self._go_on(self._code, rounds)
        if self._code is None:
            most = sys.maxsize if rounds is None else rounds
            addresses = BEGIN_MOTION.address, CONCLUDE_STEP.address
            outcome = STEP_LOOP(motion.address, self._stage, most, *addresses)
            self._stage = BEHIND_STEP
        np.copyto(job.state, motion.rows[0, : len(job.state)])
        return outcome

    def _go_on(self, code: MachineCode, rounds: int | None) -> int:
        """The same by generated code alone, up to a step that is for the step loop."""
        job, motion = self._job, self._motion
        counters, stepper = job.counters, motion.stepper
        if self._stage == START_OF_MOTION:
            if code.function("begin")(motion.address) != 0:
                self._code = None
                return PAUSED
            self._stage = BEHIND_STEP
        advance, most = code.function("advance"), MANY_TICKS if rounds is None else rounds * TICKS
        trials = [Counters.steps, Counters.rejected]
        tried = [Stepper.accepted_steps, Stepper.rejected_steps]
        while stepper[Stepper.t] != job.end:
            left = job.max_steps - int(counters[trials].sum())
            if job.control[Progress.stop] or left <= 0:
                return Outcome.INTERRUPTED if job.control[Progress.stop] else Outcome.STEP_BUDGET
            flagged = advance(motion.address, min(left, most)) & 1
            made = stepper[tried].astype(np.int64)
            counters[trials] += made
            counters[Counters.evaluations] += motion.stages * made.sum()
            stepper[tried] = 0.0
            job.control[Progress.now] = stepper[Stepper.t]
            if flagged:
                self._code, self._stage = None, FLAGGED_STEP
            if flagged or (rounds is not None and stepper[Stepper.t] != job.end):
                return PAUSED
        return Outcome.DONE


class PreparedMotion(NamedTuple):
    """A job as compiled loops take it: its workspace, with the state in row 0, and its `Motion`."""

    rows: NDArray[np.float64]
    stepper: NDArray[np.float64]
    address: int
    stages: int
    memory: object
