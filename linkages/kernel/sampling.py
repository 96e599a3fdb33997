"""Updates of sampled states, at multiples of their periods.

A mode rises at each multiple, where the states jump to their next values. Its function is a wave of
time alone, so that motions whose states repeat after a common period repeat with their modes. It
consists of parabolas, which steps between two changes tell from their ends.

An update is a few units in the last place late. States at a multiple of the period are therefore
those before it, whatever times are rounded to, and one at the start follows it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from linkages.components.contributed.terms import Parameter
from linkages.kernel.scalars import Scalar

if TYPE_CHECKING:
    from linkages.kernel.model import Model

LATE, LATER = 16 * 2.220446049250313e-16, 1e-12
"""By how much an update is late: parts of its time, and of the period."""

TOGETHER = 1e-6
"""Part of the shorter period below which updates of two periods are one."""

LONGEST_STEP = 0.49
"""Part of the period that a step may take: none may pass two changes of a wave."""


def add_updates(model: Model) -> None:
    """Give a model the modes of its updates."""
    states = model.mechanism.internal.values()
    periods = [None if s.period is None else s.period.parameter for s in states]
    known = list(dict.fromkeys(period for period in periods if period is not None))
    for place, own in enumerate(known):
        values = []
        for period, now, following in zip(periods, model.internal, model.next_values, strict=True):
            value = now if period is None else following
            if period not in (None, own):
                value = model.graph.select(_near(model, period, own), value, now)
            for other in known[:place]:  # what comes at the same time is done there
                value = model.graph.select(_near(model, other, own), now, value)
            values.append(value)
        names = [s.name for s in states if s.period is not None and s.period.parameter == own]
        model.switches.update(f"update of {', '.join(names)}", _wave(model, own), values)


def _cycles(model: Model, period: Parameter) -> Scalar:
    """Time in periods."""
    return model.inputs.time * (1.0 - LATE) / model.inputs.parameter(period) - LATER


def _wave(model: Model, period: Parameter) -> Scalar:
    """Rises through zero at multiples of a period, and falls through zero between them."""
    cycles = _cycles(model, period)
    part = cycles - model.graph.apply("floor", cycles)
    half = part - 0.5
    return model.graph.select(half, half * (part - 1.0), -half * part)


def _near(model: Model, period: Parameter, own: Parameter) -> Scalar:
    """Not negative next to a multiple of a period, at one of another period."""
    graph, cycles = model.graph, _cycles(model, period)
    length, other = map(model.inputs.parameter, (period, own))
    apart = length * (cycles - graph.apply("floor", cycles + 0.5))
    most = TOGETHER * graph.select(length - other, other, length)
    return most * most - apart * apart
