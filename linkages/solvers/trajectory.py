"""What an integration returns."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from linkages.solvers.changes import Changes
from linkages.solvers.events import Crossings
from linkages.solvers.outcome import Outcome


@dataclass(frozen=True, kw_only=True)
class Trajectory:
    """Samples of a motion, and how the integration ended.

    On failure the samples before the stop are kept, so that m may be less than what was asked.

    Parameters
    ----------
    time : (m,)
        Sample times in seconds, as requested.
    state : (m, 2n)
        Coordinates and speeds; rotating coordinates lie within [-π, π].
    turns : (m, n) of int
        Whole turns to be added to rotating coordinates.
    acceleration : (m, n)
        Accelerations of the coordinates.
    outcome
        How the integration ended.
    stop_time
        Time in seconds at which it ended.
    block
        Index of the block concerned; -1 where the outcome concerns none.
    steps, rejected, evaluations
        Accepted steps, rejected steps and calls of `rates`.
    final_state : (2n,)
        State at `stop_time`.
    final_turns : (n,) of int
        Turns at `stop_time`.
    angles : (m, d)
        Dependent angles with the whole turns made since the start.
    final_angles : (d,)
        The same at `stop_time`.
    crossings
        What was found of each event.
    lengths : (k, columns)
        Logarithms of the lengths to which tangents had grown from one time to the next.
    grown : (columns,)
        The same since the last of these times, less those of tangents as they are at `stop_time`.
    held : (m, h)
        Modes and what is remembered.
    final_held : (h,)
        The same at `stop_time`.
    changes
        Where modes have changed.
    switch
        Number of the switch concerned; -1 where the outcome concerns none.
    method, reason
        Name of the method, and why it was taken.
    """

    time: NDArray[np.float64]
    state: NDArray[np.float64]
    turns: NDArray[np.int64]
    acceleration: NDArray[np.float64]
    outcome: Outcome
    stop_time: float
    block: int
    steps: int
    rejected: int
    evaluations: int
    final_state: NDArray[np.float64]
    final_turns: NDArray[np.int64]
    angles: NDArray[np.float64]
    final_angles: NDArray[np.float64]
    changes: Changes
    crossings: tuple[Crossings, ...] = ()
    lengths: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0)))
    grown: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    held: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0)))
    final_held: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    switch: int = -1
    method: str = ""
    reason: str = ""

    @property
    def unwrapped(self) -> NDArray[np.float64]:
        """Coordinates with their whole turns, ``q + 2π·turns``, shape (m, n)."""
        return self.state[:, : self.turns.shape[1]] + 2 * np.pi * self.turns
