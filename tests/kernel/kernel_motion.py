"""Ways to follow a mechanism in time, for the tests of this folder."""

import ctypes

import numpy as np

from linkages.kernel.code.program import Kernel
from linkages.kernel.system import System

POINTER = ctypes.POINTER(ctypes.c_double)
FIRST = ((1, 4 / 5), (2, -1 / 5), (3, 4 / 105), (4, -1 / 280))
"""Weights of a central difference of eighth order."""


def places_at(of: System, time: float) -> dict[str, np.ndarray]:
    """Point → position at a time, with the coordinates of the initial state, shape (2,)."""
    joints = of.model.positions.joints
    nodes = [node for place in joints.values() for node in (place.x, place.y)]
    return dict(zip(joints, of.evaluate(nodes, time).reshape(-1, 2), strict=True))


def difference(f, step: float):
    """Derivative of a function at 0, by central differences of eighth order."""
    return sum(w * (f(k * step) - f(-k * step)) for k, w in FIRST) / step


def carried_along(of: System, times: np.ndarray) -> np.ndarray:
    """States of a mechanism without free coordinates, shape (2n, times).

    Each starts from what the one before it has settled to, as a solver would do it.
    """
    assert not of.topology.free
    state, states = of.state, []
    for time in times:
        state = of.evaluate(of.model.settled, time, state[:, None])[:, 0]
        assert np.isfinite(state).all(), time
        states.append(state)
    return np.array(states).T


def call(kernel: Kernel, time: float, state: np.ndarray, size: int):
    """Both statuses of a compiled kernel and what it writes, shape (size,).

    The size is that of the accelerations (or whatever takes their place); there is room for the
    margins and settled coordinates of a hundred blocks behind them.
    """
    timed, out = np.zeros(max(1, kernel.timed_size)), np.full(size + 800, np.nan)
    state = np.array(state, dtype=float)
    y, p, t, o = (a.ctypes.data_as(POINTER) for a in (state, kernel.parameters, timed, out))
    clock = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_double, POINTER, POINTER)(kernel.clock)
    rates = ctypes.CFUNCTYPE(ctypes.c_int64, *[POINTER] * 4)(kernel.rates)
    return clock(time, p, t), rates(y, p, t, o), out[:size]
