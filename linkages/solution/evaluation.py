"""Output variables at the sample times, evaluated with NumPy from the nodes of the model."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.load_measures import Turn
from linkages.kernel.outputs import VARIABLES, Variable, labels
from linkages.kernel.scalars import Scalar
from linkages.solution.motion import Motion, Piece

_CHUNK = 2048
"""Samples evaluated at once: small enough for intermediate values to stay in the cache."""

Values = dict[str, NDArray[np.float64]]

ValuesOf = Callable[[Piece, Sequence[str]], NDArray[np.float64]]
"""A piece and names of variables → values of their nodes, as `variable_values` has them."""


def evaluate_variables(
    motion: Motion, names: Sequence[str], values: ValuesOf | None = None
) -> Values:
    """Values of variables, each of shape (samples, …)."""
    values = values or variable_values
    # between two samples a motion may pass many change points
    pieces = [piece for piece in motion.pieces if len(piece.wanted)] or motion.pieces[:1]
    smooth = [name for name in names if not VARIABLES[name].unbounded]
    poles = [name for name in names if VARIABLES[name].unbounded]
    parts = [
        piece_variables(piece, smooth, values) | piece_variables(piece.direct(), poles, values)
        for piece in pieces
    ]
    joined = {name: np.concatenate([part[name] for part in parts], axis=1) for name in names}
    system = motion.pieces[0].system
    result: Values = {}
    for name, rows in joined.items():
        shape = tuple(len(labels(system.model, dim)) for dim in VARIABLES[name].dims)
        result[name] = np.ascontiguousarray(rows.T).reshape(rows.shape[1], *shape)
    return result


def variable_values(piece: Piece, names: Sequence[str]) -> NDArray[np.float64]:
    """Values of the nodes of variables, one after the other, shape (nodes, times)."""
    model = piece.system.model
    return evaluate_nodes(piece, [n for name in names for n in VARIABLES[name].evaluated(model)])


def piece_variables(piece: Piece, names: Sequence[str], of: ValuesOf = variable_values) -> Values:
    """Values of variables in a piece of a motion, each of shape (elements, wanted samples)."""
    count, places = 0, {}
    for name in names:
        own = len(VARIABLES[name].evaluated(piece.system.model))
        places[name], count = slice(count, count + own), count + own
    values = of(piece, names)
    result: Values = {}
    for name, place in places.items():
        rows, variable = values[place], VARIABLES[name]
        if variable.angle:
            rows = _with_turns(piece, rows, variable.dims[0])
        if variable.reduced is not None:
            rows = variable.reduced(rows)
        result[name] = _interpolated(piece, rows, variable)
    return result


def _interpolated(
    piece: Piece, rows: NDArray[np.float64], variable: Variable
) -> NDArray[np.float64]:
    """Values at the wanted times; of what may be infinite, the reciprocal is smooth."""
    if piece.samples is None or not variable.reciprocal:
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
            held=None if piece.held is None else piece.held[:, part],
        )
    return values


def _with_turns(piece: Piece, angles: NDArray[np.float64], dim: str) -> NDArray[np.float64]:
    """Continuous angles, (bodies, samples); those without counted turns stay within one turn."""
    model = piece.system.model
    if dim == "rotary_actuator":
        return _with_relative_turns(piece, angles)
    return _continuous(piece, angles, labels(model, dim))


def _with_relative_turns(piece: Piece, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles of actuators, with the turns that their bodies have made."""
    model = piece.system.model
    turns = [own.measure for own in model.actuators if isinstance(own.measure, Turn)]
    for value, turn in zip(values, turns, strict=True):
        own = evaluate_nodes(piece, [model.positions.angle(name) for name in turn.bodies])
        angle, *others = _continuous(piece, own, turn.bodies)
        value += 2 * np.pi * np.round((angle - sum(others) - value) / (2 * np.pi))
    return values


def _continuous(
    piece: Piece, angles: NDArray[np.float64], names: Sequence[str]
) -> NDArray[np.float64]:
    """Angles of bodies with their turns."""
    topology = piece.system.topology
    for row, name in enumerate(names):
        if name in topology.coordinates:
            angles[row] += 2 * np.pi * piece.turns[topology.coordinates.index(name)]
        elif name in piece.counted:
            angles[row] += 2 * np.pi * np.round((piece.counted[name] - angles[row]) / (2 * np.pi))
    return angles
