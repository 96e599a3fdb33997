"""States of a motion as one array, whatever it was integrated in on the way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.outputs import VARIABLES, coordinate_of, labels
from linkages.kernel.system import System
from linkages.solution.moving.evaluation import evaluate_variables
from linkages.solution.moving.motion import Motion, Piece

Floats = NDArray[np.float64]


def free_vectors(
    system: System,
    motion: Motion,
    *,
    names: tuple[str, ...] | None = None,
    turns: bool = True,
) -> Floats:
    """Free coordinates, rates and internal states, whatever coordinates it was integrated in.

    Parameters
    ----------
    system, motion
        Whose coordinates, and how it moves.
    names
        Other coordinates that are asked for instead.
    turns
        Whether angles have all the turns that they have made.

    Returns
    -------
    Shape (samples, 2n + s).
    """
    names = system.topology.free if names is None else names
    found = [_of_piece(system, piece, names, turns) for piece in motion.pieces]
    return np.concatenate(found, axis=1).T


def _of_piece(system: System, piece: Piece, names: tuple[str, ...], turns: bool) -> Floats:
    """Shape (2n + s, samples)."""
    layout = piece.system.layout
    if layout.bodies[: len(names)] != names or piece.samples is not None:
        return np.concatenate([_evaluated(system, piece, names), _internal(piece)])
    places = [layout.coordinates.index(name) for name in names]
    found = np.concatenate([piece.state[places], piece.state[len(piece.turns) :][places]])
    if turns:
        found[: len(names)] += 2 * np.pi * piece.turns[places]
    return np.concatenate([found, _internal(piece)])


def _internal(piece: Piece) -> Floats:
    """Internal states, shape (s, samples)."""
    return piece.interpolated(piece.state[piece.system.layout.internal_rows])


def _evaluated(system: System, piece: Piece, names: tuple[str, ...]) -> Floats:
    """The same from outputs."""
    bodies = system.mechanism.bodies
    coordinates = {name: coordinate_of(bodies[name].kind) for name in names}
    rates = {name: VARIABLES[output].rate for name, output in coordinates.items()}
    wanted = list(dict.fromkeys([*coordinates.values(), *rates.values()]))
    values = evaluate_variables(Motion(pieces=(piece,)), wanted)
    rows = []
    for outputs in (coordinates, rates):
        for name, output in outputs.items():
            index = labels(system.model, VARIABLES[output].dims[0]).index(name)
            rows.append(values[output][:, index])
    return np.array(rows)
