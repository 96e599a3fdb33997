"""Result of an integration: samples, events, mode changes, and how it ended."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property
from itertools import accumulate

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.solvers.flow import Flow, Kernel


@dataclass(frozen=True, kw_only=True, eq=False)
class Event:
    """A function of the state whose crossings of a level are located to round-off.

    It is linear, or any function that is compiled. Where a linear one takes whole multiples of
    rotating coordinates only, for example a single angle, the level means itself and all its
    multiples of a turn. Others take rotating coordinates with their whole turns. A compiled
    function takes them within one turn.

    Parameters
    ----------
    weights : (2n,)
        Weights of the coordinates and speeds in a linear function.
    function
        Any other function and its rate, instead; evaluated once for each step that is tried.
    level
        Level in the unit of the function.
    direction
        1: where the function grows with time; -1: where it falls; 0: both. Integrating backward
        in time, the function is seen along the integration.
    terminal
        Number of the crossing at which the integration ends; 0: none.
    capacity
        Number of crossings that are recorded; further ones are counted.
    """

    weights: ArrayLike = ()
    function: Kernel | None = None
    level: float = 0.0
    direction: int = 0
    terminal: int = 0
    capacity: int = 10_000

    def __post_init__(self) -> None:
        weights = np.array(self.weights, dtype=np.float64)
        object.__setattr__(self, "weights", weights)
        if self.function is not None and weights.size:
            raise ValueError("an event has either weights or a function")
        linear = self.function is None
        if weights.ndim != 1 or not np.isfinite(weights).all() or weights.any() != linear:
            raise ValueError("weights of an event must be finite numbers, not all of them zero")
        if not math.isfinite(self.level):
            raise ValueError(f"level of an event must be finite, found {self.level}")
        if self.direction not in (-1, 0, 1):
            raise ValueError(f"direction of an event must be -1, 0 or 1, found {self.direction}")
        if self.terminal < 0 or self.capacity < 1:
            raise ValueError("terminal must be at least 0 and capacity at least 1")


@dataclass(frozen=True, kw_only=True)
class Crossings:
    """Crossings of one event, in the order in which they were met.

    Rotating coordinates lie within [-π, π]; `turns` are to be added to them.
    """

    time: NDArray[np.float64]
    state: NDArray[np.float64]
    turns: NDArray[np.int64]
    angles: NDArray[np.float64]
    held: NDArray[np.float64]
    count: int  # number of crossings met, of which the first m were recorded


class EventLog:
    """Events of a run with the arrays that its loop fills, event by event in one block of rows."""

    def __init__(self, events: Sequence[Event], flow: Flow) -> None:
        self.events, self._flow, n = events, flow, flow.coordinates
        weights = [
            np.zeros(2 * n) if event.function else np.asarray(event.weights) for event in events
        ]
        for row in weights:
            if len(row) != 2 * n:
                raise ValueError(
                    f"weights of an event must hold {n} coordinates and as many speeds, "
                    f"found {len(row)}"
                )
        self.weights = np.array(weights).reshape(len(weights), 2 * n)
        self.first = np.array([*accumulate((event.capacity for event in events), initial=0)])
        rows = int(self.first[-1])
        self.time, self.state = np.zeros(rows), np.zeros((rows, 2 * n))
        self.turns = np.zeros((rows, n), dtype=np.int64)
        self.angles, self.held = np.zeros((rows, flow.counted)), np.zeros((rows, flow.held))
        self.found = np.zeros(len(weights), dtype=np.int64)

    @property
    def periods(self) -> NDArray[np.float64]:
        """Per event one turn, or 0 where the level stands for itself alone."""
        n = self._flow.coordinates
        others = np.delete(self.weights, np.flatnonzero(self._flow.rotates), axis=1)
        angles = self.weights[:, :n][:, self._flow.rotates]
        whole = (angles == np.rint(angles)).all(axis=1)
        linear = self.weights.any(axis=1)
        return np.where(linear & whole & ~others.any(axis=1), 2 * math.pi, 0.0)

    @property
    def crossings(self) -> tuple[Crossings, ...]:
        """What was found, event by event."""
        parts, names = [], ("time", "state", "turns", "angles", "held")
        for first, event, count in zip(self.first, self.events, self.found, strict=False):
            rows = slice(int(first), int(first) + min(int(count), event.capacity))
            own = {name: getattr(self, name)[rows] for name in names}
            parts.append(Crossings(**own, count=int(count)))
        return tuple(parts)


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
    INTERRUPTED = (6, "The integration was interrupted.", "What was computed so far is kept.")

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
    """Changes of modes, in the order in which they were met."""

    time: NDArray[np.float64]  # (m,)
    which: NDArray[np.int64]  # (m,): numbers of the switches
    rises: NDArray[np.bool_]  # (m,): the mode may be −1 behind a rise with an impact
    state: NDArray[np.float64]  # (m, 2n): before the change, angles within [-π, π]
    turns: NDArray[np.int64]  # (m, n): whole turns to be added
    held: NDArray[np.float64]  # (m, h): behind the change
    count: NDArray[np.int64]  # by switch; the first m changes are recorded

    def of(self, number: int, angles: int) -> tuple[Crossings, NDArray[np.bool_]]:
        """The changes of one switch, and which of them rise; without its `angles` angles."""
        here = self.which == number
        result = Crossings(
            time=self.time[here],
            state=self.state[here],
            turns=self.turns[here],
            angles=np.zeros((int(here.sum()), angles)),
            held=self.held[here],
            count=int(self.count[number]),
        )
        return result, self.rises[here]


class ChangeLog:
    """The arrays that a loop fills."""

    def __init__(self, flow: Flow) -> None:
        rows, n = CAPACITY if flow.switches else 0, flow.coordinates
        self.time, self.state = np.empty(rows), np.empty((rows, 2 * n))
        self.which, self.rises = (np.empty(rows, dtype=np.int64) for _ in range(2))
        self.turns = np.empty((rows, n), dtype=np.int64)
        self.held = np.empty((rows, flow.held))
        self.found = np.zeros(flow.switches, dtype=np.int64)
        self.noted = np.zeros(1, dtype=np.int64)

    @cached_property
    def changes(self) -> Changes:
        """What was found in the end; copies, for most of the room is not used."""
        rows = slice(0, min(int(self.noted[0]), len(self.time)))
        names = ("time", "which", "state", "turns", "held")
        own = {name: getattr(self, name)[rows].copy() for name in names}
        return Changes(**own, rises=self.rises[rows] > 0, count=self.found)


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
