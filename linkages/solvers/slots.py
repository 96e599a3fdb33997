"""Motions in the memory of a graphics processor: slots, and their copies on this side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.cuda import Device, DeviceError, DeviceKernel
from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.ptx import WIDTH
from linkages.solvers.flow import Flow
from linkages.solvers.job import Job
from linkages.solvers.methods.method import PreparedMotion, RungeKutta
from linkages.solvers.printed.device import (
    ARRAYS,
    KEPT,
    SERIES,
    SLOTS,
    series_entries,
    slot_entries,
    write_device_steps,
    write_slots,
)
from linkages.solvers.printed.shape import Shape
from linkages.solvers.steps.views import WORD

USED = 0.8
"""Part of the free memory that slots may take."""


@dataclass(frozen=True)
class DeviceSteps:
    """Steps of all motions of some functions.

    Parameters
    ----------
    kernel
        That makes them.
    shape
        Of their rows.
    parameters
        Number of parameters.
    flow
        One of theirs: keeps the functions alive.
    """

    kernel: DeviceKernel
    shape: Shape
    parameters: int
    flow: Flow

    @classmethod
    def of(cls, device: Device, method: RungeKutta, job: Job) -> DeviceSteps:
        """Written, and loaded."""
        flow = job.flow
        assert flow.routines is not None
        shape = job.shape
        text = write_device_steps(
            method.tableau, shape, flow.routines(), method.memory, device.architecture
        )
        kernel = device.load(text, "advance_lanes")
        return cls(kernel, shape, len(flow.parameters), flow)

    @cached_property
    def code(self) -> MachineCode:
        """What this processor does with slots."""
        return MachineCode(write_slots(self.shape, self.parameters))

    def room(self, device: Device, samples: int) -> int:
        """Number of slots, with room for so many samples each.

        As many as there are threads at a time, or as memory is left for, beside that of threads.

        Raises
        ------
        DeviceError
            If that is less than a warp.
        """
        words = sum(slot_entries(self.shape, self.parameters).values()) + 2 + (samples > 0)
        each = WORD * (words + samples * sum(series_entries(self.shape).values()))
        threads = self.kernel.local * device.multiprocessors * device.resident
        free = int(USED * (device.free - threads))
        found = min(self.kernel.threads, free // each) // WIDTH * WIDTH
        if found < WIDTH:
            raise DeviceError(
                f"{device.name} has {device.free} bytes of memory left; {WIDTH} motions need "
                f"{WIDTH * each}, and its threads {threads}"
            )
        return found


class Slots:
    """Slots on a graphics processor; a context manager.

    Parameters
    ----------
    device, steps
        Where, and of what.
    count
        How many, a multiple of `WIDTH`.
    samples
        For how many samples of a motion there is room.

    Attributes
    ----------
    found
        What became of the motion of each slot.
    outcomes
        Of steps that were finished on this side, by slot.
    """

    def __init__(self, device: Device, steps: DeviceSteps, count: int, samples: int) -> None:
        self._device, self._steps, self._samples = device, steps, samples
        entries = slot_entries(steps.shape, steps.parameters)
        blocks = count // WIDTH
        self.held = {n: np.zeros((blocks, max(1, e), WIDTH)) for n, e in entries.items()}
        self.found, self.outcomes, self._which, self._frames, self._contexts, self._advances = (
            np.zeros(count, dtype=np.int64) for _ in range(6)
        )
        self._series = {n: WORD * e for n, e in series_entries(steps.shape).items()}
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

    def enter(self, slot: int, method: RungeKutta, job: Job, motion: PreparedMotion) -> None:
        """Put a motion that has begun into a slot."""
        frame, block, column = motion.frame, *divmod(slot, WIDTH)
        self._steps.code.function("enter")(*self._own, frame, slot)
        self.held["budget"].view(np.int64)[block, 0, column] = job.max_steps
        self._frames[slot], self._contexts[slot] = frame, motion.context
        self._advances[slot] = method.code(job).address("advance")
        if self._samples:
            times = np.append(job.times, np.copysign(np.inf, job.end - job.start))
            self._device.put(times, self._place("times", slot, self._samples + 1))
        self._changed = True

    def leave(self, slot: int, job: Job, taken: Sequence[tuple[int, int]]) -> None:
        """Give a motion what has become of it.

        Parameters
        ----------
        slot, job
            Where it is, and which.
        taken
            First and last samples, that excluded, which were taken on this side.
        """
        self._steps.code.function("leave")(*self._own, int(self._frames[slot]), slot)
        count = int(job.counters[0])
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
            modes = ("parameters", "held") if self._steps.shape.active else ()
            self._put((*KEPT, *modes))

    def _put(self, names: Sequence[str]) -> None:
        for name in names:
            self._device.put(self.held[name], self._places[name])
        self._changed = False

    def conclude(self, slots: NDArray[np.int64], finish: int, first: int, last: int) -> None:
        """Finish steps that need more; other threads may do so for other slots meanwhile.

        Parameters
        ----------
        slots, first, last
            Which, and what part of them.
        finish
            Address of the function that finishes the step of a motion.
        """
        lists = (slots, self._frames, self._contexts, self._advances)
        given = [array.ctypes.data for array in lists]
        outcomes = self.outcomes.ctypes.data
        self._steps.code.function("conclude")(*self._own, *given, finish, outcomes, first, last)

    def row(self, name: str, entry: int) -> NDArray[np.float64]:
        """An entry of an array for all slots, as it was copied."""
        return self.held[name][:, entry].reshape(-1)
