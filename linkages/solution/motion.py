"""The motion at the sample times: integrated, or solved directly where everything is driven."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.model import Model
from linkages.kernel.system import System

Floats = NDArray[np.float64]
Watch = Callable[[float], None]


@dataclass(frozen=True, kw_only=True)
class Settings:
    """How a motion is computed.

    Parameters
    ----------
    times
        Sample times in seconds, shape (samples,), from 0 on.
    method, rtol, atol, step, max_steps
        As `linkages.solvers.integrate.integrate` takes them.
    work
        Whether to integrate the work of drives and loads along with the motion.
    watch
        Called now and then with the fraction of simulated time done.
    """

    times: Floats
    method: str
    rtol: float
    atol: float | None
    step: float | None
    max_steps: int
    work: bool = False
    watch: Watch | None = None


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Free coordinates at the sample times that were reached.

    Parameters
    ----------
    time
        Shape (samples,).
    state
        Coordinates (angles within one turn), then rates, shape (2n, samples).
    turns
        Whole turns to add to the coordinates, shape (n, samples).
    acceleration
        Shape (n, samples).
    work
        Work of drives and loads since t = 0 in joules, shape (samples,), if it was asked for.
    failure
        Why it stopped before the end, as a sentence; None if it did not.
    stop_time
        Where it stopped.
    cost
        Numbers for the summary: steps, rejected steps, evaluations.
    method, reason
        The method that was used, and why if it was chosen automatically; empty where nothing was
        integrated.
    """

    time: Floats
    state: Floats
    turns: Floats
    acceleration: Floats
    work: Floats | None
    failure: str | None
    stop_time: float
    cost: dict[str, int]
    method: str = ""
    reason: str = ""


def compute_motion(system: System, settings: Settings) -> Motion:
    """Solve for the motion of a system; nothing is integrated if it has no free coordinate."""
    if system.topology.free:
        from linkages.solution.integration import integrated_motion

        return integrated_motion(system, settings)
    from linkages.solution.driven import driven_motion

    return driven_motion(system, settings)


def block_failure(model: Model, block: int, time: float, singular: bool) -> str:
    """A sentence that says when, where and why a motion cannot go on."""
    found = next(b for b in model.topology.solved_blocks if b.index == block)
    names = " and ".join(found.unknowns)
    place = f"at t = {time:.9g} s, joint {found.loops[0].apex}, block {block} ({found.kind} dyad"
    place += f" of {names})"
    if found.kind == "PP":
        return f"{place}: the axes of {names} are parallel, so nothing determines their positions"
    if found.kind == "RRP":
        aligned = f"{found.unknowns[0]} is perpendicular to the axis of {found.unknowns[1]}"
    else:
        aligned = f"{names} are in line"
    if singular:
        return (
            f"{place}: {aligned}; this position is singular, from it the mechanism can go on in "
            "two ways and double precision cannot tell which"
        )
    return f"{place}: the mechanism cannot be assembled beyond this position, where {aligned}"
