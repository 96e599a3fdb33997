"""Where results of integrations are written: one array of each kind for many jobs."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.solvers.changes import ChangeLog
from linkages.solvers.events import EventLog
from linkages.solvers.job import Job

NOTHING_YET = (0, 0, 0, 0, -1, -1)
"""Samples, steps, rejected steps, evaluations, block, switch: see `steps.views`."""


class Room:
    """Arrays that loops fill for jobs of the same functions and equal sizes.

    Attributes
    ----------
    jobs
        Each has its row of the arrays.
    arrays
        By the names of attributes of a `Job`; the first axis is that of the jobs.
    """

    def __init__(self, jobs: Sequence[Job]) -> None:
        first = jobs[0]
        flow, count, m = first.flow, len(jobs), len(first.times)
        n, d = flow.coordinates, flow.counted
        self.jobs = jobs
        self.arrays: dict[str, NDArray] = {
            "states": np.zeros((count, m, 2 * n)),
            "turns": np.zeros((count, m, n), dtype=np.int64),
            "accelerations": np.zeros((count, m, n)),
            "final_turns": np.zeros((count, n), dtype=np.int64),
            "angles": np.zeros((count, m, d)),
            "final_angles": _stacked((job.begun for job in jobs), (count, d)),
            "lengths": np.zeros((count, *first.renormalised(m))),
            "grown": _stacked(
                (None if job.tangents is None else job.tangents.grown for job in jobs),
                (count, first.renormalised(m)[1]),
            ),
            "held": np.zeros((count, m, flow.held)),
            "counters": np.tile(np.array(NOTHING_YET, dtype=np.int64), (count, 1)),
            # time reached, and whether to stop
            "control": np.array([(job.start, 0.0) for job in jobs]),
        }
        log, changes = EventLog((), flow), ChangeLog(flow)
        for row, (job, *own) in enumerate(zip(jobs, *self.arrays.values(), strict=True)):
            vars(job).update(zip(self.arrays, own, strict=True))
            met = EventLog(job.events, flow) if job.events else log
            seen = ChangeLog(flow) if flow.switches else changes
            numbers = job.holding(job.flow)
            vars(job).update(room=self, row=row, log=met, changes=seen, parameters=numbers)


def give_rooms(jobs: Sequence[Job]) -> None:
    """Give jobs of the same functions what they need to be carried out."""
    equal: dict[tuple[Hashable, ...], list[Job]] = {}
    for job in jobs:
        equal.setdefault(job.sizes, []).append(job)
    for own in equal.values():
        Room(own)


def _stacked(
    rows: Iterable[NDArray[np.float64] | None], shape: tuple[int, int]
) -> NDArray[np.float64]:
    """What jobs begin with; zeros where they do not say."""
    found = np.zeros(shape)
    for row, own in zip(found, rows, strict=True):
        if own is not None:
            row[:] = own
    return found
