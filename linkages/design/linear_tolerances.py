"""Linear tolerance analysis: contributions, worst case, root sum of squares."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.contributors import Contributors
from linkages.design.differentiated import Differentiated, Evaluated
from linkages.errors import ComputationError
from linkages.kernel.system import System
from linkages.options.run import SimulationOptions
from linkages.solution.interpolated import (
    InterpolatedMotions,
    evaluable,
    places_of,
    resolved_motion,
)
from linkages.solution.march import compute_motion
from linkages.solution.measure_names import Source, measured_series, resolved
from linkages.solution.measured import reduced, single
from linkages.solution.motion import Settings
from linkages.solution.run_options import options_of
from linkages.solution.series import TIME
from linkages.spec.measures import Measure

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

DIRECTIONS = 32
"""Directions of errors that are tried for the worst case, where several series err."""

CANDIDATES = 512
"""Corners that are compared: those where errors may add up to most."""


@dataclass(frozen=True)
class Corner:
    """The worst value of a linear measure, and the deviations where it occurs."""

    value: float  # of the measure
    offsets: Floats
    shifts: Floats

    @property
    def deviations(self) -> tuple[Floats, Floats]:
        """Of numbers and pins."""
        return self.offsets, self.shifts

    @property
    def moved(self) -> bool:
        """Whether anything deviates there."""
        return bool(np.any(self.offsets) or np.any(self.shifts))


class LinearMeasure(ABC):
    """A measure for small deviations."""

    def __init__(self, contributors: Contributors) -> None:
        self.contributors = contributors

    @abstractmethod
    def predicted(self, offsets: Floats, shifts: Floats) -> Floats:
        """The measure for deviations of shapes (n, numbers) and (n, clearances, 2), shape (n,)."""

    @abstractmethod
    def sensitivities(self) -> Floats:
        """Change of the measure per unit of each contributor, shape (contributors,)."""

    @abstractmethod
    def moments(self, predicted: Floats) -> tuple[float, float]:
        """Expected mean and standard deviation; `predicted` are values for random deviations."""

    @abstractmethod
    def worst(self) -> tuple[Corner, Corner]:
        """Where it is least and largest."""

    @property
    def nominal(self) -> float:
        """The measure without deviations."""
        numbers, pins = len(self.contributors.zones), len(self.contributors.clearances)
        return float(self.predicted(np.zeros((1, numbers)), np.zeros((1, pins, 2)))[0])

    @property
    def contributions(self) -> Floats:
        """Largest change that each contributor makes by itself, shape (contributors,)."""
        return np.abs(self.sensitivities()) * self.contributors.halves

    @property
    def effects(self) -> Floats:
        """Change by one standard deviation of each contributor, shape (contributors,)."""
        return np.abs(self.sensitivities()) * self.contributors.deviations

    @property
    def shares(self) -> Floats:
        """Share of each contributor in the variance, shape (contributors,)."""
        squares = self.effects**2
        whole = squares.sum()
        return squares / whole if whole > 0.0 else np.zeros_like(squares)

    @property
    def deviation(self) -> float:
        """Root of the sum of the squares of the effects."""
        return float(np.sqrt(np.sum(self.effects**2)))


class SmoothMeasure(LinearMeasure):
    """A measure with a gradient: by numbers, and by shifts of pins, shape (clearances, 2)."""

    def __init__(
        self, contributors: Contributors, value: float, slopes: Floats, pushes: Floats
    ) -> None:
        super().__init__(contributors)
        self._value, self._slopes, self._pushes = value, slopes, pushes

    def predicted(self, offsets: Floats, shifts: Floats) -> Floats:
        """The measure for deviations."""
        pushed = np.einsum("nck,ck->n", shifts, self._pushes)
        return np.asarray(self._value + offsets @ self._slopes + pushed)

    def sensitivities(self) -> Floats:
        """The gradient; of pins the length of theirs."""
        return np.concatenate([self._slopes, np.hypot(*self._pushes.T)])

    def moments(self, predicted: Floats) -> tuple[float, float]:  # noqa: ARG002
        """At the middles of the zones, and the root of the sum of squares."""
        return float(self._value + self.contributors.middles @ self._slopes), self.deviation

    def worst(self) -> tuple[Corner, Corner]:
        """Corners along the signs of the gradient."""
        return self._corner(-1.0), self._corner(1.0)

    def _corner(self, sign: float) -> Corner:
        made = self.contributors
        offsets = made.middles + sign * np.sign(self._slopes) * made.halves[: len(self._slopes)]
        shifts = sign * _pointing(self._pushes[None], made.halves[len(self._slopes) :])[0]
        value = float(self.predicted(offsets[None], shifts[None])[0])
        return Corner(value, offsets, shifts)


class ErrorMeasure(LinearMeasure):
    """A measure of errors, which has a corner at no error, but whose series have gradients.

    `slopes`: series → derivatives at the samples, (samples, numbers); `pushes` by displacements of
    pins, (samples, clearances, 2).
    """

    def __init__(
        self,
        contributors: Contributors,
        measure: Measure,
        nominal: Source,
        slopes: Mapping[str, Floats],
        pushes: Mapping[str, Floats],
    ) -> None:
        super().__init__(contributors)
        self._measure, self._motion = measure, nominal
        self._slopes, self._pushes = slopes, pushes

    def predicted(self, offsets: Floats, shifts: Floats) -> Floats:
        """The measure for deviations."""
        parts = []
        for start in range(0, len(offsets), 1024):
            part = slice(start, start + 1024)
            source = _Deviating(
                self._motion, self._slopes, self._pushes, offsets[part], shifts[part],
                [*self.contributors.zones],
            )  # fmt: skip
            parts.append(reduced(self._measure, source, self._motion).values)
        return np.concatenate(parts)

    def sensitivities(self) -> Floats:
        """By one standard deviation of each contributor alone; of pins in the worst direction."""
        made = self.contributors
        numbers, pins = len(made.zones), len(made.clearances)
        none = np.zeros((1, pins, 2))
        result = []
        deviations = made.deviations
        for k, deviation in enumerate(deviations):
            if k < numbers:
                offsets = np.zeros((2, numbers))
                offsets[:, k] = deviation, -deviation
                shifts = np.repeat(none, 2, axis=0)
            else:
                pushed = self._mixed[1][:, k - numbers]
                largest = np.argsort(np.hypot(*pushed.T))[-DIRECTIONS:]
                offsets = np.zeros((len(largest), numbers))
                shifts = np.zeros((len(largest), pins, 2))
                shifts[:, k - numbers] = _pointing(pushed[largest, None], deviations[k, None])[:, 0]
            changes = self.predicted(offsets, shifts) - self.nominal
            result.append(np.abs(changes).max() / deviation)
        return np.array(result)

    def moments(self, predicted: Floats) -> tuple[float, float]:
        """Those of the predictions: a measure of errors is not linear in small deviations."""
        spread = float(predicted.std(ddof=1)) if len(predicted) > 1 else np.nan
        return (float(predicted.mean()) if len(predicted) else np.nan), spread

    def worst(self) -> tuple[Corner, Corner]:
        """The best of the corners that are worst for a series, or a mixture, at a sample."""
        made, numbers = self.contributors, len(self.contributors.zones)
        mixed, pushed = self._mixed
        bound = np.abs(mixed) @ made.halves[:numbers]
        bound += np.hypot(pushed[..., 0], pushed[..., 1]) @ made.halves[numbers:]
        likely = np.argsort(bound)[-CANDIDATES:]
        mixed, pushed = mixed[likely], pushed[likely]
        offsets = made.middles + np.sign(mixed) * made.halves[:numbers]
        shifts = _pointing(pushed, made.halves[numbers:])
        if not made.clearances:
            offsets = np.unique(offsets, axis=0)
            shifts = np.zeros((len(offsets), 0, 2))
        values = self.predicted(offsets, shifts)
        least, most = int(np.nanargmin(values)), int(np.nanargmax(values))
        still = np.zeros(numbers), np.zeros_like(shifts[0])
        best = Corner(self.nominal, *still)
        low = Corner(float(values[least]), offsets[least], shifts[least])
        high = Corner(float(values[most]), offsets[most], shifts[most])
        return (low if low.value < best.value else best), high

    @cached_property
    def _mixed(self) -> tuple[Floats, Floats]:
        """Derivatives of series and mixtures of them, at all samples one after the other."""
        names = [*self._slopes]
        weights = _weights(len(names))
        slopes = np.array([self._slopes[name] for name in names])
        pushes = np.array([self._pushes[name] for name in names])
        count = len(weights) * slopes.shape[1]
        mixed = np.einsum("wj,jsp->wsp", weights, slopes).reshape(count, slopes.shape[2])
        pushed = np.einsum("wj,jsck->wsck", weights, pushes)
        return mixed, pushed.reshape(count, *pushes.shape[2:])


class _Deviating:
    """Motions that deviate a little from a nominal one: a source of measures."""

    def __init__(
        self,
        motion: Source,
        slopes: Mapping[str, Floats],
        pushes: Mapping[str, Floats],
        offsets: Floats,
        shifts: Floats,
        zones: Sequence[str],
    ) -> None:
        self._motion, self._offsets, self._shifts = motion, offsets, shifts
        self._zones = zones
        self._slopes, self._pushes = slopes, pushes
        self.count, self.time, self.intervals = len(offsets), motion.time, None

    def sampled(self, series: str) -> Floats:
        """A series at the samples."""
        moved = self._offsets @ self._slopes[series].T
        moved = moved + np.einsum("nck,sck->ns", self._shifts, self._pushes[series])
        return np.asarray(self._motion.sampled(series) + moved)

    def during(self, series: Sequence[str], which: Whole, times: Floats) -> list[Floats]:
        """Series at times in some of the motions."""
        return self.between(series, which, places_of(self.time, times))

    def number(self, path: str) -> Floats:
        """A number of the definition, which may deviate itself."""
        own = [k for k, zone in enumerate(self._zones) if zone == path]
        return np.asarray(self._motion.number(path) + self._offsets[:, own].sum(axis=1))

    def between(self, series: Sequence[str], which: Whole, places: Floats) -> list[Floats]:
        """Series anywhere in some of the motions."""
        base = self._motion.between(series, np.zeros(len(which), dtype=int), places)
        first = np.clip(np.rint(places).astype(int) - 1, 0, len(self.time) - 3)
        part = places - first
        weights = (part - 1) * (part - 2) / 2, part * (2 - part), part * (part - 1) / 2
        result = []
        for name, values in zip(series, base, strict=True):
            moved = np.zeros(len(which))
            for k, weight in enumerate(weights):
                slopes, pushes = self._slopes[name][first + k], self._pushes[name][first + k]
                moved += weight * np.einsum("np,np->n", self._offsets[which], slopes)
                moved += weight * np.einsum("nck,nck->n", self._shifts[which], pushes)
            result.append(values + moved)
        return result


def _pointing(pushes: Floats, sizes: Floats) -> Floats:
    """Displacements of some sizes along vectors, shape (…, clearances, 2)."""
    length = np.hypot(pushes[..., 0], pushes[..., 1])[..., None]
    ways = np.divide(pushes, length, out=np.zeros_like(pushes), where=length > 0.0)
    ways[..., 0] += (length == 0.0)[..., 0]
    return ways * sizes[:, None]


def _weights(count: int) -> Floats:
    """Directions in which errors of several series add up, shape (directions, series)."""
    if count == 1:
        return np.array([[1.0], [-1.0]])
    if count == 2:
        angles = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
        return np.stack([np.cos(angles), np.sin(angles)], axis=1)
    drawn = np.random.default_rng(0).standard_normal((DIRECTIONS * count, count))
    return np.concatenate([drawn, np.eye(count), -np.eye(count)])


Slopes = Callable[[Mechanism, Sequence[str]], Floats]
"""Mechanism, paths → derivatives at its numbers, shape (…, paths)."""

VANISHING = 1e-6
"""Of its size: a clearance where its effect is differentiated, for without length it is no bar."""


def linearised(
    contributors: Contributors, measures: Mapping[str, Measure], given: Mapping[str, Any]
) -> dict[str, LinearMeasure]:
    """Name → linear measure."""
    system = System(contributors.nominal)
    measures = {name: resolved(system, each) for name, each in measures.items()}
    smooth = {name: each for name, each in measures.items() if not each.compares}
    errors = {name: each for name, each in measures.items() if each.compares}
    motion = _nominal(contributors.nominal, [*measures.values()], given)
    result: dict[str, LinearMeasure] = {}
    if smooth:
        result |= _with_gradients(contributors, smooth, motion, given)
    if errors:
        result |= _of_errors(contributors, errors, motion, given)
    return {name: result[name] for name in measures}


def _with_gradients(
    contributors: Contributors,
    measures: Mapping[str, Measure],
    motion: InterpolatedMotions,
    given: Mapping[str, Any],
) -> dict[str, LinearMeasure]:
    texts = [each.text for each in measures.values()]
    values = [single(each, motion) for each in measures.values()]

    def of(mechanism: Mechanism, paths: Sequence[str]) -> Floats:
        differentiated = Differentiated(mechanism, texts, paths, run=given)
        return _found(differentiated.at(differentiated.values))

    slopes, pushes = _gradients(contributors, of, (len(texts),))
    return {
        name: SmoothMeasure(contributors, values[k], slopes[k], pushes[k])
        for k, name in enumerate(measures)
    }


def _of_errors(
    contributors: Contributors,
    measures: Mapping[str, Measure],
    motion: InterpolatedMotions,
    given: Mapping[str, Any],
) -> dict[str, LinearMeasure]:
    names = list(dict.fromkeys(name for each in measures.values() for name in each.series))

    def along(mechanism: Mechanism, paths: Sequence[str]) -> Floats:
        differentiated = Differentiated(mechanism, (), paths, run=given)
        result = differentiated.along(differentiated.values, names, motion.time)
        return _found(result).transpose(0, 2, 1)

    gradients = _gradients(contributors, along, (len(names), len(motion.time)))
    slopes, pushes = (dict(zip(names, each, strict=True)) for each in gradients)
    return {
        name: ErrorMeasure(
            contributors,
            each,
            motion,
            {series: slopes[series] for series in each.series},
            {series: pushes[series] for series in each.series},
        )
        for name, each in measures.items()
    }


def _found(evaluated: Evaluated) -> Floats:
    assert evaluated.derivatives is not None
    return evaluated.derivatives


def _gradients(
    contributors: Contributors, slopes: Slopes, shape: tuple[int, ...]
) -> tuple[Floats, Floats]:
    """Derivatives by numbers, and by displacements of pins and blocks, (…, clearances, 2)."""
    zones = [*contributors.zones]
    by_numbers = slopes(contributors.nominal, zones) if zones else np.zeros((*shape, 0))
    result = np.zeros((*shape, len(contributors.clearances), 2))
    for axis, angle in enumerate((0.0, np.pi / 2)):
        values: dict[str, object] = {}
        for each in contributors.clearances:
            values |= {each.size_path: VANISHING * each.size, each.angle_path: float(angle)}
        if values:
            turned = contributors.varied.with_values(values)
            sizes = [each.size_path for each in contributors.clearances]
            result[..., axis] = slopes(turned, sizes)
    for k, each in enumerate(contributors.clearances):
        result[..., k, :] = each.felt(result[..., k, :])
    return by_numbers, result


def _nominal(
    mechanism: Mechanism, measures: Sequence[Measure], given: Mapping[str, Any]
) -> InterpolatedMotions:
    system = System(mechanism)
    series = {n: s for each in measures for n, s in measured_series(system, each).items()}
    whole = [n for n, each in series.items() if each.variable != TIME and not evaluable(each)]
    if whole:
        raise ValueError(
            f"{whole[0]} follows from the whole motion, so that it has no derivatives; expected "
            "an output that follows from the motion at one time"
        )
    run = options_of(SimulationOptions, mechanism, given)
    counting = any(each.angle for each in series.values())
    integrated = any(each.integrates for each in measures)
    times = np.linspace(0.0, run.end, run.samples)
    settings = Settings(times=times, run=run, counting=counting)
    motion = compute_motion(system, settings)
    if motion.failure is not None:
        raise ComputationError(f"the nominal motion: {motion.failure}", time=motion.stop_time)
    motion, time, _ = resolved_motion(system, motion, settings, integrated)
    return InterpolatedMotions([system], [motion], series, time)
