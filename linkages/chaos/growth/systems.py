"""The few operations through which every analysis touches a system.

After DynamicalSystemsBase.jl: an analysis that asks for no more than `TangentSystem` serves
linkages, ordinary differential equations and maps alike.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_SEED = 20240501


Watch = Callable[[float], None]
"""Is called now and then with the fraction done."""


@dataclass(frozen=True, eq=False)
class Growth:
    """What some intervals of a motion with tangents show.

    Parameters
    ----------
    rates
        Mean rates at which tangents grew within each interval, shape (intervals, k).
    states, times
        At the ends of intervals, shape (intervals, d) and (intervals,).
    tangents
        There, brought back to length one, shape (intervals, d, k).
    loses
        Whether sticking and contacts that close may take tangents away: those are zero, and their
        rates −∞.
    """

    rates: Floats
    states: Floats
    times: Floats
    tangents: Floats
    loses: bool = False


class TangentSystem(Protocol):
    """A motion together with tangents to it.

    `state` is a copy of shape (d,), `tangents` of shape (d, k); d and the meaning of the entries
    of `state` never change. A system may fix k when it is built, then setting another number is an
    error.
    """

    @property
    def state(self) -> Floats:
        """Copy of the state, shape (d,), angles within one turn."""

    @property
    def tangents(self) -> Floats:
        """Copy of the tangents, shape (d, k)."""

    @tangents.setter
    def tangents(self, values: Floats) -> None: ...

    @property
    def furthest(self) -> float:
        """Ratio of lengths of tangents after one interval beyond which the shortest is but error.

        Infinite for a system that brings them back in time by itself.
        """

    @property
    def time(self) -> float:
        """Seconds for a flow, steps for a map."""

    @property
    def angles(self) -> NDArray[np.bool_]:
        """Which entries of the state are angles kept within one turn, shape (d,)."""

    def advance(self, interval: float) -> None:
        """Move the state along the motion and the tangents along its variational equations."""

    def grow(
        self,
        intervals: int,
        interval: float,
        *,
        orthogonal: bool = True,
        watch: Watch | None = None,
    ) -> Iterator[Growth]:
        """Move on, with tangents brought back to length one after every interval.

        Parameters
        ----------
        intervals, interval
            How many, and their length in seconds or steps.
        orthogonal
            Whether tangents are made orthonormal, or only of length one each.
        watch
            Called with the fraction done.

        Yields
        ------
        What the next intervals show, as many at once as suits the system. An error is raised after
        what came before it.
        """


def random_directions(size: int, columns: int) -> Floats:
    """Orthonormal directions, always the same ones, shape (size, columns).

    Axes of the state space may lie in invariant subspaces; these almost surely do not.
    """
    return np.linalg.qr(np.random.default_rng(_SEED).normal(size=(size, columns)))[0]


def start_tangents(system: TangentSystem, columns: int) -> None:
    """Give a system that many random directions.

    Raises
    ------
    ValueError
        If there are not that many, or the system was built for another number.
    """
    size = len(system.state)
    if not 1 <= columns <= size:
        raise ValueError(f"count must be from 1 to {size}, not {columns}")
    tangents = random_directions(size, columns)
    with contextlib.suppress(ValueError):  # NumPy's message on shapes would not help
        system.tangents = tangents
    carried = system.tangents.shape
    if carried != tangents.shape:
        raise ValueError(
            f"the system carries {carried[1]} tangents, {columns} are needed: build it with as many"
        )


def replace_lost(system: TangentSystem) -> None:
    """Give a system new directions for those that it has lost, orthonormal to all others.

    The growth of tangents is that of neighbours from here on: what was lost before does not count.
    """
    tangents = system.tangents
    lost = ~tangents.any(axis=0)
    if lost.any():
        kept = tangents[:, ~lost]
        more = random_directions(len(tangents), len(tangents))
        whole = np.linalg.qr(np.hstack([kept, more]))[0]
        tangents[:, lost] = whole[:, kept.shape[1] : tangents.shape[1]]
        system.tangents = tangents


def part_of(watch: Watch | None, first: float, count: float, whole: float) -> Watch | None:
    """What watches a part of a computation, if the whole is watched: where it begins, its size."""
    return None if watch is None else lambda done: watch((first + count * done) / whole)
