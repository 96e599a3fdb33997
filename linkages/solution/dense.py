"""Dense samples of a motion, and motions of one structure as one source of measures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.solution.compiled_outputs import Numbers, can_be_compiled, compiled_values
from linkages.solution.contact_episodes import states
from linkages.solution.evaluation import evaluate_variables
from linkages.solution.interpolated import (
    PER_STEP,
    Followed,
    Samples,
    between_changes,
    denser,
    enough,
    evaluable,
    places_of,
    smooth,
    through,
)
from linkages.solution.interpolation import Course
from linkages.solution.joint_reactions import reactions
from linkages.solution.march import compute_motion
from linkages.solution.motion import Motion, Piece, Settings
from linkages.solution.run_options import PER_SWING, swings
from linkages.solution.series import REACTIONS, STATE, TIME, Series, requested

Floats = NDArray[np.float64]

MOST = 400_000
"""Samples; a motion that needs more would take too much memory."""

FEWEST = 2000
"""Intervals of a motion that is not integrated: a load may change wherever it likes."""

PER_TURN = 128
"""Samples of a turn of a drive: what a turn repeats oscillates a few times in it."""


class Dense:
    """A motion at closer samples, and anywhere between these."""

    def __init__(
        self,
        system: System,
        settings: Settings,
        motion: Motion,
        close: bool,
        sampled: Floats,
        values: Mapping[str, Floats],
    ) -> None:
        self.system, self.motion, self.close = system, motion, close
        self._settings, self._sampled, self._given = settings, sampled, values
        self._found: dict[str, Floats] = {}
        self.rows: dict[str, list[dict[str, Any]]] = {}
        """Variable → what is known of its extremes."""

    @classmethod
    def of(
        cls,
        system: System,
        settings: Settings,
        motion: Motion,
        sampled: Floats,
        values: Mapping[str, Floats],
    ) -> Dense:
        """A motion that has been computed, computed again at samples that are close enough."""
        result = _resolved(system, motion, settings)
        return cls(system, settings, result, _close(result), sampled, values)

    @property
    def time(self) -> Floats:
        """Shape (samples,)."""
        return self.motion.time

    def values(self, name: str) -> Floats:
        """A variable at the samples, shape (samples, …)."""
        if name not in self._found:
            self._found[name] = self._values(name)
        return self._found[name]

    def between(self, name: str, places: Floats) -> Floats:
        """A variable at places in samples from the first one, shape (places, …)."""
        variable = VARIABLES[name]
        if variable.compared and self._ideal is not None:
            return self.between(variable.compared, places) - self._ideal.between(
                variable.compared, places
            )
        samples = self.values(name)
        result = np.empty((len(places), *samples.shape[1:]))
        open_ = np.ones(len(places), dtype=bool)
        if self.close and (not variable.whole or name in REACTIONS):
            for inside, piece in self._followed.within(places):
                result[inside] = _evaluated(Motion(pieces=(piece,)), name)
                open_[inside] = False
        if open_.any():
            columns = samples.reshape(len(samples), -1).T
            rows = [through(column, places[open_], variable.smooth) for column in columns]
            result[open_] = np.reshape(np.transpose(rows), (-1, *samples.shape[1:]))
        return result

    def _values(self, name: str) -> Floats:
        variable = VARIABLES[name]
        if not variable.whole or name in REACTIONS:
            return _evaluated(self.motion, name)
        if name == STATE:
            return np.asarray(states(self.motion), dtype=float)
        if variable.compared and self._ideal is not None:
            own, ideal = (one.values(variable.compared) for one in (self, self._ideal))
            return own[: len(ideal)] - ideal
        given = self._given[name].astype(float)
        if len(given) == len(self.time):
            return given
        return self._as_sampled(given, variable.smooth)

    def _as_sampled(self, values: Floats, smooth: bool) -> Floats:
        """Values at the samples that were asked for, at those of the motion here."""
        time = self._sampled
        order = 1 if time[-1] >= time[0] else -1
        places = np.interp(self.time, time[::order], np.arange(len(time))[::order].astype(float))
        columns = values.reshape(len(values), -1).T
        rows = [through(column, places, smooth) for column in columns]
        return np.reshape(np.transpose(rows), (len(places), *values.shape[1:]))

    @cached_property
    def _followed(self) -> Followed:
        return Followed(self.system, self.motion, {})

    @cached_property
    def _ideal(self) -> Dense | None:
        """The same mechanism without clearances at the same samples, where it comes as far."""
        try:
            ideal = System(self.system.mechanism.ideal())
        except InputError:
            return None
        if ideal.topology.free and self.system.time:
            return None
        settings = _plain(self._settings, self.time)
        motion = compute_motion(ideal, settings)
        if len(motion.time) < len(self.time):
            return None
        return Dense(ideal, settings, motion, self.close, self._sampled, self._given)


def _evaluated(motion: Motion, name: str) -> Floats:
    with np.errstate(all="ignore"):  # at a singular position values are infinite
        if name in REACTIONS:
            return reactions(motion)[name]
        return evaluate_variables(motion, [name], compiled_values)[name]


def _plain(settings: Settings, times: Floats) -> Settings:
    return replace(settings, times=times, work=False, losses=False, watch=None, events=())


def _close(motion: Motion) -> bool:
    """Whether nothing happens between samples that polynomials through them do not follow."""
    count = len(motion.time)
    return count > 1 and not motion.interrupted and enough(motion, count)


def _resolved(system: System, motion: Motion, settings: Settings) -> Motion:
    """A motion with samples as close as it needs, computed again where these are closer."""
    count = len(motion.time)
    if count < 2 or motion.interrupted:
        return motion
    if motion.method:
        wanted = ceil(PER_STEP * motion.cost.get("steps", 0) / (count - 1))
        factor = min(wanted, MOST // (count - 1))
        return motion if factor <= 1 else _again(system, motion, settings, factor)
    known = [name for name in requested(system, None) if not VARIABLES[name].whole]
    names = [name for name in known if not VARIABLES[name].noise]
    factor = ceil(max(FEWEST, PER_TURN * _turns(system, motion)) / (count - 1))
    result, before = motion, np.array([])
    while factor > 1 and factor * (count - 1) <= MOST:
        result = _again(system, motion, settings, factor)
        now = swings(_evaluated(result, name) for name in names)
        if before.size:  # round-off oscillates from sample to sample, however close they are
            now[np.isfinite(before) & (now < 2.0 * before)] = np.inf
        before, short = now, ceil(PER_SWING / now.min(initial=np.inf))
        if short <= 1:
            break
        factor *= short
    return result


def _again(system: System, motion: Motion, settings: Settings, factor: int) -> Motion:
    return compute_motion(system, _plain(settings, denser(motion.time, factor)))


def _turns(system: System, motion: Motion) -> float:
    """Turns of the drive that turns most, there and back counted."""
    angles = [name for name in system.topology.driven if system.mechanism.bodies[name].rotates]
    nodes = [system.model.positions.angle(name) for name in angles]
    rows = [system.evaluate(nodes, piece.time) for piece in motion.pieces if nodes]
    if not rows:
        return 0.0
    whole = np.concatenate(rows, axis=1)
    return float(np.abs(np.diff(whole)).sum(axis=1).max() / (2 * np.pi))


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

    Each has the same bits as `linkages.solution.interpolated.Followed` alone.
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
            result = self._series[series]
            if result.variable == TIME:
                values = np.tile(self.time, (self.count, 1))
            else:
                values = self._at_samples(result)
            self._sampled[series] = values
        return self._sampled[series]

    def _at_samples(self, series: Series) -> Floats:
        samples, result = len(self.time), []
        step = max(1, _AT_ONCE // samples)
        every = [
            begin + np.arange(len(motion.time))[own.even]
            for begin, motion, own in zip(self._begin, self._motions, self._own, strict=False)
        ]
        for first in range(0, self.count, step):
            rows = np.concatenate(every[first : first + step])
            which = first + np.arange(len(rows)) // samples
            result.append(self._evaluated(self._course.piece.part(rows), which, [series])[0])
        return np.asarray(np.concatenate(result), dtype=float).reshape(self.count, samples)

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
        result = [between_changes(motion) for motion in self._motions]
        which = np.repeat(np.arange(self.count), [len(begin) for begin, _ in result])
        begin, end = (np.concatenate(edges) for edges in zip(*result, strict=True))
        return which, begin, end

    def _inner(
        self, which: Whole, wanted: Floats, of: Callable[[Samples, Floats], Floats]
    ) -> Floats:
        """Places among all samples of the motions that they are in."""
        result = np.empty(len(wanted))
        for motion in np.unique(which):
            own = which == motion
            result[own] = of(self._own[motion], wanted[own])
        return result

    def _at(
        self, series: Sequence[str], which: Whole, inner: Floats, places: Floats
    ) -> list[Floats]:
        """Series at places among all samples, and among those evenly spaced."""
        result = np.empty((len(series), len(places)))
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
                    result[k, begin + inside] = row
        for k in timed:
            result[k] = through(self.time, places, smooth(self._series[series[k]]))
        return list(result)

    def _evaluated(self, piece: Piece, which: Whole, series: Sequence[Series]) -> list[Floats]:
        names = list(dict.fromkeys(each.variable for each in series))
        numbers = self._numbers.of(which)

        def values(piece: Piece, names: Sequence[str]) -> Floats:
            return compiled_values(piece, names, numbers)

        with np.errstate(over="ignore", invalid="ignore"):
            result = evaluate_variables(Motion(pieces=(piece,)), names, values)
        return [each.picked(result, self._model) for each in series]


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
