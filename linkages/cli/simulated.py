"""Simulations that may stop before their end."""

from __future__ import annotations

from typing import Any

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import Interrupted
from linkages.solution.simulate import simulate
from linkages.solution.solution import IncompleteError, Solution


def as_far_as_possible(mechanism: Mechanism, **given: Any) -> tuple[Solution, str | None, bool]:
    """A motion; why it stopped before its end, if it did, and whether somebody stopped it.

    Parameters
    ----------
    mechanism, given
        As `linkages.simulate` takes them.
    """
    try:
        return simulate(mechanism, **given), None, False
    except IncompleteError as error:
        return error.solution, str(error), False
    except Interrupted as error:
        return error.solution, str(error), True


def how_far(solution: Solution, failure: str | None) -> dict[str, Any]:
    """Whether a motion came to its end, as JSON says it."""
    stopped = None if failure is None else {"time": solution.motion.stop_time, "reason": failure}
    return {
        "mechanism": solution.mechanism.name,
        "completed": failure is None,
        "stopped": stopped,
    }
