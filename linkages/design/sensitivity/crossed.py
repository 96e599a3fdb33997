"""Times at which laws change branch with what moves, in motions that drives determine."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.design.sensitivity.breaks import Break
from linkages.design.sensitivity.derived import Derivatives, moved_by
from linkages.kernel.graph.differentiation import derivative_along
from linkages.kernel.graph.scalars import Level, Scalar
from linkages.kernel.numbers.effects import Effects
from linkages.solution.measuring.branches import conditions_of, more_looks
from linkages.solution.measuring.course import between, unchanged
from linkages.solution.measuring.followed import APART
from linkages.solution.moving.evaluation import evaluate_nodes
from linkages.solution.moving.motion import Motion, Piece

Floats = NDArray[np.float64]

_HALVINGS = 60


def crossed(
    nodes: Sequence[Scalar], motion: Motion, effects: Effects, derivatives: Derivatives
) -> list[Break]:
    """All changes of branch between the samples of a motion that nothing is integrated of.

    Parameters
    ----------
    nodes
        What depends on the laws. Where something is integrated, these changes are modes.
    motion
        Sampled; as few changes lie between two samples as can be told from these.
    effects, derivatives
        What changes with the numbers, and how.
    """
    conditions = conditions_of(nodes, Level.STATE)
    if not conditions:
        return []
    apart = APART * float(np.spacing(motion.time[-1]))
    found = []
    for piece in motion.pieces:
        if piece.samples is None and len(piece.time) > 1:
            found += [
                Break(time, time - apart, time + apart, moved)
                for condition in conditions
                for time, moved in _of_piece(condition, piece, effects, derivatives)
            ]
    return sorted(found, key=lambda one: one.time)


def _of_piece(
    condition: Scalar, piece: Piece, effects: Effects, derivatives: Derivatives
) -> list[tuple[float, Floats]]:
    """Times in a piece at which a condition changes, and how numbers move them."""
    model, whole = piece.system.model, np.arange(len(piece.time) - 1)
    clock = {model.inputs.time.index: model.graph.one}
    ((rate,),) = derivative_along([condition], [clock])
    kept = unchanged(piece, whole)
    values, rates = evaluate_nodes(piece, [condition, rate])
    further = more_looks(piece.time, values[None], rates[None])
    places = np.union1d(
        np.arange(len(piece.time)) + 0.0, np.interp(further, piece.time, np.arange(len(piece.time)))
    )

    def at(places: Floats) -> Piece:
        interval = np.minimum(places.astype(int), len(whole) - 1)
        return between(piece, interval, places - interval)

    looked = evaluate_nodes(at(places), [condition])[0] if len(further) else values
    side = looked < 0.0
    changes = (side[:-1] != side[1:]) & kept[np.minimum(places[:-1].astype(int), len(whole) - 1)]
    low, high, before = places[:-1][changes], places[1:][changes], side[:-1][changes]
    if not len(low):
        return []
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        same = (evaluate_nodes(at(middle), [condition])[0] < 0.0) == before
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    there = at(high)
    _, slopes = derivatives.of_nodes(there, [condition], effects)
    (pace,) = evaluate_nodes(there, [rate])
    by = np.column_stack([slopes[0].T, pace])
    # without any it jumps where another one does, on which it depends
    return [
        (float(time), moved_by(row)) for time, row in zip(there.time, by, strict=True) if row.any()
    ]
