"""Why a motion stops that is led by one choice of free coordinates alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.system import System
from linkages.solution.integration import failure_text
from linkages.solution.motion import block_alignment, block_place
from linkages.solution.switching import serving
from linkages.solvers.outcome import Outcome
from linkages.solvers.trajectory import Trajectory

MOST_NAMES = 3
"""Coordinates that a message proposes."""


def stop_text(system: System, trajectory: Trajectory, state: NDArray[np.float64]) -> str:
    """Why an integration stopped before its end, as a sentence.

    Where only the choice of free coordinates is singular, and not the mechanism, it says which
    others would serve: simulations exchange them on the way, sections where a quantity has a value
    and tangents cannot yet.

    Parameters
    ----------
    system
        What moves.
    trajectory
        How it was integrated; it did not reach its end.
    state
        Integrated coordinates and rates at the stop, shape (2n,).
    """
    found = []
    if trajectory.outcome in (Outcome.SINGULAR, Outcome.UNREACHABLE) and trajectory.block >= 0:
        found = serving(system, trajectory.stop_time, state)
    if not found:
        return str(failure_text(system, trajectory))
    (given,), _ = found[0]
    others = [new for (old,), (new,) in found if old == given][:MOST_NAMES]
    place = block_place(system.model, trajectory.block, trajectory.stop_time)
    return (
        f"{place}: {block_alignment(system.model, trajectory.block)}, and {given} cannot be the "
        "free coordinate beyond this position. The mechanism itself is not singular there: "
        f"{' or '.join(others)} could be free instead of {given}. Simulations exchange free "
        "coordinates on the way; sections where a quantity has a value, and exponents, cannot do "
        f"so yet. Name {others[0]} under free, if it can stay free for the whole motion, or end "
        "before this time."
    )
