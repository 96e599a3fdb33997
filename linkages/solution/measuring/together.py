"""Motions of one structure as one source of measures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.system import System
from linkages.solution.measuring.compiled import Numbers, can_be_compiled, compiled_values
from linkages.solution.measuring.course import Course
from linkages.solution.measuring.followed import (
    Samples,
    between_changes,
    evaluable,
    places_of,
    smooth,
    through,
)
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
    time
        Evenly spaced samples among those of every motion.
    """

    def __init__(
        self,
        systems: Sequence[System],
        motions: Sequence[Motion],
        series: Mapping[str, Series],
        time: Floats,
    ) -> None:
        self.count, self._series, self._model = len(motions), series, systems[0].model
        self.time: Floats = time
        self._motions = motions
        self._own = [Samples(motion.time, time) for motion in motions]
        self._begin = np.cumsum([0, *(len(motion.time) for motion in motions)])
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
        every = [
            begin + np.arange(len(motion.time))[own.even]
            for begin, motion, own in zip(self._begin, self._motions, self._own, strict=False)
        ]
        for first in range(0, self.count, step):
            rows = np.concatenate(every[first : first + step])
            which = first + np.arange(len(rows)) // samples
            found.append(self._evaluated(self._course.piece.part(rows), which, [series])[0])
        return np.asarray(np.concatenate(found), dtype=float).reshape(self.count, samples)

    def between(self, series: Sequence[str], which: Whole, places: Floats) -> list[Floats]:
        """Series at places in some of the motions, shape (places,) each."""
        return self._at(series, which, self._inner(which, places, Samples.inner), places)

    def during(self, series: Sequence[str], which: Whole, times: Floats) -> list[Floats]:
        """Series at times in some of the motions, shape (times,) each."""
        places = places_of(self.time, times)
        return self._at(series, which, self._inner(which, times, Samples.at), places)

    @cached_property
    def intervals(self) -> tuple[Whole, Floats, Floats]:
        """Intervals of a quadrature: numbers of their motions, and where they begin and end."""
        found = [between_changes(motion) for motion in self._motions]
        which = np.repeat(np.arange(self.count), [len(begin) for begin, _ in found])
        begin, end = (np.concatenate(edges) for edges in zip(*found, strict=True))
        return which, begin, end

    def _inner(
        self, which: Whole, wanted: Floats, of: Callable[[Samples, Floats], Floats]
    ) -> Floats:
        """Places among all samples of the motions that they are in."""
        found = np.empty(len(wanted))
        for motion in np.unique(which):
            own = which == motion
            found[own] = of(self._own[motion], wanted[own])
        return found

    def _at(
        self, series: Sequence[str], which: Whole, inner: Floats, places: Floats
    ) -> list[Floats]:
        """Series at places among all samples, and among those evenly spaced."""
        found = np.empty((len(series), len(places)))
        local = np.minimum(inner.astype(int), np.diff(self._begin)[which] - 2)
        interval, part = self._begin[which] + local, inner - local
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
