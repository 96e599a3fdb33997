"""Where states go within a time, with the derivatives of that by the state and by a parameter."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.chaos.free_states import circular
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, InputError, Interrupted
from linkages.kernel.inputs import Effects
from linkages.kernel.number_effects import NoDerivativeError, Number, effects, numbers_of
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.options.run import RunOptions
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.guards import Guard, evaluated_vectors, free_vectors
from linkages.solution.march import March
from linkages.solution.motion import Motion, Piece
from linkages.solution.rhs import Equations

Floats = NDArray[np.float64]
Places = Floats | Sequence[float]

TANGENT_ATOL = 10.0
"""Absolute tolerance of deviation vectors, in relative tolerances of the amplitudes."""

LEAST_SCALE, NOTHING = 0.05, 1e-9
"""Parts of the magnitude of a coordinate: its least amplitude, and what does not move."""

DIFFERENCE = 1e-5
"""Half the step, in ranges, of differences by parameters without a known derivative."""

PROBE = 0.3819660112501051
"""Place between the ends at which it is checked that something does not depend on parameters."""

STEP = 1e-6
"""Part of a range by which a parameter is moved to see how the period of the drives follows it."""


@dataclass(frozen=True)
class Ray:
    """Parameters that change together, along a straight line from one end to the other.

    `first`, `last`: their values in SI at the place 0 and at the place 1, shape (P,).
    """

    paths: tuple[str, ...]  # dotted paths of numbers of the definition
    first: tuple[float, ...]
    last: tuple[float, ...]

    def at(self, place: float) -> dict[str, float]:
        """Values of the parameters at a place."""
        pairs = zip(self.paths, self.first, self.last, strict=True)
        return {path: a + place * (b - a) for path, a, b in pairs}

    def place(self, value: float) -> float:
        """Where the first parameter has a value."""
        return (value - self.first[0]) / (self.last[0] - self.first[0])


@dataclass(frozen=True)
class Change:
    """A change of a contact mode: when, of which switch, and whether its function rose."""

    time: float
    name: str
    rises: bool


@dataclass(frozen=True, eq=False)
class Shot:
    """Where a motion came to.

    `by_state`, `by_place`: derivatives of it by the initial state, shape (x, x), and by the places
    along rays, shape (x, P); empty without tangents.
    """

    end: Floats  # state with all turns made on the way, shape (x,)
    by_state: Floats
    by_place: Floats
    last: Piece  # the end as a piece of a motion
    changes: tuple[Change, ...]  # changes of contact modes, in the order of time
    held: Mapping[str, Floats]  # modes at the end, by name
    motion: Motion  # the motion, with the samples that were asked for

    @cached_property
    def flow(self) -> Floats:
        """Rate of change of the state at the end, shape (x,)."""
        n = len(self.last.system.topology.free)
        rates = self.last.state[len(self.last.turns) :][:n, 0]
        changes = evaluate_nodes(self.last, self.last.system.model.changes)
        return np.concatenate([rates, changes[:, 0]])


class Shooting:
    """Motions of a mechanism from given states, at given places along rays of parameters.

    `mechanism`: with free coordinates.
    `rays`: along which parameters vary; none for the mechanism as it is.
    `run`: how motions are integrated.
    `system`: at the places 0.
    `scale`: amplitudes of the state, in which deviation vectors are measured, shape (x,).
    """

    def __init__(self, mechanism: Mechanism, rays: Sequence[Ray], run: RunOptions) -> None:
        paths = [path for ray in rays for path in ray.paths]
        self.rays, self.run = tuple(rays), run
        self._numbers = [_number(mechanism, path) for path in paths]
        self.mechanism = mechanism.keeping(paths)
        self._varying = Varying(self.mechanism)
        self.system = self._varying.at({})
        self.size = self.system.layout.directions
        self.scale = np.ones(self.size)
        self._last: tuple[tuple[float, ...], System] | None = None

    def with_run(self, run: RunOptions) -> Shooting:
        """The same with motions that are integrated in another way."""
        result = copy.copy(self)
        result.run = run
        return result

    def with_ray(self, ray: Ray) -> Shooting:
        """The same with another ray of parameters, and the same amplitudes."""
        result = Shooting(self.mechanism, (*self.rays, ray), self.run)
        result.scale = self.scale
        return result

    def values(self, places: Places) -> dict[str, float]:
        """Values of all parameters at places along the rays."""
        return {
            k: v for ray, at in zip(self.rays, places, strict=True) for k, v in ray.at(at).items()
        }

    def system_at(self, places: Places, state: Floats | None = None) -> System:
        """The system at places along the rays, in a state if that is given, shape (x,)."""
        if state is None:
            return self._system(places)
        system = self._system(places)
        layout = system.layout
        if not layout.carried:
            return system.at(system.time, layout.moving(state))
        whole = system.state[layout.state_rows]
        whole[np.delete(np.arange(len(whole)), self.carried_rows)] = state
        # what is carried along follows from the rest; iterations start from where it was assembled
        piece = March(system.at(system.time, layout.moving(whole)), self.run).sample
        values = evaluated_vectors(system, piece, layout.carried)[:, 0]
        count = len(layout.carried)
        apart = whole[self.carried_rows[:count]] - values[:count]
        turning = [system.mechanism.bodies[name].rotates for name in layout.carried]
        values[:count] += np.where(turning, 2 * np.pi * np.round(apart / (2 * np.pi)), 0.0)
        whole[self.carried_rows] = values
        return system.at(system.time, layout.moving(whole))

    def _system(self, places: Places) -> System:
        """The system at places along the rays; the last one is kept."""
        key = tuple(places)
        if self._last is None or self._last[0] != key:
            self._last = key, self._varying.at(self.values(places))
        return self._last[1]

    def states(self, motion: Motion) -> Floats:
        """States at the samples of a motion with all turns, shape (samples, x)."""
        return free_vectors(self.system, motion)

    def within_turn(self, states: Floats) -> Floats:
        """States, or differences of them, with angles from −π to π, shape (…, x)."""
        turns = np.where(self.angles, np.round(states / (2 * np.pi)), 0.0)
        return np.asarray(states - 2 * np.pi * turns)

    def distances(self, apart: Floats) -> Floats:
        """Largest entries of differences of states in amplitudes, shape (…)."""
        return np.asarray(np.abs(self.within_turn(apart) / self.scale).max(axis=-1))

    def amplitudes(self, states: Floats) -> Floats:
        """Half the ranges of states, or their sizes where they do not move, shape (x,)."""
        half = 0.5 * np.ptp(states, axis=0)
        half = np.where(self.angles & (half > np.pi), np.pi, half)
        size = np.abs(states).max(axis=0)
        floor = np.where(self.angles, 0.0, LEAST_SCALE * size)
        result = np.maximum(half, floor)
        return np.where(result > NOTHING * np.maximum(size, 1e-300), result, self.sizes)

    @cached_property
    def sizes(self) -> Floats:
        """Sizes of a state: a radian, the size of the mechanism, and these per second."""
        topology, bodies = self.system.topology, self.system.mechanism.bodies
        extent = float(np.ptp(np.array([*self.system.places().values()]), axis=0).max()) or 1.0
        own = np.array([1.0 if bodies[name].rotates else extent for name in topology.free])
        inner = np.maximum(np.abs(self.initial([0.0] * len(self.rays))[2 * len(own) :]), 1.0)
        return np.concatenate([own, own, inner])

    def initial(self, places: Places) -> Floats:
        """The initial state of the definition at places along the rays, shape (x,)."""
        system = self.system_at(places)
        return np.delete(system.state[system.layout.state_rows], self.carried_rows)

    @cached_property
    def carried_rows(self) -> NDArray[np.intp]:
        """Places of what the integration carries along in a state as it is outside of it."""
        n, carried = len(self.system.topology.free), len(self.system.topology.carried)
        both = np.arange(carried)
        return np.concatenate([n + both, 2 * n + carried + both])

    @cached_property
    def angles(self) -> NDArray[np.bool_]:
        """Which entries of a state are angles that have the same meaning a turn later."""
        return circular(self.system)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the entries of a state, such as ``rod.angle`` and ``rod.speed``."""
        equations = Equations(self.system)
        kept = np.delete(np.arange(len(equations.names)), self.carried_rows)
        return tuple(equations.names[k] for k in kept)

    @cached_property
    def units(self) -> tuple[str, ...]:
        """Units of the entries of a state."""
        equations = Equations(self.system)
        kept = np.delete(np.arange(len(equations.units)), self.carried_rows)
        return tuple(equations.units[k] for k in kept)

    def energy(self, places: Places, state: Floats) -> float:
        """Kinetic and potential energy in joules."""
        system = self.system_at(places, state)
        (kinetic,) = VARIABLES["kinetic_energy"].evaluated(system.model)
        return float(system.evaluate([kinetic, system.model.potential_energy]).sum())

    def period(self, places: Places) -> float | None:
        """Common period of drives and loads in seconds; None where nothing depends on time."""
        return self._period(places) if self._constant_period is None else self._constant_period[0]

    def _period(self, places: Places) -> float | None:
        mechanism = self._varying.mechanism_at(self.values(places)) if self.rays else self.mechanism
        try:
            return common_period(mechanism)
        except NoPeriodError:
            return None

    @cached_property
    def _constant_period(self) -> tuple[float | None] | None:
        """The period, if it does not depend on the parameters."""
        count = len(self.rays)
        seen = {self._period(np.full(count, place)) for place in (0.0, PROBE, 1.0)}
        return (seen.pop(),) if len(seen) == 1 else None

    def period_slopes(self, places: Places) -> Floats:
        """Derivatives of that period by the places, shape (P,)."""
        result = np.zeros(len(self.rays))
        if self._constant_period is not None:
            return result
        for k in range(len(result)):
            before, after = ([*places], [*places])
            before[k], after[k] = places[k] - STEP, places[k] + STEP
            first, last = self.period(before), self.period(after)
            if first is not None and last is not None and first != last:
                result[k] = (last - first) / (2 * STEP)
        return result

    def shoot(
        self,
        places: Places,
        state: Floats,
        duration: float,
        *,
        start: float = 0.0,
        tangents: bool = True,
        held: Mapping[str, Floats] | None = None,
        samples: Floats | None = None,
        guards: Sequence[Guard] = (),
    ) -> Shot:
        """Follow the motion from a state for a time in seconds.

        `places`: along the rays.
        `state`: shape (x,).
        `start`: time at which it starts in seconds.
        `tangents`: whether derivatives are wanted.
        `held`: modes at the start; they follow from the state if not given.
        `samples`: times after the start, the last of which is the duration.
        Raises ComputationError if the motion cannot go on.
        """
        try:
            system = self.system_at(places, state)
        except InputError as error:
            raise ComputationError(f"no motion starts there: {error}", time=start) from error
        if start:
            system = system.at(start, system.state)
        columns = (self.size + len(self._numbers)) if tangents else 0
        if tangents:
            system = system.affected(self._effects(system))
        allowed = TANGENT_ATOL * self.run.rtol * self.scale[:, None]
        try:
            march = March(system, self.run, tangents=columns, tangent_atol=allowed, held=held)
        except InputError as error:  # the state is that of a step of Newton's method
            raise ComputationError(f"no motion starts there: {error}", time=start) from error
        if tangents:
            march.tangents = np.hstack(
                [np.diag(self.scale), np.zeros((self.size, len(self._numbers)))]
            )
        times = start + (np.array([duration]) if samples is None else samples)
        motion = march.advance(times, guards=guards)
        if motion.failure is not None or march.flipped:
            kind = Interrupted if motion.interrupted else ComputationError
            text = motion.failure or "a change point led into another way of assembly"
            raise kind(text, time=motion.stop_time)

        def again(moved: Places) -> Floats:
            other = self.shoot(moved, state, duration, start=start, tangents=False, held=held)
            return other.end

        free = system.topology.free
        end = free_vectors(self.system, Motion(pieces=(march.sample,)))[0]
        moved = march.tangents_of(free) if tangents else np.empty((self.size, 0))
        return Shot(
            end=end,
            by_state=moved[:, : self.size] / self.scale if tangents else moved,
            by_place=self._by_place(
                moved[:, self.size :], self._differences(places, again) if tangents else {}
            ),
            last=march.sample,
            changes=changes_of(motion),
            held={name: row[:1] for name, row in march.held.items()},
            motion=motion,
        )

    def _effects(self, system: System) -> Effects:
        """Nothing for the deviations of the state, then each number in units of its range."""
        return self._effects_at(system) if self._constant is None else self._constant

    @cached_property
    def _constant(self) -> Effects | None:
        """The effects, if parameters depend on the numbers linearly."""
        count = len(self.rays)
        first, *others = (
            self._effects_at(self.system_at(np.full(count, place))) for place in (0.0, PROBE, 1.0)
        )
        linear = all(
            other.fed == first.fed and np.allclose(other.slopes, first.slopes, rtol=1e-14, atol=0.0)
            for other in others
        )
        return first if linear else None

    def _effects_at(self, system: System) -> Effects:
        result = effects(system, [*[None] * self.size, *self._numbers])
        spans = [b - a for ray in self.rays for a, b in zip(ray.first, ray.last, strict=True)]
        return result.scaled(np.array([*[1.0] * self.size, *spans]))

    def _differences(self, places: Places, end: Callable[[Places], Floats]) -> dict[int, Floats]:
        """Ray → derivative of an end by its place, where that is not known of all its numbers."""
        counts = np.cumsum([0, *(len(ray.paths) for ray in self.rays)])
        result = {}
        for k, (first, last) in enumerate(pairwise(counts.tolist())):
            if None in self._numbers[first:last]:
                moved = [np.array(places, dtype=float) for _ in (0, 1)]
                moved[0][k] -= DIFFERENCE
                moved[1][k] += DIFFERENCE
                result[k] = (end(moved[1]) - end(moved[0])) / (2 * DIFFERENCE)
        return result

    def _by_place(self, columns: Floats, differences: Mapping[int, Floats]) -> Floats:
        """Derivatives by the places along rays, from those by all numbers, shape (x, P)."""
        if not self.rays or not columns.shape[1]:
            return columns
        ends = np.cumsum([len(ray.paths) for ray in self.rays])[:-1]
        parts = np.split(columns, ends, axis=1)
        return np.stack(
            [differences.get(k, part.sum(axis=1)) for k, part in enumerate(parts)], axis=1
        )


def _number(mechanism: Mechanism, path: str) -> Number | None:
    """The number at a path; None if its derivative is not known."""
    try:
        (result,) = numbers_of(mechanism, [path])
    except NoDerivativeError:
        return None
    return result


def changes_of(motion: Motion) -> tuple[Change, ...]:
    """Changes of contact modes of a motion, in the order of time."""
    result = []
    for name, changed in motion.changes.items():
        pairs = zip(changed.time.tolist(), changed.rises.tolist(), strict=True)
        result += [Change(time, name, rises) for time, rises in pairs]
    return tuple(sorted(result, key=lambda change: change.time))
