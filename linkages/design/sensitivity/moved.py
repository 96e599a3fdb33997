"""A motion anywhere between its samples, and how series of it change with numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.design.sensitivity.breaks import Passed
from linkages.design.sensitivity.derived import Derivatives
from linkages.errors import ComputationError
from linkages.kernel.numbers.effects import Effects
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.solution.measuring.followed import Followed, between, through, unchanged
from linkages.solution.moving.motion import Motion, Piece
from linkages.solution.values.series import TIME, Series

Floats = NDArray[np.float64]

JUMP = 1e-9
"""What a series differs by on both sides of a jump, as a part of its size; round-off is less."""


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
    passed
        Times at which laws change from one branch to another, if they move with the numbers.
    """

    def __init__(
        self,
        system: System,
        motion: Motion,
        series: Mapping[str, Series],
        effects: Effects,
        derivatives: Derivatives,
        passed: Sequence[Passed] = (),
    ) -> None:
        self._motion, self._series = motion, series
        self._effects, self._derivatives = effects, derivatives
        self._followed = Followed(system, motion, series)
        self._sampled: dict[str, Floats] = {}
        self._passed = passed
        self.time = self._followed.time
        self.count = len(effects)

    def places(self, times: Floats) -> Floats:
        """Where times are, in samples from the first one.

        Raises
        ------
        ValueError
            For a time outside of the motion.
        """
        own = self.time
        low, high = sorted((float(own[0]), float(own[-1])))
        outside = times[(times < low) | (times > high)]
        if len(outside):
            span = f"from {own[0]:g} s to {own[-1]:g} s"
            raise ValueError(f"t = {outside[0]:g} s is outside of the motion, {span}")
        order = 1 if own[-1] >= own[0] else -1
        return np.interp(times, own[::order], np.arange(len(own))[::order].astype(float))

    def jumps(self, names: Sequence[str]) -> list[tuple[str, float]]:
        """Series that jump where laws do, with the times; these move with the numbers."""
        if not self._passed:
            return []
        series = [self._series[name] for name in names]
        sizes = np.array([np.abs(values).max() for values in self.values(names, None)])
        found = []
        for each in self._passed:
            left, right = (
                self._derivatives.evaluated(piece, series, self._effects)[0][:, 0]
                for piece in (each.before, each.behind)
            )
            apart = np.abs(right - left) > JUMP * sizes
            found += [(name, each.time) for name, jumps in zip(names, apart, strict=True) if jumps]
        return found

    def require_followed(self, places: Floats) -> None:
        """Raise for places between the two samples around a jump of an integrated motion.

        Nothing follows derivatives through it.
        """
        for each in self._passed:
            interval = np.ceil(self.places(np.array([each.time]))[0]) - 1.0
            inside = (places > interval) & (places < interval + 1.0)
            if each.before.tangents is not None and inside.any():
                message = (
                    f"derivatives jump between two samples at t = {each.time:.6g} s, and are asked "
                    "for between these; expected more samples, or another time"
                )
                raise ComputationError(message, time=None)

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
                for k, slopes in enumerate(self.sampled([name])[0]):
                    found[row, k, left] = through(slopes, places[left], smooth)
        return list(found)

    def sampled(self, names: Sequence[str]) -> Floats:
        """Derivatives of series at all samples, shape (series, P, samples)."""
        new = [name for name in names if name not in self._sampled]
        if new:
            series = [self._series[name] for name in new]
            parts = [self._of_piece(piece, series) for piece in self._motion.pieces]
            found = np.concatenate(parts, axis=2)
            self._sampled.update(zip(new, found, strict=True))
        return np.array([self._sampled[name] for name in names])

    def _of_piece(self, piece: Piece, series: Sequence[Series]) -> Floats:
        """Derivatives at the wanted samples of a piece, as values are computed there."""
        if piece.samples is None:
            return self._derivatives.evaluated(piece, series, self._effects)[1]
        values, slopes = self._derivatives.evaluated(piece, series, self._effects)
        _, direct = self._derivatives.evaluated(piece.direct(), series, self._effects)
        found = piece.interpolated(slopes)
        for row, each in enumerate(series):
            variable = None if each.variable == TIME else VARIABLES[each.variable]
            if variable is not None and variable.unbounded:
                found[row] = direct[row]
            elif variable is not None and variable.reciprocal:  # 1/u is interpolated
                wanted = 1.0 / piece.interpolated(1.0 / values[row])
                found[row] = wanted**2 * piece.interpolated(slopes[row] / values[row] ** 2)
        return found
