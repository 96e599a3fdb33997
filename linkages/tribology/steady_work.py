"""Mean work of sliding per revolution, of motions that have settled, with standard errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.averages import FEWEST_BLOCKS, mean_error
from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.components.contributed.normal_forces import Contact, offset_names
from linkages.components.joint_clearances import Clearance, GuideClearance
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, InputError
from linkages.kernel.forces.bearing_gaps import ProfiledGap
from linkages.kernel.forces.sliding import SlidingNodes
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.options.analysis_options import WearOptions
from linkages.solution.contact_episodes import slid, sliding_in_impacts
from linkages.solution.evaluation import accelerated, evaluate_nodes
from linkages.solution.guards import free_vectors
from linkages.solution.march import March
from linkages.solution.motion import Motion, Piece
from linkages.solvers.trajectory import CAPACITY
from linkages.tribology.worn_bearings import BINS
from linkages.tribology.worn_joints import density, profiled, worn_joints

Floats = NDArray[np.float64]

BATCH = 4 * FEWEST_BLOCKS
"""Revolutions of the first mean; half of them, and of all later ones, count."""

PRECISION = 0.25
"""Standard error of a mean that is asked for, over the accuracy of the growth."""

KEPT = CAPACITY // 4
"""Changes of modes in revolutions that are computed at once, so that all of them are recorded."""

PLACED = 4
"""Steps in which a journal is placed as deep in a bearing with another profile."""

SHOWN, SAMPLES = 4, 2000
"""Revolutions of which angles and pressures are sampled, and samples in each of them."""


@dataclass(frozen=True)
class SteadyWork:
    """What was found of a motion with worn clearances.

    `work`, `error`: mean per revolution in J and its standard error, shape (clearances,).
    `distance`: of slip per revolution in m, shape (clearances,).
    `trusted`: whether the errors can be trusted.
    `peak`: largest pressure by velocity in W/m², shape (clearances,).
    `density`: of the work over the angle of journal and bearing, (clearances, 2, `BINS`).
    `away`: part of the work at which a massless link pushes, shape (clearances,).
    `spread`: mean difference per radian of the density around a bearing in both halves of what it
    was sampled in, (clearances,).
    `state`: where the motion ends, as integrated, with `worn`, the work done before, and `depths`
    of bearings, (clearances, `BINS`).
    `revolutions`: that were computed.
    """

    work: Floats
    error: Floats
    distance: Floats
    trusted: bool
    peak: Floats
    density: Floats
    away: Floats
    spread: Floats
    state: Floats
    worn: Floats
    depths: Floats
    revolutions: int


class WornMotions:
    """Settled motions of a mechanism whose clearances have worn; each goes on from the last one."""

    def __init__(self, mechanism: Mechanism, run: WearOptions) -> None:
        if not mechanism.worn:
            example = "wear: {bearing: {wear_rate: 1e-15 m²/N}}"
            raise mechanism.error([((), f"nothing wears; expected a clearance with {example}")])
        if harmonics := run.harmonics if run.feedback == "profile" else 0:
            mechanism = profiled(mechanism, harmonics)
        self.mechanism, self.run = mechanism, run
        self._varying = Varying(mechanism)
        self.base = self._varying.at({})
        try:
            self.period = common_period(mechanism)
        except NoPeriodError as error:
            raise mechanism.error([((), f"wear counts revolutions: {error}")]) from None
        self.joints = worn_joints(mechanism, self._strokes(), harmonics)
        self.terms = [
            [k for k, term in enumerate(mechanism.rubbing) if _belongs(term.name, joint.name)]
            for joint in self.joints
        ]

    def _strokes(self) -> dict[str, float]:
        """How far blocks that wear move along their guides in the first revolution."""
        own = [each for each in self.mechanism.worn if isinstance(each, GuideClearance)]
        if not own:
            return {}
        times = self.period * np.linspace(0.0, 1.0, SAMPLES + 1)
        motion = self._moved(March(self.base, self.run), times)
        nodes = [self.base.model.positions.displacements[each.slider] for each in own]
        rows = np.concatenate([evaluate_nodes(piece, nodes) for piece in motion.pieces], axis=1)
        return {each.name: float(np.ptp(row)) for each, row in zip(own, rows, strict=True)}

    @property
    def first_depths(self) -> Floats:
        """Of bearings before wear, shape (clearances, `BINS`)."""
        return np.array([joint.first_depth for joint in self.joints])

    def system(self, work: Floats, depths: Floats, before: SteadyWork | None) -> System:
        """The mechanism after some work in each clearance, where the motion before ended."""
        found = self._worn(work, depths)
        return found if before is None else found.at(0.0, self._spread(found, work, before))

    def values(self, work: Floats, depths: Floats) -> dict[str, object]:
        """What the definition of the worn mechanism has instead, by paths."""
        result: dict[str, object] = {}
        for joint, own, depth in zip(self.joints, work.tolist(), depths, strict=True):
            result |= joint.overrides(own, depth) if own or joint.harmonics else {}
        return result

    def _worn(self, work: Floats, depths: Floats) -> System:
        try:
            return self._varying.at(self.values(work, depths))
        except InputError as error:
            sizes = ", ".join(
                f"{joint.name} {joint.size(own):.4g} m"
                for joint, own in zip(self.joints, work.tolist(), strict=True)
            )
            raise ComputationError(f"no such mechanism with sizes {sizes}: {error}") from None

    def _spread(self, found: System, work: Floats, before: SteadyWork) -> Floats:
        """The state that a motion ended in, with journals as deep in larger bearings."""
        state, rows = before.state.copy(), self.base.layout.coordinates
        for joint, now, then in zip(self.joints, work.tolist(), before.worn.tolist(), strict=True):
            if isinstance(joint.own, Clearance) or joint.harmonics:
                continue
            names: tuple[str, ...] = offset_names(joint.name)
            if isinstance(joint.own, GuideClearance):
                names = (joint.own.play.offset,)
            own = [rows.index(name) for name in names]
            size = joint.size(then)
            grown = joint.size(now) - size
            state[own] *= 1.0 + grown / max(float(np.linalg.norm(state[own])), size)
        if any(joint.harmonics for joint in self.joints):
            return self._moved_along(found, self._worn(before.worn, before.depths), state)
        return state

    def _moved_along(self, found: System, then: System, state: Floats) -> Floats:
        """The same along the normals of bearings that are not round."""
        rows = self.base.layout.coordinates
        for nodes in found.model.contacts:
            gap = nodes.gap
            if not isinstance(gap, ProfiledGap):
                continue
            own = [rows.index(name) for name in gap.geometry.axes]
            values = [gap.indentation, gap.facing.x, gap.facing.y]
            wanted = then.evaluate(values, 0.0, state[:, None])[0, 0]
            for _ in range(PLACED):
                depth, *way = found.evaluate(values, 0.0, state[:, None])[:, 0]
                sign = -1.0 if gap.geometry.hole else 1.0
                state[own] += sign * (wanted - depth) * np.array(way)
        return state

    def settled(
        self, work: Floats, depths: Floats, before: SteadyWork | None, precision: float
    ) -> SteadyWork:
        """Means of a motion whose transient is left behind, to a relative precision if possible.

        The later half of all revolutions counts, so that a longer mean leaves out more of what came
        before. A chaotic motion ends with a larger error where `longest` is reached.
        """
        march = March(self.system(work, depths, before), self.run, losses=True)
        done = 0
        if before is None and self.run.skip:
            self._advance(march, done, self.run.skip)
            done = self.run.skip
        rows: list[Floats] = []
        batch = min(BATCH, max(self.run.longest, 2 * FEWEST_BLOCKS))
        while True:
            rows.append(self._advance(march, done, batch))
            done += batch
            series = np.concatenate(rows)
            later = series[min(len(series) // 2, len(series) - 2 * FEWEST_BLOCKS) :]
            errors, trust = mean_error(later)
            mean, count = later.mean(axis=0), len(self.joints)
            limits = precision * np.abs(mean[:count])
            if (errors[:count] <= limits).all() or len(series) >= self.run.longest:
                break
            batch = min(len(series), self.run.longest - len(series))
        shown = self._sampled(march, done)
        return SteadyWork(
            work=mean[:count],
            error=errors[:count],
            distance=mean[count:],
            trusted=bool((trust[:count] | (10 * errors[:count] <= limits)).all()),
            state=self._state(march),
            worn=work,
            depths=depths,
            revolutions=done + SHOWN,
            **shown,
        )

    def _advance(self, march: March, done: int, count: int) -> Floats:
        """Work and distance of each clearance in each revolution, (revolutions, 2 clearances)."""
        rows, end, bounces = [], done + count, bool(self.base.model.walls.contacts)
        together = 1 if bounces else count
        while done < end:
            last = min(done + together, end)
            times: Floats = self.period * np.arange(done, last + 1, dtype=np.float64)
            motion = self._moved(march, times)
            rows.append(np.diff(self._slid(motion), axis=1).T)
            if bounces:
                changes = sum(changed.count for changed in motion.changes.values())
                together = max(1, KEPT * (last - done) // max(changes, 1))
            done = last
        return np.concatenate(rows)

    def _moved(self, march: March, times: Floats) -> Motion:
        motion = march.advance(times)
        if motion.interrupted:
            raise KeyboardInterrupt
        if motion.failure is not None or march.flipped:
            text = motion.failure or "a change point led into another way of assembly"
            raise ComputationError(text, time=motion.stop_time)
        return motion

    def _slid(self, motion: Motion) -> Floats:
        """Work, then distance, of each clearance at the samples, (2 clearances, samples)."""
        return np.array([rows[own].sum(axis=0) for rows in slid(motion) for own in self.terms])

    def _state(self, march: March) -> Floats:
        layout = self.base.layout
        here = Motion(pieces=(march.sample,))
        return layout.moving(free_vectors(self.base, here, names=layout.bodies, turns=False)[0])

    def _sampled(self, march: March, done: int) -> dict[str, Floats]:
        """What is shown of some revolutions: pressures, and where contacts are."""
        times: Floats = self.period * (done + np.linspace(0.0, SHOWN, SHOWN * SAMPLES + 1))
        motion = self._moved(march, times)
        rows = [self._looked(accelerated(piece)) for piece in motion.pieces]
        peak, angles, halves, pushes = (
            np.concatenate(parts, axis=-1) for parts in zip(*rows, strict=True)
        )
        hits = [self._hit(*found) for found in sliding_in_impacts(motion)]
        result = np.zeros((len(self.joints), 2, BINS))
        spread, away = np.zeros((2, len(self.joints)))
        assert motion.losses is not None
        rubbed = np.diff(motion.losses[2 * len(self.mechanism.contacts) :], axis=1)
        for k, joint in enumerate(self.joints):
            if not joint.turns:
                continue
            work, at = rubbed[self.terms[k][0]], [(a[k], w[k], p[k]) for a, w, p in hits]
            reach = halves[k] if np.isfinite(halves[k]).all() else None
            if joint.harmonics:  # no narrower than motions see it
                reach = np.maximum(0.0 if reach is None else reach, 0.5 * np.pi / joint.harmonics)
                reach = np.broadcast_to(reach, halves[k].shape)
            struck = np.concatenate([np.zeros(0), *(w for _, w, _ in at)])
            for side in (0, 1):
                places = np.concatenate([np.zeros(0), *(a[side] for a, _, _ in at)])
                result[k, side] = density(angles[k, side], work, reach, (places, struck))
            if joint.harmonics and reach is not None:
                half = len(work) // 2
                first, last = (
                    density(angles[k, 1, p], work[q], reach[p])
                    for p, q in ((slice(half + 1), slice(half)), (slice(half, None),) * 2)
                )
                spread[k] = 0.5 * np.abs(first - last).mean()
            pushed = work[pushes[k, 1:] & pushes[k, :-1]].sum()
            pushed += sum(float(w[p].sum()) for _, w, p in at)
            away[k] = pushed / max(float(work.sum() + struck.sum()), 1e-300)
        return {"peak": peak.max(axis=-1), "density": result, "away": away, "spread": spread}

    def _hit(
        self, piece: Piece, work: Floats, impulses: Floats
    ) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Angles on both sides, work and pushing of each joint in rigid impacts."""
        model, count = piece.system.model, len(piece.time)
        angles = np.zeros((len(self.joints), 2, count))
        pushes = np.zeros((len(self.joints), count), dtype=bool)
        for k, (joint, own) in enumerate(zip(self.joints, self.terms, strict=True)):
            if joint.turns:
                pushes[k] = impulses[own[0]] < 0.0
                sliding = SlidingNodes(model, model.mechanism.rubbing[own[0]])
                angles[k] = _angles(evaluate_nodes(piece, _directions(sliding)), pushes[k])
        first = [own[0] for own in self.terms]
        return angles, work[first], pushes

    def _looked(self, piece: Piece) -> tuple[Floats, Floats, Floats, NDArray[np.bool_]]:
        """Pressure by velocity, angles on both sides, half angles, pushing, at the samples."""
        model, count = piece.system.model, len(piece.time)
        peak, halves = np.zeros((2, len(self.joints), count))
        angles = np.zeros((len(self.joints), 2, count))
        pushes = np.zeros((len(self.joints), count), dtype=bool)
        for k, (joint, own) in enumerate(zip(self.joints, self.terms, strict=True)):
            terms = [model.mechanism.rubbing[place] for place in own]
            nodes = [SlidingNodes(model, term) for term in terms]
            areas = [model.inputs.parameter(each.rubbing.area) for each in nodes]
            powers = [each.power / area for each, area in zip(nodes, areas, strict=True)]
            peak[k] = evaluate_nodes(piece, powers).max(axis=0)
            if not joint.turns:
                continue
            term, (sliding,) = terms[0], nodes
            values = evaluate_nodes(piece, [sliding.force, *_directions(sliding)])
            force, directions = values[0], values[1:]
            pushes[k] = force < 0.0
            angles[k] = _angles(directions, pushes[k])
            reach = getattr(joint.own, "half_angle", lambda _: None)
            if isinstance(term, Contact) and reach(1.0) is not None:
                halves[k] = reach(1.0) * np.sqrt(np.maximum(force, 0.0))  # as √F
            else:
                halves[k] = np.nan
        return peak, angles, halves, pushes


def _directions(sliding: SlidingNodes) -> list[Scalar]:
    """Where both sides touch, and how they are turned."""
    return [sliding.way, *sliding.sides]


def _angles(directions: Floats, pushes: NDArray[np.bool_]) -> Floats:
    """Of the contact in the frames of both sides, at the other side where a link pushes."""
    return np.asarray(np.where(pushes, directions[0] + np.pi, directions[0]) - directions[1:])


def _belongs(term: str, clearance: str) -> bool:
    """Whether a contact or link is that of a clearance, or one of its corners."""
    return term == clearance or term.startswith(f"{clearance}.corner")
