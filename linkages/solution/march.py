"""Integration of a linkage with free coordinates through events, modes and change points.

An integration is cut where free coordinates become ill-conditioned: there others take over, or the
motion is led through a change point, or it ends. Tangents go along, and guards are watched.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Collection, Generator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.errors import ComputationError
from linkages.kernel.dyads import LEAST_MARGIN
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.driven import driven_motion, is_determined
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.guards import Guard, GuardCrossings
from linkages.solution.motion import (
    TANGENT_ATOL,
    Changed,
    Motion,
    Piece,
    Renormalised,
    Settings,
    Tangents,
    Watch,
    absolute_tolerances,
    movable,
    passes,
)
from linkages.solution.plan import Plan
from linkages.solution.stop_messages import COULD_PASS, FOUND_NONE, failure_text, passed_text
from linkages.solvers.flow import Flow, Switching
from linkages.solvers.integration import IntegrationRequest, carry_out, request
from linkages.solvers.trajectory import Crossings, Outcome, Trajectory

if TYPE_CHECKING:
    from linkages.solution.change_points import Passage

EARLY = 0.2
"""Relative margin at which a better choice of coordinates, or a way through, is looked for."""

CLOSER = 0.25
"""Part of the present margin at which it is looked for again while the margin falls."""

PASSAGE_RTOL = 1e-10
"""Errors below this cannot be told from round-off in a step through a change point."""

STEADY = 1e-9
"""What accelerations on both sides of a time differ by, as a part, where they do not jump."""

Floats = NDArray[np.float64]


T = TypeVar("T")

Going = Generator[IntegrationRequest, Trajectory, T]
"""What asks for integrations, takes back what came of them, and returns something in the end."""


def alone(task: Going[T], progress: Callable[[], Watch | None] = lambda: None) -> T:
    """Carry out a task that asks for integrations; each is watched by its `progress`."""
    trajectory = None
    while True:
        try:
            asked = next(task) if trajectory is None else task.send(trajectory)
        except StopIteration as end:
            result: T = end.value
            return result
        trajectory = carry_out(asked, progress())


def compute_motion(system: System, settings: Settings) -> Motion:
    """Solve for the motion of a system; nothing is integrated if it has no free coordinate."""
    if not system.topology.coordinates:
        return driven_motion(system, settings)
    march = March(
        system,
        settings.run,
        work=settings.work,
        losses=settings.losses,
        counting=settings.counting,
    )
    return march.advance(settings.times, guards=settings.events, watch=settings.watch)


class March:
    """A motion that can go on, and be copied to go two ways.

    It starts at the state of `system`. Its `tangents` solve the variational equations; those of a
    system with effects of numbers are derivatives by them. `held` are modes and latched values by
    name, which otherwise follow from the state. Whole turns of dependent angles are counted if
    `counting`, or if free coordinates may be exchanged. `flipped` are blocks in another assembly
    branch than at the start of the present equations, `cost` is the number of steps, rejected steps
    and evaluations. Raises ValueError for more tangents than directions.
    """

    def __init__(
        self,
        system: System,
        run: RunOptions,
        *,
        work: bool = False,
        losses: bool = False,
        tangents: int = 0,
        tangent_atol: float | Floats = TANGENT_ATOL,
        counting: bool = False,
        held: Mapping[str, Floats] | None = None,
    ) -> None:
        if tangents and system.effects is None and tangents > system.layout.directions:
            raise ValueError(
                f"{system.mechanism.name}: free coordinates, their rates and internal states are "
                f"{system.layout.directions}; expected at most as many tangents, found {tangents}"
            )
        self.run, self._passing = run, passes(system, run)
        self._tangent_atol = tangent_atol
        self._extra = (work, losses, tangents, counting or bool(movable(system)))
        self.cost = {"steps": 0, "rejected": 0, "evaluations": 0}
        self._done: ArrayLike = 0.0
        effects = system.effects
        started = None if effects is None else system.layout.tangents_of(effects.state)
        self._enter(system, {}, started, held or {})

    def _enter(
        self,
        system: System,
        angles: dict[str, float],
        tangents: Floats | None,
        held: Mapping[str, Floats],
    ) -> None:
        """Go on with the coordinates of a system, from its initial state.

        `angles` are those of its bodies with all turns; `tangents` default to the axes.
        """
        self.system = system
        work, losses, columns, counting = self._extra
        self._plan = Plan.of(system, work=work, losses=losses, tangents=columns, counting=counting)
        self.layout = self._plan.layout
        self._held = self._holding(held)
        self.flipped: tuple[int, ...] = ()
        self._bound_to: tuple[object, ...] = ()
        self.time = system.time
        if tangents is None:
            tangents = np.eye(self.layout.directions)[:, :columns]
        self._vector = self.layout.packed(system.state, self._done, tangents)
        within = dict(zip(self.layout.coordinates, system.state, strict=False))
        turned = [angles.get(name, angle) - angle for name, angle in within.items()]
        self._turns = np.round(np.array(turned) / (2 * np.pi))
        self._angles = np.array([angles.get(name, 0.0) for name in self.layout.counted])

    def _holding(self, held: Mapping[str, Floats]) -> Floats:
        """Modes and what is remembered, shape (h,); those of the initial state, if not given."""
        layout = self.layout
        if not layout.held:
            return np.zeros(0)
        if held:
            return layout.holding(held)
        start = self.system.starting_held()
        return np.concatenate([start, np.zeros(layout.held - len(start))])

    @property
    def state(self) -> Floats:
        """Integrated coordinates of `system` and their rates, shape (2m,)."""
        return self.layout.motion(self._vector)

    @property
    def tangents(self) -> Floats:
        """Of free coordinates, rates and internal states of `system`, shape (x, k)."""
        return self._vector[self.layout.tangent_rows]

    @tangents.setter
    def tangents(self, values: Floats) -> None:
        self._vector[self.layout.tangent_rows] = values

    @property
    def held(self) -> dict[str, Floats]:
        """Modes and what is remembered by their names, the latter with its tangents."""
        return self.layout.named(self._held)

    @held.setter
    def held(self, values: Mapping[str, Floats]) -> None:
        self._held = self.layout.holding(values)

    def tangents_of(self, free: tuple[str, ...]) -> Floats:
        """The same in other free coordinates and their rates, shape (x, k)."""
        if free == self.layout.free:
            return self.tangents
        from linkages.solution.change_points import exchanged_tangents

        return exchanged_tangents(self.sample, free, self.tangents)

    def __copy__(self) -> March:
        """Another one in the same state, which goes its own way from there."""
        result = object.__new__(type(self))
        vars(result).update(vars(self), _vector=self._vector.copy(), cost=dict(self.cost))
        result._held = self._held.copy()
        return result

    def step_over(self, behind: float, moved: Floats) -> None:
        """Go on at time `behind` where laws of drives jump; tangents change by (f⁻ − f⁺) ∂t*/∂p.

        `moved` is ∂t*/∂p, shape (P,).
        """
        rates, watched = self._beside(self.time, behind)
        switches = self.system.model.switches.switches
        for switch, (before, after) in zip(switches, watched >= 0.0, strict=True):
            if before != after:
                message = f"a law of a drive jumps here, and '{switch.name}' with it"
                raise ComputationError(f"{message}; no derivative is known", time=self.time)
        moving = self.tangents
        moving[len(self.layout.free) :] += np.outer(rates[:, 0] - rates[:, 1], moved)
        self.tangents, self.time = moving, behind

    def require_steady(self, before: float, behind: float) -> None:
        """Raise where laws jump between two times here: numbers may move that to one side only."""
        rates, _ = self._beside(before, behind)
        apart, size = np.abs(rates[:, 1] - rates[:, 0]), np.abs(rates).max(axis=1)
        if (apart > STEADY * size).any():
            message = "laws of drives jump at the start, or several at a time, which numbers move"
            raise ComputationError(f"{message}; there is no derivative", time=self.time)

    def _beside(self, before: float, behind: float) -> tuple[Floats, Floats]:
        """Accelerations and what is watched, as if the time were another one, shape (…, 2)."""
        model, count = self.system.model, len(self.system.model.changes)
        held = self._held[: self.layout.remembered]
        result = self.system.evaluate(
            [*model.changes, *model.switches.watched],
            np.array([before, behind]),
            np.repeat(self.state[:, None], 2, axis=1),
            flipped={block: np.ones(2, dtype=bool) for block in self.flipped},
            held=np.repeat(held[:, None], 2, axis=1),
        )
        return result[:count], result[count:]

    def starting(self, run: RunOptions) -> March:
        """Another one from here, integrated in another way, at no cost so far."""
        result = copy.copy(self)
        result.run, result.cost = run, dict.fromkeys(self.cost, 0)
        return result

    @property
    def constrained(self) -> bool:
        """Whether modes may leave no neighbours in some directions, which takes tangents away."""
        return self._plan.switching is not None and self._plan.switching.constrains

    @property
    def sample(self) -> Piece:
        """Where the motion is now, as one sample."""
        turns = np.zeros((1, self.layout.size))
        rows = self._vector[None], turns, self._angles[None], self._held[None]
        return self._piece(np.array([self.time]), *rows)

    @property
    def here(self) -> System:
        """The system where the motion is now, in the present assembly branch."""
        held = self._held[: self.layout.remembered] if self.layout.held else None
        return self.system.at(self.time, self.state, self.flipped, held)

    @property
    def _looking(self) -> bool:
        """Whether to look for a way through singular positions."""
        return self._passing or bool(self.system.topology.redundant)

    def _thresholds(self, stopped: Collection[int] = ()) -> Floats:
        """Relative margins at which to stop; less where a block starts close to singular.

        Blocks that stopped the motion at this time keep theirs even if their margins do not fall
        now: where it is about to turn back, margins of several fall at once.
        """
        blocks = len(self.system.margin_scale)
        if not (blocks and (self._looking or movable(self.system))):
            return np.full(blocks, LEAST_MARGIN)
        model = self.system.model
        values = evaluate_nodes(self.sample, [*model.margins, *model.margin_rates])[:, 0]
        relative = np.abs(values[:blocks]) / self.system.margin_scale
        with np.errstate(invalid="ignore"):  # in a change point rates are infinite
            growing = values[:blocks] * values[blocks:] * self._direction > 0
        growing[[*stopped]] = False
        return np.where(growing, EARLY, np.clip(CLOSER * relative, LEAST_MARGIN, EARLY))

    def advance(
        self,
        times: Floats,
        *,
        guards: Sequence[Guard] = (),
        renormalised: Renormalised | None = None,
        watch: Watch | None = None,
    ) -> Motion:
        """Advance to the last of some times, shape (samples,), or to where the motion cannot go on.

        It ends as well where one of the guards has been crossed as often as it wants.
        """
        going = self.advancing(times, guards=guards, renormalised=renormalised)
        return alone(going, lambda: self._progress(watch))

    def advancing(
        self,
        times: Floats,
        *,
        guards: Sequence[Guard] = (),
        renormalised: Renormalised | None = None,
    ) -> Going[Motion]:
        """As `advance`, but asks for integrations instead of carrying them out."""
        self._times, self._taken = times, 0
        self._direction = 1.0 if times[-1] >= self.time else -1.0
        if self._direction < 0.0 and self._plan.switching is not None:
            self._require_past(self._plan.switching)
        self._begun = self.time
        self._pieces: list[Piece] = []
        self._notes: list[str] = []
        self._changes: dict[str, Changed] = {}
        self._renormalised = renormalised
        self._watched = [GuardCrossings(guard) for guard in guards]
        self._least = self._thresholds()
        self._stopped: tuple[float, tuple[int, ...]] = self.time, ()
        while True:
            trajectory = yield from self._integrated()
            if not self._goes_on(trajectory):
                way_on = FOUND_NONE if self._passing else COULD_PASS
                failure = failure_text(self.system, trajectory, way_on)
                stop_time = trajectory.stop_time
                break
            if self._taken == len(times) or any(watched.done for watched in self._watched):
                # a passage led beyond the end, or through the last crossing
                earlier = min if self._direction > 0.0 else max
                failure, stop_time = None, float(earlier(self.time, times[-1]))
                break
        return Motion(
            pieces=tuple(self._pieces),
            failure=failure,
            stop_time=stop_time,
            interrupted=trajectory.outcome is Outcome.INTERRUPTED,
            cost=dict(self.cost),
            method=trajectory.method,
            reason=trajectory.reason,
            notes=tuple(self._notes),
            crossings={watched.guard.name: watched.motion for watched in self._watched},
            changes=self._changes,
        )

    def _require_past(self, switching: Switching) -> None:
        """Make sure that a state says where it came from."""
        lost = [*switching.owners, *(k for k, place in enumerate(switching.jumps) if place >= 0)]
        if lost:
            raise ComputationError(
                f"'{switching.names[lost[0]]}' remembers or jumps: such a motion cannot be "
                "followed backward in time, for a state does not say where it came from",
                time=self.time,
            )

    def _integrated(self) -> Going[Trajectory]:
        """Have it integrated until something happens, and keep the samples."""
        trajectory = yield self._request()
        while trajectory.outcome is Outcome.EVENT and not self._met(trajectory):
            # what does not count has used up the room; steps must not depend on how much there was
            for watched in self._watched:
                watched.widen()
            trajectory = yield self._request()
        for key in self.cost:
            self.cost[key] += getattr(trajectory, key)
        self._keep(trajectory)
        self.time = trajectory.stop_time
        self._vector, self._held = trajectory.final_state, trajectory.final_held
        self._turns = self._turns + trajectory.final_turns[: len(self._turns)]
        self._angles = trajectory.final_angles
        return trajectory

    def _request(self) -> IntegrationRequest:
        """Ask for an integration from the present state on."""
        used = self.cost["steps"] + self.cost["rejected"]
        tangents = self._renormalised
        return request(
            self._flow(),
            self._vector,
            self._times[self._taken :],
            start=self.time,
            **self.run.integration | {"atol": self._tolerances(), "max_steps": self.run.left(used)},
            angles=self._angles,
            events=[w.event(self._plan, self.system, self.flipped) for w in self._watched],
            tangents=None if tangents is None else tangents.plan(self.layout),
            holds=self._held,
        )

    def _flow(self) -> Flow:
        """The equations now, bound once for as long as they stay the same."""
        wanted = self.system, self.flipped, tuple(self._least.tolist())
        if self._bound_to != wanted:
            self._bound_to = wanted
            self._known_flow = self._plan.bind(self.system, self.flipped, self._least)
        return self._known_flow

    def _met(self, trajectory: Trajectory) -> bool:
        """Whether a guard was crossed as often as it wants."""
        pairs = zip(self._watched, trajectory.crossings, strict=True)
        return any(watched.enough(self._crossed(item)) for watched, item in pairs)

    def _crossed(self, found: Crossings) -> Piece:
        return self._piece(found.time, found.state, found.turns, found.angles, found.held)

    def _keep(self, trajectory: Trajectory) -> None:
        """Keep the samples of an integration, and what was crossed."""
        rows = trajectory.turns, trajectory.angles, trajectory.held
        rates = trajectory.acceleration.T
        tangents = self._tangents(trajectory.state.T, rates, trajectory.held.T)
        self._pieces.append(self._piece(trajectory.time, trajectory.state, *rows, rates, tangents))
        self._taken += len(trajectory.time)
        if self._renormalised is not None:
            self._renormalised.add(trajectory, self.layout)
        for watched, crossings in zip(self._watched, trajectory.crossings, strict=True):
            watched.add(self._crossed(crossings))
        names = () if self._plan.switching is None else self._plan.switching.names
        for number, name in enumerate(names):
            result, rises = trajectory.changes.of(number, len(self._angles))
            # whole turns of dependent angles are not counted there
            piece = replace(self._crossed(result), counted={})
            before = self._changes.get(name, Changed.none())
            self._changes[name] = before.followed_by(piece, rises, result.count)

    def _piece(
        self,
        time: Floats,
        state: Floats,
        turns: NDArray,
        angles: Floats,
        held: Floats,
        rates: Floats | None = None,
        tangents: Tangents | None = None,
    ) -> Piece:
        """States of an integration from the present one on; accelerations are zero if not given."""
        count = len(self._turns)
        return Piece(
            system=self.system,
            time=time,
            state=self.layout.motion(state.T),
            turns=turns.T[:count] + self._turns[:, None],
            acceleration=np.zeros((count, len(time))) if rates is None else rates[:count],
            work=self.layout.work_done(state.T),
            losses=self.layout.lost(state.T) if self.layout.losses else None,
            counted=dict(zip(self.layout.counted, angles.T, strict=True)),
            flipped={b: np.ones(len(time), dtype=bool) for b in self.flipped},
            held=held.T[: self.layout.remembered],
            tangents=tangents,
        )

    def _tangents(self, states: Floats, rates: Floats, held: Floats) -> Tangents | None:
        """How samples change with numbers, if that is asked for."""
        layout = self.layout
        if not layout.fed:
            return None
        rows = layout.tangent_rows
        shape = layout.tangents, len(layout.memories), states.shape[-1]
        memories = held[layout.remembered :].reshape(shape)
        return Tangents(states[rows], rates[rows[len(layout.free) :] - layout.size], memories)

    def _present_angles(self) -> dict[str, float]:
        """Angles of bodies that are integrated or counted, with all their turns."""
        bodies = self.system.mechanism.bodies
        angles = self._vector[: len(self._turns)] + 2 * np.pi * self._turns
        own = zip(self.layout.coordinates, angles.tolist(), strict=True)
        turning = {name: angle for name, angle in own if name in bodies and bodies[name].rotates}
        return {**turning, **dict(zip(self.layout.counted, self._angles.tolist(), strict=True))}

    def _progress(self, watch: Watch | None) -> Watch | None:
        """Progress of an integration as that of all of them."""
        if watch is None:
            return None
        span = float(self._times[-1]) - self._begun
        done = (self.time - self._begun) / span if span else 0.0
        return lambda fraction: watch(done + (1.0 - done) * fraction)

    def _goes_on(self, trajectory: Trajectory) -> bool:
        """Whether there is a way on from where an integration ended before its end."""
        if trajectory.outcome is not Outcome.SINGULAR:
            return False
        if self._least[trajectory.block] <= LEAST_MARGIN:
            return False
        self._done = self._vector[self.layout.done_rows]
        if self._exchanged():
            return True
        if not (self._looking and self._pass_through()):
            at, blocks = self._stopped
            known = blocks if at == self.time else ()
            self._stopped = self.time, (*known, trajectory.block)
            self._least = self._thresholds(self._stopped[1])
        return True

    def _exchanged(self) -> bool:
        """Go on with other free coordinates, if there are better ones."""
        from linkages.solution.change_points import better_system

        old = self.system
        better = better_system(self.sample)
        if better is None:
            return False
        self._notes.append(
            f"at t = {self.time:.6g} s the free coordinate "
            f"{_exchange_words(movable(old), movable(better))}, which is better conditioned there"
        )
        tangents = self.tangents_of(better.topology.free) if self.layout.tangents else self.tangents
        entered = better.affected(old.effects)
        self._enter(entered, self._present_angles(), tangents, self.held)
        self._least = self._thresholds()
        return True

    def _pass_through(self) -> bool:
        """Step across the change point ahead, if it is one."""
        from linkages.solution.change_points import Crossing

        crossing = Crossing(self._bound(self.flipped), self._direction)
        ahead = crossing.ahead(self.time, self._vector)
        if ahead is None:
            return False
        left, blocks = ahead
        beyond = tuple(sorted(set(self.flipped) ^ set(blocks)))
        if not all(("side", block) in self.system.model.inputs.parameters for block in blocks):
            return False
        rtol = max(self.run.rtol, PASSAGE_RTOL)
        tolerance = np.maximum(self._tolerances(), PASSAGE_RTOL) + rtol * np.abs(self._vector)
        state = self.time, self._vector, left, blocks, tolerance, self._angles
        passage = crossing.across(self._bound(beyond), *state)
        if passage is None:
            return False
        return self._led_through(passage, beyond)

    def _bound(self, flipped: tuple[int, ...]) -> Flow:
        """The equations in an assembly branch, with what is held now."""
        flow = self._plan.bind(self.system, flipped)
        flow.parameters[len(flow.parameters) - flow.held :] = self._held
        return flow

    def _tolerances(self) -> Floats:
        """Absolute tolerances, of everything that is integrated."""
        return absolute_tolerances(self.system.mechanism, self.layout, self.run, self._tangent_atol)

    def _led_through(self, passage: Passage, beyond: tuple[int, ...]) -> bool:
        """Take the samples within a passage and go on behind it, if that may be done."""
        from linkages.solution.change_points import keeps_modes

        piece = self._led_across(passage, beyond)
        if not keeps_modes(piece):
            return False
        determined = is_determined(piece)
        if not (self._passing or determined):
            return False
        self._pieces.append(piece)
        self._taken += len(piece.wanted)
        self.cost["steps"] += 1
        self.cost["evaluations"] += passage.evaluations
        if not determined:
            text = passed_text(self.system.model, passage.crossing, passage.blocks)
            self._notes.append(text)
        for watched in self._watched:
            watched.add_within(piece)
        self.flipped = beyond
        self.time, self._vector = float(passage.time[-1]), passage.state[:, -1].copy()
        self._angles = passage.angles[:, -1]
        if self._renormalised is not None:
            rows = self.layout.tangent_rows
            inside = piece.interpolated(passage.state[rows.ravel()])
            inside = inside.T.reshape(-1, *rows.shape)
            factor = self._renormalised.led_through(self.layout, inside)
            self.tangents = self.tangents @ factor
        self._least = self._thresholds()
        return True

    def _led_across(self, passage: Passage, beyond: tuple[int, ...]) -> Piece:
        """The piece of a motion within a passage."""
        times = self._times[self._taken :]
        inside = (times - passage.time[-1]) * self._direction <= 0
        count, blocks = len(self._turns), range(len(self.system.topology.solved_blocks))
        before = np.array([[b in self.flipped] for b in blocks])
        after = np.array([[b in beyond] for b in blocks])
        modes = np.where(passage.beyond, after, before)
        turns = np.zeros((len(passage.time), count))
        held = np.tile(self._held, (len(passage.time), 1))
        piece = self._piece(passage.time, passage.state.T, turns, passage.angles.T, held)
        return replace(
            piece,
            acceleration=passage.acceleration[:count],
            tangents=self._tangents(passage.state, passage.acceleration, held.T),
            flipped={b: where for b, where in enumerate(modes) if where.any()},
            samples=times[inside],
            crossing=passage.crossing,
        )


def _exchange_words(old: tuple[str, ...], new: tuple[str, ...]) -> str:
    gone = [name for name in old if name not in new]
    come = [name for name in new if name not in old]
    return f"{', '.join(gone)} was exchanged for {', '.join(come)}"
