"""Which laws and loads have no finite value at a time, for messages that name them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.functions import Function
from linkages.kernel.forces.loads import LoadNodes
from linkages.kernel.numbers.laws import law_values
from linkages.kernel.system import System
from linkages.reading.paths import dotted
from linkages.solvers.trajectory import Trajectory

NEAR = 1e-9
"""How far beyond a stop a law is looked at, beside the time itself (or one second)."""

WITHOUT_BOUND = 1e6
"""How many times as large as its median until then a law is that grows without bound."""

BEFORE = 401
"""Times before a stop at which the median is taken."""


def undefined_load(system: System, times: NDArray[np.float64]) -> tuple[int, str] | None:
    """The first time at which a load of a driven system has no value, and a sentence about it."""
    found = []
    for load in system.model.loads:
        lost = _lost(system, load, times, None) & _reached(system, times)
        if lost.any():
            first = int(np.argmax(lost))
            place = f"at t = {times[first]:.9g} s, {dotted(load.load.path)}: {load.undefined}"
            found.append((first, f"{place}. End before, or change the load."))
    return min(found) if found else None


def _lost(
    system: System,
    load: LoadNodes,
    times: NDArray[np.float64] | float,
    state: NDArray[np.float64] | None,
) -> NDArray[np.bool_]:
    """Where a load has no value though all has one that it depends on."""
    given, rated = (
        np.isfinite(system.evaluate(nodes, times, state)) for nodes in (load.given, load.doubtful)
    )
    lost = ~rated[:1].all(axis=0) & rated[1:].all(axis=0)
    return np.asarray(lost | ~given.all(axis=0))


def _reached(system: System, times: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Where all joints have a place."""
    joints = system.model.positions.joints.values()
    places = [node for joint in joints for node in (joint.x, joint.y)]
    return np.asarray(np.isfinite(system.evaluate(places, times)).all(axis=0))


def loads_at_stop(system: System, trajectory: Trajectory) -> list[str]:
    """Loads that explain why an integration stopped: without a value there, or without bound."""
    time = trajectory.stop_time
    found = [
        dotted(load.path)
        for load in system.mechanism.loads
        if any(_breaks(law, time) for law in load.laws)
    ]
    return [*dict.fromkeys(found), *_springs(system, trajectory)]


def _breaks(law: Function, time: float) -> bool:
    near = NEAR * max(1.0, abs(time))
    around = law_values(law, time + near * np.array([0.0, -1.0, 1.0, -1e-3, 1e-3, 1e-6, -1e-6]))
    if not np.isfinite(around).all():
        return True
    before = np.abs(law_values(law, np.linspace(0.0, time, BEFORE)))
    return bool(np.abs(around).max() > WITHOUT_BOUND * np.median(before) > 0.0)


def _springs(system: System, trajectory: Trajectory) -> Iterator[str]:
    """Springs whose ends meet, and other laws of state without a value, at the last state."""
    count, total = len(system.topology.coordinates), len(trajectory.final_state) // 2
    state = np.concatenate(
        [trajectory.final_state[:count], trajectory.final_state[total : total + count]]
    )
    time = trajectory.stop_time
    ahead = NEAR * max(1.0, abs(time)) * np.array([0.0, 1e-3, 1.0, 1e3])
    states = np.repeat(state[:, None], len(ahead), axis=1)
    states[:count] += ahead * states[count:]
    for load in system.model.loads:
        if not load.load.given and _lost(system, load, time + ahead, states).any():
            yield f"{dotted(load.load.path)} ({load.undefined})"
