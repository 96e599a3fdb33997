"""Derivatives of a motion between its samples."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebpts1, chebval, chebvander
from numpy.typing import NDArray

from linkages.design.derived import Derivatives
from linkages.design.law_breaks import Break
from linkages.errors import ComputationError
from linkages.kernel.dual_numbers import Varied
from linkages.kernel.inputs import Effects
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.solution.evaluation import compiled_accelerated
from linkages.solution.interpolated import InterpolatedMotions, places_of, through
from linkages.solution.motion import Motion, Piece
from linkages.solution.series import REACTIONS, TIME, Series

Floats = NDArray[np.float64]

JUMP = 1e-9
"""What a series differs by on both sides of a jump, as a part of its size; round-off is less."""


class Moved:
    """Series of a motion with their derivatives.

    `motion` has samples on both sides of all breaks, `time` those that are wanted, evenly spaced.
    `numbers` are those of the definition that measures have.
    Places are indices of `time`: `sides` are just before and after breaks, shape (breaks, 2),
    `grid` all samples of the motion. Samples of an `integrated` motion are as close as its steps.
    """

    def __init__(
        self,
        system: System,
        motion: Motion,
        series: Mapping[str, Series],
        effects: Effects,
        derivatives: Derivatives,
        time: Floats,
        breaks: Sequence[Break] = (),
        numbers: Mapping[str, Varied] | None = None,
    ) -> None:
        self._motion, self._series = motion, series
        self._effects, self._derivatives = effects, derivatives
        self._followed = InterpolatedMotions([system], [motion], series)
        self._sampled: dict[str, Floats] = {}
        self.numbers = numbers or {}
        self.integrated = bool(system.layout.moved)
        self.time, self.count = time, len(effects)
        own = self._followed.time
        self.breaks = [one for one in breaks if own[0] < one.before and one.behind < own[-1]]
        self._outside = [one for one in breaks if one not in self.breaks]
        self._sides = np.array([[one.before, one.behind] for one in self.breaks]).reshape(-1, 2)
        self._times = np.array([one.time for one in self.breaks])
        self._first = np.searchsorted(own, self._sides[:, 0])
        self.sides: Floats = self.places(self._sides)
        self.grid: Floats = self.places(own)
        self._ideal: tuple[Moved, frozenset[str]] | None = None
        self._wanted = np.rint(self._inner(np.arange(len(time), dtype=np.float64))).astype(int)

    def against(self, ideal: Moved, names: Sequence[str]) -> Moved:
        """The same, with some series less those of another motion."""
        for each in ideal.breaks:
            if each.moved.any() and not (self._times == each.time).any():
                message = "the ideal mechanism changes its mode here, and the own one does not"
                raise ComputationError(f"{message}; no derivative is known", time=each.time)
        result = copy.copy(self)
        result._ideal = ideal, frozenset(names)
        return result

    def places(self, times: Floats) -> Floats:
        """Where times are, in samples from the first one."""
        own = self.time
        low, high = sorted((float(own[0]), float(own[-1])))
        outside = times[(times < low) | (times > high)]
        if len(outside):
            span = f"from {own[0]:g} s to {own[-1]:g} s"
            raise ValueError(f"t = {outside[0]:g} s is outside of the motion, {span}")
        return places_of(own, times)

    def stretch(self, place: float) -> tuple[float, float]:
        """The places between which nothing changes, around one of them."""
        time = np.interp(place, np.arange(len(self.time)), self.time)
        passed = int(np.searchsorted(self._times, time, side="right"))
        low = self.sides[passed - 1, 1] if passed else 0.0
        high = self.sides[passed, 0] if passed < len(self.sides) else len(self.time) - 1.0
        return float(low), float(high)

    def _inner(self, places: Floats) -> Floats:
        """Places among the samples of the motion, never between the two sides of a break."""
        if not self.breaks:
            return places
        own = self._followed.time
        times = np.interp(places, np.arange(len(self.time)), self.time)
        result = np.interp(times, own, np.arange(len(own)))
        last = np.searchsorted(self._sides[:, 0], times) - 1
        within = (last >= 0) & (times < self._sides[last, 1])
        first = self._first[last]
        return np.where(within, np.where(times < self._times[last], first, first + 1), result)

    def jumps_at_ends(self, names: Sequence[str]) -> list[tuple[str, float]]:
        """Series that jump at the very start or end of the motion, with the times."""
        series = [self._series[name] for name in names]
        filled = [piece for piece in self._motion.pieces if len(piece.time)]
        result = []
        for each in self._outside if self.count else ():
            if not each.moved.any():
                continue
            starts = each.before <= self._followed.time[0]
            end = filled[0].part(slice(0, 1)) if starts else filled[-1].part(slice(-1, None))
            left, right = (
                self._derivatives.evaluated(
                    compiled_accelerated(replace(end, time=np.array([time]))), series, self._effects
                )[0][:, 0]
                for time in (each.before, each.behind)
            )
            sizes = np.array([np.abs(values).max() for values in self.values(names, None)])
            apart = np.abs(right - left) > JUMP * sizes
            result += [(name, each.time) for name, jumps in zip(names, apart, strict=True) if jumps]
        return result

    def values(self, names: Sequence[str], places: Floats | None) -> list[Floats]:
        """Series at places, in samples from the first one; at all samples if there are none."""
        if places is None:
            result = [self._followed.sampled(name)[0][self._wanted] for name in names]
        else:
            which = np.zeros(len(places), dtype=np.int64)
            result = self._followed.between(names, which, self._inner(places))
        for row, other in self._others(names, lambda ideal, own: ideal.values(own, places)):
            result[row] = result[row] - other
        return result

    def slopes(self, names: Sequence[str], places: Floats) -> list[Floats]:
        """Derivatives of series at places, shape (P, places) each."""
        result = self._own_slopes(names, places)
        for row, other in self._others(names, lambda ideal, own: ideal.slopes(own, places)):
            result[row] = result[row] - other
        return result

    def sampled(self, names: Sequence[str]) -> Floats:
        """Derivatives of series at all samples that are asked for, shape (series, P, samples)."""
        result = self._everywhere(names)[..., self._wanted]
        for row, other in self._others(names, lambda ideal, own: list(ideal.sampled(own))):
            result[row] = result[row] - other
        return result

    def _others(
        self, names: Sequence[str], of: Callable[[Moved, list[str]], list[Floats]]
    ) -> Iterator[tuple[int, Floats]]:
        """Rows of series that are compared, with what they are compared with."""
        if self._ideal is None:
            return
        ideal, compared = self._ideal
        rows = [row for row, name in enumerate(names) if name in compared]
        if rows:
            yield from zip(rows, of(ideal, [names[row] for row in rows]), strict=True)

    def _own_slopes(self, names: Sequence[str], places: Floats) -> list[Floats]:
        result = np.empty((len(names), self.count, len(places)))
        left = np.ones(len(places), dtype=bool)
        series = [self._series[name] for name in names]
        places = self._inner(places)
        for inside, piece in self._followed.within(places):
            _, slopes = self._derivatives.evaluated(piece, series, self._effects)
            result[:, :, inside] = slopes
            left[inside] = False
        if left.any():
            for row, name in enumerate(names):
                smooth = name == TIME or VARIABLES[self._series[name].variable].smooth
                for k, slopes in enumerate(self._everywhere([name])[0]):
                    result[row, k, left] = through(slopes, places[left], smooth)
        return list(result)

    def _everywhere(self, names: Sequence[str]) -> Floats:
        """Derivatives of series at all samples of the motion."""
        new = [name for name in names if name not in self._sampled]
        if new:
            series = [self._series[name] for name in new]
            parts = [self._of_piece(piece, series) for piece in self._motion.pieces]
            result = np.concatenate(parts, axis=2)
            self._sampled.update(zip(new, result, strict=True))
        return np.array([self._sampled[name] for name in names])

    def _of_piece(self, piece: Piece, series: Sequence[Series]) -> Floats:
        """Derivatives at the wanted samples of a piece, as values are computed there."""
        if piece.samples is None:
            return self._derivatives.evaluated(piece, series, self._effects)[1]
        if any(each.variable in REACTIONS for each in series):
            message = "joint reactions have no derivative within a passage through a change point"
            raise ComputationError(message, time=piece.crossing)
        values, slopes = self._derivatives.evaluated(piece, series, self._effects)
        _, direct = self._derivatives.evaluated(piece.direct(), series, self._effects)
        result = piece.interpolated(slopes)
        for row, each in enumerate(series):
            variable = None if each.variable == TIME else VARIABLES[each.variable]
            if variable is not None and variable.unbounded:
                result[row] = direct[row]
            elif variable is not None and variable.reciprocal:  # 1/u is interpolated
                wanted = 1.0 / piece.interpolated(1.0 / values[row])
                result[row] = wanted**2 * piece.interpolated(slopes[row] / values[row] ** 2)
        return result


_DEGREE = 24
NODES = chebpts1(_DEGREE + 1)
_FIT: Floats = np.asarray(np.linalg.inv(chebvander(NODES, _DEGREE)), dtype=float)
_EXACT = 1e-13
"""Relative size of the last coefficients of a polynomial that says all of a function."""


class Near(NamedTuple):
    """Polynomials about a place, in samples: Chebyshev coefficients, shape (degree + 1, rows)."""

    middle: float
    half: float
    coefficients: Floats

    @classmethod
    def through(cls, middle: float, half: float, rows: Floats) -> Near:
        """Those with values at `middle + half * NODES`, shape (rows, nodes)."""
        return cls(middle, half, _FIT @ np.broadcast_to(rows, (len(rows), len(NODES))).T)

    @property
    def exact(self) -> bool:
        """Whether they say all of what they are of."""
        size = np.abs(self.coefficients)
        return bool((size[-3:] <= _EXACT * size.max(axis=0)).all())

    def rate(self, place: float, order: int) -> Floats:
        """Derivatives at a place, by places, shape (rows,)."""
        result = chebval((place - self.middle) / self.half, chebder(self.coefficients, order))
        return np.asarray(result / self.half**order)
