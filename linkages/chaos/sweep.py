"""One engine for all sweeps: many independent computations over the cores of a machine.

Compiled kernels run without Python's global lock, so threads are enough. Each computation depends
on its own input alone, never on the number of cores or on the order in which they end.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from typing import Any, Protocol

from linkages.errors import LinkagesError

POLL = 0.1


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
        return [
            "not computed: interrupted" if o is None else (o.reason or "") for o in self.outcomes
        ]


def sweep(
    task: Callable[[Any], Any],
    points: Sequence[Any],
    *,
    executor: Executor | None = None,
    watch: Callable[[Progress], None] | None = None,
) -> Swept:
    """Compute a task for many points.

    Parameters
    ----------
    task
        Point → result. The first point is computed before all others, so that what must be
        compiled is compiled once.
    points
        What to compute it for.
    executor
        Where; the cores of this machine if not given.
    watch
        Called after each result.

    Returns
    -------
    All outcomes; after Ctrl-C those that were there.
    """
    found: list[Outcome | None] = [None] * len(points)
    begun, interrupted = time.monotonic(), False

    def keep(outcome: Outcome, done: int) -> None:
        found[outcome.index] = outcome
        if watch is not None:
            elapsed = time.monotonic() - begun
            left = elapsed / done * (len(points) - done)
            watch(Progress(done, len(points), elapsed, left))

    try:
        if points:
            keep(attempt(task, 0, points[0]), 1)
        rest = points[1:]
        for done, outcome in enumerate((executor or Threads()).run(task, rest), 2):
            keep(Outcome(outcome.index + 1, outcome.value, outcome.reason), done)
    except KeyboardInterrupt:
        interrupted = True
    return Swept(tuple(found), interrupted)
