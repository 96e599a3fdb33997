"""Many independent computations over the cores of a machine.

Compiled kernels release Python's global lock, so threads are enough. Results do not depend on the
number of cores or on the order in which computations end.
"""

from __future__ import annotations

import math
import os
import re
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol, TypeVar

from linkages.errors import InputError, LinkagesError
from linkages.interrupts import interrupts_kept
from linkages.kernel.code.cuda import DeviceError
from linkages.options.run import RunOptions

CGROUPS = Path("/sys/fs/cgroup")
OWN = Path("/proc/self/cgroup")


def available_cores() -> int:
    """Cores by affinity, and by the quota of a container where there is one; at least one."""
    count: Callable[[], int | None] = getattr(os, "process_cpu_count", _by_affinity)  # from 3.13
    allowed, granted = count() or 1, quota()
    return allowed if granted is None else max(1, min(allowed, granted))


def _by_affinity() -> int | None:
    if hasattr(os, "sched_getaffinity"):  # not on macOS and Windows
        return len(os.sched_getaffinity(0))
    return os.cpu_count()


def quota(root: Path = CGROUPS, own: Path = OWN) -> int | None:
    """Cores that control groups grant, rounded up; None where nothing limits them."""
    result: list[int] = []
    for folder in _groups(root, own):
        try:
            granted, period = (folder / "cpu.max").read_text(encoding="ascii").split()
        except (OSError, ValueError):
            continue
        if granted != "max":
            result.append(math.ceil(int(granted) / int(period)))
    return min(result, default=None)


def _groups(root: Path, own: Path) -> list[Path]:
    """The group of this process and all that it is part of."""
    try:
        lines = own.read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
    inner = next((line.removeprefix("0::/") for line in lines if line.startswith("0::")), "")
    group = root / inner
    return [group, *(parent for parent in group.parents if parent.is_relative_to(root))]


POLL = 0.1
INTERRUPTED = "not computed: interrupted"

STEPS_PER_PERIOD = 100_000
"""Steps that a computation of a sweep may take for each period that it covers, unless it is said.

Motions of mechanisms with clearances take thousands: one that needs more than this is stuck."""

Run = TypeVar("Run", bound=RunOptions)
Result = TypeVar("Result")

_ending = threading.local()


def stopping() -> bool:
    """Whether the sweep that this thread computes for has ended: what it computes is not wanted."""
    ended: threading.Event | None = getattr(_ending, "event", None)
    return ended is not None and ended.is_set()


_WHEN = re.compile(r"^at t = \S+ s(?:, |: )")
_SET = re.compile(r" \(from set .*\)$")


def per_period(run: Run, periods: int) -> Run:
    """Options of a computation of a sweep that covers so many periods."""
    most = STEPS_PER_PERIOD * periods
    return replace(run, max_steps=most) if run.max_steps is None else run


@dataclass(frozen=True)
class TaskOutcome:
    """What became of one computation."""

    index: int  # its place in the sweep
    value: Any  # the result; None if it failed
    reason: str | None  # why it failed, without the time; None if it did not
    # Simulated time in seconds at which it failed, if it had come so far
    stop_time: float | None = None


class Executor(Protocol):
    """Runs tasks somewhere: here on threads; a batch integrator or a cluster fits behind it."""

    def run(self, task: Callable[[Any], Any], points: Sequence[Any]) -> Iterator[TaskOutcome]:
        """Yield outcomes as they come, in any order; stop early when closed."""
        ...


class Threads:
    """The cores of this machine; all that this process may use if `workers` is not given."""

    def __init__(self, workers: int | None = None) -> None:
        self.workers = workers or available_cores()

    def run(self, task: Callable[[Any], Any], points: Sequence[Any]) -> Iterator[TaskOutcome]:
        """Yield outcomes as they come; those under way are finished when it is closed."""
        ended = threading.Event()
        pool = ThreadPoolExecutor(
            self.workers, "linkages-sweep", initializer=setattr, initargs=(_ending, "event", ended)
        )
        waiting = iter(enumerate(points))
        running: dict[Future[TaskOutcome], None] = {}

        def fill() -> None:
            while len(running) < self.workers:
                following = next(waiting, None)
                if following is None:
                    return
                running[pool.submit(attempt, task, *following)] = None

        try:
            with interrupts_kept():
                fill()
            while running:
                with interrupts_kept():
                    done, _ = wait(running, timeout=POLL, return_when=FIRST_COMPLETED)
                for future in done:
                    del running[future]
                    yield future.result()
                with interrupts_kept():
                    fill()
        finally:
            with interrupts_kept():
                ended.set()
                pool.shutdown(wait=False, cancel_futures=True)


def attempt(task: Callable[[Any], Any], index: int, point: Any) -> TaskOutcome:
    """Run a task; errors that concern the mechanism are outcomes, others are raised."""
    try:
        return TaskOutcome(index, task(point), None)
    except DeviceError:
        raise
    except (LinkagesError, ValueError) as error:
        return TaskOutcome(index, None, reason_of(error), getattr(error, "time", None))


def finished(task: Callable[[], Result]) -> tuple[Result, bool]:
    """Finish a sweep after its last point, whatever interrupts that."""
    try:
        return task(), False
    except KeyboardInterrupt:
        return task(), True


def reason_of(error: Exception) -> str:
    """Why something failed, in words that are the same wherever it fails for the same reason."""
    if isinstance(error, InputError):
        return "; ".join(
            f"{problem.path}: {_SET.sub('', problem.message)}".removeprefix(": ")
            for problem in error.problems
        )
    return _WHEN.sub("", str(error))


@dataclass(frozen=True)
class Progress:
    """How far a sweep is; times are in seconds."""

    done: int
    total: int
    elapsed: float
    remaining: float
    computed: int = 0  # computations of this run; others were in a store
    # What became of points that have no result → how many
    failures: Mapping[str, int] = field(default_factory=dict)

    @property
    def rate(self) -> float:
        """Computations per second in this run."""
        return self.computed / self.elapsed if self.elapsed else 0.0
