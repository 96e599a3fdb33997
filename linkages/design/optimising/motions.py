"""Motions of a search: how good each is, its peaks, and derivatives of both by places."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.design.optimising.problem import Problem
from linkages.design.optimising.record import Record
from linkages.design.sensitivity.differentiated import Differentiated
from linkages.design.sensitivity.moved import Moved
from linkages.design.sensitivity.reductions import inner, peaks, sampled
from linkages.errors import ComputationError, InputError
from linkages.solution.measuring.summits import Summits, summits
from linkages.spec.measures import read_measure

Floats = NDArray[np.float64]

_KEPT = 8
"""Motions that are remembered: searches ask for values, then for derivatives of the same."""


class Linear(NamedTuple):
    """Values, shape (n,), and their derivatives by places, shape (n, paths)."""

    values: Floats
    slopes: Floats


@dataclass(frozen=True, eq=False)
class Found:
    """A motion: measures with their derivatives, and itself."""

    measures: Linear
    moved: Moved


class Motions:
    """Motions at places in the box of bounds; each is recorded.

    Parameters
    ----------
    problem, record
        Whose they are.
    more
        Measures beside those that tell how good a point is.
    series
        Texts of what changes with time, of which peaks are asked for.
    """

    def __init__(
        self, problem: Problem, record: Record, more: Sequence[str], series: Sequence[str]
    ) -> None:
        self._problem, self._record = problem, record
        texts = list(dict.fromkeys([*problem.texts, *more]))
        self.row = {text: row for row, text in enumerate(texts)}
        self._whole = {text: read_measure(f"final({text})") for text in series}
        paths, finals = problem.ranges.paths, [each.text for each in self._whole.values()]
        self._own = Differentiated(problem.mechanism, [*texts, *finals], paths, run=problem.given)
        self._kept: dict[bytes, Found | None] = {}

    def at(self, places: Floats) -> Found | None:
        """The motion at some places; None if it cannot be computed."""
        key = places.tobytes()
        if key not in self._kept:
            found = self._computed(places)
            if len(self._kept) == _KEPT:
                del self._kept[next(iter(self._kept))]
            self._kept[key] = found
        return self._kept[key]

    def _computed(self, places: Floats) -> Found | None:
        problem, ranges = self._problem, self._problem.ranges
        try:
            moved = self._own.moved(ranges.numbers(places), self._own.series)
            found = self._own.reduced(moved)
        except (ComputationError, InputError) as error:
            self._record.add(problem.refused(places, error))
            return None
        assert found.derivatives is not None
        rows = [self.row[text] for text in problem.texts]
        self._record.add(problem.tried(places, found.values[rows]))
        return Found(Linear(found.values, found.derivatives * ranges.width), moved)

    def peaks(self, found: Found, series: str, sign: float) -> Summits:
        """Local maxima of a series, or of its negative."""
        node, moved = inner(self._whole[series]), found.moved
        return summits(
            sign * sampled(node, moved),
            lambda places: sign * sampled(node, moved, places),
        )

    def held(self, found: Found, series: str, sign: float, places: Floats) -> Linear:
        """Some of these peaks, at places in samples from the first one."""
        value, slopes = peaks(inner(self._whole[series]), found.moved, places, sign)
        assert slopes is not None
        own = self._problem.ranges.width / self._own.scales
        return Linear(sign * value, sign * slopes.T * own)

    def curves(self, places: Floats) -> tuple[Floats, dict[str, Floats]]:
        """Times, and all series over them, without recording; raises what motions raise."""
        numbers = self._problem.ranges.numbers(places)
        moved = self._own.moved(numbers, self._own.series, derivatives=False)
        found = {text: sampled(inner(measure), moved) for text, measure in self._whole.items()}
        return moved.time, found

    @property
    def units(self) -> dict[str, str]:
        """Unit of every measure and series, in SI."""
        return dict(zip([*self.row, *self._whole], self._own.units, strict=True))
