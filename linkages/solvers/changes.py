"""Record of the times at which modes of a motion change."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from linkages.solvers.events import Crossings
from linkages.solvers.flow import Flow

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
