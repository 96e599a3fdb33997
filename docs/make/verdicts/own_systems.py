"""Two kinds of systems of one's own: ordinary differential equations and maps."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import DOP853

from linkages.chaos.exponents import Floats, Growth
from linkages.errors import ComputationError


class _Moving(ABC):
    """State, tangents and time of a system, and what may be done to them between advances."""

    furthest = 1e9  # of numbers with 16 digits
    parts = 1
    """How often tangents are brought back to length one within an interval."""

    def __init__(self, state: ArrayLike, angles: ArrayLike | None, time: float) -> None:
        self._state = np.array(state, dtype=float)
        if self._state.ndim != 1 or not np.isfinite(self._state).all():
            raise ValueError("state must be finite numbers in one dimension")
        size = len(self._state)
        self.angles: NDArray[np.bool_] = np.zeros(size, dtype=bool)
        if angles is not None:
            self.angles = np.array(angles, dtype=bool)
        if self.angles.shape != (size,):
            raise ValueError(f"angles must be one entry for each of {size} entries of the state")
        self._tangents = np.zeros((size, 0))
        self.time = float(time)

    @property
    def state(self) -> Floats:
        """Copy of the state, shape (d,), angles in [-π, π]."""
        return self._state.copy()

    @property
    def tangents(self) -> Floats:
        """Copy of the tangents, shape (d, k); none (k = 0) until they are set."""
        return self._tangents.copy()

    @tangents.setter
    def tangents(self, values: ArrayLike) -> None:
        new = np.array(values, dtype=float)
        if new.ndim != 2 or len(new) != len(self._state):
            raise ValueError(f"tangents must have shape ({len(self._state)}, k), not {new.shape}")
        self._tangents = new

    def restart(
        self,
        state: ArrayLike | None = None,
        tangents: ArrayLike | None = None,
        time: float | None = None,
    ) -> None:
        """Go on from another state, with other tangents, at another time; None keeps a value."""
        if state is not None:
            new = np.array(state, dtype=float)
            if new.shape != self._state.shape or not np.isfinite(new).all():
                raise ValueError(f"state must be {len(self._state)} finite numbers")
            self._state = new
        if tangents is not None:
            self.tangents = np.asarray(tangents, dtype=float)
        if time is not None:
            self.time = float(time)

    @abstractmethod
    def advance(self, interval: float) -> None:
        """Move the state along the motion and the tangents along its variational equations."""

    def grow(
        self,
        intervals: int,
        interval: float,
        *,
        orthogonal: bool = True,
        watch: Callable[[float], None] | None = None,
    ) -> Iterator[Growth]:
        """As `TangentSystem` has it, interval by interval."""
        for number in range(intervals):
            grown = np.zeros(self._tangents.shape[1])
            for _ in range(self.parts):
                self.advance(interval / self.parts)
                lengths = np.linalg.norm(self._tangents, axis=0)
                directions = self._tangents / lengths
                if orthogonal:
                    directions, upper = np.linalg.qr(self._tangents)
                    lengths = np.abs(np.diag(upper))
                self.tangents = directions
                with np.errstate(divide="ignore"):
                    grown += np.log(lengths)
            yield Growth(
                grown[None] / interval, self.state[None], np.array([self.time]), directions[None]
            )
            if watch is not None:
                watch((number + 1) / intervals)

    def _accept(self, state: Floats, tangents: Floats, time: float) -> None:
        if not (np.isfinite(state).all() and np.isfinite(tangents).all()):
            raise ComputationError(
                f"The motion diverged before time {time:g}: a value is no longer a finite number. "
                "Start elsewhere, or renormalise tangents after shorter intervals.",
                time=self.time,
            )
        if self.angles.any():
            state[self.angles] = np.remainder(state[self.angles] + np.pi, 2 * np.pi) - np.pi
        self._state, self._tangents, self.time = state, tangents, time


class Ode(_Moving):
    """A system of differential equations y' = f(t, y), with its variational equations, by DOP853.

    `function`, `jacobian`: f(t, y), shape (d,), in seconds and any units of y, and ∂f/∂y.
    `rtol`, `atol`: of a step. Tangents take `rtol` of their own length as absolute tolerance, so
    that an advance commutes with rescaling them.
    `angles`: which entries of the state are angles; f must have period 2π in them.
    `parts`: how often tangents are brought back to length one within an interval: more than once
    where a direction contracts so much that it gets lost beside the others.

    E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, II.5 and I.14.
    """

    def __init__(
        self,
        function: Callable[[float, Floats], ArrayLike],
        jacobian: Callable[[float, Floats], ArrayLike],
        state: ArrayLike,
        rtol: float = 1e-9,
        atol: ArrayLike = 1e-12,
        *,
        angles: ArrayLike | None = None,
        time: float = 0.0,
        parts: int = 1,
    ) -> None:
        super().__init__(state, angles, time)
        self.parts = parts
        self._function, self._jacobian = function, jacobian
        self._rtol = rtol
        self._atol = np.broadcast_to(np.asarray(atol, dtype=float), self._state.shape)
        self._step: float | None = None

    def advance(self, interval: float) -> None:
        """Integrate over a time in seconds, which may be negative; raises ComputationError."""
        if interval == 0.0:
            return
        size, columns = self._tangents.shape
        end = self.time + interval
        lengths = np.linalg.norm(self._tangents, axis=0)
        atol = np.concatenate([self._atol, np.tile(self._rtol * lengths, size)])
        first = None if self._step is None else min(self._step, abs(end - self.time))
        solver = DOP853(
            self._rates,
            self.time,
            np.concatenate([self._state, self._tangents.ravel()]),
            end,
            first_step=first,
            rtol=self._rtol,
            atol=np.maximum(atol, np.finfo(float).tiny),
        )
        while solver.status == "running":
            step = float(solver.h_abs)  # what the tolerance allows; the last step is cut off
            message = solver.step()
            if solver.status == "failed" or not np.isfinite(solver.y).all():
                raise ComputationError(
                    f"The motion cannot be continued at time {solver.t:g}: "
                    f"{message or 'a value is no longer a finite number.'}",
                    time=float(solver.t),
                )
        self._step = max(step, float(solver.h_abs))
        y = solver.y.copy()
        self._accept(y[:size], y[size:].reshape(size, columns), end)

    def _rates(self, time: float, y: Floats) -> Floats:
        size, columns = self._tangents.shape
        state = y[:size]
        rates = np.empty_like(y)
        rates[:size] = self._function(time, state)
        if columns:
            jacobian = np.asarray(self._jacobian(time, state))
            rates[size:] = (jacobian @ y[size:].reshape(size, columns)).ravel()
        return rates


class Map(_Moving):
    """A map x → f(x), with its tangents multiplied by ∂f/∂x, the Jacobian at x, shape (d, d)."""

    def __init__(
        self,
        function: Callable[[Floats], ArrayLike],
        jacobian: Callable[[Floats], ArrayLike],
        state: ArrayLike,
        *,
        angles: ArrayLike | None = None,
    ) -> None:
        super().__init__(state, angles, 0.0)
        self._function, self._jacobian = function, jacobian

    def advance(self, interval: float) -> None:
        """Take a whole number of steps; raises ComputationError if the motion diverges."""
        if interval < 0 or interval != int(interval):
            raise ValueError(f"a map advances by a whole number of steps, not by {interval}")
        for _ in range(int(interval)):
            tangents = self._tangents
            if tangents.shape[1]:
                tangents = np.asarray(self._jacobian(self._state), dtype=float) @ tangents
            state = np.array(self._function(self._state), dtype=float)
            self._accept(state, tangents, self.time + 1.0)
