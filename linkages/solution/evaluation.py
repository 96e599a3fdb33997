"""Output variables at the sample times, evaluated with NumPy from the nodes of the model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.outputs import VARIABLES, labels
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.solution.motion import Motion

_CHUNK = 2048
"""Samples evaluated at once: small enough for intermediate values to stay in the cache."""

ANGLES = {"bar_angle": "bar", "clearance_angle": "clearance"}


def evaluate_variables(
    system: System, motion: Motion, names: Sequence[str]
) -> dict[str, NDArray[np.float64]]:
    """Values of variables, each of shape (samples, …).

    Parameters
    ----------
    system, motion
        What moves, and how.
    names
        Entries of `linkages.kernel.outputs.VARIABLES`.
    """
    nodes: list[Scalar] = []
    places: dict[str, slice] = {}
    for name in names:
        start = len(nodes)
        nodes += VARIABLES[name].nodes(system.model)
        places[name] = slice(start, len(nodes))
    speeds = _speeds(system) if "bar_angle" in names else []
    values = _evaluated(system, motion, [*nodes, *speeds])
    found: dict[str, NDArray[np.float64]] = {}
    for name, place in places.items():
        rows = values[place]
        if name in ANGLES:
            rows = _unwrapped(system, motion, rows, ANGLES[name], values[len(nodes) :])
        elif name == "closure_residual":
            rows = np.abs(rows).max(axis=0, initial=0.0)[None]
        shape = tuple(len(labels(system.model, dim)) for dim in VARIABLES[name].dims)
        found[name] = np.ascontiguousarray(rows.T).reshape(len(motion.time), *shape)
    return found


def _evaluated(system: System, motion: Motion, nodes: list[Scalar]) -> NDArray[np.float64]:
    values = np.empty((len(nodes), len(motion.time)))
    for start in range(0, len(motion.time), _CHUNK):
        part = slice(start, start + _CHUNK)
        values[:, part] = system.evaluate(
            nodes, motion.time[part], motion.state[:, part], motion.acceleration[:, part]
        )
    return values


def _speeds(system: System) -> list[Scalar]:
    bodies = system.model.velocities.bodies
    return [bodies[name] for name in labels(system.model, "bar")]


def _unwrapped(
    system: System,
    motion: Motion,
    angles: NDArray[np.float64],
    dim: str,
    speeds: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Continuous angles, shape (bodies, samples).

    A free angle has its turns counted by the solver. A dependent one gets the whole turns that
    bring it closest to where its speeds at two samples say that it is.
    """
    for row, name in enumerate(labels(system.model, dim)):
        if name in system.topology.free:
            angles[row] += 2 * np.pi * motion.turns[system.topology.free.index(name)]
        elif name in system.topology.dependent:
            change = 0.5 * (speeds[row, 1:] + speeds[row, :-1]) * np.diff(motion.time)
            turns = np.round((change - np.diff(angles[row])) / (2 * np.pi))
            angles[row, 1:] += 2 * np.pi * np.cumsum(turns)
    return angles
