"""The equations of slidercrank_contact.c in Python, integrated by SciPy's DOP853: the usual way.

A crossing within a step is found on SciPy's interpolant, and a new leg begins there.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

CRANK, ROD, CENTRE, ROD_MASS, SLIDER_MASS = 0.05, 0.12, 0.06, 0.21, 0.14
ROD_MOMENT = 0.00025 + ROD_MASS * CENTRE**2
OMEGA = 5000 * math.pi / 30
SIZE, STIFFNESS, DAMPING, LEAST = 0.5e-3, 6.61e10, 0.75 * (1 - 0.81), 1e-3


@dataclass(frozen=True)
class Counted:
    """What a run cost."""

    seconds: float
    evaluations: float

    @classmethod
    def of(cls, run: Callable[[], float]) -> Counted:
        """Time a run that returns its number of evaluations."""
        begin = time.perf_counter()
        evaluations = run()
        return cls(time.perf_counter() - begin, evaluations)

    def __sub__(self, other: Counted) -> Counted:
        return Counted(self.seconds - other.seconds, self.evaluations - other.evaluations)


def rates(t: float, y: np.ndarray, first: float | None) -> tuple[float, ...]:
    """Derivatives of offset and rate; in contact `first` is the rate of the touch."""
    ex, ey, vx, vy = y.tolist()
    Ax, Ay = CRANK * math.cos(OMEGA * t), CRANK * math.sin(OMEGA * t)
    ax, ay = -(OMEGA**2) * Ax, -(OMEGA**2) * Ay
    ls = ey - Ay
    lc = math.sqrt(ROD**2 - ls**2)
    spin = (vy - OMEGA * Ax) / lc
    turn = (ls * spin**2 - ay) / lc
    slide = ax - lc * spin**2 - ls * turn
    Fx = Fy = 0.0
    if first is not None:
        rho = math.hypot(ex, ey)
        depth = max(rho - SIZE, 0.0)
        rate = (ex * vx + ey * vy) / rho
        force = STIFFNESS * depth**1.5 * max(1 + DAMPING * rate / first, 0.0)
        Fx, Fy = -force * ex / rho, -force * ey / rho
    weighed = ROD_MOMENT * turn + ROD_MASS * CENTRE / ROD * (lc * ay - ls * ax)
    vyy = (Fy - ls / lc * Fx) * lc**2 / ROD_MOMENT - weighed * lc / ROD_MOMENT
    return vx, vy, Fx / SLIDER_MASS + slide - ls / lc * vyy, vyy


def integrate(end: float, rtol: float) -> tuple[np.ndarray, int]:
    """Offset and rate at the end, and the number of evaluations."""
    t, y, first, evaluations = 0.0, np.zeros(4), None, 0
    scales = np.array([SIZE, SIZE, SIZE * OMEGA, SIZE * OMEGA])

    def depth(state: np.ndarray) -> float:
        return math.hypot(state[0], state[1]) - SIZE

    while t < end:
        sign = 1.0 if first is None else -1.0
        leg = DOP853(
            lambda t, y, first=first: rates(t, y, first), t, y, end,
            rtol=rtol, atol=0.1 * rtol * scales, first_step=min(1e-7, end - t),
        )  # fmt: skip
        while leg.status == "running":
            leg.step()
            looks = leg.t_old + np.linspace(0, 1, 9)[1:] * (leg.t - leg.t_old)
            curve = leg.dense_output()
            beyond = [k for k, look in enumerate(looks) if sign * depth(curve(look)) > 0]
            if beyond:
                high = looks[beyond[0]]
                low = looks[beyond[0] - 1] if beyond[0] else leg.t_old + 1e-3 * (high - leg.t_old)
                if depth(curve(low)) * depth(curve(high)) < 0:
                    high = brentq(lambda t, curve=curve: depth(curve(t)), low, high, xtol=1e-16)
                t, y = high, curve(high)
                rate = float(y[:2] @ y[2:]) / math.hypot(y[0], y[1])
                first = max(rate, LEAST) if first is None else None
                break
        else:
            t, y = leg.t, leg.y
        evaluations += leg.nfev
    return y, evaluations
