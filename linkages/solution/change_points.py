"""Passage through change points, and exchange of ill-conditioned free coordinates.

At a change point the closure is singular, but the motion that inertia continues is smooth: the
assembly branch of the blocks concerned changes sign with their margin. Close to it accelerations
have lost their digits to round-off (ε/m³ at the relative margin m). One step of collocation at
Gauss's nodes leads across, with the change point in its middle, between two nodes; nodes beyond it
are in the other branch. Its order is so high that the step can be long, and all nodes stay away
from the change point.

Any bodies may be independent whose removal from the closure leaves a regular Jacobian (generalized
coordinate partitioning; R. A. Wehage, E. J. Haug, J. Mech. Design 104, 247 (1982)).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from linkages.components.contributed.terms import UNSEEN
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError
from linkages.kernel.differentiation import derivative, derivative_along
from linkages.kernel.dyads import LEAST_MARGIN
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.motion import Piece, movable
from linkages.solvers.flow import Flow, caller
from linkages.solvers.tableau import cardinals
from linkages.topology.topology import closure_jacobian, distance_from_singular

Floats = NDArray[np.float64]

STAGES = 10
"""Even, so that no node lies in the middle."""

COMPARED = 8
"""Stages of the step that the first one is compared with."""

MOST_ITERATIONS = 100

CENTRINGS = 2
"""How often the time of the change point is improved before the step across it."""

SAME_TIME = 0.2
"""Blocks whose margins vanish within this part of the way are taken to do so together."""

CONTINUES = 0.5
"""How much the rate of a margin may change in the step, relative to itself."""


def vanishes(times: Floats, margins: Floats, crossing: float) -> bool:
    """Whether margins m of a block, shape (times,), vanish: m² is smooth and has a zero.

    Where links miss each other, or cannot quite reach, the least value of m² is above or below
    zero.
    """
    place, beside, least = crossing, 0.05 * (times[-1] - times[0]), np.inf
    for _ in range(3):
        around = cardinals(times, place + beside * np.array([-1.0, 0.0, 1.0]))
        before, least, after = around @ margins**2
        slope, bend = 0.5 * (after - before), before - 2.0 * least + after
        if not bend > 0.0:
            return False
        place, least = place - beside * slope / bend, least - 0.5 * slope**2 / bend
        beside *= 0.1
    return bool(abs(least) <= LEAST_MARGIN**2)


@dataclass(frozen=True)
class Passage:
    """A step through a change point: `state` has shape (2n, m), `acceleration` (n, m)."""

    time: Floats  # where the state was computed, its ends included, shape (m,)
    state: Floats
    acceleration: Floats
    angles: Floats  # dependent angles with their whole turns, shape (d, m)
    beyond: NDArray[np.bool_]  # which of these times lie behind the change point
    crossing: float  # time of the change point
    blocks: tuple[int, ...]  # those that changed their mode
    evaluations: int  # how often the kernel was called


class Crossing:
    """Tries to step across a change point; `direction` is +1 forward in time, −1 backward."""

    def __init__(self, flow: Flow, direction: float) -> None:
        self._flow = flow
        self._direction = direction
        self._size = flow.written
        self._evaluations = 0

    def ahead(self, t: float, y: Floats) -> tuple[float, tuple[int, ...]] | None:
        """Time until the next margin vanishes if it goes on as it does, and the blocks."""
        status, out = caller(self._flow, self._size)(t, y)
        if status != 0:
            return None
        margin, rate = self._margins(out)
        with np.errstate(divide="ignore", invalid="ignore"):
            left = np.where(margin * rate * self._direction < 0, np.abs(margin / rate), np.inf)
        nearest = float(left.min(initial=np.inf))
        if not np.isfinite(nearest):
            return None
        return nearest, tuple(int(b) for b in np.flatnonzero(left <= nearest * (1 + SAME_TIME)))

    def across(
        self,
        other: Flow,
        t: float,
        y: Floats,
        left: float,
        blocks: Collection[int],
        tolerance: Floats,
        angles: Floats,
    ) -> Passage | None:
        """Step across, or None if no smooth motion leads there.

        `tolerance` has shape (2n,); `angles` are dependent, before the change point, shape (d,).
        """
        self._other = other
        for _ in range(CENTRINGS):
            rough = self._collocated(t, y, 2.0 * self._direction * left, COMPARED)
            if rough is None:
                return None
            left = abs(self._zero(rough[0], rough[2], min(blocks)) - t)
        h = 2.0 * self._direction * left
        result = self._collocated(t, y, h, STAGES)
        compared = self._collocated(t, y, h, COMPARED)
        if result is None or compared is None:
            return None
        times, states, outputs = result
        if not (np.abs(states[-1] - compared[1][-1]) <= tolerance).all():
            return None
        if not self._continues(outputs[0], outputs[-1], blocks):
            return None
        crossing = t + self._direction * left
        relative = np.array([self._margins(out)[0] for out in outputs]) / self._flow.margin_scale
        if not all(vanishes(times, relative[:, block], crossing) for block in blocks):
            return None
        n = self._flow.coordinates
        return Passage(
            time=times,
            state=np.array(states).T,
            acceleration=np.array([out[:n] for out in outputs]).T,
            angles=self._angles(angles, h, outputs),
            beyond=(times - crossing) * self._direction > 0,
            crossing=crossing,
            blocks=tuple(blocks),
            evaluations=self._evaluations,
        )

    def _zero(self, times: Floats, outputs: list[Floats], block: int) -> float:
        """When a margin vanishes, by inverse interpolation."""
        margins = [self._margins(out)[0][block] for out in outputs]
        if not (np.diff(margins) * np.sign(margins[-1] - margins[0]) > 0).all():
            return float(0.5 * (times[0] + times[-1]))
        return float((cardinals(np.array(margins), np.zeros(1)) @ times)[0])

    def _margins(self, out: Floats) -> tuple[Floats, Floats]:
        n, b = self._flow.coordinates, len(self._flow.margin_scale)
        return out[n : n + b], out[n + b : n + 2 * b]

    def _continues(self, first: Floats, last: Floats, blocks: Collection[int]) -> bool:
        """Whether margins went through zero, and no others did, as smoothly as they began."""
        (margin, rate), (margin_end, rate_end) = self._margins(first), self._margins(last)
        for block in range(len(margin)):
            changed = margin[block] * margin_end[block] < 0
            if changed != (block in blocks):
                return False
            if changed and abs(rate_end[block] - rate[block]) > CONTINUES * abs(rate[block]):
                return False
        return True

    def _rates(self, t: float, y: Floats, beyond: bool) -> Floats | None:
        self._evaluations += 1
        status, out = caller(self._other if beyond else self._flow, self._size)(t, y)
        return out if status == 0 and np.isfinite(out).all() else None

    def _collocated(
        self, t: float, y: Floats, h: float, stages: int
    ) -> tuple[Floats, list[Floats], list[Floats]] | None:
        """Times, states and outputs of the kernel at the start, the nodes and the end of a step."""
        nodes, weights, once = gauss(stages)
        times = t + h * nodes
        beyond = nodes > 0.5
        n = self._flow.coordinates
        first = self._rates(t, y, beyond=False)
        if first is None:
            return None
        position, speed, acceleration = y[:n], y[n:], np.tile(first[:n], (stages, 1))
        before = np.inf
        for _ in range(MOST_ITERATIONS):
            speeds = speed + h * once @ acceleration
            states = np.concatenate([position + h * once @ speeds, speeds], axis=1)
            outputs = [self._rates(*at) for at in zip(times, states, beyond, strict=True)]
            rows = [out[:n] for out in outputs if out is not None]
            if len(rows) < stages:
                return None
            change = float(np.abs(np.array(rows) - acceleration).max())
            acceleration = np.array(rows)
            # a motion without acceleration has its round-off alone: speeds say how much matters
            scale = max(float(np.abs(rows).max()), float(np.abs(speed).max()) / abs(h))
            if change == 0.0 or (change >= 0.5 * before and change <= 1e-6 * scale):
                break  # the rest is round-off
            before = change
        else:
            return None
        speeds = speed + h * once @ acceleration
        end = np.concatenate([position + h * weights @ speeds, speed + h * weights @ acceleration])
        last = self._rates(t + h, end, beyond=True)
        if last is None:
            return None
        reached = [y, *states, end]
        result = [first, *(out for out in outputs if out is not None), last]
        settled = [self._settled(at, out) for at, out in zip(reached, result, strict=True)]
        return np.array([t, *times, t + h]), settled, result

    def _angles(self, start: Floats, h: float, outputs: list[Floats]) -> Floats:
        """Dependent angles at the start, the nodes and the end of a step, shape (d, m)."""
        if not len(start):
            return np.zeros((0, len(outputs)))
        end = self._size - 2 * self._flow.switches
        last = np.array(outputs)[:, end - 3 * len(start) : end].reshape(len(outputs), 3, -1)
        cosines, sines, speeds = last.transpose(1, 2, 0)
        _, weights, once = gauss(STAGES)
        turned = h * speeds[:, 1:-1] @ np.vstack([np.zeros(STAGES), once, weights]).T
        angles = np.arctan2(sines, cosines)
        return angles + 2 * np.pi * np.round((start[:, None] + turned - angles) / (2 * np.pi))

    def _settled(self, y: Floats, out: Floats) -> Floats:
        """A state with what iterations found for the coordinates that are carried along."""
        flow, state = self._flow, y.copy()
        n, place = flow.coordinates, flow.coordinates + 2 * len(flow.margin_scale)
        first = flow.first_carried
        state[first : first + flow.carried] = out[place : place + flow.carried]
        rates = place + flow.carried
        state[n + first : n + first + flow.carried] = out[rates : rates + flow.carried]
        return state


@cache
def gauss(stages: int) -> tuple[Floats, Floats, Floats]:
    """Nodes and weights on [0, 1], and integrals of the cardinal polynomials up to each node."""
    nodes, weights = (1.0 + leggauss(stages)[0]) / 2, leggauss(stages)[1] / 2
    once = np.array([node * (weights @ cardinals(nodes, node * nodes)) for node in nodes])
    return nodes, weights, once


BETTER = 2.0
"""How much farther from singular other coordinates must be to be worth a change."""

SAME_PLACE = 1e-6
"""Part of the size of a mechanism by which round-off close to a singular position moves points."""


def better_system(here: Piece) -> System | None:
    """The same mechanism at a sample with better free coordinates; None if there are none."""
    place = _Configuration(here)
    if not place.finite:  # in a change point
        return None
    present = place.distance(here.system.topology.free)
    best = max(place.choices(), key=place.distance, default=None)
    if best is None or place.distance(best) < BETTER * present:
        return None
    try:
        result = System(place.mechanism(best), float(here.time[0]), near=place.places)
    except InputError:
        return None
    result = place.wound(result)
    return result if place.is_place_of(result) else None


def exchanged_tangents(here: Piece, free: tuple[str, ...], tangents: Floats) -> Floats:
    """Tangents at a sample in other free coordinates and their rates, shape (x, k).

    Those by numbers contain what these change while the present free coordinates stay.
    """
    system, count = here.system, len(free)
    model, effects = system.model, system.effects
    moved = [model.positions.coordinate(name) for name in free]
    moved += [model.velocities.bodies[name] for name in free]
    inputs = [model.inputs.coordinate(i) for i in range(count)]
    inputs += [model.inputs.rate(i) for i in range(count)]

    def values(rows: Sequence[Sequence[Scalar]], **further: Any) -> Floats:
        nodes = [node for row in rows for node in row]
        result = system.evaluate(nodes, here.time, here.state, flipped=here.flipped, **further)
        return result.reshape(len(rows), -1)

    change = np.eye(system.layout.directions)
    change[: 2 * count, : 2 * count] = values(derivative(moved, inputs))
    result = change @ tangents
    if effects is not None:
        by_numbers = derivative_along(moved, model.inputs.fed(effects.fed))
        result[: 2 * count] += values(by_numbers, further={"slope": effects.slopes[:, None]})
    return result


def keeps_modes(piece: Piece) -> bool:
    """Whether the functions of all switches keep the signs that they have within a piece."""
    switches = piece.system.model.switches.switches
    if piece.held is None or not len(piece.held):
        return True
    values = evaluate_nodes(piece, [switch.function for switch in switches])
    modes = piece.held[: len(switches)]
    watched = [s.active is None or modes[s.active, 0] > 0.0 for s in switches]
    return bool((values * modes >= 0.0)[watched].all())


def closure_nodes(system: System) -> list[Scalar]:
    """Places of all joints, then directions of all sliders: what a closure Jacobian takes."""
    positions, bodies = system.model.positions, system.mechanism.bodies
    axes = [positions.travel(name) for name, body in bodies.items() if not body.rotates]
    return [node for vector in (*positions.joints.values(), *axes) for node in (vector.x, vector.y)]


def closure_of(system: System, values: Floats) -> tuple[dict[str, Floats], Floats]:
    """Places of joints and the closure Jacobian, from values of `closure_nodes`."""
    rows, joints = values.reshape(-1, 2), system.model.positions.joints
    sliders = [name for name, body in system.mechanism.bodies.items() if not body.rotates]
    places = dict(zip(joints, rows[: len(joints)], strict=True))
    axes = dict(zip(sliders, rows[len(joints) :], strict=True))
    return places, closure_jacobian(system.topology, places, axes)


class _Configuration:
    """Where everything is at a sample, and how fast it moves."""

    def __init__(self, here: Piece) -> None:
        self._system = system = here.system
        self._topology = system.topology
        own = [name for name in system.mechanism.bodies if name not in self._topology.followers]
        closure = closure_nodes(system)
        coordinates = [system.model.positions.coordinate(name) for name in own]
        rates = [system.model.velocities.bodies[name] for name in own]
        nodes = [*closure, *coordinates, *rates]
        values = system.evaluate(nodes, here.time, here.state, flipped=here.flipped)[:, 0]
        self.finite = bool(np.isfinite(values).all())
        places, *others = np.split(values, [len(closure), len(closure) + len(own)])
        self.places, self._jacobian = closure_of(system, places)
        internal = here.state[system.layout.internal_rows, 0].tolist()
        self._internal = dict(zip(system.topology.internal, internal, strict=True))
        self._coordinates, self._rates = (
            dict(zip(own, row.tolist(), strict=True)) for row in others
        )

    def wound(self, other: System) -> System:
        """Another system with the whole turns of this one, where springs and gears count them."""
        other = other.with_internal(self._internal)
        topology, state = other.topology, other.state.copy()
        for index, name in enumerate(topology.coordinates):
            if name in topology.carried:
                state[index] = self._coordinates[name]
        return other.turned(state, self._system.assembly.turns)

    def is_place_of(self, other: System) -> bool:
        """Whether all points of another system are where they are here."""
        joints = other.model.positions.joints
        nodes = [node for name in self.places for node in (joints[name].x, joints[name].y)]
        places = np.array(list(self.places.values()))
        gap = np.abs(other.evaluate(nodes).reshape(-1, 2) - places).max()
        return bool(gap <= SAME_PLACE * np.ptp(places, axis=0).max())

    def choices(self) -> Iterator[tuple[str, ...]]:
        """Sets of free coordinates with one of them exchanged."""
        topology, bodies = self._topology, self._system.mechanism.bodies
        candidates = [
            name
            for name in topology.dependent
            if name not in topology.followers and bodies[name].kind not in UNSEEN
        ]
        for given in movable(self._system):
            for candidate in candidates:
                yield tuple(candidate if name == given else name for name in topology.free)

    def distance(self, free: tuple[str, ...]) -> float:
        """How far the closure is from singular with these coordinates free, 0 to 1."""
        return distance_from_singular(self._topology, self._jacobian, free)

    def mechanism(self, free: tuple[str, ...]) -> Mechanism:
        """The mechanism with other free coordinates, in their present state."""
        state = {name: (self._coordinates[name], self._rates[name]) for name in free}
        return self._system.mechanism.with_state(state)
