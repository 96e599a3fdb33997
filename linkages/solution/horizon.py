"""How long a solution can be believed: comparison with a run at a tighter tolerance."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.guards import free_vectors
from linkages.solution.march import compute_motion
from linkages.solution.motion import Motion, Settings
from linkages.solvers.integration import LEAST_RTOL, METHODS

TIGHTER = 0.01
"""Factor on the tolerance of the comparison run (on the step of a fixed-step method: one half)."""

WRONG = 0.5e-3
"""Difference from which on the third digit is wrong, in units of the amplitude."""


ADDED_UP = 1e3

_MORE_STEPS = 10
"""What a tighter tolerance may take in steps: order 4 needs 3 times as many."""


@dataclass(frozen=True)
class Horizon:
    """The last sample time at which a solution has three correct digits.

    From there on a free coordinate or its rate differs from the comparison run by more than half a
    unit in the third digit of its amplitude.
    """

    time: float
    whole: bool  # whether that is the end of the solution: then the horizon lies beyond it
    # Largest difference of a free coordinate over the solution, in units of its amplitude
    error: float


def cost_factor(method: str) -> float:
    """Cost of a run with its comparison run, in runs: steps of order p shrink with rtol^(1/p)."""
    return 1.0 + TIGHTER ** (-1.0 / METHODS[method].order)


def find_horizon(system: System, settings: Settings, motion: Motion) -> Horizon | None:
    """Compare a motion with one at a tighter tolerance; None where there is nothing to compare."""
    if not system.layout.moved or len(motion.time) < 2:
        return None
    tighter = _tighter(settings, motion)
    if tighter is None:
        return None
    other = compute_motion(system, tighter)
    if other.interrupted:
        raise KeyboardInterrupt
    return horizon_between(system, settings.run, motion, other)


def horizon_between(system: System, run: RunOptions, motion: Motion, other: Motion) -> Horizon:
    """Until when a motion is like another one with smaller errors."""
    count = min(len(motion.time), len(other.time))
    if count < 2:  # the comparison run went elsewhere at once
        return Horizon(time=float(motion.time[0]), whole=False, error=math.inf)
    differences = _relative(system, run, motion, other, count)
    wrong = differences > WRONG
    first = int(np.argmax(wrong)) if wrong.any() else count
    last = max(0, first - 1)
    return Horizon(
        time=float(motion.time[last]),
        whole=first == len(motion.time),
        error=float(differences.max()),
    )


def _tighter(settings: Settings, motion: Motion) -> Settings | None:
    run = settings.run
    if run.step is not None:
        closer = replace(run, step=run.step / 2)
    elif run.rtol <= LEAST_RTOL:
        return None
    else:
        rtol = max(LEAST_RTOL, run.rtol * TIGHTER)
        closer = replace(run, rtol=rtol, atol=run.atol and run.atol * rtol / run.rtol)
    closer = replace(closer, max_steps=_MORE_STEPS * run.most_steps)
    return replace(settings.plain(motion.time), run=closer)


def _relative(
    system: System, run: RunOptions, motion: Motion, other: Motion, count: int
) -> NDArray[np.float64]:
    """Largest difference at each of `count` samples in units of the amplitudes.

    The amplitude of an angle is at most half a turn. Differences within some absolute tolerances
    are never wrong, because errors of steps add up.
    """
    own, better = (free_vectors(system, item)[:count].T for item in (motion, other))
    amplitude = 0.5 * (better.max(axis=1) - better.min(axis=1))
    for row, name in enumerate(system.topology.free):
        if system.mechanism.bodies[name].rotates:
            amplitude[row] = min(amplitude[row], np.pi)
    within = run.rtol if run.atol is None else run.atol
    scale = np.maximum(amplitude, ADDED_UP * within / WRONG)[:, None]
    return (np.abs(own - better) / scale).max(axis=0)
