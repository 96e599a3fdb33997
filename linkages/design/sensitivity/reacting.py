"""How joint reactions change with numbers: A r = b, so A dr = db − dA r."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import Parameter, Path
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.numbers.effects import Effects, slots
from linkages.solution.moving.motion import Piece
from linkages.solution.values.reactions import Statics

Floats = NDArray[np.float64]
OfNodes = Callable[[Piece, Sequence[Scalar]], tuple[Floats, Floats]]
"""Values of nodes in a piece, and their derivatives, shapes (nodes, n) and (nodes, P, n)."""

_STEP = 1e-40
"""Into the complex plane: A and b are polynomials, so imaginary parts are derivatives [1]_.

.. [1] W. Squire, G. Trapp, SIAM Review 40 (1998) 110.
"""

_CHUNK = 1024


def changing_reactions(piece: Piece, of_nodes: OfNodes, effects: Effects) -> tuple[Floats, Floats]:
    """Reactions and their derivatives, shapes (r, n) and (r, P, n), in the order of `row_of`.

    Parameters
    ----------
    piece
        Samples of a motion.
    of_nodes
        What evaluates nodes with their derivatives.
    effects
        What changes with the numbers.

    Raises
    ------
    ValueError
        Where constraints are redundant, so that rigid bodies do not determine reactions.
    """
    starts = range(0, len(piece.time), _CHUNK) or [0]
    parts = [_of_chunk(piece.part(slice(k, k + _CHUNK)), of_nodes, effects) for k in starts]
    values, changes = zip(*parts, strict=True)
    return np.concatenate(values, axis=1), np.concatenate(changes, axis=2)


def _of_chunk(piece: Piece, of_nodes: OfNodes, effects: Effects) -> tuple[Floats, Floats]:
    known: dict[tuple[int, ...], tuple[Floats, Floats]] = {}

    def evaluated(nodes: Sequence[Scalar]) -> tuple[Floats, Floats]:
        key = tuple(node.index for node in nodes)
        if key not in known:
            known[key] = of_nodes(piece, nodes)
        return known[key]

    asked = piece.system.model, piece.system.topology, len(piece.time)
    statics = Statics(*asked, lambda nodes: evaluated(nodes)[0])
    matrix, right = statics.equations()
    if matrix.shape[1] != matrix.shape[2]:
        raise ValueError(
            "joint reactions: constraints are redundant, so that rigid bodies do not determine "
            "them; no derivative is known"
        )
    forces = np.linalg.solve(matrix, right[..., None])[..., 0]
    columns = []
    for number, slopes in enumerate(_slopes(effects)):

        def along(nodes: Sequence[Scalar], number: int = number) -> NDArray[np.complex128]:
            values, changes = evaluated(nodes)
            return values + 1j * _STEP * changes[:, number]

        def moved(parameter: Parameter, slopes: dict[Path, float] = slopes) -> complex:
            return parameter.value + 1j * _STEP * slopes.get(parameter.path, 0.0)

        equations = Statics(*asked, along, moved).equations()
        beside, push = (part.imag / _STEP for part in equations)
        columns.append(push - (beside @ forces[..., None])[..., 0])
    found = np.linalg.solve(matrix, np.stack(columns, axis=-1)) if columns else None
    count = len(piece.time)
    values = statics.at_places(forces).reshape(count, -1).T
    changes = np.empty((len(values), len(effects), count))
    for number in range(len(effects)):
        assert found is not None
        changes[:, number] = statics.at_places(found[..., number]).reshape(count, -1).T
    return values, changes


def _slopes(effects: Effects) -> list[dict[Path, float]]:
    """For each number the parameters that it feeds, with their derivatives."""
    found: list[dict[Path, float]] = [{} for _ in range(len(effects))]
    for (number, path), slope in zip(slots(effects.fed), effects.slopes.tolist(), strict=True):
        found[number][path] = slope
    return found
