"""Many motions on a graphics processor, for whoever integrates many in a thread."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Lock

from linkages.kernel.code.cuda import Device
from linkages.kernel.code.ptx import WIDTH
from linkages.solvers import arrays
from linkages.solvers.job import Job
from linkages.solvers.launches import Launches
from linkages.solvers.methods.method import Method, RungeKutta
from linkages.solvers.outcome import Outcome
from linkages.solvers.slots import DeviceSteps, Slots
from linkages.solvers.steps.views import NOW
from linkages.solvers.supervise import supervise

LOGGER = logging.getLogger(__name__)

FEWEST = 64
"""Motions; fewer are integrated in lanes of this processor."""

PER_MULTIPROCESSOR = 384
"""Motions: of threads with 168 registers, as the nine-bar has, no more run at a time."""

_KEPT = 16
"""Kernels; more of them are not needed at a time."""


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
                launches = Launches(method, jobs, slots, self._helpers)
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
        key = (method.name, job.flow.clock, job.shape)
        if key not in self._known:
            if len(self._known) == _KEPT:
                self._known.clear()
            self._known[key] = DeviceSteps.of(self.device, method, job)
        return self._known[key]


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
