"""Events: a function of coordinates and speeds crosses a level."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.solvers.flow import Companion, Flow


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
    function: Companion | None = None
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

    Parameters
    ----------
    time : (m,)
        Times in seconds.
    state : (m, 2n)
        Coordinates and speeds; rotating coordinates lie within [-π, π].
    turns : (m, n) of int
        Whole turns to be added to rotating coordinates.
    angles : (m, d)
        Dependent angles with the whole turns made since the start.
    held : (m, h)
        Modes and what is remembered.
    count
        Number of crossings met, of which the first m were recorded.
    """

    time: NDArray[np.float64]
    state: NDArray[np.float64]
    turns: NDArray[np.int64]
    angles: NDArray[np.float64]
    held: NDArray[np.float64]
    count: int


@dataclass(frozen=True, eq=False)
class EventLog:
    """Events of a run with the arrays that its loop fills, event by event in one block of rows.

    Parameters
    ----------
    events
        What is looked for.
    flow
        What is integrated.
    """

    events: Sequence[Event]
    flow: Flow
    weights: NDArray[np.float64] = field(init=False)
    first: NDArray[np.int64] = field(init=False)
    time: NDArray[np.float64] = field(init=False)
    state: NDArray[np.float64] = field(init=False)
    turns: NDArray[np.int64] = field(init=False)
    angles: NDArray[np.float64] = field(init=False)
    held: NDArray[np.float64] = field(init=False)
    found: NDArray[np.int64] = field(init=False)

    def __post_init__(self) -> None:
        n = self.flow.coordinates
        weights = [
            np.zeros(2 * n) if event.function else np.asarray(event.weights)
            for event in self.events
        ]
        for found in weights:
            if len(found) != 2 * n:
                raise ValueError(
                    f"weights of an event must hold {n} coordinates and as many speeds, "
                    f"found {len(found)}"
                )
        first = np.array([*accumulate((event.capacity for event in self.events), initial=0)])
        arrays: dict[str, NDArray] = {
            "weights": np.array(weights).reshape(len(weights), 2 * n),
            "first": first,
            "time": np.zeros(first[-1]),
            "state": np.zeros((first[-1], 2 * n)),
            "turns": np.zeros((first[-1], n), dtype=np.int64),
            "angles": np.zeros((first[-1], self.flow.counted)),
            "held": np.zeros((first[-1], self.flow.held)),
            "found": np.zeros(len(weights), dtype=np.int64),
        }
        for name, array in arrays.items():
            object.__setattr__(self, name, array)

    @property
    def periods(self) -> NDArray[np.float64]:
        """Per event one turn, or 0 where the level stands for itself alone."""
        n = self.flow.coordinates
        others = np.delete(self.weights, np.flatnonzero(self.flow.rotates), axis=1)
        angles = self.weights[:, :n][:, self.flow.rotates]
        whole = (angles == np.rint(angles)).all(axis=1)
        linear = self.weights.any(axis=1)
        return np.where(linear & whole & ~others.any(axis=1), 2 * math.pi, 0.0)

    @property
    def crossings(self) -> tuple[Crossings, ...]:
        """What was found, event by event."""
        parts = []
        for first, event, found in zip(self.first, self.events, self.found, strict=False):
            rows = slice(int(first), int(first) + min(int(found), event.capacity))
            parts.append(
                Crossings(
                    time=self.time[rows],
                    state=self.state[rows],
                    turns=self.turns[rows],
                    angles=self.angles[rows],
                    held=self.held[rows],
                    count=int(found),
                )
            )
        return tuple(parts)
