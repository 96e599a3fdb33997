"""Many independent motions in batches."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.errors import Interrupted, LinkagesError
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.guards import Guard
from linkages.solution.march import Going, March, T
from linkages.solution.motion import Motion, Renormalised, Watch
from linkages.solution.plan import is_stiff
from linkages.solvers.integration import METHODS, IntegrationRequest
from linkages.solvers.job import AUTO, choose
from linkages.solvers.lanes import integrate_many
from linkages.solvers.method import RungeKutta
from linkages.solvers.trajectory import Outcome, Trajectory

Floats = NDArray[np.float64]


def march_many(
    marches: Sequence[March],
    times: ArrayLike,
    *,
    guards: Sequence[Guard] = (),
    renormalised: Sequence[Renormalised] | None = None,
    watch: Watch | None = None,
) -> list[Motion | LinkagesError]:
    """Advance many marches to the last of some times, those of one structure side by side.

    Every motion has the bits that `March.advance` gives for it alone. `times` has shape (samples,)
    or (motions, samples); a motion ends where a guard has been crossed as often as it wants.
    `watch` gets the fraction of motions that have ended about 20 times a second; what it raises
    ends all.
    """
    rows = np.broadcast_to(np.asarray(times, dtype=float), (len(marches), np.shape(times)[-1]))
    own = [None] * len(marches) if renormalised is None else renormalised
    going = [
        march.advancing(rows[index], guards=guards, renormalised=own[index])
        for index, march in enumerate(marches)
    ]
    return side_by_side(going, watch)


def side_by_side(tasks: Sequence[Going[T]], watch: Watch | None = None) -> list[T | LinkagesError]:
    """Carry out tasks that yield integrations side by side; `watch` is that of `march_many`."""
    result: dict[int, T | LinkagesError] = {}
    asked: dict[int, IntegrationRequest] = {}

    def go_on(index: int, trajectory: Trajectory | None) -> None:
        task = tasks[index]
        try:
            asked[index] = next(task) if trajectory is None else task.send(trajectory)
        except StopIteration as end:
            result[index] = end.value
        except LinkagesError as error:
            result[index] = error

    def look(fraction: float) -> None:
        if watch is not None:
            watch((len(result) + fraction * len(under_way)) / len(tasks))

    for index in range(len(tasks)):
        go_on(index, None)
    while asked:
        under_way, asked = asked, {}
        trajectories = integrate_many(list(under_way.values()), watch=look)
        for index, trajectory in zip(under_way, trajectories, strict=True):
            if trajectory.outcome is Outcome.INTERRUPTED:
                raise Interrupted("interrupted", time=trajectory.stop_time)
            go_on(index, trajectory)
    return [result[index] for index in range(len(tasks))]


def cpu_only(system: System, run: RunOptions, tangents: int = 0) -> str:
    """Why motions of a system are integrated on the CPU only, as what they are; empty if not so."""
    if not system.topology.coordinates:
        return "a motion that drives determine"
    picked = choose(run.rtol, stiff=not tangents and is_stiff(system)).name
    name = picked if run.method == AUTO else run.method
    if run.step is not None:
        return "a motion in steps of one length"
    method = METHODS.get(name)
    if method is not None and not (method.adaptive and isinstance(method, RungeKutta)):
        return f"a motion by the method '{name}'"
    return ""
