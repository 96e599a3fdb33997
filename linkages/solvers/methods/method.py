"""What a method of integration is, and the explicit Runge–Kutta methods as one kind of it."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import accumulate, chain
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.machine import MachineCode
from linkages.solvers.coefficients.tableau import Tableau
from linkages.solvers.job import Job, Room
from linkages.solvers.outcome import Outcome
from linkages.solvers.printed.step import compiled_step
from linkages.solvers.steps.loaded import Loaded
from linkages.solvers.steps.views import (
    EVALUATIONS,
    NOW,
    PLAIN,
    REJECTED,
    REJECTIONS,
    STEPS,
    STOP,
    TAKEN,
    WORD,
    T,
)

ADAPTIVE_STEPS, BEGIN_MOTION, CONCLUDE_STEP = (
    Loaded("linkages.solvers.loops.adaptive_steps", name)
    for name in ("adaptive_steps", "begin_motion", "conclude_step")
)
# Trials between two looks at whether to stop.
TICKS = 1024

FIXED_STEPS = Loaded("linkages.solvers.loops.fixed_steps", "fixed_steps")


@dataclass(frozen=True, kw_only=True)
class Method(ABC):
    """A method of integration; `methods.METHODS` lists them.

    Parameters
    ----------
    name
        Name by which users ask for it.
    order
        Order of the method.
    adaptive
        Whether steps follow a tolerance unless a step is given.
    summary
        One line for lists of methods.

    Attributes
    ----------
    switching
        Whether it stops where modes of a flow change, and goes on.
    """

    name: str
    order: int
    adaptive: bool
    summary: str
    switching: ClassVar[bool] = False

    @abstractmethod
    def prepare(self, job: Job) -> Callable[[], int]:
        """Load what a job needs and return its loop, with all arguments bound.

        The loop fills the arrays of the job, leaves the global interpreter lock to others while
        it runs, and returns an `Outcome`.
        """


@dataclass(frozen=True, kw_only=True)
class RungeKutta(Method):
    """An explicit Runge–Kutta method: a tableau under one of two compiled loops.

    Parameters
    ----------
    build
        Makes the tableau; called once, when the method is first used.
    memory
        Exponent of the error of the step before in the step control: 0 for control by the last
        error alone, about 0.4/order for PI control.
    """

    build: Callable[[], Tableau]
    memory: float = 0.0
    switching: ClassVar[bool] = True

    @cached_property
    def tableau(self) -> Tableau:
        """Coefficients of the method."""
        return self.build()

    def prepare(self, job: Job) -> Callable[[], int]:
        """Bind the loop with steps of ``job.step``, or that by tolerance where there is none."""
        motions = self.motions(job.room)
        motion = motions.of(job)
        if job.step is None:
            loop = partial(adapted, self.code(job), job, motion)
        else:
            places = (motion.context + WORD * place for place in motions.places)
            shared = (*places, job.start, job.end)
            loop = partial(FIXED_STEPS, *shared, step_count(job), job.max_steps)
        return partial(run, loop, job, motion.rows, motion)

    def code(self, job: Job) -> MachineCode:
        """The printed steps."""
        return compiled_step(self.tableau, job.shape, self.memory)

    def motions(self, room: Room) -> PreparedMotions:
        """What loops take of the jobs of a room."""
        # Listing methods need not wait for it.
        from linkages.solvers import arrays, hooks

        tableau, job, jobs = self.tableau, room.jobs[0], room.jobs
        store, code = arrays.Memory(len(jobs)), self.code(job)
        rows, pace = arrays.workspace(len(tableau.extended_c) + 1, jobs), arrays.pace(jobs)
        events, record = hooks.events(store, room), arrays.record(store, room)
        system = arrays.system(store, room, rows, pace, code, record, events)
        table = arrays.table(store, tableau, job.flow)
        hook = hooks.hook(store, events, system, table, record)
        switching = hooks.switching(store, room, events, system, table, record, tableau.quarters)
        record = arrays.observed(store, room, system, record, switching)
        words = (system, table, record, hook, switching)
        control = arrays.control(store, room, code) if job.step is None else ()
        return PreparedMotions(
            rows=rows,
            pace=pace,
            frames=np.atleast_1d(system.frame),
            contexts=np.atleast_1d(store.words([*chain(*words, control)])),
            places=tuple(accumulate((len(word) for word in words[:-1]), initial=0)),
            stages=table.end,
            memory=store,
        )


def adapted(code: MachineCode, job: Job, motion: PreparedMotion) -> int:
    """Integrate with steps that follow a tolerance; returns an `Outcome`.

    The loop is compiled where it is needed: printed code has a motion that nothing watches for
    itself, unless a step needs more than arithmetic.
    """
    counters, pace, flagged = job.counters, motion.pace, 0
    if pace[PLAIN] and code.function("begin")(motion.frame) == 0:
        advance = code.function("advance")
        while not flagged and pace[T] != job.end:
            left = job.max_steps - int(counters[STEPS] + counters[REJECTED])
            if job.control[STOP] or left <= 0:
                return Outcome.INTERRUPTED if job.control[STOP] else Outcome.STEP_BUDGET
            flagged = advance(motion.frame, min(left, TICKS)) & 1
            made = pace[[TAKEN, REJECTIONS]].astype(np.int64)
            counters[[STEPS, REJECTED]] += made
            counters[EVALUATIONS] += motion.stages * made.sum()
            pace[[TAKEN, REJECTIONS]] = 0.0
            job.control[NOW] = pace[T]
        if not flagged:
            return Outcome.DONE
    return ADAPTIVE_STEPS(motion.context, flagged, BEGIN_MOTION.address, CONCLUDE_STEP.address)


class PreparedMotion(NamedTuple):
    """A job as compiled loops take it.

    Parameters
    ----------
    rows
        Its workspace, with the state in row 0.
    pace
        How it goes on; see `linkages.solvers.steps.views`.
    frame, context
        Addresses: of the addresses named by `FRAME`; of a `SystemView`, `TableView`, `Record`,
        `Hook` and `SwitchingView`, one behind the other, and for adaptive steps a `Control` behind
        them.
    stages
        Evaluations of a step.
    memory
        Keeps everything alive.
    """

    rows: NDArray[np.float64]
    pace: NDArray[np.float64]
    frame: int
    context: int
    stages: int
    memory: object


@dataclass(frozen=True, kw_only=True)
class PreparedMotions:
    """The jobs of a room as compiled loops take them; all arrays have a row for each job.

    Parameters
    ----------
    rows, pace, frames, contexts, stages, memory
        As a `PreparedMotion` has them.
    places
        Where the parts of a context begin, in words.
    """

    rows: NDArray[np.float64]
    pace: NDArray[np.float64]
    frames: NDArray[np.int64]
    contexts: NDArray[np.int64]
    stages: int
    memory: object
    places: tuple[int, ...]

    def of(self, job: Job) -> PreparedMotion:
        """That of one of the jobs."""
        k = job.row
        frame, context = int(self.frames[k]), int(self.contexts[k])
        return PreparedMotion(self.rows[k], self.pace[k], frame, context, self.stages, self.memory)


def step_count(job: Job) -> int:
    """Number of equal steps, none longer than ``job.step``, that reach the end."""
    assert job.step is not None
    # The allowance keeps a span of a whole number of steps from getting one more.
    return max(1, math.ceil(abs(job.end - job.start) / job.step - 1e-9))


def run(loop: Callable[[], int], job: Job, rows: NDArray[np.float64], _memory: object) -> int:
    """Run a loop and hand over its final state; `_memory` lives as long as this call."""
    outcome = loop()
    np.copyto(job.state, rows[0, : len(job.state)])
    return outcome
