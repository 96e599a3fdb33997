"""The motion of a solution anywhere between its samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.solution.measuring.compiled import compiled_values
from linkages.solution.measuring.course import Course
from linkages.solution.moving.evaluation import evaluate_variables
from linkages.solution.moving.motion import Motion, Piece, Settings, compute_motion
from linkages.solution.resolved import MOST_SAMPLES
from linkages.solution.values.reactions import reactions
from linkages.solution.values.requests import REACTIONS
from linkages.solution.values.series import TIME, Series

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

PER_STEP = 4
"""Samples per step with which quintic polynomials are as good as the steps."""

MOST_STEPS = 1_000_000
"""A motion that took more is not computed again: that would take seconds."""

_FIVE = range(5)
"""Samples that a polynomial goes through, of series that are not evaluated between samples."""


class Followed:
    """A solution as a source of measures, see `linkages.solution.measuring.reduced.Source`.

    Between samples outputs are evaluated from the interpolated state, see `Course`. What needs more
    than the motion at one time is interpolated itself: by polynomials through five samples, or
    linearly if it may jump.

    Parameters
    ----------
    system, motion
        What is measured, with samples as `resolved_motion` gives them.
    series
        Name → series that measures name.
    data
        Outputs that need more than the motion at one time; samples may be further apart.
    """

    count = 1

    def __init__(
        self,
        system: System,
        motion: Motion,
        series: Mapping[str, Series],
        data: xr.Dataset | None = None,
    ) -> None:
        self._model, self._series, self._data = system.model, series, data
        self._motion = motion
        self.time: Floats = motion.time
        self._sampled: dict[str, Floats] = {}

    def sampled(self, series: str) -> Floats:
        """The series at the samples, shape (1, samples)."""
        if series not in self._sampled:
            found = self._series[series]
            if found.variable == TIME:
                values = self.time
            elif evaluable(found):
                values = found.picked(self._evaluated(self._motion, [found]), self._model)
            else:
                assert self._data is not None
                values = self._between_samples(found.of(self._data).to_numpy(), found)
            self._sampled[series] = np.asarray(values, dtype=float)[None]
        return self._sampled[series]

    def between(self, series: Sequence[str], which: Whole, places: Floats) -> list[Floats]:  # noqa: ARG002
        """The series at places, shape (places,) each."""
        followed = [k for k, name in enumerate(series) if evaluable(self._series[name])]
        found = np.empty((len(series), len(places)))
        left = np.ones(found.shape, dtype=bool)
        chosen = [self._series[series[k]] for k in followed]
        for inside, piece in self.within(places) if followed else []:
            values = self._evaluated(Motion(pieces=(piece,)), chosen)
            for k, each in zip(followed, chosen, strict=True):
                found[k, inside] = each.picked(values, self._model)
                left[k, inside] = False
        for row, name, open_ in zip(found, series, left, strict=True):
            if open_.any():
                row[open_] = self._interpolated(name, places[open_])
        return list(found)

    def _evaluated(self, motion: Motion, series: Sequence[Series]) -> dict[str, Floats]:
        names = list(dict.fromkeys(each.variable for each in series))
        with np.errstate(over="ignore", invalid="ignore"):
            plain = [name for name in names if name not in REACTIONS]
            found = evaluate_variables(motion, plain, compiled_values)
            if len(plain) < len(names):
                found |= reactions(motion)
        return found

    def _interpolated(self, name: str, places: Floats) -> Floats:
        """From values at samples alone."""
        (values,) = self.sampled(name)
        return through(values, places, smooth(self._series[name]))

    def _between_samples(self, values: Floats, series: Series) -> Floats:
        """What the data have, at the samples of the motion that is followed."""
        assert self._data is not None
        given = self._data["time"].to_numpy()
        if len(given) == len(self.time):
            return values
        order = 1 if given[-1] >= given[0] else -1
        places = np.interp(self.time, given[::order], np.arange(len(given))[::order].astype(float))
        return through(values, places, smooth(series))

    @cached_property
    def courses(self) -> list[tuple[int, Course]]:
        """Pieces that can be followed, with the number of their first sample."""
        found, begin = [], 0
        for piece in self._motion.pieces:
            if piece.samples is None and len(piece.time) > 1:
                found.append((begin, Course.of(self._motion, piece)))
            begin += len(piece.wanted)
        return found

    def within(self, places: Floats) -> list[tuple[NDArray[np.intp], Piece]]:
        """Places that lie in a piece, and the motion there."""
        found = []
        for begin, course in self.courses:
            last = min(len(course.piece.time), len(self.time) - begin) - 1
            inside = np.flatnonzero((places >= begin) & (places <= begin + last))
            if last < 1:
                continue
            interval = np.minimum((places[inside] - begin).astype(int), last - 1)
            part = places[inside] - begin - interval
            found += [(inside[which], piece) for which, piece in course.between(interval, part)]
        return found


def enough(motion: Motion, samples: int) -> bool:
    """Whether quintic polynomials through so many samples are as good as the steps of a motion.

    An adaptive method takes several steps per oscillation: nothing happens between such samples.
    """
    return samples - 1 >= PER_STEP * motion.cost.get("steps", 0)


def factor_of(motion: Motion, samples: int) -> int:
    """How many times as close samples must be for quintic polynomials to be as good as the steps.

    Powers of two, so that motions which are alike are sampled alike.
    """
    count = samples - 1
    if count < 1 or motion.interrupted or motion.cost.get("steps", 0) > MOST_STEPS:
        return 1
    factor = 1
    while not enough(motion, factor * count + 1) and 2 * factor * count <= MOST_SAMPLES:
        factor *= 2
    return factor


def denser(times: Floats, factor: int) -> Floats:
    """Times with others evenly between them."""
    count = len(times) - 1
    return np.interp(np.arange(count * factor + 1) / factor, np.arange(count + 1), times)


def resolved_motion(system: System, motion: Motion, settings: Settings) -> Motion:
    """A motion with samples as close as `factor_of` says, computed again if need be."""
    factor = factor_of(motion, len(motion.time))
    if factor == 1:
        return motion
    times = denser(motion.time, factor)
    return compute_motion(
        system, replace(settings, times=times, work=False, losses=False, events=())
    )


def smooth(series: Series) -> bool:
    """Whether polynomials go through its samples."""
    return series.variable in VARIABLES and VARIABLES[series.variable].smooth


def through(values: Floats, places: Floats, smoothly: bool) -> Floats:
    """Values at places, by polynomials through five samples or linearly."""
    if not smoothly or len(values) < len(_FIVE):
        return np.interp(places, np.arange(len(values)), values)
    first = np.clip(np.rint(places).astype(int) - 2, 0, len(values) - len(_FIVE))
    found = np.zeros(len(places))
    for node in range(len(_FIVE)):
        others = [other for other in range(len(_FIVE)) if other != node]
        weight = np.prod([(places - first - other) / (node - other) for other in others], axis=0)
        found += weight * values[first + node]
    return found


def evaluable(series: Series) -> bool:
    """Whether it can be computed from the motion at one time."""
    return series.variable in REACTIONS or (
        series.variable in VARIABLES and not VARIABLES[series.variable].whole
    )
