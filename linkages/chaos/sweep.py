"""One engine for all sweeps: many independent computations over the cores of a machine.

Compiled kernels run without Python's global lock, so threads are enough. Each computation depends
on its own input alone, never on the number of cores or on the order in which they end.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from typing import Any, Protocol

from linkages.errors import LinkagesError

POLL = 0.1
INTERRUPTED = "not computed: interrupted"


@dataclass(frozen=True)
class Outcome:
    """What became of one computation.

    Parameters
    ----------
    index
        Its place in the sweep.
    value
        The result; None if it failed.
    reason
        Why it failed; None if it did not.
    """

    index: int
    value: Any
    reason: str | None


class Executor(Protocol):
    """Runs tasks somewhere: here on threads; a batch integrator or a cluster fits behind it."""

    def run(self, task: Callable[[Any], Any], points: Sequence[Any]) -> Iterator[Outcome]:
        """Yield outcomes as they come, in any order; stop early when closed."""
        ...


class Threads:
    """The cores of this machine.

    Parameters
    ----------
    workers
        Number of threads; as many as there are cores if not given.
    """

    def __init__(self, workers: int | None = None) -> None:
        self.workers = workers or os.cpu_count() or 1

    def run(self, task: Callable[[Any], Any], points: Sequence[Any]) -> Iterator[Outcome]:
        """Yield outcomes as they come; those under way are finished when it is closed."""
        pool = ThreadPoolExecutor(self.workers, thread_name_prefix="linkages-sweep")
        waiting = iter(enumerate(points))
        running: dict[Future[Outcome], None] = {}

        def fill() -> None:
            while len(running) < self.workers:
                following = next(waiting, None)
                if following is None:
                    return
                running[pool.submit(attempt, task, *following)] = None

        try:
            fill()
            while running:
                done, _ = wait(running, timeout=POLL, return_when=FIRST_COMPLETED)
                for future in done:
                    del running[future]
                    yield future.result()
                fill()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def attempt(task: Callable[[Any], Any], index: int, point: Any) -> Outcome:
    """Run a task; what cannot be computed is an outcome with its reason.

    Only errors that say something about the mechanism count as that; others are faults of the
    program and are raised.
    """
    try:
        return Outcome(index, task(point), None)
    except (LinkagesError, ValueError) as error:
        return Outcome(index, None, str(error))


@dataclass(frozen=True)
class Progress:
    """How far a sweep is.

    Parameters
    ----------
    done, total
        Computations.
    elapsed, remaining
        Seconds; `remaining` is estimated.
    """

    done: int
    total: int
    elapsed: float
    remaining: float

    @classmethod
    def after(cls, done: int, total: int, begun: float) -> Progress:
        """Progress since a time of the monotonic clock."""
        elapsed = time.monotonic() - begun
        return cls(done, total, elapsed, elapsed / done * (total - done))


@dataclass(frozen=True)
class Swept:
    """Outcomes of a sweep.

    Parameters
    ----------
    outcomes
        One per point, in their order; None where it was interrupted before.
    interrupted
        Whether Ctrl-C ended it.
    """

    outcomes: tuple[Outcome | None, ...]
    interrupted: bool

    @property
    def reasons(self) -> list[str]:
        """Why there is no result, per point; empty where there is one."""
        return [INTERRUPTED if o is None else (o.reason or "") for o in self.outcomes]


def sweep(
    task: Callable[[Any], Any],
    points: Sequence[Any],
    *,
    executor: Executor | None = None,
    watch: Callable[[Progress], None] | None = None,
    alone: bool = True,
) -> Swept:
    """Compute a task for many points.

    Parameters
    ----------
    task
        Point → result.
    points
        What to compute it for.
    executor
        Where; the cores of this machine if not given.
    watch
        Called after each result.
    alone
        Whether the first point is computed before all others, so that what must be compiled is
        compiled once.

    Returns
    -------
    All outcomes; after Ctrl-C those that were there.
    """
    found: list[Outcome | None] = [None] * len(points)
    begun, interrupted = time.monotonic(), False

    def keep(outcome: Outcome, done: int) -> None:
        found[outcome.index] = outcome
        if watch is not None:
            watch(Progress.after(done, len(points), begun))

    first = 1 if alone else 0
    try:
        for index, point in enumerate(points[:first]):
            keep(attempt(task, index, point), index + 1)
        rest = (executor or Threads()).run(task, points[first:])
        for done, outcome in enumerate(rest, first + 1):
            keep(replace(outcome, index=outcome.index + first), done)
    except KeyboardInterrupt:
        interrupted = True
    return Swept(tuple(found), interrupted)
