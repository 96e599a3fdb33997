"""Many motions on a graphics processor.

Threads make steps until one needs more than arithmetic. Between two launches the functions of
single motions finish such steps on this side, and motions that have ended make room for others.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.cuda import WIDTH, Device, DeviceError, DeviceKernel
from linkages.kernel.code.machine import MachineCode
from linkages.solvers import arrays
from linkages.solvers.device_steps import (
    ARRAYS,
    ENDED,
    FLAGGED,
    KEPT,
    SERIES,
    SLOTS,
    SPENT,
    series_entries,
    slot_entries,
    write_device_steps,
    write_slots,
)
from linkages.solvers.flow import Flow
from linkages.solvers.integration import supervise
from linkages.solvers.job import Job, JobBatch, make_batches
from linkages.solvers.loops.memory import WORD, Counters, Progress, Stepper
from linkages.solvers.loops.row_layout import RowLayout
from linkages.solvers.method import (
    BEGIN_MOTION,
    CONCLUDE_STEP,
    Method,
    PreparedMotion,
    RungeKutta,
)
from linkages.solvers.trajectory import Outcome

USED = 0.8
"""Part of the free memory that slots may take."""


@dataclass(frozen=True)
class DeviceSteps:
    """Steps of all motions of some functions."""

    kernel: DeviceKernel  # that makes them
    layout: RowLayout  # of their rows
    parameters: int  # number of parameters
    flow: Flow  # one of theirs: keeps the functions alive

    @classmethod
    def of(cls, device: Device, method: RungeKutta, job: Job) -> DeviceSteps:
        """Written, and loaded."""
        flow = job.flow
        assert flow.routines is not None
        layout = job.layout
        text = write_device_steps(
            method.tableau, layout, flow.routines(), method.memory, device.architecture
        )
        kernel = device.load(text, "advance_lanes")
        return cls(kernel, layout, len(flow.parameters), flow)

    @cached_property
    def code(self) -> MachineCode:
        """What this processor does with slots."""
        return MachineCode(write_slots(self.layout, self.parameters))

    def room(self, device: Device, samples: int) -> int:
        """Number of slots for so many samples: of the threads at a time, or in the free memory."""
        words = sum(slot_entries(self.layout, self.parameters).values()) + 2 + (samples > 0)
        each = WORD * (words + samples * sum(series_entries(self.layout).values()))
        threads = self.kernel.local * device.multiprocessors * device.resident
        free = int(USED * (device.free - threads))
        result = min(self.kernel.threads, free // each) // WIDTH * WIDTH
        if result < WIDTH:
            raise DeviceError(
                f"{device.name} has {device.free} bytes of memory left; {WIDTH} motions need "
                f"{WIDTH * each}, and its threads {threads}"
            )
        return result


class Slots:
    """Slots on a graphics processor; a context manager.

    `count` is a multiple of `WIDTH`; `found` and `outcomes` of steps finished on this side are by
    slot.
    """

    def __init__(self, device: Device, steps: DeviceSteps, count: int, samples: int) -> None:
        self._device, self._steps, self._samples = device, steps, samples
        entries = slot_entries(steps.layout, steps.parameters)
        blocks = count // WIDTH
        self.held = {n: np.zeros((blocks, max(1, e), WIDTH)) for n, e in entries.items()}
        self.found, self.outcomes, self._which, self._motions = (
            np.zeros(count, dtype=np.int64) for _ in range(4)
        )
        self._series = {n: WORD * e for n, e in series_entries(steps.layout).items()}
        sizes = {name: array.nbytes for name, array in self.held.items()}
        sizes |= {n: count * e * (samples + (n == "times")) for n, e in self._series.items()}
        sizes |= {"which": self._which.nbytes, "found": self.found.nbytes}
        self._places = {name: device.reserve(sizes[name]) for name in ARRAYS}
        self._own = [self.held[name].ctypes.data for name in SLOTS]
        self._changed = True  # whether slots have been filled since they were copied there

    def __enter__(self) -> Slots:
        return self

    def __exit__(self, *_: object) -> None:
        self._device.release([*self._places.values()])

    def enter(self, slot: int, job: Job, motion: PreparedMotion) -> None:
        """Put a motion that has begun into a slot."""
        block, column = divmod(slot, WIDTH)
        self._steps.code.function("enter")(*self._own, motion.address, slot)
        self.held["budget"].view(np.int64)[block, 0, column] = job.max_steps
        self._motions[slot] = motion.address
        if self._samples:
            times = np.append(job.times, np.copysign(np.inf, job.end - job.start))
            self._device.put(times, self._place("times", slot, self._samples + 1))
        self._changed = True

    def leave(self, slot: int, job: Job, taken: Sequence[tuple[int, int]]) -> None:
        """Give a motion what has become of it."""
        self._steps.code.function("leave")(*self._own, int(self._motions[slot]), slot)
        count = int(job.counters[Counters.samples])
        if not self._samples or not count:
            return
        arrays = (job.states, job.turns, job.accelerations, job.angles)
        for name, array in zip(SERIES[1:], arrays, strict=True):
            own = [array[first:last].copy() for first, last in taken]
            self._device.get(self._place(name, slot, self._samples), array[:count])
            for (first, last), rows in zip(taken, own, strict=True):
                array[first:last] = rows

    def _place(self, name: str, slot: int, samples: int) -> int:
        return self._places[name] + slot * samples * self._series[name]

    def advance(self, slots: NDArray[np.int64], ticks: int) -> None:
        """Make at most so many trials of the motions in some slots; see `found`."""
        device, count = self._device, len(slots)
        if self._changed:
            self._put(SLOTS)
        device.put(slots, self._places["which"])
        self._steps.kernel.run(
            [*(self._places[name] for name in ARRAYS), self._samples, ticks], count
        )
        device.get(self._places["found"], self.found)

    def fetch(self) -> None:
        """Copy what steps have changed to this side."""
        for name in KEPT:
            self._device.get(self._places[name], self.held[name])

    def store(self) -> None:
        """Copy it back, before the next steps."""
        if not self._changed:
            modes = ("parameters", "held") if self._steps.layout.active else ()
            self._put((*KEPT, *modes))

    def _put(self, names: Sequence[str]) -> None:
        for name in names:
            self._device.put(self.held[name], self._places[name])
        self._changed = False

    def conclude(self, slots: NDArray[np.int64], finish: int, first: int, last: int) -> None:
        """Finish steps that need more; other threads may do so for other slots meanwhile."""
        lists = (slots.ctypes.data, self._motions.ctypes.data, finish, self.outcomes.ctypes.data)
        self._steps.code.function("conclude")(*self._own, *lists, first, last)

    def row(self, name: str, entry: int) -> NDArray[np.float64]:
        """An entry of an array for all slots, as it was copied."""
        return self.held[name][:, entry].reshape(-1)


SECONDS = 0.05
"""About how long a launch takes, so that Ctrl-C is heard and a display can be drawn between two."""

MOST_TICKS = 4096
"""Trials of a motion in a launch."""

_HALF = 32


class Launches:
    """One launch after the other, until all motions have ended."""

    def __init__(self, method: RungeKutta, jobs: Sequence[Job], slots: Slots, helpers: int) -> None:
        self._method, self._jobs, self._slots, self._helpers = method, jobs, slots, helpers
        self._waiting = iter(range(len(jobs)))
        self._free = [*range(len(slots.found))][::-1]
        self._running: dict[int, tuple[int, PreparedMotion]] = {}
        self._taken: dict[int, list[tuple[int, int]]] = {}
        self._ticks = 64
        self._pool: ThreadPoolExecutor | None = None
        self.control = np.zeros(2)
        self.outcomes = [Outcome.INTERRUPTED] * len(jobs)
        self.trials = self.number = self.concluded = 0
        self.seconds = 0.0

    def stop(self) -> None:
        """Ask it to end after the present launch."""
        self.control[Progress.stop] = 1.0

    def run(self) -> int:
        """Integrate; returns 0."""
        with ThreadPoolExecutor(self._helpers) as self._pool:
            self._go_on()
        for slot in [*self._running]:
            self._leave(slot, Outcome.INTERRUPTED)
        return 0

    def _go_on(self) -> None:
        self._fill()
        while self._running:
            self._launch()
            result = self._slots.found
            active = self._active
            halted = active[result[active] & (FLAGGED | ENDED | SPENT) != 0]
            if self.control[Progress.stop] or len(halted):
                self._slots.fetch()
                self._conclude(halted[result[halted] & FLAGGED != 0])
                self._part(halted)
                if self.control[Progress.stop]:
                    break
                self._fill()
                self._slots.store()

    @property
    def _active(self) -> NDArray[np.int64]:
        return np.fromiter(self._running, dtype=np.int64, count=len(self._running))

    def _fill(self) -> None:
        """Begin motions in all free slots."""
        while self._free and not self.control[Progress.stop]:
            entering = [*islice(self._waiting, len(self._free))]
            if not entering:
                return
            self._enter(entering)

    def _enter(self, entering: Sequence[int]) -> None:
        """Begin some motions, for which there are slots."""
        make_batches([self._jobs[index] for index in entering])
        motions: dict[JobBatch, list[PreparedMotion]] = {}
        for index in entering:
            job = self._jobs[index]
            if job.batch not in motions:
                motions[job.batch] = self._method.motions(job.batch)
            motion = motions[job.batch][job.row]
            outcome = BEGIN_MOTION(motion.address)
            slot = self._free.pop()
            self._running[slot] = index, motion
            self._taken[slot] = [(0, int(job.counters[Counters.samples]))]
            self._slots.enter(slot, job, motion)
            if outcome != Outcome.DONE or motion.stepper[Stepper.t] == job.end:
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
        if not len(flagged):
            return
        assert self._pool is not None
        before = self._slots.row("counters", Counters.samples).view(np.int64)[flagged]
        ends = np.linspace(0, len(flagged), min(self._helpers, len(flagged)) + 1).astype(int)
        finish = CONCLUDE_STEP.address

        def part(first: int, last: int) -> None:
            self._slots.conclude(flagged, finish, first, last)

        list(self._pool.map(part, ends[:-1].tolist(), ends[1:].tolist()))
        after = self._slots.row("counters", Counters.samples).view(np.int64)[flagged]
        taken = after > before
        spans = zip(before[taken].tolist(), after[taken].tolist(), strict=True)
        for slot, span in zip(flagged[taken].tolist(), spans, strict=True):
            self._taken[slot].append(span)
        self.concluded += len(flagged)

    def _part(self, halted: NDArray[np.int64]) -> None:
        """End motions that do not go on."""
        became = self._slots.found[halted]
        outcomes = np.where(became & SPENT != 0, Outcome.STEP_BUDGET, Outcome.DONE)
        outcomes = np.where(became & FLAGGED != 0, self._slots.outcomes[halted], outcomes)
        times, ends = (
            self._slots.row("stepper", entry)[halted] for entry in (Stepper.t, Stepper.end)
        )
        leaving = (outcomes != Outcome.DONE) | (times == ends)
        for slot, outcome in zip(halted[leaving].tolist(), outcomes[leaving].tolist(), strict=True):
            self._leave(slot, Outcome(outcome))

    def _leave(self, slot: int, outcome: Outcome) -> None:
        index, motion = self._running.pop(slot)
        job = self._jobs[index]
        self._slots.leave(slot, job, self._taken.pop(slot))
        np.copyto(job.state, motion.rows[0, : len(job.state)])
        reached = (
            job.control[Progress.now],
            motion.stepper[Stepper.t],
        )  # the first, where its last step was cut short
        job.control[Progress.now] = max(reached) if job.end >= job.start else min(reached)
        self.outcomes[index] = outcome
        self.control[Progress.now] += 1.0
        self._free.append(slot)


LOGGER = logging.getLogger(__name__)

FEWEST = 64
"""Motions; fewer are integrated in lanes of this processor."""

PER_MULTIPROCESSOR = 384
"""Motions: of threads with 168 registers, as the nine-bar has, no more run at a time."""

_KEPT = 16
"""Kernels; more of them are not needed at a time."""


class Accelerator:
    """Integrates many motions on a graphics processor; a context manager.

    `helpers` threads of this processor finish steps. Raises DeviceError if there is no device.
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
        """Run jobs of the same functions, of one thread at a time; also whether Ctrl-C came."""
        with self._lock:
            steps = self._steps(method, jobs[0])
            samples = max(len(job.times) * arrays.is_unobserved(job) for job in jobs)
            whole_warps = -(-len(jobs) // WIDTH) * WIDTH
            count = min(steps.room(self.device, samples), whole_warps)
            with Slots(self.device, steps, count, samples) as slots:
                launches = Launches(method, jobs, slots, self._helpers)
                _, interrupted = supervise(
                    launches.run, launches.stop, lambda: look(launches.control[Progress.now])
                )
            LOGGER.info(
                "%d motions in %d slots of %s (%d registers): %d steps tried in %d launches that "
                "took %.3g s, %d steps finished on the CPU",
                len(jobs), count, self.device.name, steps.kernel.registers, launches.trials,
                launches.number, launches.seconds, launches.concluded,
            )  # fmt: skip
        return launches.outcomes, interrupted

    def _steps(self, method: RungeKutta, job: Job) -> DeviceSteps:
        key = (method.name, job.flow.clock, job.layout)
        if key not in self._known:
            if len(self._known) == _KEPT:
                self._known.clear()
            self._known[key] = DeviceSteps.of(self.device, method, job)
        return self._known[key]


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
