"""Dense samples of a motion: closer ones, and values anywhere between these."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.solution.evaluation import compiled_values
from linkages.solution.interpolated import (
    PER_STEP,
    InterpolatedMotions,
    denser,
    evaluate_outputs,
    looks_of,
    places_of,
    resolves_steps,
    through,
)
from linkages.solution.march import compute_motion
from linkages.solution.motion import Motion, Settings
from linkages.solution.run_options import PER_SWING, swings
from linkages.solution.series import REACTIONS, STATE, requested

Floats = NDArray[np.float64]

MOST = 400_000
"""Samples; a motion that needs more would take too much memory."""

CLOSER = 4
"""How many times as many intervals as measures need a motion that drives determine has at first: a
load may change wherever it likes."""


class DenseMotion:
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
    ) -> DenseMotion:
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
            result[open_] = _through(samples, places[open_], variable.smooth)
        return result

    def _values(self, name: str) -> Floats:
        variable = VARIABLES[name]
        if not variable.whole or name in REACTIONS:
            return _evaluated(self.motion, name)
        if name == STATE:
            from linkages.solution.contact_episodes import states

            return np.asarray(states(self.motion), dtype=float)
        if variable.compared and self._ideal is not None:
            own, ideal = (one.values(variable.compared) for one in (self, self._ideal))
            return own[: len(ideal)] - ideal
        given = self._given[name].astype(float)
        if len(given) == len(self.time):
            return given
        return _through(given, places_of(self._sampled, self.time), variable.smooth)

    @cached_property
    def _followed(self) -> InterpolatedMotions:
        return InterpolatedMotions([self.system], [self.motion], {})

    @cached_property
    def _ideal(self) -> DenseMotion | None:
        """The same mechanism without clearances at the same samples, where it comes as far."""
        try:
            ideal = System(self.system.mechanism.ideal())
        except InputError:
            return None
        if ideal.topology.free and self.system.time:
            return None
        settings = self._settings.plain(self.time)
        motion = compute_motion(ideal, settings)
        if len(motion.time) < len(self.time):
            return None
        return DenseMotion(ideal, settings, motion, self.close, self._sampled, self._given)


def _through(values: Floats, places: Floats, smoothly: bool) -> Floats:
    """The same as `through` for values of shape (samples, …)."""
    rows = [through(column, places, smoothly) for column in values.reshape(len(values), -1).T]
    return np.reshape(np.transpose(rows), (len(places), *values.shape[1:]))


def _evaluated(motion: Motion, name: str) -> Floats:
    with np.errstate(all="ignore"):  # at a singular position values are infinite
        return evaluate_outputs(motion, [name], compiled_values)[name]


def _close(motion: Motion) -> bool:
    """Whether nothing happens between samples that polynomials through them do not follow."""
    count = len(motion.time)
    return count > 1 and not motion.interrupted and resolves_steps(motion, count)


def _resolved(system: System, motion: Motion, settings: Settings) -> Motion:
    """A motion with samples as close as it needs, computed again where these are closer."""
    count = len(motion.time)
    if count < 2 or motion.interrupted:
        return motion
    if motion.method:
        wanted = ceil(PER_STEP * motion.cost.get("steps", 0) / (count - 1))
        factor = min(wanted, MOST // (count - 1))
        if factor <= 1:
            return motion
        return compute_motion(system, settings.plain(denser(motion.time, factor)))
    known = [name for name in requested(system, None) if not VARIABLES[name].whole]
    names = [name for name in known if not VARIABLES[name].noise]
    times = looks_of(system, motion)
    factor = min(CLOSER, MOST // (len(times) - 1))
    result, before = motion, np.array([])
    while factor * (len(times) - 1) <= MOST:
        result = compute_motion(system, settings.plain(denser(times, factor)))
        now = swings(_evaluated(result, name) for name in names)
        if before.size:  # round-off oscillates from sample to sample, however close they are
            now[np.isfinite(before) & (now < 2.0 * before)] = np.inf
        before, short = now, ceil(PER_SWING / now.min(initial=np.inf))
        if short <= 1:
            break
        factor *= short
    return result
