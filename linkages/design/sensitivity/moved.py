"""A motion anywhere between its samples, and how series of it change with numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.design.sensitivity.derived import Derivatives
from linkages.design.sensitivity.numbers import Effects
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.solution.measuring.followed import Followed, between, through, unchanged
from linkages.solution.moving.motion import Motion, Piece
from linkages.solution.values.series import TIME, Series

Floats = NDArray[np.float64]


class Moved:
    """Series of a motion with their derivatives.

    Parameters
    ----------
    system, motion
        What moves, and how.
    series
        Name → series.
    effects
        What changes with the numbers.
    derivatives
        How series are differentiated.
    """

    def __init__(
        self,
        system: System,
        motion: Motion,
        series: Mapping[str, Series],
        effects: Effects,
        derivatives: Derivatives,
    ) -> None:
        self._motion, self._series = motion, series
        self._effects, self._derivatives = effects, derivatives
        self._followed = Followed(system, motion, series)
        self._sampled: dict[str, Floats] = {}
        self.time = self._followed.time
        self.count = len(effects.parameters)

    def values(self, names: Sequence[str], places: Floats | None) -> list[Floats]:
        """Series at places, in samples from the first one; at all samples if there are none."""
        if places is None:
            return [self._followed.sampled(name)[0] for name in names]
        return self._followed.between(names, np.zeros(len(places), dtype=np.int64), places)

    def slopes(self, names: Sequence[str], places: Floats) -> list[Floats]:
        """Derivatives of series at places, shape (P, places) each."""
        found = np.empty((len(names), self.count, len(places)))
        left = np.ones(len(places), dtype=bool)
        series = [self._series[name] for name in names]
        begin = 0
        for piece in self._motion.pieces:
            last = len(piece.wanted) - 1
            inside = np.flatnonzero(left & (places >= begin) & (places <= begin + last))
            if piece.samples is None and last > 0 and len(inside):
                interval = np.minimum((places[inside] - begin).astype(int), last - 1)
                part = places[inside] - begin - interval
                kept = unchanged(piece, interval) | (part == 0.0) | (part == 1.0)
                inside, interval, part = inside[kept], interval[kept], part[kept]
                whole = np.where(part == 1.0, interval + 1, interval)
                ends = unchanged(piece, interval)
                for chosen, moved in (
                    (ends, between(piece, interval[ends], part[ends])),
                    (~ends, piece.part(whole[~ends])),
                ):
                    if chosen.any():
                        _, slopes = self._derivatives.evaluated(moved, series, self._effects)
                        found[:, :, inside[chosen]] = slopes
                left[inside] = False
            begin += last + 1
        if left.any():
            for row, name in enumerate(names):
                smooth = name == TIME or VARIABLES[self._series[name].variable].smooth
                for k, slopes in enumerate(self._at_samples(name)):
                    found[row, k, left] = through(slopes, places[left], smooth)
        return list(found)

    def _at_samples(self, name: str) -> Floats:
        """Derivatives of a series at all samples, shape (P, samples)."""
        if name not in self._sampled:
            parts = [self._of_piece(piece, self._series[name]) for piece in self._motion.pieces]
            self._sampled[name] = np.concatenate(parts, axis=1)
        return self._sampled[name]

    def _of_piece(self, piece: Piece, series: Series) -> Floats:
        if piece.samples is None:
            return self._derivatives.evaluated(piece, [series], self._effects)[1][0]
        variable = None if series.variable == TIME else VARIABLES[series.variable]
        if variable is not None and variable.unbounded:
            return self._derivatives.evaluated(piece.direct(), [series], self._effects)[1][0]
        (values,), (slopes,) = self._derivatives.evaluated(piece, [series], self._effects)
        if variable is not None and variable.reciprocal:  # as values are: 1/u is interpolated
            wanted = 1.0 / piece.interpolated(1.0 / values)
            return wanted**2 * piece.interpolated(slopes / values**2)
        return piece.interpolated(slopes)
