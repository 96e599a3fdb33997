"""A linkage with tangents to its motion: what exponents and indicators are computed from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.contact_log import ContactLog
from linkages.chaos.stops import stop_text
from linkages.errors import ComputationError, Interrupted
from linkages.kernel.system import System
from linkages.solution.plan import Plan
from linkages.solvers.integrate import MAX_STEPS, integrate
from linkages.solvers.outcome import Outcome

Floats = NDArray[np.float64]

TANGENT_ATOL = 1e-6
"""Absolute tolerance of tangents: they are of length one when they start."""


class LinkageTangents:
    """Free coordinates and rates of a mechanism, with solutions of the variational equations.

    Parameters
    ----------
    system
        A system with free coordinates.
    tangents
        Number of tangents, at most 2n.
    method, rtol, atol, step, max_steps
        As `linkages.simulate` takes them; `atol` is that of the motion, and `max_steps` are those
        of all advances together.
    parts
        Equal parts of every advance after which `passed` keeps where the motion is; none if 0.
    log
        Notes states for what is asked of forces later, if there is one.

    Attributes
    ----------
    passed
        Times and states of all integrated coordinates, shape (k,) and (2m, k): at the start, then
        at the ends of parts of each advance.
    """

    def __init__(
        self,
        system: System,
        tangents: int = 1,
        method: str = "dop853",
        rtol: float = 1e-10,
        atol: float | None = None,
        step: float | None = None,
        max_steps: int = MAX_STEPS,
        parts: int = 0,
        log: ContactLog | None = None,
    ) -> None:
        self.system = system
        self.time = system.time
        self._count = len(system.topology.free)
        self._columns = tangents
        self._flow = Plan.of(system, tangents=tangents).bind(system)
        self._method, self._rtol, self._step = method, rtol, step
        self._total = self._flow.coordinates
        self._tangent_rows = self._rows()
        self._atol = np.full(2 * self._total, rtol if atol is None else atol)
        self._atol[self._tangent_rows.ravel()] = TANGENT_ATOL
        self._vector = np.zeros(2 * self._total)
        self.evaluations = 0
        self._turns = np.zeros(self._count)
        self._max_steps, self._steps = max_steps, 0
        self._parts = max(parts, 1)
        self._keeps, self._log = bool(parts), log
        self.passed: list[tuple[Floats, Floats]] = []
        self.restart(self._own(system.state), np.eye(2 * self._count)[:, :tangents])
        if parts:
            self._keep(np.array([self.time]), self._vector[:, None])

    def _rows(self) -> NDArray[np.int64]:
        """Places of the tangents in the integrated vector, shape (2n, k)."""
        n, first = self._count, self._total - self._columns * self._count
        places = first + np.arange(self._columns) * n + np.arange(n)[:, None]
        return np.concatenate([places, self._total + places])

    def _own(self, state: Floats) -> Floats:
        """Free coordinates and rates of a state of the system."""
        half = len(state) // 2
        return np.concatenate([state[: self._count], state[half : half + self._count]])

    @property
    def tolerance(self) -> float:
        """Error of a step in tangents of length one."""
        return max(TANGENT_ATOL, self._rtol)

    @property
    def angles(self) -> NDArray[np.bool_]:
        """Which entries of the state are angles, kept within one turn."""
        rotates = self._flow.rotates[: self._count]
        return np.concatenate([rotates, np.zeros(self._count, dtype=bool)])

    @property
    def state(self) -> Floats:
        """Free coordinates, then their rates, shape (2n,)."""
        n = self._count
        return np.concatenate([self._vector[:n], self._vector[self._total : self._total + n]])

    @property
    def here(self) -> System:
        """The system, where the motion is now."""
        return self.system.at(self.time, self._plain(self._vector))

    def __copy__(self) -> LinkageTangents:
        """Another one in the same state, which goes its own way from there."""
        found = object.__new__(type(self))
        vars(found).update(vars(self), _vector=self._vector.copy(), passed=[])
        if self._keeps:
            found._keep(np.array([self.time]), found._vector[:, None])
        return found

    @property
    def unwrapped(self) -> Floats:
        """Free coordinates with the turns made since the start, shape (n,)."""
        return self._vector[: self._count] + 2 * np.pi * self._turns

    @property
    def tangents(self) -> Floats:
        """Shape (2n, k)."""
        return self._vector[self._tangent_rows].copy()

    @tangents.setter
    def tangents(self, values: Floats) -> None:
        self._vector[self._tangent_rows] = values

    def restart(
        self,
        state: Floats | None = None,
        tangents: Floats | None = None,
        time: float | None = None,
    ) -> None:
        """Go on from another state, with other tangents, at another time."""
        if time is not None:
            self.time = time
        if state is not None:
            n = self._count
            carried = len(self.system.topology.carried)
            full = self.system.state
            half = len(full) // 2
            self._vector[n : n + carried] = full[n : n + carried]
            self._vector[self._total + n : self._total + n + carried] = full[half + n :]
            self._vector[:n], self._vector[self._total : self._total + n] = state[:n], state[n:]
        if tangents is not None:
            self.tangents = tangents

    def advance(self, interval: float) -> None:
        """Integrate motion and tangents over a time in seconds.

        Raises
        ------
        ComputationError
            If the motion cannot go on.
        Interrupted
            After Ctrl-C.
        """
        each = 1 if self._log is None else self._log.looks(interval / self._parts)
        count = self._parts * each
        times = self.time + interval * (np.arange(1, count + 1) / count)
        trajectory = integrate(
            self._flow,
            self._vector,
            times,
            start=self.time,
            method=self._method,
            rtol=self._rtol,
            atol=self._atol,
            step=self._step,
            max_steps=max(1, self._max_steps - self._steps),
        )
        self._steps += trajectory.steps + trajectory.rejected
        self.evaluations += trajectory.evaluations
        if trajectory.outcome is not Outcome.DONE:
            text = stop_text(self.system, trajectory, self._plain(trajectory.final_state))
            if trajectory.outcome is Outcome.INTERRUPTED:
                raise Interrupted(text, time=trajectory.stop_time)
            raise ComputationError(text, time=trajectory.stop_time)
        self._vector, self.time = trajectory.final_state.copy(), float(times[-1])
        self._turns += trajectory.final_turns[: self._count]
        if self._log is not None:
            accelerations = trajectory.acceleration.T[: len(self.system.topology.coordinates)]
            self._log.note(trajectory.time, self._plain(trajectory.state.T), accelerations)
        if self._keeps:
            kept = slice(each - 1, None, each)
            self._keep(trajectory.time[kept], trajectory.state.T[:, kept])

    def _keep(self, time: Floats, vectors: Floats) -> None:
        self.passed.append((time, self._plain(vectors)))

    def _plain(self, vectors: Floats) -> Floats:
        """Integrated coordinates and rates without the tangents."""
        count = len(self.system.topology.coordinates)
        return np.concatenate([vectors[:count], vectors[self._total : self._total + count]])
