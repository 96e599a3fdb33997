"""Collocation methods: Gauss's for long conservative motions, Radau's for stiff equations.

E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996, sections
IV.5 and IV.8.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from linkages.solvers.arrays import Entries, Memory, kernel_entries
from linkages.solvers.job import Job, JobBatch
from linkages.solvers.loops.explicit_steps import COMMON, compiled_common
from linkages.solvers.loops.memory import HISTORY
from linkages.solvers.loops.scalar_stages import Loaded
from linkages.solvers.methods.method import Method, Steps
from linkages.solvers.tableau import Collocation

FUNCTIONS = {
    name: Loaded("linkages.solvers.loops.collocation_steps", name)
    for name in ("attempt", "further", "interpolate", "between", "advance")
}
# Of Newton's iteration, in units of the allowed error: between these, its square root.
LOOSEST, TIGHTEST = 0.03, 10.0 * sys.float_info.epsilon


@dataclass(frozen=True, kw_only=True)
class CollocationMethod(Method):
    """An implicit Runge–Kutta method whose stages are those of a polynomial."""

    # Makes its coefficients; called once, when the method is first used
    build: Callable[[], Collocation]

    @cached_property
    def collocation(self) -> Collocation:
        """Coefficients of the method."""
        return self.build()

    @property
    def newton(self) -> bool:
        """Whether Newton's method solves the stages, as it must for stiff equations."""
        return self.adaptive

    def steps(self, job: Job) -> Steps:
        """What its steps consist of, for such jobs."""
        method = self.collocation
        names = {name: function.address for name, function in FUNCTIONS.items()}
        if self.newton:
            names["between"] = names["interpolate"]
        code = compiled_common(method, job.layout)
        return Steps(
            functions={**names, **{name: code.address(name) for name in COMMON}},
            coefficients=method,
            rows=2 * method.stages + 3,
            compared=tuple(range(1, method.stages + (not method.ends))),
            code=code,
        )

    def collocation_entries(self, memory: Memory, batch: JobBatch) -> Entries:
        """Its coefficients and memory, for the jobs of a batch."""
        jobs, method, flow = batch.jobs, self.collocation, batch.jobs[0].flow
        s, n = method.stages, flow.coordinates
        history = HISTORY + (3 + s) * n
        linear = [job.flow.linearise() if job.flow.linearise else None for job in jobs]
        memory.keep(linear)
        loose = [min(LOOSEST, max(TIGHTEST / job.rtol, math.sqrt(job.rtol))) for job in jobs]
        return {
            "stages": s,
            "A": memory.floats(method.A),
            "AA": memory.floats(method.A @ method.A),
            "b": memory.floats(method.b),
            "bA": memory.floats(method.b @ method.A),
            "dense": memory.floats(method.integrals),
            "nodes": memory.floats(method.continued),
            "continued": len(method.continued),
            "ahead": memory.rows(np.tile(method.ahead, (memory.count, 1, 1))),
            "ratio": memory.rows(np.ones((memory.count, 1))),
            "weights": memory.zeros(2 * s),
            "timed": memory.zeros(s, flow.timed_size),
            "timed_size": flow.timed_size,
            "kept": memory.zeros(s, n),
            "changes": memory.zeros(2),
            "committed": memory.zeros(history),
            "tried": memory.zeros(history),
            "newton": int(self.newton),
            "linear": kernel_entries(memory, jobs, linear),
            "start": memory.rows(np.full((memory.count, 1 + 3 * n + flow.held), math.nan)),
            "slopes": memory.zeros(2 * n * n + flow.written),
            "matrix": memory.zeros(s * n, s * n),
            "residual": memory.zeros(s * n),
            "pivots": memory.zeros(s * n),
            "scale": memory.zeros(2 * n),
            "error": memory.floats(method.error if self.newton else []),
            "newton_tolerance": memory.rows(np.array([(value, 0.0) for value in loose])),
        }


RADAU = CollocationMethod(
    name="radau",
    order=5,
    adaptive=True,
    summary="Radau IIA of order 5, implicit, adaptive; for stiff springs, dampers and oil films",
    build=partial(Collocation, stages=3, ends=True),
)

GAUSS8 = CollocationMethod(
    name="gauss8",
    order=8,
    adaptive=False,
    summary="Gauss collocation of order 8, symmetric, fixed step; for long conservative motions",
    build=partial(Collocation, stages=4),
)
