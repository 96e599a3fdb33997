"""The initial-value problem that methods and peers solve, with a reference solution."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError
from linkages.kernel.system import System
from linkages.solution.moving.plan import build_flow
from linkages.solution.remarks.stops import failure_text
from linkages.solvers.flow import Flow
from linkages.solvers.integration import integrate

REFERENCE = "gauss8"


@dataclass(frozen=True)
class Problem:
    """Motion of a mechanism from t = 0 to `end`.

    Parameters
    ----------
    mechanism
        With at least one free coordinate.
    end
        Seconds.
    """

    mechanism: Mechanism
    end: float

    @cached_property
    def system(self) -> System:
        """Its topology and equations."""
        return System(self.mechanism)

    @cached_property
    def flow(self) -> Flow:
        """Its compiled differential equation."""
        return build_flow(self.system)

    def solve(
        self, method: str, *, rtol: float = 1e-10, step: float | None = None
    ) -> tuple[NDArray[np.float64], int]:
        """Coordinates at the end, shape (n,), and the number of evaluations.

        Raises
        ------
        ComputationError
            If the motion cannot be computed to its end.
        """
        found = integrate(
            self.flow, self.system.state, [0.0, self.end], method=method, rtol=rtol, step=step
        )
        failure = failure_text(self.system, found)
        if failure is not None:
            raise ComputationError(f"{method} stopped {failure}", time=found.stop_time)
        return found.unwrapped[-1], found.evaluations

    @cached_property
    def _references(self) -> list[NDArray[np.float64]]:
        """Ends by the symmetric implicit method at three steps, each half of the one before.

        It makes no truncation error worth mentioning at these steps, sums with compensation, and
        shares no coefficient with the explicit methods that are measured.
        """
        _, evaluations = self.solve("dop853", rtol=1e-10)
        step = self.end * 12 / evaluations
        return [self.solve(REFERENCE, step=step / 2**k)[0] for k in (1, 2, 3)]

    @property
    def exact(self) -> NDArray[np.float64]:
        """Coordinates at the end by the best reference there is, shape (n,)."""
        return self._references[-1]

    @property
    def uncertainty(self) -> float:
        """By how much the two finest references differ: errors below it mean nothing."""
        return float(np.abs(self._references[-1] - self._references[-2]).max())

    def error(self, coordinates: NDArray[np.float64]) -> float:
        """Largest absolute error of the coordinates at the end (rad or m)."""
        return float(np.abs(coordinates - self.exact).max())
