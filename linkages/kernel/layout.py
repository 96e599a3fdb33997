"""Layout of the arrays of an integration: names of coordinates and parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.kernel.inputs import Fed, slots
from linkages.reading.paths import KeyPath
from linkages.topology.topology import Topology

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]


@dataclass(frozen=True)
class Layout:
    """Places of everything that is integrated, and of the parameters.

    An integrated vector is ``[free, internal, carried, work, losses, tangents | rates of the
    same]``, shape (2N,). Internal states, the work and losses are the rates of their coordinates,
    which themselves mean nothing: no tolerance is asked of them. A tangent has one entry for each
    free coordinate and internal state, and a rate for each of them. The motion alone is ``[free,
    internal, carried | rates of the same]``, shape (2m,). Vectors may
    have further axes behind the first.

    Outside of the integration the state of a motion is ``[free, carried | rates of the same |
    internal]``, shape (y,), and a tangent ``[free | rates of the same | internal]``, shape (x,).

    Parameters
    ----------
    free
        Bodies whose coordinates move freely.
    internal
        Names of the internal states.
    carried
        Dependent bodies whose coordinates the integration carries along.
    counted
        Dependent bodies whose whole turns are counted beside the vector.
    work
        Whether the work of drives and loads is integrated as well.
    losses
        Number of powers lost in contacts that are integrated as well.
    tangents
        Number of solutions of the variational equations.
    fed
        Parameters that each tangent moves as well: those that a number of the definition feeds.
    parameters
        Path of each entry of the parameter array.
    modes, memories
        Names of modes, and of what a motion remembers. They are held beside the vector, ``[modes,
        memories, memories of the first tangent, …]``, shape (h,).
    """

    free: tuple[str, ...]
    internal: tuple[str, ...] = ()
    carried: tuple[str, ...] = ()
    counted: tuple[str, ...] = ()
    work: bool = False
    losses: int = 0
    tangents: int = 0
    fed: Fed = ()
    parameters: tuple[KeyPath, ...] = ()
    modes: tuple[str, ...] = ()
    memories: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        topology: Topology,
        work: bool = False,
        losses: int = 0,
        tangents: int = 0,
        counting: bool = False,
    ) -> Layout:
        """The layout of a mechanism's integration, without parameters."""
        counted = topology.counted if counting else ()
        internal, carried = topology.internal, topology.carried
        return cls(topology.free, internal, carried, counted, work, losses, tangents)

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """What is integrated twice: free coordinates, internal states, what is carried along."""
        return (*self.free, *self.internal, *self.carried)

    @property
    def bodies(self) -> tuple[str, ...]:
        """Bodies whose coordinate is integrated: the free ones, then those carried along."""
        return (*self.free, *self.carried)

    @cached_property
    def moved(self) -> int:
        """Number of free coordinates and internal states: of coordinates of a tangent."""
        return len(self.free) + len(self.internal)

    @cached_property
    def directions(self) -> int:
        """Number x of entries of a tangent: the dimension of the states of a motion."""
        return 2 * len(self.free) + len(self.internal)

    @cached_property
    def size(self) -> int:
        """Number N of integrated coordinates, with the work, losses and tangents."""
        return len(self.coordinates) + self.more

    @cached_property
    def more(self) -> int:
        """Number of integrated coordinates beyond those of the motion."""
        return int(self.work) + self.losses + self.tangents * self.moved

    @cached_property
    def motion_rows(self) -> Rows:
        """Places of the motion in an integrated vector, shape (2m,)."""
        first = np.arange(len(self.coordinates))
        return np.concatenate([first, self.size + first])

    @cached_property
    def state_rows(self) -> Rows:
        """Places of a state, as it is outside of the integration, in a motion, shape (y,)."""
        count, n = len(self.coordinates), len(self.free)
        internal = np.arange(n, self.moved)
        bodies = np.delete(np.arange(count), internal)
        return np.concatenate([bodies, count + bodies, count + internal])

    @cached_property
    def internal_rows(self) -> Rows:
        """Places of the internal states in an integrated vector, shape (s,)."""
        return self.size + np.arange(len(self.free), self.moved)

    @cached_property
    def idle_rows(self) -> Rows:
        """Places in an integrated vector that mean nothing: integrals of internal states."""
        own = np.arange(len(self.free), self.moved)
        first = self.size - self.tangents * self.moved
        moved = first + np.arange(self.tangents)[:, None] * self.moved + own
        return np.concatenate([own, moved.ravel()])

    @cached_property
    def carried_rows(self) -> Rows:
        """Places of what is carried along and its rates in the motion, shape (2c,)."""
        count = len(self.coordinates)
        first = np.arange(self.moved, count)
        return np.concatenate([first, count + first])

    @cached_property
    def tangent_rows(self) -> Rows:
        """Places of the tangents in an integrated vector, shape (x, tangents)."""
        n = self.moved
        first = self.size - self.tangents * n
        places = first + np.arange(self.tangents) * n + np.arange(n)[:, None]
        return np.concatenate([places[: len(self.free)], self.size + places])

    @cached_property
    def held(self) -> int:
        """Number h of modes, memories and tangents of memories."""
        return len(self.modes) + len(self.memories) * (1 + self.tangents)

    @cached_property
    def remembered(self) -> int:
        """Number of modes and memories, without their tangents."""
        return len(self.modes) + len(self.memories)

    def named(self, held: Floats) -> dict[str, Floats]:
        """What is held by its name, for other free coordinates: a memory with its tangents."""
        modes, memories = held[: len(self.modes)], held[len(self.modes) :]
        rows = memories.reshape(1 + self.tangents, len(self.memories)).T if self.held else ()
        result = {name: modes[k : k + 1] for k, name in enumerate(self.modes)}
        return result | dict(zip(self.memories, rows, strict=True))

    def holding(self, named: Mapping[str, Floats]) -> Floats:
        """What is held in this layout, from its names, shape (h,); without tangents, they are 0."""
        memories = np.zeros((1 + self.tangents, len(self.memories)))
        for column, name in enumerate(self.memories):
            memories[: len(named[name]), column] = named[name]
        return np.concatenate([*(named[name] for name in self.modes), memories.ravel()])

    @property
    def slopes(self) -> tuple[KeyPath, ...]:
        """Paths of the slopes, which stand behind the other parameters."""
        return tuple(("slope", slot) for slot, _ in enumerate(slots(self.fed)))

    def tangents_of(self, states: Floats) -> Floats:
        """Derivatives of the initial coordinates and rates as tangents, shape (x, P)."""
        half = len(self.coordinates)
        rows = [*range(len(self.free)), *range(half, half + self.moved)]
        return np.asarray(states[rows])

    @cached_property
    def work_row(self) -> int | None:
        """Place of the work in an integrated vector; None if it is not integrated."""
        return self.size + len(self.coordinates) if self.work else None

    @cached_property
    def done_rows(self) -> Rows:
        """Places of the work, if it is integrated, and of the losses in an integrated vector."""
        first = self.size + len(self.coordinates)
        return np.arange(first, first + int(self.work) + self.losses)

    def motion(self, vectors: Floats) -> Floats:
        """Coordinates and their rates alone, shape (2m, …)."""
        result = np.asarray(vectors[self.motion_rows])
        result[len(self.free) : self.moved] = 0.0  # integrals of internal states
        return result

    def moving(self, states: Floats) -> Floats:
        """Motions from states as they are outside of the integration, shape (2m, …)."""
        result = np.zeros((2 * len(self.coordinates), *states.shape[1:]))
        result[self.state_rows] = states
        return result

    def work_done(self, vectors: Floats) -> Floats | None:
        """The work in joules, shape (…); None if it is not integrated."""
        return None if self.work_row is None else np.asarray(vectors[self.work_row])

    def lost(self, vectors: Floats) -> Floats:
        """The losses in joules, shape (losses, …)."""
        return np.asarray(vectors[self.done_rows[int(self.work) :]])

    def packed(
        self, motion: Floats, done: ArrayLike = 0.0, tangents: ArrayLike | None = None
    ) -> Floats:
        """An integrated vector from its parts, shape (2N,).

        Parameters
        ----------
        motion
            Coordinates and their rates, shape (2m,).
        done
            Work and losses so far in joules, those that are integrated.
        tangents
            Shape (x, tangents); zero if not given.
        """
        vector = np.zeros(2 * self.size)
        vector[self.motion_rows] = motion
        vector[self.done_rows] = done
        if tangents is not None:
            vector[self.tangent_rows] = tangents
        return vector
