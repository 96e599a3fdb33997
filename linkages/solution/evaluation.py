"""Output variables at the sample times, evaluated with NumPy from the nodes of the model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.outputs import VARIABLES, labels
from linkages.kernel.scalars import Scalar
from linkages.solution.motion import Motion, Piece
from linkages.topology.topology import Topology

_CHUNK = 2048
"""Samples evaluated at once: small enough for intermediate values to stay in the cache."""

ADVANTAGES = ("mechanical_advantage", "slider_mechanical_advantage")
ANGLES = {"bar_angle": "bar", "clearance_angle": "clearance"}

POLES = ("clearance_force", "transmission_angle", "load_force", "load_torque")
"""Outputs that may grow without bound towards a change point, or have a kink or a jump there: they
cannot be interpolated."""

Values = dict[str, NDArray[np.float64]]


def evaluate_variables(motion: Motion, names: Sequence[str]) -> Values:
    """Values of variables, each of shape (samples, …).

    Parameters
    ----------
    motion
        How the mechanism moves.
    names
        Entries of `linkages.kernel.outputs.VARIABLES`.
    """
    smooth = [name for name in names if name not in POLES]
    poles = [name for name in names if name in POLES]
    parts = [
        piece_variables(piece, smooth) | piece_variables(piece.direct(), poles)
        for piece in motion.pieces
    ]
    joined = {name: _joined(motion, [part[name] for part in parts], name) for name in names}
    system = motion.pieces[0].system
    found: Values = {}
    for name, rows in joined.items():
        shape = tuple(len(labels(system.model, dim)) for dim in VARIABLES[name].dims)
        found[name] = np.ascontiguousarray(rows.T).reshape(rows.shape[1], *shape)
    return found


def piece_variables(piece: Piece, names: Sequence[str]) -> Values:
    """Values of variables in a piece of a motion, each of shape (elements, wanted samples)."""
    nodes: list[Scalar] = []
    places: dict[str, slice] = {}
    for name in names:
        start = len(nodes)
        nodes += VARIABLES[name].nodes(piece.system.model)
        places[name] = slice(start, len(nodes))
    turning = [dim for name, dim in ANGLES.items() if name in names]
    speeds = [node for dim in turning for node in _speeds(piece, dim)]
    values = evaluate_nodes(piece, [*nodes, *speeds])
    taken = len(nodes)
    found: Values = {}
    for name, place in places.items():
        rows = values[place]
        if name in ANGLES:
            rows = _unwrapped(piece, rows, ANGLES[name], values[taken : taken + len(rows)])
            taken += len(rows)
        elif name == "closure_residual":
            rows = np.abs(rows).max(axis=0, initial=0.0)[None]
        elif name == "transmission_angle":
            rows = np.abs(rows)  # atan2(-0.0, -1.0) is -π
        found[name] = _interpolated(piece, rows, name)
    return found


def _interpolated(piece: Piece, rows: NDArray[np.float64], name: str) -> NDArray[np.float64]:
    """Values at the wanted times; of what may be infinite, the reciprocal is smooth."""
    if piece.samples is None or name not in ADVANTAGES:
        return piece.interpolated(rows)
    with np.errstate(divide="ignore"):
        return 1.0 / piece.interpolated(1.0 / rows)


def evaluate_nodes(piece: Piece, nodes: list[Scalar]) -> NDArray[np.float64]:
    """Values of nodes of a piece's model at its times, shape (nodes, times)."""
    values = np.empty((len(nodes), len(piece.time)))
    for start in range(0, len(piece.time), _CHUNK):
        part = slice(start, start + _CHUNK)
        flipped = {block: where[part] for block, where in piece.flipped.items()}
        values[:, part] = piece.system.evaluate(
            nodes,
            piece.time[part],
            piece.state[:, part],
            piece.acceleration[:, part],
            flipped=flipped,
        )
    return values


def _speeds(piece: Piece, dim: str) -> list[Scalar]:
    velocities = piece.system.model.velocities
    return [velocities.turning(name) for name in labels(piece.system.model, dim)]


def _unwrapped(
    piece: Piece, angles: NDArray[np.float64], dim: str, speeds: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Continuous angles, shape (bodies, samples).

    An integrated angle has its turns counted by the solver, and one that follows from others by a
    ratio has theirs. Any other gets the whole turns that bring it closest to where its speeds at
    two samples say that it is.
    """
    topology = piece.system.topology
    for row, name in enumerate(labels(piece.system.model, dim)):
        if name in topology.coordinates:
            angles[row] += 2 * np.pi * piece.turns[topology.coordinates.index(name)]
        elif name in topology.dependent and not _follows(topology, name):
            change = 0.5 * (speeds[row, 1:] + speeds[row, :-1]) * np.diff(piece.time)
            turns = np.round((change - np.diff(angles[row])) / (2 * np.pi))
            angles[row, 1:] += 2 * np.pi * np.cumsum(turns)
    return angles


def _follows(topology: Topology, name: str) -> bool:
    """Whether an angle follows from others that count with their whole turns."""
    return name in topology.slaves and name in topology.turned


def _joined(motion: Motion, parts: list[NDArray[np.float64]], name: str) -> NDArray[np.float64]:
    """Rows of all pieces in a row; angles go on from piece to piece."""
    rows, added = parts[0], np.zeros(len(parts[0]))
    for piece, part in zip(motion.pieces[1:], parts[1:], strict=True):
        if name in ANGLES and part.shape[1] and rows.shape[1]:
            moved = _moved(motion, piece, rows.shape[1], name)
            turns = np.round((moved - (part[:, 0] - rows[:, -1])) / (2 * np.pi))
            known, counted = _known(piece, name), _counted(motion, piece, name)
            added = np.select([known, counted], [np.zeros_like(turns), added], turns)
            part = part + 2 * np.pi * added[:, None]
        rows = np.concatenate([rows, part], axis=1)
    return rows


def _known(piece: Piece, name: str) -> NDArray[np.bool_]:
    """Which angles have all their turns in every piece."""
    topology = piece.system.topology
    names = labels(piece.system.model, ANGLES[name])
    return np.array([n in topology.driven or _follows(topology, n) for n in names], dtype=bool)


def _counted(motion: Motion, piece: Piece, name: str) -> NDArray[np.bool_]:
    """Which angles have had their turns counted by the solver since the piece before."""
    before = [p for p in motion.pieces[: motion.pieces.index(piece)] if p.wanted.size][-1]
    names = labels(piece.system.model, ANGLES[name])
    same = before.system is piece.system
    counted = piece.system.topology.coordinates
    return np.array([same and n in counted for n in names], dtype=bool)


def _moved(motion: Motion, piece: Piece, reached: int, name: str) -> NDArray[np.float64]:
    """How far bodies turn between the last sample before a piece and its first one."""
    before = [p for p in motion.pieces[: motion.pieces.index(piece)] if p.wanted.size][-1]
    gap = piece.wanted[0] - motion.time[reached - 1]
    speed = name.replace("angle", "speed")
    first = piece_variables(before, [speed])[speed][:, -1]
    second = piece_variables(piece, [speed])[speed][:, 0]
    return np.asarray(0.5 * (first + second) * gap)
