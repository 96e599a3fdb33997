"""Lengths of tangents that do not depend on which coordinates are free.

The kinetic energy measures displacements δq, by δqᵀ J δq, and what neighbours differ by in velocity
beyond that the mechanism is elsewhere, Dδq/dt = δq̇ + J⁻¹K δq with K_ij = ⟨∂v/∂q̇_i, ∂v/∂q_j⟩ over
all masses (the metric of Sasaki [1]_). Of all states its volumes are det J times those of
coordinates and rates, as volumes of coordinates and momenta are.

References
----------
.. [1] S. Sasaki, Tôhoku Math. J. 10 (1958) 338: on the differential geometry of tangent bundles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.growth.volumes import Volumes
from linkages.kernel.graph.differentiation import derivative
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.vectors import Vector
from linkages.kernel.model import Model
from linkages.solution.moving.evaluation import evaluate_nodes
from linkages.solution.moving.motion import Motion, Piece

Floats = NDArray[np.float64]


@dataclass
class _Moved:
    """Derivatives of velocities by a coordinate."""

    joints: dict[str, Vector]
    bodies: dict[str, Scalar]

    def turning(self, name: str) -> Scalar:
        """Of the angular speed of a body."""
        return self.bodies[name]


def _carried_along(model: Model) -> list[Scalar]:
    """K, row by row."""
    inertia, velocities = model.inertia, model.velocities
    joints, bodies = [*model.positions.joints], [*inertia.moments]
    places = [velocities.joints[name] for name in joints]
    nodes = [node for place in places for node in (place.x, place.y)]
    nodes += [velocities.turning(name) for name in bodies]
    count = len(model.topology.free)
    slopes = derivative(nodes, [model.inputs.coordinate(i) for i in range(count)])
    fields = []
    for column in range(count):
        own = [row[column] for row in slopes]
        moved = {name: Vector(*own[2 * k : 2 * k + 2]) for k, name in enumerate(joints)}
        turned = dict(zip(bodies, own[2 * len(joints) :], strict=True))
        fields.append(_Moved(moved, turned))
    return [inertia.product(field, partial) for partial in model.partials for field in fields]


def _measures(piece: Piece) -> Floats:
    """Matrices L with lengths |L δ| of tangents δ at the samples, shape (times, x, x)."""
    system = piece.system
    count, size = len(system.topology.free), system.layout.directions
    root = np.linalg.cholesky(Volumes(system).masses(piece))
    found = np.tile(np.eye(size), (len(root), 1, 1))
    upper = np.swapaxes(root, 1, 2)
    values = piece.interpolated(evaluate_nodes(piece, _carried_along(system.model)))
    along = values.T.reshape(-1, count, count)
    found[:, :count, :count] = found[:, count : 2 * count, count : 2 * count] = upper
    found[:, count : 2 * count, :count] = np.linalg.solve(root, along)
    return found


def _logarithms(tangents: Floats, orthogonal: bool) -> Floats:
    """Of lengths, each less its parts along tangents before it if orthogonal, shape (times, k)."""
    with np.errstate(divide="ignore"):
        if orthogonal:
            upper = np.linalg.qr(tangents)[1]
            return np.log(np.abs(np.diagonal(upper, axis1=1, axis2=2)))
        return np.log(np.linalg.norm(tangents, axis=1))


class FixedMetric:
    """Corrects how tangents grow, from the first exchange of coordinates in a run on.

    Until then lengths are those in the coordinates themselves. At the exchange the growth since the
    start becomes that in this metric, so that the ratio of old and new lengths is no part of it.

    Parameters
    ----------
    start
        Where the motion is at the start, as one sample.
    tangents
        There, shape (x, k).

    """

    def __init__(self, start: Piece, tangents: Floats) -> None:
        self._start, self._tangents = start, tangents
        self._before: Floats | None = None

    @property
    def exchanged(self) -> bool:
        """Whether lengths are those of this metric."""
        return self._before is not None

    def corrected(
        self, lengths: Floats, ends: Motion, tangents: Floats, orthogonal: bool
    ) -> Floats:
        """Logarithms of lengths by which tangents have grown in some intervals.

        Parameters
        ----------
        lengths
            The same in the coordinates themselves, shape (intervals, k).
        ends
            The motion at their ends.
        tangents
            There, in the coordinates of its pieces, shape (intervals, x, k).
        orthogonal
            Whether they have been made orthonormal, or only of length one each.
        """
        free = self._start.system.topology.free
        pieces = [piece for piece in ends.pieces if len(piece.wanted)]
        other = [piece.system.topology.free != free for piece in pieces]
        if self._before is None:
            if not any(other):
                return lengths
            kept = sum(len(piece.wanted) for piece in pieces[: other.index(True)])
            pieces = pieces[other.index(True) :]
            self._before = self._beyond([self._start], self._tangents[None], orthogonal)[-1]
        else:
            kept = 0
        beyond = self._beyond(pieces, tangents[kept:], orthogonal)
        moved = np.diff(np.vstack([self._before, beyond]), axis=0)
        self._before = beyond[-1]
        found = lengths.copy()
        found[kept:] += np.where(np.isneginf(found[kept:]), 0.0, moved)
        return found

    def _beyond(self, pieces: list[Piece], tangents: Floats, orthogonal: bool) -> Floats:
        """Logarithms of lengths in this metric over those in the coordinates, shape (times, k)."""
        measures = np.concatenate([_measures(piece) for piece in pieces])
        both = (_logarithms(each, orthogonal) for each in (measures @ tangents, tangents))
        ours, plain = both
        lost = np.isneginf(plain)
        return np.where(lost, 0.0, ours) - np.where(lost, 0.0, plain)
