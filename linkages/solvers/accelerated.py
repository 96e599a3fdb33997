"""Many motions on a graphics processor: launches of bounded length, and what is left to the CPU.

Threads make steps until one needs more than arithmetic. Between two launches such steps are
finished on this side, by the functions of single motions, and motions that have ended make room for
others.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.cuda import Device
from linkages.kernel.code.ptx import WIDTH
from linkages.solvers import arrays
from linkages.solvers.job import Job
from linkages.solvers.methods.method import (
    BEGIN_MOTION,
    CONCLUDE_STEP,
    Method,
    PreparedMotion,
    RungeKutta,
)
from linkages.solvers.outcome import Outcome
from linkages.solvers.printed.device import ENDED, FLAGGED, SPENT
from linkages.solvers.printed.shape import Shape
from linkages.solvers.slots import DeviceSteps, Slots
from linkages.solvers.steps.views import END, NOW, SAMPLES, STOP, T
from linkages.solvers.supervise import supervise

LOGGER = logging.getLogger(__name__)

FEWEST = 64
"""Motions; fewer are integrated in lanes of this processor."""

PER_MULTIPROCESSOR = 384
"""Motions: of threads with 168 registers, as the nine-bar has, no more run at a time."""

SECONDS = 0.05
"""About how long a launch takes, so that Ctrl-C is heard and a display can be drawn between two."""

MOST_TICKS = 4096
"""Trials of a motion in a launch."""

_KEPT = 16
"""Kernels; more of them are not needed at a time."""

_HALF = 32


class Accelerator:
    """Integrates many motions on a graphics processor; a context manager.

    Parameters
    ----------
    device
        Which; the first one of this machine if not given. It is closed with this.
    helpers
        Threads of this processor that finish steps.

    Raises
    ------
    DeviceError
        There is none.
    """

    def __init__(self, device: Device | None = None, helpers: int = 1) -> None:
        self.device = Device() if device is None else device
        self._helpers, self._lock = helpers, Lock()
        self._known: dict[tuple[object, ...], DeviceSteps] = {}

    def __enter__(self) -> Accelerator:
        return self

    def __exit__(self, *_: object) -> None:
        with self._lock:  # what another thread has begun there ends first
            self._known.clear()
            self.device.close()

    @property
    def motions(self) -> int:
        """Number that fills it, about."""
        return PER_MULTIPROCESSOR * self.device.multiprocessors

    def takes(self, method: Method, jobs: Sequence[Job]) -> bool:
        """Whether it is worth while, and possible: no events are looked for."""
        if len(jobs) < FEWEST or not isinstance(method, RungeKutta):
            return False
        return all(
            job.step is None
            and job.flow.routines is not None
            and not (job.events or arrays.is_watched(job))
            for job in jobs
        )

    def run(
        self, method: RungeKutta, jobs: Sequence[Job], look: Callable[[float], None]
    ) -> tuple[list[Outcome], bool]:
        """Run jobs of the same functions; returns also whether Ctrl-C was pressed.

        One thread at a time; `look` is called with the number of jobs that have ended.
        """
        with self._lock:
            steps = self._steps(method, jobs[0])
            samples = max(len(job.times) * arrays.is_plain(job) for job in jobs)
            count = min(steps.room(self.device, samples), _whole_warps(len(jobs)))
            with Slots(self.device, steps, count, samples) as slots:
                launches = _Launches(method, jobs, slots, self._helpers)
                _, interrupted = supervise(
                    launches.run, launches.stop, lambda: look(launches.control[NOW])
                )
            LOGGER.info(
                "%d motions in %d slots of %s (%d registers): %d steps tried in %d launches that "
                "took %.3g s, %d steps finished on the CPU",
                len(jobs), count, self.device.name, steps.kernel.registers, launches.trials,
                launches.number, launches.seconds, launches.concluded,
            )  # fmt: skip
        return launches.outcomes, interrupted

    def _steps(self, method: RungeKutta, job: Job) -> DeviceSteps:
        key = (method.name, job.flow.clock, Shape.of(job.flow, job.tangents, job.events))
        if key not in self._known:
            if len(self._known) == _KEPT:
                self._known.clear()
            self._known[key] = DeviceSteps.of(self.device, method, job)
        return self._known[key]


class _Launches:
    """One launch after the other, until all motions have ended.

    Attributes
    ----------
    control
        Number of motions that have ended, and whether to stop.
    outcomes
        Of all jobs.
    trials, number, seconds, concluded
        Trials of all motions, launches, how long these took, and steps finished on this side.
    """

    def __init__(self, method: RungeKutta, jobs: Sequence[Job], slots: Slots, helpers: int) -> None:
        self._method, self._jobs, self._slots, self._helpers = method, jobs, slots, helpers
        self._waiting = iter(range(len(jobs)))
        self._free = [*range(len(slots.found))][::-1]
        self._running: dict[int, tuple[int, PreparedMotion]] = {}
        self._taken: dict[int, list[tuple[int, int]]] = {}
        self._ticks = 64
        self.control = np.zeros(2)
        self.outcomes = [Outcome.INTERRUPTED] * len(jobs)
        self.trials = self.number = self.concluded = 0
        self.seconds = 0.0

    def stop(self) -> None:
        """Ask it to end after the present launch."""
        self.control[STOP] = 1.0

    def run(self) -> int:
        """Integrate; returns 0."""
        self._fill()
        while self._running:
            self._launch()
            found = self._slots.found
            active = self._active
            halted = active[found[active] & (FLAGGED | ENDED | SPENT) != 0]
            if self.control[STOP] or len(halted):
                self._slots.fetch()
                self._conclude(halted[found[halted] & FLAGGED != 0])
                self._part(halted)
                if self.control[STOP]:
                    break
                self._fill()
                self._slots.store()
        for slot in [*self._running]:
            self._leave(slot, Outcome.INTERRUPTED)
        return 0

    @property
    def _active(self) -> NDArray[np.int64]:
        return np.fromiter(self._running, dtype=np.int64, count=len(self._running))

    def _fill(self) -> None:
        """Begin motions in all free slots."""
        while self._free and not self.control[STOP]:
            index = next(self._waiting, None)
            if index is None:
                return
            job = self._jobs[index]
            motion = self._method.motion(job)
            outcome = BEGIN_MOTION(motion.context)
            slot = self._free.pop()
            self._running[slot] = index, motion
            self._taken[slot] = [(0, int(job.counters[SAMPLES]))]
            self._slots.enter(slot, self._method, job, motion)
            if outcome != Outcome.DONE or motion.pace[T] == job.end:
                self._leave(slot, Outcome(outcome))

    def _launch(self) -> None:
        """Make some trials, as many as take about as long as a launch should."""
        active, begun = self._active, time.perf_counter()
        self._slots.advance(active, self._ticks)
        spent = time.perf_counter() - begun
        self.trials += int((self._slots.found[active] >> _HALF).sum())
        self.number += 1
        self.seconds += spent
        wanted = int(self._ticks * min(2.0, SECONDS / max(spent, 1e-9)))
        self._ticks = max(1, min(MOST_TICKS, wanted))

    def _conclude(self, flagged: NDArray[np.int64]) -> None:
        """Finish steps that need more than arithmetic."""
        if not len(flagged):
            return
        counted = self._slots.row("counters", SAMPLES).view(np.int64)
        before = counted[flagged].copy()
        ends = np.linspace(0, len(flagged), min(self._helpers, len(flagged)) + 1).astype(int)
        finish = CONCLUDE_STEP.address

        def part(first: int, last: int) -> None:
            self._slots.conclude(flagged, finish, first, last)

        with ThreadPoolExecutor(len(ends) - 1) as pool:
            list(pool.map(part, ends[:-1].tolist(), ends[1:].tolist()))
        after = self._slots.row("counters", SAMPLES).view(np.int64)[flagged]
        for slot, first, last in zip(
            flagged.tolist(), before.tolist(), after.tolist(), strict=True
        ):
            if last > first:
                self._taken[slot].append((first, last))
        self.concluded += len(flagged)

    def _part(self, halted: NDArray[np.int64]) -> None:
        """End motions that do not go on."""
        times, ends = self._slots.row("pace", T), self._slots.row("pace", END)
        for slot in halted.tolist():
            became, outcome = int(self._slots.found[slot]), Outcome.DONE
            if became & FLAGGED:
                outcome = Outcome(int(self._slots.outcomes[slot]))
            elif became & SPENT:
                outcome = Outcome.STEP_BUDGET
            if outcome is not Outcome.DONE or times[slot] == ends[slot]:
                self._leave(slot, outcome)

    def _leave(self, slot: int, outcome: Outcome) -> None:
        """Take a motion out of its slot."""
        index, motion = self._running.pop(slot)
        job = self._jobs[index]
        self._slots.leave(slot, job, self._taken.pop(slot))
        np.copyto(job.state, motion.rows[0, : len(job.state)])
        reached = job.control[NOW], motion.pace[T]  # the first, where its last step was cut short
        job.control[NOW] = max(reached) if job.end >= job.start else min(reached)
        self.outcomes[index] = outcome
        self.control[NOW] += 1.0
        self._free.append(slot)


def _whole_warps(count: int) -> int:
    """The next number that fills warps."""
    return -(-count // WIDTH) * WIDTH


_PLACE: ContextVar[Accelerator | None] = ContextVar("accelerator", default=None)


def accelerator() -> Accelerator | None:
    """Where this thread integrates many motions beside the CPU; None for nowhere."""
    return _PLACE.get()


@contextmanager
def accelerated(by: Accelerator | None) -> Iterator[None]:
    """Have this thread integrate motions on a graphics processor meanwhile."""
    token = _PLACE.set(by)
    try:
        yield
    finally:
        _PLACE.reset(token)
