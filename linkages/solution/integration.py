"""Motions with integrated coordinates, by a compiled solver.

A run is cut where free coordinates become ill-conditioned: there others take over, or the motion
is led through a change point, or it ends.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.dyads import LEAST_MARGIN
from linkages.kernel.system import System
from linkages.solution.crossings import crossed_piece, passed_piece, solver_events
from linkages.solution.determined import is_determined
from linkages.solution.flows import Flows
from linkages.solution.motion import (
    STOPS_THERE,
    Motion,
    Piece,
    Settings,
    block_failure,
    passed_text,
)
from linkages.solution.passage import Crossing, Passage
from linkages.solution.switching import better_system, movable
from linkages.solution.undefined import loads_at_stop
from linkages.solvers.integrate import integrate
from linkages.solvers.outcome import Outcome
from linkages.solvers.trajectory import Trajectory

EARLY = 0.2
"""Relative margin at which a better choice of coordinates, or a way through, is looked for."""

CLOSER = 0.25
"""Part of the present margin at which it is looked for again while the margin falls."""

PASSAGE_RTOL = 1e-10
"""Errors below this cannot be told from round-off in a step through a change point."""

Floats = NDArray[np.float64]


def integrated_motion(system: System, settings: Settings) -> Motion:
    """Integrate a system that has free coordinates, or others that are carried along."""
    return _Run(system, settings).motion()


class _Run:
    """One motion, piece by piece."""

    def __init__(self, system: System, settings: Settings) -> None:
        self._settings = settings
        self._direction = 1.0 if settings.times[-1] >= system.time else -1.0
        self._start = system.time
        self._crossed: dict[str, list[Piece]] = {event.name: [] for event in settings.events}
        self._pieces: list[Piece] = []
        self._notes: list[str] = []
        self._cost = {"steps": 0, "rejected": 0, "evaluations": 0}
        self._method = self._reason = ""
        self._taken = 0
        self._work = 0.0
        self._counting = settings.counting or bool(movable(system))
        self._enter(system, {})

    def _enter(self, system: System, angles: dict[str, float]) -> None:
        """Go on with the coordinates of a system, from its initial state.

        `angles` are those of its bodies with all the turns that they have made, if any.
        """
        self._system = system
        self._flows = Flows(system, self._settings.work, counting=self._counting)
        self._flipped: tuple[int, ...] = ()
        self._time = system.time
        self._state = self._extended(system.state)
        topology = system.topology
        within = dict(zip(topology.coordinates, system.state, strict=False))
        turned = [angles.get(name, angle) - angle for name, angle in within.items()]
        self._turns = np.round(np.array(turned) / (2 * np.pi))
        counted = topology.counted if self._counting else ()
        self._angles = np.array([angles.get(name, 0.0) for name in counted])
        self._least = self._thresholds()

    def _extended(self, state: Floats) -> Floats:
        """A state with the work done so far, if that is integrated as well."""
        count = len(self._system.topology.coordinates)
        extra = ([0.0], [self._work]) if self._settings.work else ([], [])
        return np.array([*state[:count], *extra[0], *state[count:], *extra[1]])

    def _plain(self, states: Floats) -> tuple[Floats, Floats | None]:
        """States without the work, shape (2n, …), and the work."""
        count = len(self._system.topology.coordinates)
        total = len(states) // 2
        plain = np.concatenate([states[:count], states[total : total + count]])
        return plain, states[total + count] if self._settings.work else None

    @property
    def _watchful(self) -> bool:
        return self._looking or bool(movable(self._system))

    @property
    def _looking(self) -> bool:
        """Whether to look for a way through singular positions."""
        return self._settings.passing or bool(self._system.topology.redundant)

    def _thresholds(self, stopped: int | None = None) -> Floats:
        """Relative margins at which to stop; less where a block starts close to singular.

        A block that the last run stopped at is one of these, even if its margin does not fall now.
        """
        blocks = len(self._system.topology.solved_blocks)
        if not self._watchful:
            return np.full(blocks, LEAST_MARGIN)
        state, _ = self._plain(self._state[:, None])
        flipped = {block: np.array([True]) for block in self._flipped}
        model = self._system.model
        nodes = [*model.margins, *model.margin_rates]
        values = self._system.evaluate(nodes, self._time, state, flipped=flipped)[:, 0]
        relative = np.abs(values[:blocks]) / self._flows.margin_scale
        with np.errstate(invalid="ignore"):  # in a change point rates are infinite
            growing = values[:blocks] * values[blocks:] * self._direction > 0
        if stopped is not None:
            growing[stopped] = False
        return np.where(growing, EARLY, np.clip(CLOSER * relative, LEAST_MARGIN, EARLY))

    def motion(self) -> Motion:
        """Integrate to the end, or to where the motion cannot go on."""
        while True:
            trajectory = self._integrate()
            if trajectory.outcome is not Outcome.SINGULAR or not self._went_on(trajectory):
                failure = failure_text(self._system, trajectory, self._settings.way_on)
                stop_time = trajectory.stop_time
                break
            if self._taken == len(self._settings.times):  # a passage led beyond the end
                failure, stop_time = None, float(self._settings.times[-1])
                break
        return Motion(
            pieces=tuple(self._pieces),
            failure=failure,
            stop_time=stop_time,
            interrupted=trajectory.outcome is Outcome.INTERRUPTED,
            cost=self._cost,
            method=self._method,
            reason=self._reason,
            notes=tuple(self._notes),
            crossed={name: tuple(pieces) for name, pieces in self._crossed.items()},
        )

    def _integrate(self) -> Trajectory:
        """Integrate until something happens, and keep the samples."""
        settings = self._settings
        trajectory = integrate(
            self._flows.flow(self._flipped, self._least),
            self._state,
            settings.times[self._taken :],
            start=self._time,
            method=settings.method,
            rtol=settings.rtol,
            atol=settings.atol,
            step=settings.step,
            max_steps=max(1, settings.max_steps - self._cost["steps"] - self._cost["rejected"]),
            angles=self._angles,
            watch=self._watch(),
            events=solver_events(self._system, settings.events, int(settings.work), self._flipped),
        )
        for key in self._cost:
            self._cost[key] += getattr(trajectory, key)
        self._method, self._reason = trajectory.method, trajectory.reason
        count = len(self._system.topology.coordinates)
        state, work = self._plain(trajectory.state.T)
        self._pieces.append(
            Piece(
                system=self._system,
                time=trajectory.time,
                state=state,
                turns=trajectory.turns.T[:count] + self._turns[:, None],
                acceleration=trajectory.acceleration.T[:count],
                work=work,
                counted=self._counted(trajectory.angles.T),
                flipped={b: np.ones(len(trajectory.time), dtype=bool) for b in self._flipped},
            )
        )
        self._taken += len(trajectory.time)
        for event, met in zip(settings.events, trajectory.crossings, strict=True):
            piece = crossed_piece(event, met, self._pieces[-1], self._turns)
            self._crossed[event.name].append(piece)
        return trajectory

    def _counted(self, rows: Floats) -> dict[str, Floats]:
        """Dependent bodies with their angles, shape (d, …), if their turns are counted."""
        return dict(zip(self._system.topology.counted, rows, strict=False))

    def _present_angles(self) -> dict[str, float]:
        """Angles of bodies that are integrated or counted, with all their turns."""
        topology = self._system.topology
        bodies = self._system.mechanism.bodies
        angles = self._state[: len(self._turns)] + 2 * np.pi * self._turns
        own = zip(topology.coordinates, angles.tolist(), strict=True)
        turning = {name: angle for name, angle in own if bodies[name].rotates}
        return {**turning, **dict(zip(topology.counted, self._angles.tolist(), strict=True))}

    def _watch(self) -> Callable[[float], None] | None:
        watch, times = self._settings.watch, self._settings.times
        if watch is None:
            return None
        span = times[-1] - self._start
        done = float((self._time - self._start) / span) if span else 0.0
        return lambda fraction: watch(done + (1.0 - done) * fraction)

    def _went_on(self, trajectory: Trajectory) -> bool:
        """Whether the motion can go on from a stop at a small margin."""
        if self._least[trajectory.block] <= LEAST_MARGIN:
            return False
        count = len(self._system.topology.coordinates)
        self._time, self._state = trajectory.stop_time, trajectory.final_state
        self._turns = self._turns + trajectory.final_turns[:count]
        self._angles = trajectory.final_angles
        state, work = self._plain(self._state[:, None])
        self._work = 0.0 if work is None else float(work[0])
        better = better_system(self._system, self._time, state[:, 0], self._flipped)
        if better is not None:
            old, new = (movable(s) for s in (self._system, better))
            self._notes.append(
                f"at t = {self._time:.6g} s the free coordinate {_exchanged(old, new)}, "
                "which is better conditioned there"
            )
            self._enter(better, self._present_angles())
            return True
        if not (self._looking and self._pass_through()):
            self._least = self._thresholds(trajectory.block)
        return True

    def _pass_through(self) -> bool:
        """Step across the change point ahead, if it is one."""
        crossing = Crossing(self._flows.flow(self._flipped), self._direction)
        ahead = crossing.ahead(self._time, self._state)
        if ahead is None:
            return False
        left, blocks = ahead
        beyond = tuple(sorted(set(self._flipped) ^ set(blocks)))
        if not all(("side", block) in self._system.model.inputs.parameters for block in blocks):
            return False
        passage = crossing.across(
            self._flows.flow(beyond),
            self._time,
            self._state,
            left,
            blocks,
            self._tolerance(),
            self._angles,
        )
        if passage is None:
            return False
        return self._keep(passage, beyond)

    def _tolerance(self) -> Floats:
        settings = self._settings
        rtol = max(settings.rtol, PASSAGE_RTOL)
        atol = rtol if settings.atol is None else max(settings.atol, PASSAGE_RTOL)
        return np.asarray(atol + rtol * np.abs(self._state))

    def _keep(self, passage: Passage, beyond: tuple[int, ...]) -> bool:
        """Take the samples within a passage and go on behind it, if that may be done."""
        piece = self._led_across(passage, beyond)
        determined = is_determined(piece)
        if not (self._settings.passing or determined):
            return False
        self._pieces.append(piece)
        self._taken += len(piece.wanted)
        for event in self._settings.events:
            self._crossed[event.name].append(passed_piece(event, piece))
        self._cost["steps"] += 1
        self._cost["evaluations"] += passage.evaluations
        if not determined:
            model = self._system.model
            self._notes.append(passed_text(model, passage.crossing, passage.blocks))
        self._flipped = beyond
        self._time, self._state = float(passage.time[-1]), passage.state[:, -1].copy()
        self._angles = passage.angles[:, -1]
        self._least = self._thresholds()
        return True

    def _led_across(self, passage: Passage, beyond: tuple[int, ...]) -> Piece:
        """The piece of a motion within a passage."""
        times = self._settings.times[self._taken :]
        inside = (times - passage.time[-1]) * self._direction <= 0
        state, work = self._plain(passage.state)
        count = len(self._system.topology.coordinates)
        before = np.array([[b in self._flipped] for b in range(self._blocks)])
        after = np.array([[b in beyond] for b in range(self._blocks)])
        modes = np.where(passage.beyond, after, before)
        return Piece(
            system=self._system,
            time=passage.time,
            state=state,
            turns=np.repeat(self._turns[:, None], len(passage.time), axis=1),
            acceleration=passage.acceleration[:count],
            work=work,
            counted=self._counted(passage.angles),
            flipped={b: where for b, where in enumerate(modes) if where.any()},
            samples=times[inside],
            crossing=passage.crossing,
        )

    @property
    def _blocks(self) -> int:
        return len(self._system.topology.solved_blocks)


def _exchanged(old: tuple[str, ...], new: tuple[str, ...]) -> str:
    gone = [name for name in old if name not in new]
    come = [name for name in new if name not in old]
    return f"{', '.join(gone)} was exchanged for {', '.join(come)}"


def failure_text(system: System, trajectory: Trajectory, way_on: str = STOPS_THERE) -> str | None:
    """Why an integration stopped before its end, as a sentence; None if it did not.

    `way_on` is what can be said of the way on from a singular position.
    """
    outcome = trajectory.outcome
    if outcome is Outcome.DONE:
        return None
    if outcome in (Outcome.UNREACHABLE, Outcome.SINGULAR) and trajectory.block >= 0:
        singular = outcome is Outcome.SINGULAR
        where = (trajectory.block, trajectory.stop_time)
        text = block_failure(system.model, *where, singular, way_on)
        return f"{text}. {outcome.remedy}"
    if outcome in (Outcome.NOT_FINITE, Outcome.STEP_TOO_SMALL):
        names = loads_at_stop(system, trajectory)
        if names:
            has = "has" if len(names) == 1 else "have"
            return (
                f"at t = {trajectory.stop_time:.9g} s: {', '.join(names)} {has} no finite value "
                "there, or none just before or behind. End before, or change the load."
            )
    return f"at t = {trajectory.stop_time:.9g} s: {outcome}"
