"""Where laws of a motion that drives determine change from one branch to another."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.graph.differentiation import derivative_along
from linkages.kernel.graph.scalars import Level, Scalar, reachable
from linkages.kernel.model import Model

Floats = NDArray[np.float64]

_CLOSER = 64
"""Parts into which an interval is cut where two changes may hide in it."""


def conditions_of(nodes: Sequence[Scalar], *levels: Level) -> list[Scalar]:
    """What decides between branches below nodes and depends on no more than some level."""
    found = {
        node.operands[0]
        for node in reachable(nodes)
        if node.operation == "select" and node.operands[0].level in levels
    }
    return sorted(found, key=lambda node: node.index)


def watched(model: Model, nodes: Sequence[Scalar]) -> list[Scalar]:
    """All conditions below nodes, then their rates where drives determine the motion."""
    conditions = conditions_of(nodes, Level.TIME, Level.STATE)
    rates = derivative_along(conditions, [{model.inputs.time.index: model.graph.one}])
    return [*conditions, *(rate for (rate,) in rates)]


def brackets(times: Floats, look: Callable[[Floats], Floats]) -> Floats:
    """Times just before and just behind each change of a branch, shape (changes, 2).

    Parameters
    ----------
    times
        At which to look at least, in order.
    look
        Times → conditions and then their rates, shape (2 conditions, times).
    """
    values, rates = np.split(look(times), 2)
    more = more_looks(times, values, rates)
    if len(more):
        order = 1 if times[-1] >= times[0] else -1
        times = np.union1d(times, more)[::order]
        values = np.split(look(times), 2)[0]
    crossed = ((values[:, :-1] < 0.0) != (values[:, 1:] < 0.0)).any(axis=0)
    return np.stack([times[:-1][crossed], times[1:][crossed]], axis=1)


def more_looks(times: Floats, values: Floats, rates: Floats) -> Floats:
    """Further times at which to look, where a function may dip below zero between two of them.

    There it heads for zero at the first and away from it at the second, and both tangents meet on
    the other side: what is curved one way only lies on theirs.

    Parameters
    ----------
    times, values, rates
        Shapes (n,), and (functions, n) twice.
    """
    sides = np.where(values < 0.0, -1.0, 1.0)
    size, rate, steps = sides * values, sides * rates, np.diff(times)
    with np.errstate(divide="ignore", invalid="ignore"):
        falls, rises = -rate[:, :-1], rate[:, 1:]
        meet = (size[:, 1:] - size[:, :-1] - rises * steps) / (-falls - rises)
        lowest = size[:, :-1] - falls * meet
    hidden = (sides[:, :-1] == sides[:, 1:]) & (falls > 0.0) & (rises > 0.0) & (lowest < 0.0)
    within = np.flatnonzero(hidden.any(axis=0))
    parts = np.arange(1, _CLOSER) / _CLOSER
    return np.asarray(times[within, None] + steps[within, None] * parts).ravel()
