"""A mechanism with deviation vectors, and their metric.

The kinetic energy measures displacements δq, by δqᵀ J δq, and what neighbours differ by in velocity
beyond that the mechanism is elsewhere, Dδq/dt = δq̇ + J⁻¹K δq with K_ij = ⟨∂v/∂q̇_i, ∂v/∂q_j⟩ over
all masses (the metric of Sasaki [1]_). Of all states its volumes are det J times those of
coordinates and rates, as volumes of coordinates and momenta are.

References
----------
.. [1] S. Sasaki, Tôhoku Math. J. 10 (1958) 338: on the differential geometry of tangent bundles.
"""

from __future__ import annotations

import copy
import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.contact_log import ContactLog
from linkages.chaos.exponents import Growth, part_of
from linkages.chaos.free_states import circular, wrapped
from linkages.chaos.volume_contraction import Volumes
from linkages.errors import ComputationError, Interrupted
from linkages.kernel.differentiation import derivative
from linkages.kernel.model import Model
from linkages.kernel.scalars import Scalar, Vector
from linkages.kernel.system import System
from linkages.options.run import DEFAULTS, RunOptions
from linkages.solution.contact_episodes import Touch, slowest_touch, touch_counts
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.guards import free_vectors
from linkages.solution.march import March
from linkages.solution.motion import TANGENT_ATOL, Motion, Piece, Renormalised

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
    result = np.tile(np.eye(size), (len(root), 1, 1))
    upper = np.swapaxes(root, 1, 2)
    values = piece.interpolated(evaluate_nodes(piece, _carried_along(system.model)))
    along = values.T.reshape(-1, count, count)
    result[:, :count, :count] = result[:, count : 2 * count, count : 2 * count] = upper
    result[:, count : 2 * count, :count] = np.linalg.solve(root, along)
    return result


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

    `start`: where the motion is at the start, as one sample.
    `tangents`: there, shape (x, k).
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

        `lengths`: the same in the coordinates themselves, shape (intervals, k).
        `tangents`: there, in the coordinates of its pieces, shape (intervals, x, k).
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
        result = lengths.copy()
        result[kept:] += np.where(np.isneginf(result[kept:]), 0.0, moved)
        return result

    def _beyond(self, pieces: list[Piece], tangents: Floats, orthogonal: bool) -> Floats:
        """Logarithms of lengths in this metric over those in the coordinates, shape (times, k)."""
        measures = np.concatenate([_measures(piece) for piece in pieces])
        both = (_logarithms(each, orthogonal) for each in (measures @ tangents, tangents))
        ours, plain = both
        lost = np.isneginf(plain)
        return np.where(lost, 0.0, ours) - np.where(lost, 0.0, plain)


MOST_NUMBERS = 2**22
"""Numbers in the samples of one integration: some 32 MiB, tangents included."""


class LinkageTangents:
    """States of a mechanism, with solutions of the variational equations.

    The free coordinates are those of the system at its start; where the motion is integrated in
    others for a while, the state is still in these, and tangents are in those. How they grow does
    not depend on it.

    `system`: a system with free coordinates.
    `tangents`: number of tangents, at most x, the number of free coordinates, rates and internal
    states.
    `run`: how it is integrated; `max_steps` are those of all advances together.
    `parts`: equal parts of every interval after which `motion` keeps where it is; none if 0.
    `log`: notes the motion for what is asked of forces later, if there is one.
    `march`: how it moves.
    `parts`: that number.
    `metric`: how lengths of tangents are measured, from the last beginning of `batches` on.
    """

    def __init__(
        self,
        system: System,
        tangents: int = 1,
        run: RunOptions = DEFAULTS,
        *,
        parts: int = 0,
        log: ContactLog | None = None,
    ) -> None:
        self.system = system
        self.march = March(system, run, tangents=tangents)
        self.parts, self._log = parts, log
        self._begin()

    def _begin(self) -> None:
        start = Motion(pieces=(self.march.sample,))
        self._kept: list[Motion] = [start] if self.parts else []
        self._ends = [start]
        self._touching: list[Motion] = []
        self.metric = FixedMetric(self.march.sample, self.tangents)

    def __copy__(self) -> LinkageTangents:
        """Another one in the same state, which goes its own way from there."""
        result = object.__new__(type(self))
        vars(result).update(vars(self), march=copy.copy(self.march))
        result._begin()
        return result

    def starting(self, run: RunOptions) -> LinkageTangents:
        """Another one in the same state, integrated in another way."""
        result = copy.copy(self)
        result.march = self.march.starting(run)
        result._log = None
        return result

    @property
    def _size(self) -> int:
        return len(self.system.topology.free)

    @property
    def time(self) -> float:
        """Seconds."""
        return self.march.time

    @property
    def furthest(self) -> float:
        """Any ratio of lengths: steps bring tangents back before errors show in the shortest."""
        return math.inf

    @property
    def tolerance(self) -> float:
        """Error of a step in tangents of length one."""
        return max(TANGENT_ATOL, self.march.run.rtol)

    @property
    def angles(self) -> NDArray[np.bool_]:
        """Which entries of the state are angles, kept within one turn."""
        return circular(self.system)

    @property
    def state(self) -> Floats:
        """Free coordinates, their rates, and internal states, shape (x,)."""
        return self._states(Motion(pieces=(self.march.sample,)))[0]

    @property
    def here(self) -> System:
        """The system, where the motion is now."""
        return self.march.here

    @property
    def turned(self) -> Floats:
        """Free coordinates with all turns at the start and at ends of intervals, shape (m, n)."""
        result = [free_vectors(self.system, ends)[:, : self._size] for ends in self._ends]
        return np.concatenate(result)

    @property
    def motion(self) -> Motion:
        """What was kept of the motion: its start, then the ends of parts of each interval."""
        return replace(
            self._kept[-1],
            pieces=tuple(piece for part in self._kept for piece in part.pieces),
            notes=tuple(note for part in self._kept for note in part.notes),
        )

    def slowest(self, since: float = -math.inf) -> Touch | None:
        """The touch at the smallest rate in integrations that began at a time or later, if any."""
        result = [slowest_touch(part) for part in self._touched(since)]
        return min((touch for touch in result if touch is not None), default=None)

    def touches(self, since: float = -math.inf) -> dict[str, int]:
        """How often each contact was touched in integrations that began at a time or later."""
        result: Counter[str] = Counter()
        for part in self._touched(since):
            result.update(touch_counts(part))
        return dict(result)

    def _touched(self, since: float) -> list[Motion]:
        return [part for part in self._touching if part.time[0] > since]

    @property
    def tangents(self) -> Floats:
        """Of the coordinates that the motion is integrated in, shape (x, k)."""
        return self.march.tangents

    @tangents.setter
    def tangents(self, values: Floats) -> None:
        self.march.tangents = values

    def advance(self, interval: float) -> None:
        """Integrate motion and tangents over a time in seconds."""
        motion = self.march.advance(np.array([self.time + interval]))
        self.require(motion)

    def grow(
        self,
        intervals: int,
        interval: float,
        *,
        orthogonal: bool = True,
        watch: Callable[[float], None] | None = None,
    ) -> Iterator[Growth]:
        """As `TangentSystem` has it; one integration for as many intervals as memory allows."""
        done = 0
        for times, renormalised in self.batches(intervals, interval, orthogonal):
            count = len(times) // self.sampling(interval)[0]
            motion = self.march.advance(
                times, renormalised=renormalised, watch=part_of(watch, done, count, intervals)
            )
            yield self.taken(motion, renormalised, interval)
            self.require(motion)
            done += count

    def sampling(self, interval: float) -> tuple[int, int]:
        """Samples of an interval, and how many intervals are integrated at once."""
        parts = max(self.parts, 1)
        each = parts * (1 if self._log is None else self._log.looks(interval / parts))
        return each, max(1, MOST_NUMBERS // (2 * self.march.layout.size * each))

    def batches(
        self, intervals: int, interval: float, orthogonal: bool
    ) -> Iterator[tuple[Floats, Renormalised]]:
        """Sample times of one integration after the other, and what they do with tangents."""
        each, most = self.sampling(interval)
        start, done = self.time, 0
        self.metric = FixedMetric(self.march.sample, self.tangents)
        while done < intervals:
            count = min(most, intervals - done)
            times = start + interval * (done + np.arange(1, count * each + 1) / each)
            yield times, Renormalised(each, orthogonal=orthogonal)
            done += count

    def taken(self, motion: Motion, renormalised: Renormalised, interval: float) -> Growth:
        """What an integration gave, and what of it is kept."""
        each, _ = self.sampling(interval)
        if self._log is not None:
            self._log.note(motion)
        if motion.changes:
            self._touching.append(motion.part(last=1))
        if self.parts:
            between = each // self.parts
            self._kept.append(motion.part(between - 1, each=between))
        ends = motion.part(each - 1, each=each)
        self._ends.append(ends)
        lengths = self.metric.corrected(
            renormalised.lengths, ends, renormalised.tangents, renormalised.orthogonal
        )
        return Growth(
            rates=lengths / interval,
            states=self._states(ends),
            times=ends.time,
            tangents=renormalised.tangents,
            loses=self.march.constrained,
        )

    def _states(self, motion: Motion) -> Floats:
        """States, angles within one turn, shape (samples, x)."""
        result = free_vectors(self.system, motion, turns=False)
        beyond = self.angles & (np.abs(result) > np.pi)
        return np.where(beyond, wrapped(result), result)

    def require(self, motion: Motion) -> None:
        """Raise what ended a motion early."""
        if motion.interrupted:
            raise Interrupted(str(motion.failure), time=motion.stop_time)
        if motion.failure is not None:
            raise ComputationError(motion.failure, time=motion.stop_time)
