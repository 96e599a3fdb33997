"""Radau's method of order 5 for stiff equations, stepped by SciPy with exact derivatives.

References
----------
.. [1] E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996,
       section IV.8.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from linkages.solvers.job import Job
from linkages.solvers.methods.method import Method


@dataclass(frozen=True, kw_only=True)
class Radau(Method):
    """The implicit method of SciPy, over compiled right-hand sides."""

    def prepare(self, job: Job) -> Callable[[], int]:
        """Bind the loop, whose steps run in Python; a fixed step is none of its abilities."""
        if job.step is not None:
            raise ValueError(f"method '{self.name}' finds its steps itself: leave out the step")
        if job.events:
            raise ValueError(f"method '{self.name}' locates no events: take an explicit method")
        from linkages.solvers.methods.stiff_steps import StiffRun

        return StiffRun(job).run


RADAU = Radau(
    name="radau",
    order=5,
    adaptive=True,
    summary="Radau IIA of order 5, implicit, adaptive; for stiff springs, dampers and oil films",
)
