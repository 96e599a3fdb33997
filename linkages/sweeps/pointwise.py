"""Points of a sweep one by one: what cannot be computed has a code and a reason."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from linkages.errors import InputError, LinkagesError
from linkages.kernel.system import System
from linkages.kernel.varying import Along, Varying
from linkages.solution.solution import IncompleteError
from linkages.sweeps.answers import Answer, Code, OverTimeError
from linkages.sweeps.points import Points
from linkages.sweeps.running import stopping

BUDGET = "max_steps"
"""Stands in what is said of a motion that used up its steps."""

SIDE_BY_SIDE = 8, 128
"""Fewest and most motions that are integrated together."""

_BLOCK = 64


def answered(along: Along, place: int, of: Callable[[System], Answer]) -> Answer:
    """The answer at one of some points.

    Parameters
    ----------
    along, place
        The mechanisms there, and which of them.
    of
        What is asked of one.
    """
    if stopping():
        raise KeyboardInterrupt
    try:
        system = along.system(place)
    except InputError as error:
        return Answer.of(error, refusal_code(along.varying, along.points[place]))
    return attempted(lambda: of(system))


def attempted(task: Callable[[], Answer]) -> Answer:
    """An answer, or why there is none."""
    try:
        return task()
    except OverTimeError as error:
        return Answer({}, Code.OVER_TIME, str(error))
    except InputError as error:
        return Answer.of(error, Code.INVALID)
    except IncompleteError as error:
        return Answer.of(error, stop_code(error), evaluations(error.solution.motion))
    except (LinkagesError, ValueError) as error:
        return Answer.of(error, stop_code(error))


def end_when_stopping(_fraction: float) -> None:
    """Watch a computation: ends it when the sweep has ended that it is for."""
    if stopping():
        raise KeyboardInterrupt


def refusal_code(varying: Varying, overrides: Any) -> Code:
    """Whether values cannot be used, or the mechanism that they make cannot be assembled."""
    try:
        varying.mechanism_at(overrides)
    except InputError:
        return Code.INVALID
    return Code.NOT_ASSEMBLED


def stop_code(error: Exception) -> Code:
    """What became of a motion that stopped."""
    return Code.OVER_BUDGET if BUDGET in str(error) else Code.STOPPED


def evaluations(motion: Any) -> int:
    """What a motion cost."""
    return int(motion.cost.get("evaluations", 0))


def first_system(varying: Varying, points: Points) -> System:
    """The first system along the points that can be built.

    Raises
    ------
    InputError
        What is wrong with the first, if none can.
    """
    refusal: Exception | None = None
    for first in range(0, points.count, _BLOCK):
        for overrides in points.overrides(first, min(first + _BLOCK, points.count)):
            try:
                return varying.at(overrides)
            except InputError as error:
                refusal = refusal or error
    assert refusal is not None
    raise refusal
