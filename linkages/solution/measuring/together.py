"""Motions of one structure as one source of measures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.system import System
from linkages.solution.measuring.compiled import Numbers, can_be_compiled, compiled_values
from linkages.solution.measuring.course import Course
from linkages.solution.measuring.followed import evaluable, smooth, through
from linkages.solution.moving.evaluation import evaluate_variables
from linkages.solution.moving.motion import Motion, Piece
from linkages.solution.values.requests import REACTIONS
from linkages.solution.values.series import TIME, Series

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

_AT_ONCE = 16384
"""States that are evaluated at once, about: few enough for their outputs to fit into memory."""


def goes_together(motion: Motion, series: Mapping[str, Series]) -> bool:
    """Whether a motion can be measured beside others, with the bits that it has alone."""
    own = [each for each in series.values() if each.variable != TIME]
    simple = all(evaluable(each) and each.variable not in REACTIONS for each in own)
    whole = len(motion.pieces) == 1 and len(motion.time) > 1
    return simple and whole and can_be_compiled(motion.pieces[0])


class Together:
    """Motions of one structure with the same sample times, each in one piece.

    What `linkages.solution.measuring.followed.Followed` is for one, in all bits.

    Parameters
    ----------
    systems, motions
        What is measured, with samples as `resolved_motion` gives them.
    series
        Name → series that measures name.
    """

    def __init__(
        self, systems: Sequence[System], motions: Sequence[Motion], series: Mapping[str, Series]
    ) -> None:
        self.count, self._series, self._model = len(motions), series, systems[0].model
        self.time: Floats = motions[0].time
        courses = [Course.of(motion, motion.pieces[0]) for motion in motions]
        self._course = Course.joined(courses, _joined([motion.pieces[0] for motion in motions]))
        self._numbers = Numbers(systems, np.arange(0))
        self._sampled: dict[str, Floats] = {}

    def sampled(self, series: str) -> Floats:
        """A series at the samples, shape (motions, samples)."""
        if series not in self._sampled:
            found = self._series[series]
            if found.variable == TIME:
                values = np.tile(self.time, (self.count, 1))
            else:
                values = self._at_samples(found)
            self._sampled[series] = values
        return self._sampled[series]

    def _at_samples(self, series: Series) -> Floats:
        samples, found = len(self.time), []
        step = max(1, _AT_ONCE // samples)
        for first in range(0, self.count, step):
            which = np.repeat(np.arange(first, min(first + step, self.count)), samples)
            rows = slice(first * samples, first * samples + len(which))
            found.append(self._evaluated(self._course.piece.part(rows), which, [series])[0])
        return np.asarray(np.concatenate(found), dtype=float).reshape(self.count, samples)

    def between(self, series: Sequence[str], which: Whole, places: Floats) -> list[Floats]:
        """Series at places in some of the motions, shape (places,) each."""
        found, last = np.empty((len(series), len(places))), len(self.time) - 2
        local = np.minimum(places.astype(int), last)
        interval, part = which * len(self.time) + local, places - local
        timed = [k for k, name in enumerate(series) if self._series[name].variable == TIME]
        rows = [k for k in range(len(series)) if k not in timed]
        chosen = [self._series[series[k]] for k in rows]
        for begin in range(0, len(places), _AT_ONCE):
            some = slice(begin, begin + _AT_ONCE)
            numbers = self._numbers.of(which[some])
            for inside, piece in self._course.between(interval[some], part[some], numbers):
                values = self._evaluated(piece, which[some][inside], chosen)
                for k, row in zip(rows, values, strict=True):
                    found[k, begin + inside] = row
        for k in timed:
            found[k] = through(self.time, places, smooth(self._series[series[k]]))
        return list(found)

    def _evaluated(self, piece: Piece, which: Whole, series: Sequence[Series]) -> list[Floats]:
        names = list(dict.fromkeys(each.variable for each in series))
        numbers = self._numbers.of(which)

        def values(piece: Piece, names: Sequence[str]) -> Floats:
            return compiled_values(piece, names, numbers)

        with np.errstate(over="ignore", invalid="ignore"):
            found = evaluate_variables(Motion(pieces=(piece,)), names, values)
        return [each.picked(found, self._model) for each in series]


def _joined(pieces: Sequence[Piece]) -> Piece:
    """Samples of several motions, one behind the other."""
    first = pieces[0]
    return Piece(
        system=first.system,
        time=np.concatenate([piece.time for piece in pieces]),
        state=np.concatenate([piece.state for piece in pieces], axis=1),
        turns=np.concatenate([piece.turns for piece in pieces], axis=1),
        acceleration=np.concatenate([piece.acceleration for piece in pieces], axis=1),
        counted={
            name: np.concatenate([piece.counted[name] for piece in pieces])
            for name in first.counted
        },
        held=(
            None
            if first.held is None
            else np.concatenate([piece.held for piece in pieces if piece.held is not None], axis=1)
        ),
    )
