"""Gauss's collocation of order 8, symmetric and symplectic, for long conservative motions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

from linkages.solvers.job import Job
from linkages.solvers.methods.method import Method, run, step_count
from linkages.solvers.methods.vern9 import VERN9
from linkages.solvers.steps.compiled_loops import Loaded
from linkages.solvers.tableau import Collocation

IMPLICIT_STEPS = Loaded("linkages.solvers.loops.fixed_steps", "implicit_steps")


@dataclass(frozen=True, kw_only=True)
class Gauss(Method):
    """Collocation at Gauss's nodes, in equal steps, solved by fixed-point iteration."""

    @cached_property
    def collocation(self) -> Collocation:
        """Coefficients of the method."""
        return Collocation(stages=self.order // 2)

    def prepare(self, job: Job) -> Callable[[], int]:
        """Bind the loop; a step must be given."""
        from linkages.solvers import arrays
        from linkages.solvers.methods.method import event_hooks, step_hook

        assert job.step is not None
        # The explicit method of the nearest order locates the end of reach and singular positions.
        tableau, memory, room = VERN9.tableau, arrays.Memory(), job.room
        first = len(tableau.extended_c) + 1
        rows = arrays.workspace(first + 2 * self.collocation.stages, room.jobs)
        record = arrays.record(memory, room)
        pace = arrays.pace(room.jobs)
        system = arrays.system(memory, room, rows, pace, VERN9.code(job), record)
        table = arrays.table(memory, tableau, job.flow)
        record = arrays.observed(memory, room, system, record)
        nodes = arrays.nodes(memory, self.collocation, job.flow, first)
        hook = step_hook(memory, event_hooks(memory, room), system, table, record)
        views = (system, nodes, table, record, hook)
        places = [memory.words(words) for words in views]
        span = (job.start, job.end, step_count(job), job.max_steps)
        loop = partial(IMPLICIT_STEPS, *places, *span)
        return partial(run, loop, job, rows[0], memory)


GAUSS8 = Gauss(
    name="gauss8",
    order=8,
    adaptive=False,
    summary="Gauss collocation of order 8, symmetric, fixed step; for long conservative motions",
)
