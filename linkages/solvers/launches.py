"""Launches of bounded length on a graphics processor, and what is left to the CPU.

Threads make steps until one needs more than arithmetic. Between two launches such steps are
finished on this side, by the functions of single motions, and motions that have ended make room for
others.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from linkages.solvers.job import Job, Room, give_rooms
from linkages.solvers.methods.method import (
    BEGIN_MOTION,
    CONCLUDE_STEP,
    PreparedMotion,
    PreparedMotions,
    RungeKutta,
)
from linkages.solvers.outcome import Outcome
from linkages.solvers.printed.device import ENDED, FLAGGED, SPENT
from linkages.solvers.slots import Slots
from linkages.solvers.steps.views import END, NOW, SAMPLES, STOP, T

SECONDS = 0.05
"""About how long a launch takes, so that Ctrl-C is heard and a display can be drawn between two."""

MOST_TICKS = 4096
"""Trials of a motion in a launch."""

_HALF = 32


class Launches:
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
        self._pool: ThreadPoolExecutor | None = None
        self.control = np.zeros(2)
        self.outcomes = [Outcome.INTERRUPTED] * len(jobs)
        self.trials = self.number = self.concluded = 0
        self.seconds = 0.0

    def stop(self) -> None:
        """Ask it to end after the present launch."""
        self.control[STOP] = 1.0

    def run(self) -> int:
        """Integrate; returns 0."""
        with ThreadPoolExecutor(self._helpers) as self._pool:
            self._go_on()
        for slot in [*self._running]:
            self._leave(slot, Outcome.INTERRUPTED)
        return 0

    def _go_on(self) -> None:
        """Launch until all have ended, or are to stop."""
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

    @property
    def _active(self) -> NDArray[np.int64]:
        return np.fromiter(self._running, dtype=np.int64, count=len(self._running))

    def _fill(self) -> None:
        """Begin motions in all free slots."""
        while self._free and not self.control[STOP]:
            entering = [*islice(self._waiting, len(self._free))]
            if not entering:
                return
            self._enter(entering)

    def _enter(self, entering: Sequence[int]) -> None:
        """Begin some motions, for which there are slots."""
        give_rooms([self._jobs[index] for index in entering])
        motions: dict[Room, PreparedMotions] = {}
        for index in entering:
            job = self._jobs[index]
            if job.room not in motions:
                motions[job.room] = self._method.motions(job.room)
            motion = motions[job.room].of(job)
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
        assert self._pool is not None
        before = self._slots.row("counters", SAMPLES).view(np.int64)[flagged]
        ends = np.linspace(0, len(flagged), min(self._helpers, len(flagged)) + 1).astype(int)
        finish = CONCLUDE_STEP.address

        def part(first: int, last: int) -> None:
            self._slots.conclude(flagged, finish, first, last)

        list(self._pool.map(part, ends[:-1].tolist(), ends[1:].tolist()))
        after = self._slots.row("counters", SAMPLES).view(np.int64)[flagged]
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
        times, ends = (self._slots.row("pace", entry)[halted] for entry in (T, END))
        leaving = (outcomes != Outcome.DONE) | (times == ends)
        for slot, outcome in zip(halted[leaving].tolist(), outcomes[leaving].tolist(), strict=True):
            self._leave(slot, Outcome(outcome))

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
