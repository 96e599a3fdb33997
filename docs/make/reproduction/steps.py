"""The paper's method, RK4, at several steps against the converged answer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import linkages
from make.reproduction.reported import press

END = 1.0
"""Time of the comparison, in s."""

STEPS = (1e-6, 2e-6, 5e-6, 1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3)

CONVERGED = (("vern9", 1e-13), ("dop853", 1e-13))
"""Two methods whose difference shows how far the converged answer can be trusted."""

_SAMPLES = 2001


@dataclass(frozen=True)
class StepError:
    """What a step gives at the end."""

    step: float  # in seconds
    error: float  # of α̇ at the end, in units of its amplitude over the run

    @property
    def digits(self) -> int:
        """Correct digits: an error of half a unit in the n-th digit of the amplitude leaves n."""
        return max(0, int(np.floor(-np.log10(2 * max(self.error, 1e-16)))))


def speed(start: str, **solver) -> np.ndarray:
    """Clearance speed over the run in rad/s."""
    data = linkages.simulate(
        press(start), end=END, samples=_SAMPLES, outputs=["clearance_speed"], **solver
    ).data
    return data.clearance_speed.to_numpy()[:, 0]


def converged(start: str) -> tuple[np.ndarray, float]:
    """The converged speed, and the difference of two methods at the end in units of amplitude."""
    first, second = (speed(start, method=method, rtol=rtol) for method, rtol in CONVERGED)
    return first, float(abs(first[-1] - second[-1]) / np.abs(first).max())


def study(start: str, steps=STEPS) -> list[StepError]:
    """The error of every step."""
    reference, _ = converged(start)
    amplitude = np.abs(reference).max()
    return [
        StepError(step, float(abs(speed(start, method="rk4", step=step)[-1] - reference[-1]))
                  / float(amplitude))
        for step in steps
    ]  # fmt: skip


def first_wrong(found: list[StepError], digit: int = 1) -> float:
    """The shortest step from which on this digit is wrong; inf if it is right at every step."""
    wrong = [one.step for one in sorted(found, key=lambda one: one.step) if one.digits < digit]
    return min(wrong, default=float("inf"))
