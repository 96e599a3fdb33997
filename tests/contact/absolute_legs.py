"""Motions of the independent formulation: legs between located touches, leaves and slacks.

SciPy's DOP853 integrates a leg. A crossing is found on its interpolant, and then located by steps
of the method itself, which are more accurate than the interpolant.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from absolute_contact import AbsoluteContact, Mode
from absolute_gaps import CONTACT, FREE, SLACK
from scipy.integrate import DOP853, DenseOutput, solve_ivp
from scipy.optimize import brentq

FIRST_STEP = 1e-7
LOOKS = np.arange(1, 17) / 16
"""Where within a step signs are looked at: only a hop within a sixteenth of it would be missed."""


@dataclass(frozen=True)
class Event:
    """A located change of a clearance's state, with the rate of the indentation."""

    time: float
    clearance: str
    kind: str
    rate: float


@dataclass(frozen=True)
class Motion:
    """States at sample times, the modes they are in, and the events on the way."""

    states: np.ndarray
    modes: list[list[Mode]]
    events: list[Event]
    evaluations: int


@dataclass(frozen=True)
class Guard:
    """A sign to watch: positive as long as nothing happens."""

    clearance: int
    what: str
    value: Callable[[np.ndarray], float]


def motion(
    model: AbsoluteContact,
    times: Sequence[float],
    *,
    rtol: float = 1e-12,
    start: np.ndarray | None = None,
    modes: Sequence[Mode] | None = None,
) -> Motion:
    """March from t = 0 through all sample times."""
    y = model.start() if start is None else start
    t, now = 0.0, list(modes or [Mode() for _ in model.gaps])
    events: list[Event] = []
    states, sampled, evaluations = [], [], 0
    for end in times:
        while t < end:
            t, y, crossed, count = Leg(model, now, rtol).run(t, y, end)
            evaluations += count
            if crossed is not None:
                y = model.projected(t, y)
                now, event = changed(model, t, y, now, crossed)
                events.append(event)
        states.append(y)
        sampled.append([replace(mode) for mode in now])
    return Motion(np.array(states), sampled, events, evaluations)


class Leg:
    """Integration in given modes until one of them ends."""

    def __init__(self, model: AbsoluteContact, modes: list[Mode], rtol: float) -> None:
        self.model, self.modes, self.rtol = model, modes, rtol
        self.guards = [guard for k in range(len(modes)) for guard in self._guards(k)]

    def _guards(self, k: int) -> list[Guard]:
        model, gap, mode = self.model, self.model.gaps[k], self.modes[k]

        def depth(y: np.ndarray) -> float:
            return model.wall(y, k).rho - gap.size

        def push(y: np.ndarray) -> float:
            wall = model.wall(y, k)
            if gap.damping:
                return gap.push(max(wall.rho - gap.size, 0.0), wall.speed, mode.first)
            return gap.factor(wall.speed, mode.first)

        if mode.state == FREE:
            return [Guard(k, "depth", lambda y: -depth(y))]
        sign = 1.0 if mode.state == CONTACT else -1.0
        return [Guard(k, "depth", depth), Guard(k, "push", lambda y: sign * push(y))]

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        return self.model.rates(t, y, self.modes)

    def _atol(self, y: np.ndarray) -> np.ndarray:
        """Offsets are small differences of large coordinates, and their rates of large rates."""
        size, model = min(gap.size for gap in self.model.gaps), self.model
        speed = max(1e-2, float(np.abs(model.speeds(y)).max()))
        scales = np.repeat([size, 1e-2 * speed], model.size)
        return self.rtol * np.concatenate([scales, np.ones(3)])

    def run(
        self, t: float, y: np.ndarray, end: float
    ) -> tuple[float, np.ndarray, Guard | None, int]:
        """The time and state of what comes first, what it is, and the number of evaluations."""
        atol = self._atol(y)
        solver = DOP853(
            self.rates, t, y, end, rtol=self.rtol, atol=atol, first_step=min(FIRST_STEP, end - t)
        )
        while solver.status == "running":
            before = solver.t, solver.y.copy()
            solver.step()
            assert solver.status != "failed", solver.t
            found = self._first(solver, before[0])
            if found is not None:
                time, guard = found
                time, state, more = self._located(before, time, guard)
                return time, state, guard, solver.nfev + more
        return solver.t, solver.y, None, solver.nfev

    def _first(self, solver: DOP853, begin: float) -> tuple[float, Guard] | None:
        """The earliest crossing within a step, on its interpolant."""
        curve = solver.dense_output()
        looks = begin + LOOKS * (solver.t - begin)
        states = curve(looks).T
        crossings = []
        for guard in self.guards:
            behind = next((j for j, state in enumerate(states) if guard.value(state) < 0), None)
            if behind is not None:
                low = begin + 1e-3 * (looks[0] - begin) if behind == 0 else looks[behind - 1]
                crossings.append((self._root(guard, curve, low, looks[behind]), guard))
        return min(crossings, key=lambda crossing: crossing[0], default=None)

    @staticmethod
    def _root(guard: Guard, curve: DenseOutput, low: float, high: float) -> float:
        def value(time: float) -> float:
            return guard.value(curve(time))

        return low if value(low) <= 0 else brentq(value, low, high, xtol=1e-18)

    def _located(
        self, before: tuple[float, np.ndarray], time: float, guard: Guard
    ) -> tuple[float, np.ndarray, int]:
        """Newton's method, with the integrator from the begin of the step as the function."""
        begin, y = before
        state, evaluations, tiny = y, 0, 1e-9
        for _ in range(3):
            if time > begin:
                span, atol = (begin, time), self._atol(y)
                found = solve_ivp(
                    self.rates, span, y, "DOP853", rtol=self.rtol, atol=atol,
                    first_step=time - begin,
                )  # fmt: skip
                state, evaluations = found.y[:, -1], evaluations + found.nfev
            value = guard.value(state)
            slope = (guard.value(state + tiny * self.rates(time, state)) - value) / tiny
            if abs(value / slope) < 1e-18:
                break
            time = max(time - value / slope, begin)
        return time, state, evaluations


def changed(
    model: AbsoluteContact, t: float, y: np.ndarray, modes: Sequence[Mode], guard: Guard
) -> tuple[list[Mode], Event]:
    """The modes after an event."""
    k, new = guard.clearance, replace(modes[guard.clearance])
    speed = model.wall(y, k).speed
    if guard.what == "push":
        new.state, kind = (SLACK, "slack") if new.state == CONTACT else (CONTACT, "again")
    elif new.state == FREE:
        new = Mode(CONTACT, max(speed, model.gaps[k].least_rate))
        kind = "touch"
    else:
        new.state, kind = FREE, "leave"
    return [*modes[:k], new, *modes[k + 1 :]], Event(t, model.gaps[k].name, kind, speed)
