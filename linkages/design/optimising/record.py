"""Every motion of a search: numbers, what came of them, and which of them are best."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from linkages.design.optimising.goals import Constraint, Goal

Floats = NDArray[np.float64]

HOLDS = 1e-8
"""By what part of its size a constraint may be violated and still holds."""


ROUND_OFF = 1e-11
"""Part of the goal by which two values are alike."""


@dataclass(frozen=True)
class Tried:
    """What came of some numbers.

    Parameters
    ----------
    places
        In the box of bounds, from 0 to 1.
    value
        Of the goal; nan if there is none.
    measured, excesses
        Of the constraints; nan if there are none.
    missing
        How much of the motion there is not: 0 if all of it is there, up to 1 where it stops before
        its end, 2 if a measure has no value, above 2 and up to 3 by how far from assembly the
        mechanism is, 3 if the numbers make no sense.
    reason
        Why, if not all of it is there.
    """

    places: Floats
    value: float
    measured: Floats
    excesses: Floats
    missing: float = 0.0
    reason: str = ""


@dataclass
class Record:
    """What was tried in a search, in its order.

    Parameters
    ----------
    goal, constraints
        What is sought.
    watch
        Called after each, with how many there are and the best value so far.
    most
        How many there may be; None for any number.
    plateau
        Whether a search has ended where nothing is gained any more but by round-off.
    settled
        The goal at the best end of a search, and its first-order optimality.
    """

    goal: Goal
    constraints: Sequence[Constraint]
    watch: Callable[[int, float], None] | None = None
    most: int | None = None
    tried: list[Tried] = field(default_factory=list)
    sizes: Floats | None = None
    best: Tried | None = None
    plateau: bool = False
    settled: tuple[float, float] = (math.nan, math.nan)

    def add(self, one: Tried) -> None:
        """Keep what came of some numbers; raises `EnoughError` when there may be no more."""
        self.tried.append(one)
        if self.sizes is None and not one.missing:
            sizes = np.maximum(np.abs(one.measured), np.abs(one.excesses))
            self.sizes = np.where(sizes > 0.0, sizes, 1.0)
        if self.best is None or self.order(one) < self.order(self.best):
            self.best = one
        if self.watch is not None:
            self.watch(len(self.tried), self.best.value)
        if self.most is not None and len(self.tried) >= self.most:
            raise EnoughError

    def settle(self, places: Floats, optimality: float) -> None:
        """Prefer where a search has settled to what is better by round-off alone."""
        one = next(t for t in reversed(self.tried) if np.array_equal(t.places, places))
        best = self.best
        assert best is not None
        if self.holds(one) and abs(one.value - best.value) <= ROUND_OFF * abs(one.value):
            self.best = one
        if self.best is one or abs(one.value - best.value) <= HOLDS * abs(best.value):
            self.settled = best.value, optimality

    @property
    def optimality(self) -> float:
        """Of the best, by `Round.optimality`; nan if no search has ended there."""
        value, optimality = self.settled
        known = self.best is not None and abs(self.best.value - value) <= HOLDS * abs(value)
        return optimality if known else math.nan

    def order(self, one: Tried) -> tuple[float, float, float]:
        """Less is better: first what can be computed, then what satisfies the constraints."""
        if one.missing:
            return one.missing, np.inf, np.inf
        return 0.0, self.violation(one), self.goal.sign * one.value

    def violations(self, one: Tried) -> Floats:
        """Of each constraint, as a part of its size; zero where it holds."""
        found = [c.violation(e) for c, e in zip(self.constraints, one.excesses, strict=True)]
        parts = np.array(found) / (1.0 if self.sizes is None else self.sizes)
        return np.where(parts <= HOLDS, 0.0, parts)

    def violation(self, one: Tried) -> float:
        """Sum over the constraints; infinite for what cannot be computed."""
        return np.inf if one.missing else float(self.violations(one).sum())

    def holds(self, one: Tried) -> bool:
        """Whether it can be computed and satisfies all constraints."""
        return self.violation(one) == 0.0


class EnoughError(Exception):
    """As many motions as may be were computed."""
