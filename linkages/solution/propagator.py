"""States, and tangents to their motion, moved over intervals of time: what own analyses call."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.errors import ComputationError, Interrupted
from linkages.solution.arguments import whole_number
from linkages.solution.flows import Flows, watched
from linkages.solution.integration import failure_text
from linkages.solution.surface import parse_events
from linkages.solvers.events import Event
from linkages.solvers.integrate import MAX_STEPS, integrate
from linkages.solvers.methods import FIXED_STEP_METHODS
from linkages.solvers.outcome import Outcome
from linkages.solvers.trajectory import Trajectory

if TYPE_CHECKING:
    from linkages.solution.rhs import Equations

Floats = NDArray[np.float64]

TANGENT_ATOL = 1e-6
"""Absolute tolerance of tangents: they are of length one when they start."""


@dataclass(frozen=True, kw_only=True)
class Crossed:
    """Crossings of one event.

    Parameters
    ----------
    time : (m,)
        When, in seconds.
    y : (2n, m)
        The state there.
    """

    time: Floats
    y: Floats


@dataclass(frozen=True, kw_only=True)
class Advanced:
    """Where an advance came to.

    Parameters
    ----------
    time
        In seconds: the end, or that of the crossing at which the advance stopped.
    y : (2n,)
        The state there; angles with all the turns made since the beginning.
    tangents : (2f, k)
        Tangents there.
    crossings
        Event → its crossings on the way.
    """

    time: float
    y: Floats
    tangents: Floats
    crossings: Mapping[str, Crossed] = field(default_factory=dict)


class Propagator:
    """Moves a state, and solutions of the variational equations, along the motion.

    It keeps nothing between calls. From `linkages.Equations.flow`.

    Parameters
    ----------
    equations
        Of a mechanism.
    tangents
        Number k of tangents, at most 2f, f being the number of free coordinates. A tangent has 2f
        entries: deviations of the free coordinates, then of their rates.
    events
        Series → how it crosses its value: ``{"piston.velocity": "up"}``, ``"down"`` or ``"both"``.
        A value other than 0 stands behind it: ``"crank.angle=90 deg"``.
    stop
        Whether an advance ends at the first crossing of an event.
    method, rtol, atol, step, max_steps
        As `linkages.simulate` takes them; what is None is that of the definition.

    Raises
    ------
    ValueError
        For arguments that make no sense.
    """

    def __init__(
        self,
        equations: Equations,
        tangents: int = 0,
        *,
        events: Mapping[str, str] | None = None,
        stop: bool = False,
        method: str | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        step: float | None = None,
        max_steps: int = MAX_STEPS,
    ) -> None:
        system, defaults = equations.system, equations.mechanism.simulation
        self._system = system
        self._own, self._free = len(system.topology.coordinates), len(system.topology.free)
        self.tangents = whole_number("tangents", tangents)
        if not 0 <= self.tangents <= 2 * self._free:
            found = f"tangents must be from 0 to {2 * self._free}, twice the free coordinates"
            raise ValueError(f"{found}; found {tangents}")
        self._flow = Flows(system, tangents=self.tangents).flow()
        self._total = self._flow.coordinates
        self._events = parse_events(system, events or {})
        more = self._total - self._own
        self._functions = [watched(system, e.surface.nodes, more) for e in self._events]
        self._stop = stop
        self._method = defaults.method if method is None else method
        self._step = defaults.step if step is None else step
        if step is None and self._method not in FIXED_STEP_METHODS:
            self._step = None
        self._rtol = defaults.rtol if rtol is None else rtol
        atol = defaults.atol if atol is None else atol
        self._atol = np.full(2 * self._total, self._rtol if atol is None else atol)
        self._atol[self._places.ravel()] = TANGENT_ATOL
        self._max_steps = max_steps

    @property
    def _places(self) -> NDArray[np.int64]:
        """Places of the tangents in what is integrated, shape (2f, k)."""
        first = self._total - self.tangents * self._free
        columns = first + np.arange(self.tangents) * self._free
        places = columns + np.arange(self._free)[:, None]
        return np.concatenate([places, self._total + places])

    def advance(
        self, y: ArrayLike, t0: float, t1: float, tangents: ArrayLike | None = None
    ) -> Advanced:
        """Move a state, and tangents to it, from one time to another.

        Parameters
        ----------
        y : (2n,)
            State at `t0`, as `Equations` has it.
        t0, t1
            Times in seconds; `t1` may be the earlier one.
        tangents : (2f, k)
            Tangents at `t0` as columns; the first k columns of the unit matrix if not given.

        Raises
        ------
        ComputationError
            If the motion cannot go on.
        Interrupted
            After Ctrl-C.
        """
        vector, turns = self._vector(y, tangents)
        time = float(t0)
        found: list[list[tuple[Floats, Floats]]] = [[] for _ in self._events]
        steps = self._max_steps
        while True:
            trajectory = self._integrated(vector, time, float(t1), steps)
            steps = max(1, steps - trajectory.steps - trajectory.rejected)
            stops = self._collect(trajectory, turns, found)
            time, vector = trajectory.stop_time, trajectory.final_state.copy()
            turns = turns + trajectory.final_turns[: self._own]
            if stops or trajectory.outcome is Outcome.DONE:
                break
        return Advanced(
            time=time,
            y=self._whole(vector[None], turns[None])[0],
            tangents=vector[self._places],
            crossings={
                event.name: Crossed(
                    time=np.concatenate([times for times, _ in parts]),
                    y=np.concatenate([states for _, states in parts]).T,
                )
                for event, parts in zip(self._events, found, strict=True)
            },
        )

    def _vector(self, y: ArrayLike, tangents: ArrayLike | None) -> tuple[Floats, Floats]:
        """What is integrated, angles within one turn, and the turns taken off."""
        own, total, k = self._own, self._total, self.tangents
        given = np.array(y, dtype=np.float64)
        if given.shape != (2 * own,):
            raise ValueError(f"y must have shape ({2 * own},), found {given.shape}")
        columns = np.eye(2 * self._free, k) if tangents is None else np.asarray(tangents, float)
        if columns.shape != (2 * self._free, k):
            expected = f"({2 * self._free}, {k})"
            raise ValueError(f"tangents must have shape {expected}, found {columns.shape}")
        turns = np.where(self._flow.rotates[:own], np.rint(given[:own] / (2 * np.pi)), 0.0)
        vector = np.zeros(2 * total)
        vector[:own], vector[total : total + own] = given[:own] - 2 * np.pi * turns, given[own:]
        vector[self._places] = columns
        return vector, turns

    def _whole(self, vectors: Floats, turns: Floats) -> Floats:
        """States with all turns, shape (m, 2n), from rows of what is integrated."""
        own, total = self._own, self._total
        coordinates = vectors[:, :own] + 2 * np.pi * turns[:, :own]
        return np.concatenate([coordinates, vectors[:, total : total + own]], axis=1)

    def _integrated(self, vector: Floats, t0: float, t1: float, steps: int) -> Trajectory:
        events = [
            Event(function=function, direction=event.sign, terminal=int(self._stop))
            for event, function in zip(self._events, self._functions, strict=True)
        ]
        trajectory = integrate(
            self._flow,
            vector,
            [t1],
            start=t0,
            method=self._method,
            rtol=self._rtol,
            atol=self._atol,
            step=self._step,
            max_steps=steps,
            events=events,
        )
        if trajectory.outcome not in (Outcome.DONE, Outcome.EVENT):
            text = str(failure_text(self._system, trajectory))
            error = Interrupted if trajectory.outcome is Outcome.INTERRUPTED else ComputationError
            raise error(text, time=trajectory.stop_time)
        return trajectory

    def _collect(
        self, trajectory: Trajectory, turns: Floats, found: Iterable[list[tuple[Floats, Floats]]]
    ) -> bool:
        """Keep the crossings of a trajectory; whether there was one at which to stop."""
        stops = False
        for event, crossings, parts in zip(self._events, trajectory.crossings, found, strict=True):
            if crossings.count > len(crossings.time):
                raise ComputationError(
                    f"{event.name}: more than {len(crossings.time)} crossings; expected shorter "
                    "advances",
                    time=float(crossings.time[-1]),
                )
            states = self._whole(crossings.state, crossings.turns[:, : self._own] + turns)
            there = event.surface.reached(self._system, crossings.time, states.T)
            parts.append((crossings.time[there], states[there]))
            stops = stops or (self._stop and bool(there.any()))
        return stops
