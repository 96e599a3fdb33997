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
from linkages.solution.measuring.compiled import Numbers, compiled_accelerated, compiled_values
from linkages.solution.moving.evaluation import evaluate_variables
from linkages.solution.moving.motion import Motion, Piece, Settings, Tangents, compute_motion
from linkages.solution.resolved import MOST_SAMPLES
from linkages.solution.values.reactions import joint_reactions
from linkages.solution.values.requests import REACTION
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

    Between samples the state is interpolated from states, rates and accelerations at both of them
    (quintic polynomials), and outputs are evaluated from it. What needs more than the motion at one
    time is interpolated itself: by polynomials through five samples, or linearly if it may jump.

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
            plain = [name for name in names if name != REACTION]
            found = evaluate_variables(motion, plain, compiled_values)
            if REACTION in names:
                found[REACTION] = joint_reactions(motion)
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
    def _starts(self) -> list[tuple[int, Piece]]:
        """Pieces that can be followed, with the number of their first sample."""
        found, begin = [], 0
        for piece in self._motion.pieces:
            if piece.samples is None and len(piece.time) > 1:
                found.append((begin, piece))
            begin += len(piece.wanted)
        return found

    def within(self, places: Floats) -> list[tuple[NDArray[np.intp], Piece]]:
        """Places that lie in a piece, and the motion there."""
        found = []
        for begin, piece in self._starts:
            last = min(len(piece.time), len(self.time) - begin) - 1
            inside = np.flatnonzero((places >= begin) & (places <= begin + last))
            interval = np.minimum((places[inside] - begin).astype(int), last - 1)
            if last < 1:
                continue
            kept = unchanged(piece, interval)
            inside, interval = inside[kept], interval[kept]
            if len(inside):
                part = places[inside] - begin - interval
                found.append((inside, between(piece, interval, part)))
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
    return series.variable == REACTION or (
        series.variable in VARIABLES and not VARIABLES[series.variable].whole
    )


def unchanged(piece: Piece, interval: Whole) -> NDArray[np.bool_]:
    """Where no mode changes between a sample and the next."""
    found = np.ones(len(interval), dtype=bool)
    if piece.held is not None:
        found &= (piece.held[:, interval] == piece.held[:, interval + 1]).all(axis=0)
    for where in piece.flipped.values():
        found &= where[interval] == where[interval + 1]
    return found


def between(piece: Piece, interval: Whole, part: Floats, numbers: Numbers | None = None) -> Piece:
    """A piece of a motion at times between its samples.

    Parameters
    ----------
    piece
        Sampled.
    interval, part
        Sample before each time, and where in the interval the time lies, from 0 to 1, (times,).
    numbers
        Whose motion each time is of, where the piece is of several.
    """
    begun = piece.part(interval)
    step = piece.time[interval + 1] - piece.time[interval]
    half = len(piece.state) // 2
    turned = 2 * np.pi * piece.turns
    ends = [
        (piece.state[:half, at] + turned[:, at] - turned[:, interval],
         piece.state[half:, at] * step, piece.acceleration[:, at] * step**2)
        for at in (interval, interval + 1)
    ]  # fmt: skip
    weights, rates = _quintic(part)
    values = [row for end in ends for row in end]
    position = sum(w * row for w, row in zip(weights, values, strict=True))
    speed = sum(w * row for w, row in zip(rates, values, strict=True)) / step
    own = slice(len(piece.system.topology.free), piece.system.layout.moved)
    if own.start < own.stop:  # the integral of an internal state is not known
        speed[own] = _cubic(part, *[(end[1][own] / step, end[2][own] / step) for end in ends])
    counted = {
        name: angle[interval] + part * (angle[interval + 1] - angle[interval])
        for name, angle in piece.counted.items()
    }
    moved = replace(
        begun,
        time=piece.time[interval] + part * step,
        state=np.stack([position, speed]).reshape(2 * half, -1) if half else begun.state,
        counted=counted,
        work=None,
        losses=None,
        tangents=None if piece.tangents is None else _tangents(piece, interval, part, step),
    )
    return compiled_accelerated(moved, numbers)


def _tangents(piece: Piece, interval: Whole, part: Floats, step: Floats) -> Tangents:
    """Derivatives of an interpolated state: they are interpolated as it is."""
    assert piece.tangents is not None
    before, behind = (piece.tangents.part(at) for at in (interval, interval + 1))
    free = len(piece.system.topology.free)
    rows = [
        row
        for end in (before, behind)
        for row in (end.state[:free], end.state[free : 2 * free] * step, end.rate[:free] * step**2)
    ]
    weights, rates = _quintic(part)
    position = sum(w * row for w, row in zip(weights, rows, strict=True))
    speed = sum(w * row for w, row in zip(rates, rows, strict=True)) / step
    internal = _cubic(
        part,
        (before.state[2 * free :], before.rate[free:] * step),
        (behind.state[2 * free :], behind.rate[free:] * step),
    )
    state = np.concatenate(
        [np.stack([position, speed]).reshape(2 * free, *np.shape(rows[0])[1:]), internal]
    )
    return Tangents(state, before.rate, before.memories)


def _cubic(s: Floats, begin: tuple[Floats, Floats], end: tuple[Floats, Floats]) -> Floats:
    """A cubic polynomial at s with values and slopes at 0 and at 1."""
    rise = s**2 * (3 - 2 * s)
    early, late = s * (1 - s) ** 2, s**2 * (s - 1)
    return (1 - rise) * begin[0] + rise * end[0] + early * begin[1] + late * end[1]


def _quintic(s: Floats) -> tuple[tuple[Floats, ...], tuple[Floats, ...]]:
    """Weights of value, slope and bend at 0, then at 1, of a polynomial at s, and their rates."""
    cube = s**3
    bends = -4 + 7 * s - 3 * s**2
    late = cube * (10 - 15 * s + 6 * s**2), cube * bends, 0.5 * cube * (1 - s) ** 2
    early = 1 - late[0], s - cube * (6 - 8 * s + 3 * s**2), 0.5 * s**2 * (1 - s) ** 3
    rise = 30 * s**2 * (1 - s) ** 2
    late_rate = (
        rise, s**2 * (-12 + 28 * s - 15 * s**2), 0.5 * s**2 * (1 - s) * (3 - 5 * s)
    )  # fmt: skip
    early_rate = (
        -rise, 1 - s**2 * (18 - 32 * s + 15 * s**2), 0.5 * s * (1 - s) ** 2 * (2 - 5 * s)
    )  # fmt: skip
    return (*early, *late), (*early_rate, *late_rate)
