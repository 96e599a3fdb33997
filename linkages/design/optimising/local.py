"""The nearest optimum by exact derivatives; peaks by the epigraph, exchanging where they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.design.optimising.goals import Peak, Plain, Sum
from linkages.design.optimising.located import Located
from linkages.design.optimising.problem import Measured, Problem
from linkages.design.optimising.record import Record
from linkages.errors import ComputationError, InputError

Floats = NDArray[np.float64]

EVENLY = 32
"""Times at which series are held down besides their maxima: others may come to lead."""

MOST_ROUNDS = 20
"""Exchanges of the times of maxima; they settle as quickly as those of Remez's algorithm do."""

SETTLED = 1e-10
"""Part of its size by which a series may exceed the bound on its maxima."""

_TOLERANCE = 1e-13
_ITERATIONS = 200
_STEEP = 1e3


class _Linear(NamedTuple):
    """Values and derivatives by all variables: places, then bounds on peaks."""

    values: Floats
    derivatives: Floats


@dataclass(eq=False)
class Local:
    """A search from one start.

    Parameters
    ----------
    problem, record
        What is sought, and where motions are recorded.
    """

    problem: Problem
    record: Record
    times: dict[tuple[str, float], list[float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.goal = self.problem.goal.sum
        self.limits = [each.sum for each in self.problem.constraints]
        self.peaks = _peaks([self.goal, *self.limits])

    def from_(self, places: Floats) -> None:
        """Search from some places; what is found is in the record."""
        located = Located(self.problem, self.peaks)
        even = np.linspace(0.0, self.problem.run.end, EVENLY + 1).tolist()
        self.times = {peak: list(even) for peak in self.peaks}
        try:
            tops = located.at(places)
        except (ComputationError, InputError) as error:
            self.record.add(self.problem.refused(places, error))
            return
        for _ in range(MOST_ROUNDS):
            for peak, found in tops.items():
                self.times[peak] = sorted({*self.times[peak], *found.time.tolist()})
            bounds = np.array([found.value.max() for found in tops.values()])
            reached = _Smooth(self, places, bounds).minimised()
            if reached is None:
                return
            places, bounds = reached
            self.record.settle(places)
            if not self.peaks:
                return
            tops = located.at(places)
            over = np.array([found.value.max() for found in tops.values()]) - bounds
            sizes = np.array([np.abs(found.value).max() for found in tops.values()])
            if (over <= SETTLED * sizes).all():
                return


def _peaks(sums: Sequence[Sum]) -> list[tuple[str, float]]:
    """Series and signs of all peaks, each once."""
    parts = [part for each in sums for part in each.parts]
    return list(dict.fromkeys((p.series, p.sign) for p in parts if isinstance(p, Peak)))


class _Smooth:
    """The smooth problem with peaks at given times, in places and bounds that are about one."""

    def __init__(self, search: Local, places: Floats, bounds: Floats) -> None:
        self.search, self.count = search, len(places)
        times = {
            peak: [(f"at({t!r} s, {peak[0]})", peak[1]) for t in search.times[peak]]
            for peak in search.peaks
        }
        self.held = [
            (row, text, sign) for row, p in enumerate(search.peaks) for text, sign in times[p]
        ]
        plain = [
            part.measure
            for each in (search.goal, *search.limits)
            for part in each.parts
            if isinstance(part, Plain)
        ]
        texts = [*plain, *(text for _, text, _ in self.held)]
        self.measured = Measured(search.problem, search.record, texts)
        self.sizes = np.maximum(np.abs(bounds), np.finfo(float).tiny)
        self.start = np.concatenate([places, bounds / self.sizes])
        self.last: Floats | None = None
        self.worst = 0.0
        self.scales: Floats | None = None

    def minimised(self) -> tuple[Floats, Floats] | None:
        """Places and bounds at the optimum; None if the start cannot be computed."""
        from scipy import optimize

        first = self._all(self.start)
        if first is None:
            return None
        sizes = np.abs(first.derivatives).max(axis=1)
        self.scales = np.where(sizes > 0.0, sizes, 1.0)
        found = optimize.minimize(
            self._value, self.start, jac=self._slope, method="SLSQP", bounds=self._box(),
            constraints=self._conditions(), options={"ftol": _TOLERANCE, "maxiter": _ITERATIONS},
        )  # fmt: skip
        return np.clip(found.x[: self.count], 0.0, 1.0), found.x[self.count :] * self.sizes

    def _box(self) -> list[tuple[float | None, float | None]]:
        return [(0.0, 1.0)] * self.count + [(None, None)] * len(self.sizes)

    def _conditions(self) -> list[dict[str, Any]]:
        """Constraints as SLSQP takes them: not below zero, or zero."""
        own = [each.equal for each in self.search.problem.constraints]
        equal = np.array([*own, *(False for _ in self.held)], dtype=bool)
        return [
            {
                "type": kind,
                "fun": lambda z, rows=rows: -self._limits(z)[rows],
                "jac": lambda z, rows=rows: -self._limit_slopes(z)[rows],
            }
            for kind, rows in (("ineq", ~equal), ("eq", equal))
            if rows.any()
        ]

    def _value(self, z: Floats) -> float:
        found = self._all(z)
        if found is None:
            # worse than all that can be computed, so that steps become shorter
            return self.worst + _STEEP
        value = float(found.values[0]) / self._scale[0]
        self.worst = max(self.worst, value)
        return value

    def _slope(self, z: Floats) -> Floats:
        found = self._computed(z)
        return found.derivatives[0] / self._scale[0]

    def _limits(self, z: Floats) -> Floats:
        return self._computed(z).values[1:] / self._scale[1:]

    def _limit_slopes(self, z: Floats) -> Floats:
        return self._computed(z).derivatives[1:] / self._scale[1:, None]

    @property
    def _scale(self) -> Floats:
        assert self.scales is not None
        return self.scales

    def _computed(self, z: Floats) -> _Linear:
        """All values, or those of the last place that has some."""
        found = self._all(z)
        if found is None:
            assert self.last is not None
            found = self._all(self.last)
        assert found is not None
        return found

    def _all(self, z: Floats) -> _Linear | None:
        """Goal, constraints and what is held down, none of which shall be above zero."""
        found = self.measured.at(np.clip(z[: self.count], 0.0, 1.0))
        if found is None:
            return None
        values, slopes = found
        bounds = z[self.count :] * self.sizes
        sums = [self.search.goal, *self.search.limits]
        rows = [self._sum(each, values, slopes, bounds) for each in sums]
        for peak, text, sign in self.held:
            row = self.measured.row[text]
            below = np.zeros(len(self.sizes))
            below[peak] = -self.sizes[peak]
            slope = np.concatenate([sign * slopes[row], below])
            rows.append((sign * values[row] - bounds[peak], slope))
        self.last = np.array(z)
        return _Linear(np.array([value for value, _ in rows]), np.array([s for _, s in rows]))

    def _sum(
        self, wanted: Sum, values: Floats, slopes: Floats, bounds: Floats
    ) -> tuple[float, Floats]:
        total, slope = wanted.constant, np.zeros(self.count + len(self.sizes))
        for part in wanted.parts:
            if isinstance(part, Plain):
                row = self.measured.row[part.measure]
                total += part.factor * values[row]
                slope[: self.count] += part.factor * slopes[row]
            else:
                place = self.search.peaks.index((part.series, part.sign))
                total += part.factor * bounds[place]
                slope[self.count + place] += part.factor * self.sizes[place]
        return float(total), slope
