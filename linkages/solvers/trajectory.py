"""Result of an integration: samples, mode changes, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from linkages.solvers.events import Crossings
from linkages.solvers.flow import Flow


class Outcome(IntEnum):
    """How an integration ended.

    The values are what the compiled loops return. Every member carries a `sentence` that says
    what happened and a `remedy` that says what to do about it.
    """

    sentence: str
    remedy: str

    DONE = 0, "The integration reached its end.", ""
    UNREACHABLE = (
        1,
        "The links of a block no longer reach each other: the position cannot be assembled.",
        "Check lengths, drives and the initial state, or end the simulation before this time.",
    )
    SINGULAR = (
        2,
        "The two links of a block are aligned: the mechanism may go on in either assembly mode.",
        "Change a length or an initial state so that the links pass beside this position, "
        "or end the simulation before this time.",
    )
    STEP_TOO_SMALL = (
        3,
        "The step fell below the resolution of time before the tolerance was met.",
        "Look for a force that grows without bound near this time; a loose tolerance can lead to "
        "such places, and a very tight one can ask for more than round-off allows.",
    )
    NOT_FINITE = (
        4,
        "The motion diverged: a state or an acceleration is no longer a finite number.",
        "Take a smaller step, or an adaptive method.",
    )
    STEP_BUDGET = (
        5,
        "The allowed number of steps was used up before the end.",
        "Raise max_steps, loosen the tolerance, or simulate a shorter time.",
    )
    INTERRUPTED = (
        6,
        "The integration was interrupted.",
        "What was computed so far is kept.",
    )

    NOT_CONVERGED = (
        7,
        "The equations of an implicit step could not be solved: its stages did not settle.",
        "Take a smaller step: the iteration converges if accelerations change little within one.",
    )
    EVENT = (
        8,
        "The integration ended at an event, as asked for.",
        "Start again from the final state to go on.",
    )

    SLIDING = (
        9,
        "A mode has no value: on both sides of the zero of its function the motion is pushed back "
        "onto it, as friction that jumps holds a body at rest.",
        "Take a force times sign(…), on whose zero the motion may stay, or a law without a jump, "
        "such as tanh(v/v0) for friction.",
    )
    CHATTER = (
        10,
        "A mode changes again and again while time hardly goes on, as where a ball comes to rest "
        "by ever smaller impacts.",
        "End before this time, or take a law that lets this end.",
    )

    def __new__(cls, value: int, sentence: str = "", remedy: str = "") -> Outcome:
        """Make a member from its value and its two sentences."""
        member = int.__new__(cls, value)
        member._value_ = value
        member.sentence = sentence
        member.remedy = remedy
        return member

    def __str__(self) -> str:
        return f"{self.sentence} {self.remedy}".strip()


CAPACITY = 10_000
"""Changes that a run keeps; further ones are counted."""


@dataclass(frozen=True, kw_only=True)
class Changes:
    """Changes of modes, in the order in which they were met.

    Parameters
    ----------
    time : (m,)
        In seconds.
    which : (m,) of int
        Numbers of the switches.
    rises : (m,) of bool
        Whether the function rose through zero; with an impact the mode may be −1 behind it as well.
    state : (m, 2n)
        Coordinates and speeds before the change; rotating coordinates lie within [-π, π].
    turns : (m, n) of int
        Whole turns to be added to rotating coordinates.
    held : (m, h)
        Modes and what is remembered, behind the change.
    count : (switches,) of int
        Changes of each switch, of which the first m together are recorded.
    """

    time: NDArray[np.float64]
    which: NDArray[np.int64]
    rises: NDArray[np.bool_]
    state: NDArray[np.float64]
    turns: NDArray[np.int64]
    held: NDArray[np.float64]
    count: NDArray[np.int64]

    def of(self, number: int, angles: int) -> tuple[Crossings, NDArray[np.bool_]]:
        """The changes of one switch, and which of them rise; without its `angles` angles."""
        here = self.which == number
        found = Crossings(
            time=self.time[here],
            state=self.state[here],
            turns=self.turns[here],
            angles=np.zeros((int(here.sum()), angles)),
            held=self.held[here],
            count=int(self.count[number]),
        )
        return found, self.rises[here]


@dataclass(frozen=True, eq=False)
class ChangeLog:
    """The arrays that a loop fills.

    Parameters
    ----------
    flow
        What is integrated.
    """

    flow: Flow
    time: NDArray[np.float64] = field(init=False)
    which: NDArray[np.int64] = field(init=False)
    rises: NDArray[np.int64] = field(init=False)
    state: NDArray[np.float64] = field(init=False)
    turns: NDArray[np.int64] = field(init=False)
    held: NDArray[np.float64] = field(init=False)
    found: NDArray[np.int64] = field(init=False)
    noted: NDArray[np.int64] = field(init=False)

    def __post_init__(self) -> None:
        rows, n = CAPACITY if self.flow.switches else 0, self.flow.coordinates
        arrays: dict[str, NDArray] = {
            "time": np.empty(rows),
            "which": np.empty(rows, dtype=np.int64),
            "rises": np.empty(rows, dtype=np.int64),
            "state": np.empty((rows, 2 * n)),
            "turns": np.empty((rows, n), dtype=np.int64),
            "held": np.empty((rows, self.flow.held)),
            "found": np.zeros(self.flow.switches, dtype=np.int64),
            "noted": np.zeros(1, dtype=np.int64),
        }
        for name, array in arrays.items():
            object.__setattr__(self, name, array)

    @cached_property
    def changes(self) -> Changes:
        """What was found in the end; copies, for most of the room is not used."""
        rows = slice(0, min(int(self.noted[0]), len(self.time)))
        return Changes(
            time=self.time[rows].copy(),
            which=self.which[rows].copy(),
            rises=self.rises[rows] > 0,
            state=self.state[rows].copy(),
            turns=self.turns[rows].copy(),
            held=self.held[rows].copy(),
            count=self.found,
        )


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
