"""Methods of integration, and the callbacks of events and modes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.machine import MachineCode
from linkages.solvers import arrays
from linkages.solvers.arrays import Memory
from linkages.solvers.flow import Kernel
from linkages.solvers.job import Job, JobBatch
from linkages.solvers.loops.explicit_steps import compiled_step
from linkages.solvers.loops.memory import (
    ACCEPTED_STEPS,
    EVALUATIONS,
    HALVED,
    NOW,
    REJECTED,
    REJECTED_STEPS,
    STEPS,
    STOP,
    UNOBSERVED,
    VALUES,
    WORD,
    Events,
    Hook,
    Record,
    SwitchesView,
    SwitchingView,
    SystemView,
    T,
    TableView,
)
from linkages.solvers.loops.scalar_stages import Loaded
from linkages.solvers.tableau import Collocation, Tableau
from linkages.solvers.trajectory import Outcome

STEP_LOOP, BEGIN_MOTION, CONCLUDE_STEP = (
    Loaded("linkages.solvers.loops.step_loop", name)
    for name in ("step_loop", "begin_motion", "conclude_step")
)
# Trials between two looks at whether to stop.
TICKS = 1024


class Steps(NamedTuple):
    """What the steps of a method consist of.

    Parameters
    ----------
    functions
        Addresses of compiled functions, by name: ``attempt``, ``further``, ``interpolate``,
        ``between``, ``first`` and ``sample``, as a `SystemView` has them, and of those that go on
        by the tolerance, ``advance``, and begin a motion that nothing watches, or 0, ``begin``.
    coefficients
        Of its rows.
    rows
        Number of rows of the workspace.
    compared
        Rows at which switches are compared with cubics.
    code
        Machine code that must live as long as these functions.
    """

    functions: Mapping[str, int]
    coefficients: Tableau | Collocation
    rows: int
    compared: Sequence[int]
    code: MachineCode


@dataclass(frozen=True, kw_only=True)
class Method(ABC):
    """A method of integration; `integration.METHODS` lists them.

    A method brings its steps. Their length, events, modes, singular positions, samples and
    deviation vectors are matters of the loop, `linkages.solvers.loops.step_loop`.

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
    """

    name: str
    order: int
    adaptive: bool
    summary: str

    @abstractmethod
    def steps(self, batch: JobBatch) -> Steps:
        """What its steps consist of."""

    def loop(self, job: Job, motion: PreparedMotion) -> int:  # noqa: ARG002
        """Integrate; returns an `Outcome`."""
        return STEP_LOOP(motion.context, 0, BEGIN_MOTION.address, CONCLUDE_STEP.address)

    def view(self, memory: Memory, batch: JobBatch) -> Sequence[Any]:  # noqa: ARG002
        """What its steps need beside the rest."""
        return ()

    def prepare(self, job: Job) -> Callable[[], int]:
        """Load what a job needs and return its loop, with all arguments bound.

        The loop fills the arrays of the job, leaves the global interpreter lock to others while
        it runs, and returns an `Outcome`.
        """
        motion = self.motions(job.batch).of(job)
        return partial(run, partial(self.loop, job, motion), job, motion.rows, motion)

    def motions(self, batch: JobBatch) -> PreparedMotions:
        """What loops take of the jobs of a batch."""
        jobs, flow = batch.jobs, batch.jobs[0].flow
        store, steps = arrays.Memory(len(jobs)), self.steps(batch)
        store.keep(steps.code)
        rows, stepper = arrays.workspace(steps.rows, jobs), arrays.stepper(jobs)
        events, record = event_hooks(store, batch), arrays.record(store, batch)
        view = self.view(store, batch)
        own = np.zeros((len(jobs), len(SystemView._fields) + len(record) + len(view)), int)
        place = store.rows(own) if view else 0
        system = arrays.system(store, batch, rows, stepper, steps.functions, record, events, place)
        if view:
            own[:] = store.table([*system, *record, *view])
        table = arrays.table(store, steps.coefficients, flow)
        hook = step_hook(store, events, system, table, record)
        switching = mode_hooks(store, batch, events, system, table, record, steps.compared)
        record = arrays.observed(store, batch, system, record, switching)
        control = arrays.control(store, batch, steps.functions)
        words = (system, table, record, hook, switching, control)
        return PreparedMotions(
            rows=rows,
            stepper=stepper,
            pointer_tables=np.atleast_1d(system.pointers),
            contexts=np.atleast_1d(store.words([*chain(*words)])),
            stages=table.cost,
            memory=store,
        )


@dataclass(frozen=True, kw_only=True)
class RungeKutta(Method):
    """An explicit Runge–Kutta method.

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

    @cached_property
    def tableau(self) -> Tableau:
        """Coefficients of the method."""
        return self.build()

    def loop(self, job: Job, motion: PreparedMotion) -> int:
        """Integrate; generated steps go on by themselves as long as they can."""
        if job.step is None:
            return adapted(self.code(job), job, motion)
        return super().loop(job, motion)

    def code(self, job: Job) -> MachineCode:
        """The generated steps."""
        return compiled_step(self.tableau, job.layout, self.memory)

    def steps(self, batch: JobBatch) -> Steps:
        """What its steps consist of."""
        tableau, code = self.tableau, self.code(batch.jobs[0])
        names = ["attempt", "further", "interpolate", "first", "sample", "begin"]
        if tableau.error.size:
            names.append("advance")
        functions = {name: code.address(name) for name in names}
        return Steps(
            functions={"advance": 0, **functions, "between": functions["interpolate"]},
            coefficients=tableau,
            rows=len(tableau.extended_c) + 1,
            compared=tableau.quarters,
            code=code,
        )


def adapted(code: MachineCode, job: Job, motion: PreparedMotion) -> int:
    """Integrate with steps that follow a tolerance; returns an `Outcome`.

    The loop is compiled where it is needed: generated code has a motion that nothing watches for
    itself, unless a step needs more than arithmetic.
    """
    counters, stepper, flagged = job.counters, motion.stepper, 0
    if stepper[UNOBSERVED] and code.function("begin")(motion.pointers) == 0:
        advance = code.function("advance")
        while not flagged and stepper[T] != job.end:
            left = job.max_steps - int(counters[STEPS] + counters[REJECTED])
            if job.control[STOP] or left <= 0:
                return Outcome.INTERRUPTED if job.control[STOP] else Outcome.STEP_BUDGET
            flagged = advance(motion.pointers, min(left, TICKS)) & 1
            made = stepper[[ACCEPTED_STEPS, REJECTED_STEPS]].astype(np.int64)
            counters[[STEPS, REJECTED]] += made
            counters[EVALUATIONS] += motion.stages * made.sum()
            stepper[[ACCEPTED_STEPS, REJECTED_STEPS]] = 0.0
            job.control[NOW] = stepper[T]
        if not flagged:
            return Outcome.DONE
    return STEP_LOOP(motion.context, flagged, BEGIN_MOTION.address, CONCLUDE_STEP.address)


class PreparedMotion(NamedTuple):
    """A job as compiled loops take it.

    Parameters
    ----------
    rows
        Its workspace, with the state in row 0.
    stepper
        How it goes on; see `linkages.solvers.loops.memory`.
    pointers, context
        Addresses: of the addresses named by `POINTERS`; of a `SystemView`, `TableView`, `Record`,
        `Hook`, `SwitchingView` and `Control`, one behind the other.
    stages
        Evaluations of a step.
    memory
        Keeps everything alive.
    """

    rows: NDArray[np.float64]
    stepper: NDArray[np.float64]
    pointers: int
    context: int
    stages: int
    memory: object


@dataclass(frozen=True, kw_only=True)
class PreparedMotions:
    """The jobs of a batch as compiled loops take them; all arrays have a row for each job.

    Parameters
    ----------
    rows, stepper, pointer_tables, contexts, stages, memory
        As a `PreparedMotion` has them.
    """

    rows: NDArray[np.float64]
    stepper: NDArray[np.float64]
    pointer_tables: NDArray[np.int64]
    contexts: NDArray[np.int64]
    stages: int
    memory: object

    def of(self, job: Job) -> PreparedMotion:
        """That of one of the jobs."""
        k = job.row
        pointers, context = int(self.pointer_tables[k]), int(self.contexts[k])
        return PreparedMotion(
            self.rows[k], self.stepper[k], pointers, context, self.stages, self.memory
        )


def run(loop: Callable[[], int], job: Job, rows: NDArray[np.float64], _memory: object) -> int:
    """Run a loop and hand over its final state; `_memory` lives as long as this call."""
    outcome = loop()
    np.copyto(job.state, rows[0, : len(job.state)])
    return outcome


WATCH_STEP = Loaded("linkages.solvers.loops.crossings", "watch_step")
FIND_SWITCH = Loaded("linkages.solvers.loops.mode_changes", "find_switch")
ESTIMATE_SWITCH = Loaded("linkages.solvers.loops.mode_changes", "estimate_switch")
APPLY_SWITCH = Loaded("linkages.solvers.loops.mode_transitions", "apply_switch")


def event_hooks(memory: Memory, batch: JobBatch) -> Events | None:
    """The events of jobs, if they have any."""
    jobs, logs = batch.jobs, [job.log for job in batch.jobs]
    count = len(logs[0].events)
    if not count:
        return None
    watched = [[job.events[event].function for job in jobs] for event in range(count)]
    functions = [place for own in watched for place in function_words(memory, jobs, own)]
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


def step_hook(
    memory: Memory, found: Events | None, system: SystemView, table: TableView, record: Record
) -> Hook:
    """What watches the steps of jobs for their events; nothing where they have none."""
    if found is None:
        return Hook(0, 0)
    context = memory.words([*system, *table, *record, *found])
    return Hook(WATCH_STEP.address, context)


def function_words(
    memory: Memory, jobs: Sequence[Job], functions: Sequence[Kernel | None]
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


def mode_hooks(
    memory: Memory,
    batch: JobBatch,
    found: Events | None,
    system: SystemView,
    table: TableView,
    record: Record,
    compared: Sequence[int],
) -> SwitchingView:
    """What finds and makes changes of modes; nothing where there are none."""
    jobs, flow = batch.jobs, batch.jobs[0].flow
    own = flow.switching
    if own is None:
        return SwitchingView(0, 0, 0, 0, 0, 0)
    logs = [job.changes for job in jobs]
    switchings = [job.flow.switching for job in jobs]
    becoming = [None if each is None else each.transition for each in switchings]
    # events have left their copies there
    transition = function_words(memory, jobs, becoming)
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
        couples_others=memory.integers(own.couples_others),
        transition=memory.words(transition),
        written=memory.zeros(own.written),
        before=memory.zeros(3 * flow.coordinates),
        copies=memory.words([word for copy in memory.copies for word in copy]),
        copied=len(memory.copies),
        events=0 if found is None else found.events,
        values_of_events=0 if found is None else found.values,
        pending=memory.zeros(2),
        kind=memory.zeros(1),
        halved=system.stepper + WORD * HALVED,
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
        FIND_SWITCH.address,
        ESTIMATE_SWITCH.address,
        APPLY_SWITCH.address,
        context,
        switches.kind,
        first_steps,
    )
