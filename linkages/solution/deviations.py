"""How tangents grow along a motion, from one sample to another at which they are renormalised."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.layout import Layout
from linkages.solvers.flow import Renormalisation
from linkages.solvers.trajectory import Trajectory

Floats = NDArray[np.float64]


class Renormalised:
    """Brings tangents back to length one after every so many samples, and keeps how they grew.

    Parameters
    ----------
    every
        After how many samples.
    orthogonal
        Whether they are made orthonormal, or only of length one each.
    """

    def __init__(self, every: int = 1, *, orthogonal: bool = True) -> None:
        self._every, self.orthogonal = every, orthogonal
        self._seen = 0
        self._grown: Floats | None = None
        self._lengths: list[Floats] = []
        self._tangents: list[Floats] = []

    def plan(self, layout: Layout) -> Renormalisation:
        """What the next integration is to do with its tangents."""
        if self._grown is None:
            self._grown = np.zeros(layout.tangents)
        return Renormalisation(
            size=layout.moved,
            placed=len(layout.free),
            columns=layout.tangents,
            grown=self._grown,
            every=self._every,
            offset=self._seen % self._every,
            orthogonal=self.orthogonal,
        )

    def add(self, trajectory: Trajectory, layout: Layout) -> None:
        """Take what an integration did."""
        self._lengths.append(trajectory.lengths)
        self._grown = trajectory.grown
        first = self._every - 1 - self._seen % self._every
        self._tangents.append(trajectory.state[first :: self._every, layout.tangent_rows])
        self._seen += len(trajectory.time)

    def led_through(self, layout: Layout, samples: Floats) -> Floats:
        """Take a part of the motion in which nobody renormalised tangents.

        Parameters
        ----------
        samples
            Tangents at the samples of that part, shape (samples, x, k).

        Returns
        -------
        What tangents at its end are multiplied by, shape (k, k).
        """
        plan = self.plan(layout)
        lengths, tangents, factor = plan.undone(samples, plan.grown)
        self._lengths.append(lengths)
        self._tangents.append(tangents)
        self._seen += len(samples)
        return factor

    @property
    def lengths(self) -> Floats:
        """Logarithms of the lengths before they were renormalised, shape (times, k)."""
        return np.concatenate(self._lengths)

    @property
    def tangents(self) -> Floats:
        """Tangents after that, shape (times, x, k), in the coordinates they were integrated in."""
        return np.concatenate(self._tangents)
