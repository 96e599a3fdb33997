"""What a method of integration is, and the explicit Runge–Kutta methods as one kind of it."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import chain
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.solvers.coefficients.tableau import Tableau
from linkages.solvers.job import Job
from linkages.solvers.steps.loaded import Loaded

ADAPTIVE_STEPS = Loaded("linkages.solvers.loops.adaptive_steps", "adaptive_steps")
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
        motion = self.motion(job)
        if job.step is None:
            loop = partial(ADAPTIVE_STEPS, motion.context)
        else:
            shared = (*motion.words, job.start, job.end)
            loop = partial(FIXED_STEPS, *shared, step_count(job), job.max_steps)
        return partial(run, loop, job, motion.rows, motion)

    def motion(self, job: Job) -> Motion:
        """What a loop takes of a job."""
        # Listing methods need not wait for it.
        from linkages.solvers import arrays, hooks

        tableau, store = self.tableau, arrays.Memory()
        rows = arrays.workspace(tableau, job.flow, job.state)
        system = arrays.system(store, job, rows, tableau, self.memory)
        table = arrays.table(store, tableau, job.flow)
        record = arrays.record(store, job, system)
        events = hooks.events(store, job)
        hook = hooks.hook(store, events, system, table, record)
        switching = hooks.switching(store, job, events, system, table, record, tableau.c)
        words, context = (system, table, record, hook, switching), 0
        if job.step is None:
            control = arrays.control(store, job, tableau, self.memory)
            context = store.integers([*chain(*words, control)])
        return Motion(rows, words, context, store)


class Motion(NamedTuple):
    """A job as compiled loops take it.

    Parameters
    ----------
    rows
        Its workspace, with the state in row 0.
    words
        A `System`, `Table`, `Record`, `Hook` and `Switching` of `linkages.solvers.steps.views`.
    context
        Address of the same and a `Control` behind them, for adaptive steps; 0 for others.
    memory
        Keeps everything alive.
    """

    rows: NDArray[np.float64]
    words: tuple[tuple[int, ...], ...]
    context: int
    memory: object


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
