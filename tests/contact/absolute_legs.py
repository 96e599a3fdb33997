"""Motions of the independent formulation: legs between located touches, leaves and slacks."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from absolute_contact import AbsoluteContact, Mode
from absolute_gaps import CONTACT, FREE, SLACK
from scipy.integrate import DOP853, OdeSolver, solve_ivp
from scipy.optimize import brentq

RTOL = 1e-12
LOOKS = np.arange(1, 17) / 16
"""Where within a step signs are looked at: a hop within a sixteenth of a step would be missed, and
a leg begins with steps of a hundredth of an impact."""


@dataclass(frozen=True)
class Event:
    """A located change of a clearance's state."""

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


def motion(
    model: AbsoluteContact,
    times: Sequence[float],
    *,
    rtol: float = RTOL,
    start: np.ndarray | None = None,
    modes: Sequence[Mode] | None = None,
    begin: float = 0.0,
    method: type[OdeSolver] = DOP853,
) -> Motion:
    """March from `begin` through all sample times."""
    y = model.start() if start is None else start
    t, now = begin, list(modes or [Mode() for _ in model.gaps])
    events: list[Event] = []
    states, sampled, evaluations = [], [], 0
    for end in times:
        while t < end:
            leg = _leg(model, t, y, now, end, rtol, method)
            t, y, evaluations = leg.time, leg.state, evaluations + leg.evaluations
            if leg.change is not None:
                y = model.projected(t, y)
                now, event = _changed(model, t, y, now, *leg.change)
                events.append(event)
        states.append(y)
        sampled.append([replace(mode) for mode in now])
    return Motion(np.array(states), sampled, events, evaluations)


@dataclass(frozen=True)
class _Leg:
    time: float
    state: np.ndarray
    evaluations: int
    change: tuple[int, str] | None


def _guards(model: AbsoluteContact, modes: Sequence[Mode]) -> list[tuple[int, str, float]]:
    """(clearance, what is watched, its sign while nothing happens)."""
    found = []
    for k, mode in enumerate(modes):
        if mode.state == FREE:
            found.append((k, "depth", -1.0))
        else:
            found.append((k, "depth", 1.0))
            found.append((k, "push", 1.0 if mode.state == CONTACT else -1.0))
    return found


def _watched(
    model: AbsoluteContact, y: np.ndarray, modes: Sequence[Mode], k: int, what: str
) -> float:
    gap = model.gaps[k]
    offset, rate = (part[k] for part in model.offsets(y))
    rho = math.hypot(*offset)
    if what == "depth":
        return rho - gap.size
    speed = float(offset @ rate) / rho
    if gap.damping:
        return gap.push(max(rho - gap.size, 0.0), speed, modes[k].first)
    return gap.factor(speed, modes[k].first)


def _leg(
    model: AbsoluteContact, t: float, y: np.ndarray, modes: list[Mode], end: float, rtol: float,
    method: type[OdeSolver],
) -> _Leg:  # fmt: skip
    """Integrate until something changes or `end` is reached."""

    def rates(time: float, state: np.ndarray) -> np.ndarray:
        return model.rates(time, state, modes)

    guards = _guards(model, modes)
    atol = _absolute(model, y, rtol)
    solver = method(rates, t, y, end, rtol=rtol, atol=atol, first_step=min(1e-7, end - t))
    extra = 0
    while solver.status == "running":
        before = solver.t, solver.y.copy()
        solver.step()
        assert solver.status != "failed", solver.t
        curve = solver.dense_output()
        looks = before[0] + LOOKS * (solver.t - before[0])
        first: tuple[float, int, str] | None = None
        for k, what, sign in guards:

            def value(time: float, k: int = k, what: str = what) -> float:
                return _watched(model, curve(time), modes, k, what)

            values = np.array([sign * value(time) for time in looks])
            values[-1] = sign * _watched(model, solver.y, modes, k, what)
            if (values < 0).any():
                j = int(np.argmax(values < 0))
                low = looks[j - 1] if j else before[0] + 1e-3 * (looks[0] - before[0])
                if sign * value(low) <= 0:  # it stands on its wrong side from the start
                    low = before[0]
                    root = low
                elif j == len(looks) - 1 and sign * value(looks[-1]) > 0:
                    root = looks[-1]
                else:
                    root = brentq(value, low, looks[j], xtol=1e-18, rtol=1e-15)
                if first is None or root < first[0]:
                    first = root, k, what
        if first is not None:
            time, state, more = _refined(model, rates, before, modes, first, rtol, atol)
            return _Leg(time, state, solver.nfev + extra + more, first[1:])
    return _Leg(solver.t, solver.y, solver.nfev, None)


def _refined(model, rates, before, modes, first, rtol, atol):
    """The time and state of an event, by steps of the method itself instead of its interpolant."""
    (t, y), (time, k, what) = before, first
    evaluations = 0
    for _ in range(3):
        state = y
        if time > t:
            found = solve_ivp(
                rates, (t, time), y, method="DOP853", rtol=rtol, atol=atol, first_step=time - t
            )
            state, evaluations = found.y[:, -1], evaluations + found.nfev
        value = _watched(model, state, modes, k, what)
        ahead = state + 1e-9 * rates(time, state)
        slope = (_watched(model, ahead, modes, k, what) - value) / 1e-9
        step = -value / slope
        if abs(step) < 1e-16 * max(time, 1e-3):
            break
        time = max(time + step, t)
    return time, state, evaluations


def _absolute(model: AbsoluteContact, y: np.ndarray, rtol: float) -> np.ndarray:
    """Absolute tolerances: offsets are small differences of large coordinates."""
    size = min(gap.size for gap in model.gaps)
    speed = max(1e-2, float(np.abs(y[model.size : 2 * model.size]).max()))
    places = np.full(model.size, rtol * size)
    speeds = np.full(model.size, rtol * 1e-2 * speed)
    return np.concatenate([places, speeds, np.full(3, rtol)])


def _changed(
    model: AbsoluteContact, t: float, y: np.ndarray, modes: Sequence[Mode], k: int, what: str
) -> tuple[list[Mode], Event]:
    """The modes after an event."""
    gap, mode = model.gaps[k], modes[k]
    offset, rate = (part[k] for part in model.offsets(y))
    speed = float(offset @ rate) / math.hypot(*offset)
    new = replace(mode)
    if what == "depth":
        new.state = CONTACT if mode.state == FREE else FREE
        kind = "touch" if mode.state == FREE else "leave"
        if kind == "touch":
            new.first = max(speed, gap.least_rate)
    else:
        new.state = SLACK if mode.state == CONTACT else CONTACT
        kind = "slack" if new.state == SLACK else "again"
    return [*modes[:k], new, *modes[k + 1 :]], Event(t, gap.name, kind, speed)
