"""Tangents to start from."""

from __future__ import annotations

import contextlib

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.growth.systems import TangentSystem

Floats = NDArray[np.float64]

_SEED = 20240501


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
