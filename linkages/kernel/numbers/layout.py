"""What stands where in the arrays of an integration: names of coordinates and parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.components.contributed.terms import Path
from linkages.topology.topology import Topology

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]


@dataclass(frozen=True)
class Layout:
    """Places of everything that is integrated, and of the parameters.

    An integrated vector is ``[free, carried, work, tangents | rates of the same]``, shape (2N,).
    The work is the rate of its coordinate, which itself means nothing; a tangent has one entry for
    each free coordinate, and a rate for each of them. The motion alone is ``[free, carried | rates
    of the same]``, shape (2m,). Vectors may have further axes behind the first.

    Parameters
    ----------
    free
        Bodies whose coordinates move freely.
    carried
        Dependent bodies whose coordinates the integration carries along.
    counted
        Dependent bodies whose whole turns are counted beside the vector.
    work
        Whether the work of drives and loads is integrated as well.
    tangents
        Number of solutions of the variational equations.
    parameters
        Path of each entry of the parameter array.
    modes, memories
        Names of modes, and of what a motion remembers. They are held beside the vector, ``[modes,
        memories, memories of the first tangent, …]``, shape (h,).
    """

    free: tuple[str, ...]
    carried: tuple[str, ...] = ()
    counted: tuple[str, ...] = ()
    work: bool = False
    tangents: int = 0
    parameters: tuple[Path, ...] = ()
    modes: tuple[str, ...] = ()
    memories: tuple[str, ...] = ()

    @classmethod
    def of(
        cls, topology: Topology, work: bool = False, tangents: int = 0, counting: bool = False
    ) -> Layout:
        """The layout of a mechanism's integration, without parameters."""
        counted = topology.counted if counting else ()
        return cls(topology.free, topology.carried, counted, work, tangents)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Bodies whose coordinate is integrated."""
        return (*self.free, *self.carried)

    @property
    def size(self) -> int:
        """Number N of integrated coordinates, with the work and the tangents."""
        return len(self.coordinates) + self.more

    @property
    def more(self) -> int:
        """Number of integrated coordinates beyond those of the motion."""
        return int(self.work) + self.tangents * len(self.free)

    @cached_property
    def motion_rows(self) -> Rows:
        """Places of the motion in an integrated vector, shape (2m,)."""
        first = np.arange(len(self.coordinates))
        return np.concatenate([first, self.size + first])

    @cached_property
    def carried_rows(self) -> Rows:
        """Places of what is carried along and its rates in the motion, shape (2c,)."""
        count = len(self.coordinates)
        first = np.arange(len(self.free), count)
        return np.concatenate([first, count + first])

    @cached_property
    def tangent_rows(self) -> Rows:
        """Places of the tangents in an integrated vector, shape (2n, tangents)."""
        n = len(self.free)
        first = self.size - self.tangents * n
        places = first + np.arange(self.tangents) * n + np.arange(n)[:, None]
        return np.concatenate([places, self.size + places])

    @property
    def held(self) -> int:
        """Number h of modes, memories and tangents of memories."""
        return len(self.modes) + len(self.memories) * (1 + self.tangents)

    @property
    def remembered(self) -> int:
        """Number of modes and memories, without their tangents."""
        return len(self.modes) + len(self.memories)

    def named(self, held: Floats) -> dict[str, Floats]:
        """What is held by its name, for other free coordinates: a memory with its tangents."""
        modes, memories = held[: len(self.modes)], held[len(self.modes) :]
        rows = memories.reshape(1 + self.tangents, len(self.memories)).T if self.held else ()
        found = {name: modes[k : k + 1] for k, name in enumerate(self.modes)}
        return found | dict(zip(self.memories, rows, strict=True))

    def holding(self, named: Mapping[str, Floats]) -> Floats:
        """What is held in this layout, from its names, shape (h,)."""
        modes = [named[name] for name in self.modes]
        return np.concatenate([*modes, np.array([named[name] for name in self.memories]).T.ravel()])

    @property
    def work_row(self) -> int | None:
        """Place of the work in an integrated vector; None if it is not integrated."""
        return self.size + len(self.coordinates) if self.work else None

    def motion(self, vectors: Floats) -> Floats:
        """Coordinates and their rates without work and tangents, shape (2m, …)."""
        return np.asarray(vectors[self.motion_rows])

    def work_done(self, vectors: Floats) -> Floats | None:
        """The work in joules, shape (…); None if it is not integrated."""
        return None if self.work_row is None else np.asarray(vectors[self.work_row])

    def packed(
        self, motion: Floats, work: float = 0.0, tangents: ArrayLike | None = None
    ) -> Floats:
        """An integrated vector from its parts, shape (2N,).

        Parameters
        ----------
        motion
            Coordinates and their rates, shape (2m,).
        work
            Work done so far in joules, if it is integrated.
        tangents
            Shape (2n, tangents); zero if not given.
        """
        vector = np.zeros(2 * self.size)
        vector[self.motion_rows] = motion
        if self.work_row is not None:
            vector[self.work_row] = work
        if tangents is not None:
            vector[self.tangent_rows] = tangents
        return vector
