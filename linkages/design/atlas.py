"""Starts of searches from an atlas: driven motions of many mechanisms, side by side.

What bounds, branches and senses allow is looked at evenly. Where the goal is a sum of squares, the
best places are then improved together, by the method of Levenberg and Marquardt (J. J. Moré,
Lecture Notes in Mathematics 630 (1978) 105–116) in the box of bounds. A point of a target has no
time: at every place it is compared with the nearest point of the path, so that derivatives across
the path count alone (variable projection; G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973)
413–432, in the variant of L. Kaufman).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.scene import Target
from linkages.design.goals import Constraint, Goal, distances_of
from linkages.design.ranges import Ranges
from linkages.errors import InputError
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.options.run import SimulationOptions
from linkages.solution.measure_names import known_series, resolved
from linkages.solution.measured import reduced
from linkages.solution.series import Series
from linkages.spec.measures import Measure
from linkages.sweeps.driven_batch import DrivenMotions, complete_motions, serves, values_at
from linkages.sweeps.points import probabilities

Floats = NDArray[np.float64]
Plane = NDArray[np.complex128]
Whole = NDArray[np.intp]

LOOKS, MEASURED_LOOKS = 1024, 64
"""Places of the atlas for each start: of sums of squares, and of measures of any other kind."""

MOST, TOGETHER, LANES = 65536, 512, 16
"""Most places in all; how many are computed at once; and how many are improved for each start."""

_ROUNDS, _HALVED, _GAINED, _DAMPING, _STUCK, _FLAT = 80, 8, 1e-3, 1e-3, 1e9, 1e-9
"""Steps at most, after how many only the better half goes on, part of a sum of squares that a step
must gain, damping at first and where no step gains, and what is added to it in directions in which
nothing changes, as a part of the largest."""

_COMPARED = 512
"""One in so many of the mechanisms that are read together is compared with what it is by itself."""

_WORTH, _ALIKE = 1.25, 0.01
"""How many times the least sum of squares a place may have to be searched from, and within what
part of it two places lead to the same."""

_STEP, _APART = 1e-6, 1e-4
"""Part of a range of a difference quotient; and within which two places are alike."""

_NEWTON, _BESIDE = 4, 1e-2
"""Steps to the nearest point of a path, and parts of an interval beside it of its derivatives."""


class Nearest(NamedTuple):
    """Where paths are nearest to points: times or places, and directions; 0 where a path ends."""

    at: Floats
    tangent: Plane


def nearest(path: Callable[[Floats], Plane], points: Plane, grid: Floats, curve: Plane) -> Nearest:
    """Where paths are nearest to points, shape (…, points).

    `curve`, shape (…, grid), is the path at an even `grid`; `path` gives it anywhere, and takes
    shapes (3, …, points).
    """
    at = grid[np.argmin(np.abs(curve[..., None] - points), axis=-2)]
    low, high, step = grid[0], grid[-1], grid[1] - grid[0]
    beside = _BESIDE * step
    for turn in range(_NEWTON + 1):
        middle = np.clip(at, *sorted((low + beside, high - beside)))
        before, here, behind = path(middle + beside * np.array([-1.0, 0.0, 1.0])[:, None, None])
        rate, bend = (behind - before) / (2 * beside), (behind - 2 * here + before) / beside**2
        if turn == _NEWTON:
            break
        off = here - points
        slope = (off * rate.conj()).real
        rise = np.abs(rate) ** 2 + (off * bend.conj()).real
        with np.errstate(divide="ignore", invalid="ignore"):
            move = np.where(rise > 0.0, -slope / rise, -np.sign(slope) * abs(step))
        reach = abs(step)
        at = np.clip(middle + np.clip(np.nan_to_num(move), -reach, reach), *sorted((low, high)))
    speed = np.abs(rate)
    moving = (at != low) & (at != high) & (speed > 0.0)
    return Nearest(at, np.where(moving, rate / np.where(moving, speed, 1.0), 0.0))


def across(tangent: Plane, slopes: Plane) -> Plane:
    """Derivatives of the nearest point less what moves it along the path."""
    return np.asarray(slopes - tangent * (slopes * tangent.conj()).real)


class _Aimed(NamedTuple):
    """Residuals of some motions, shape (motions, m), and what their derivatives are taken at."""

    residuals: Floats
    times: Floats  # shape (motions, k)
    tangent: Plane  # the same; zeros where times are fixed


class Aim(Protocol):
    """What motions are compared with: residuals whose squares are added."""

    @property
    def names(self) -> list[str]:
        """Of series."""
        ...

    def of(self, motions: DrivenMotions) -> _Aimed:
        """Residuals of motions."""
        ...

    def along(self, changes: Floats, tangent: Plane) -> Floats:
        """Derivatives of residuals, (…, m), from those of series at the times, (series, …, k)."""
        ...


@dataclass(frozen=True)
class Timed:
    """Values of series at times; `there`, shape (series, times), is what was measured."""

    names: list[str]
    times: Floats
    there: NDArray[np.bool_]
    values: Floats  # shape (measured,)
    sigma: Floats

    def of(self, motions: DrivenMotions) -> _Aimed:
        """Residuals of motions."""
        count, times = motions.count, np.tile(self.times, (motions.count, 1))
        which = np.repeat(np.arange(count), len(self.times))
        rows = np.array(motions.during(self.names, which, times.ravel())).reshape(-1, *times.shape)
        residuals = (self._measured(rows) - self.values) / self.sigma
        return _Aimed(residuals, times, np.zeros(times.shape, dtype=complex))

    def along(self, changes: Floats, tangent: Plane) -> Floats:  # noqa: ARG002
        """Derivatives of residuals."""
        return np.asarray(self._measured(changes) / self.sigma)

    def _measured(self, rows: Floats) -> Floats:
        return np.asarray(np.moveaxis(rows, 0, -2)[..., self.there])


@dataclass(frozen=True)
class Passed:
    """Points that the path of a joint is to pass, at whatever times."""

    joint: str
    points: Plane
    weight: float

    @property
    def names(self) -> list[str]:
        """Of series."""
        return [f"{self.joint}.{axis} position" for axis in ("x", "y")]

    def of(self, motions: DrivenMotions) -> _Aimed:
        """Residuals of motions."""
        x, y = (motions.sampled(name) for name in self.names)

        def path(times: Floats) -> Plane:
            which = np.broadcast_to(np.arange(motions.count)[:, None], times.shape)
            rows = motions.during(self.names, which.ravel(), times.ravel())
            return np.asarray(rows[0] + 1j * rows[1]).reshape(times.shape)

        at, tangent = nearest(path, self.points, motions.time, x + 1j * y)
        return _Aimed(self.parts(path(at) - self.points), at, tangent)

    def along(self, changes: Floats, tangent: Plane) -> Floats:
        """Derivatives of residuals."""
        return self.parts(across(tangent, changes[0] + 1j * changes[1]))

    def parts(self, offsets: Plane) -> Floats:
        """Residuals of offsets, shape (…, 2 points)."""
        return np.asarray(self.weight * np.concatenate([offsets.real, offsets.imag], axis=-1))


def passed_by(mechanism: Mechanism, goal: Goal) -> list[Passed]:
    """What a goal consists of, if it is the distances of paths from targets; else nothing."""
    targets = {one.name: one for one in mechanism.components if isinstance(one, Target)}
    return [
        Passed(joint, np.array(targets[name].points) @ np.array([1.0, 1j]), float(np.sqrt(factor)))
        for factor, joint, name in distances_of(goal.sum)
        if name in targets
    ]


class Atlas:
    """Motions at many places in the box of bounds.

    `aims` are those of a sum of squares, which is `constrained` or not; else `measured` is what is
    made small, with constraints.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        ranges: Ranges,
        run: SimulationOptions,
        aims: Sequence[Aim] = (),
        measured: tuple[Goal, Sequence[Constraint]] | None = None,
        constrained: bool = False,
    ) -> None:
        self._ranges, self._run, self._aims, self._measured = ranges, run, aims, measured
        self._alone = bool(aims) and not constrained
        self._mechanism = mechanism

    def starts(self, first: Floats, count: int, seed: int) -> list[Floats]:
        """Places from which to search: that of the first numbers, then the best of the atlas."""
        plain = self._ranges.starts(first, count, seed)
        if count < 2 or not self._serves:
            return plain
        looks = min(MOST, (LOOKS if self._aims else MEASURED_LOOKS) * (count - 1))
        places = probabilities(self._ranges.paths, looks, seed, "sobol").T
        costs = np.concatenate([self._costs(each) for each in _parts(places)])
        best = np.argsort(costs, kind="stable")[: (LANES if self._aims else 1) * (count - 1)]
        best = best[np.isfinite(costs[best])]
        found, costs = places[best], costs[best]
        if self._aims:
            found, costs = self._improved(found, costs, count - 1)
        order = np.argsort(costs, kind="stable")
        if self._alone:
            order = _worth(costs, order)
        chosen: list[Floats] = []
        for place in found[order]:
            if all(np.abs(place - one).max() > _APART for one in chosen):
                chosen.append(place)
        if not self._alone or not chosen:
            chosen += plain[1:]
        return [plain[0], *chosen[: count - 1]]

    @cached_property
    def _varying(self) -> Varying:
        return Varying(self._mechanism.keeping(self._ranges.paths))

    @cached_property
    def _system(self) -> System | None:
        """What all are built upon; None if that is not known."""
        try:
            self._varying.at({})
        except InputError:
            return None
        return None if self._varying.base is None else self._varying.base.system

    @cached_property
    def _wanted(self) -> list[Measure]:
        """The goal and excesses of constraints."""
        assert self._system is not None
        goal, constraints = self._measured or (None, ())
        texts = [goal.measure, *(each.excess for each in constraints)] if goal else []
        return [resolved(self._system, each) for each in texts]

    @cached_property
    def _series(self) -> dict[str, Series]:
        assert self._system is not None
        names = [name for each in self._aims for name in each.names]
        names += [name for each in self._wanted for name in each.series]
        return known_series(self._system, dict.fromkeys(names))

    @property
    def _serves(self) -> bool:
        """Whether drives alone determine all motions, and numbers of the file no measure."""
        if self._system is None or any(each.numbers for each in self._wanted):
            return False
        return serves(self._system, self._series)

    def _assembled(self, places: Floats) -> tuple[Whole, Floats, Floats]:
        """Which places can be assembled, their parameters (p, n) and sizes of margins."""
        numbers = [self._ranges.overrides(row) for row in self._ranges.numbers(places)]
        along = self._varying.along(numbers, _COMPARED)
        rows = np.array([k for k, one in enumerate(along.columns) if one is not None], dtype=int)
        columns = np.array([one for one in along.columns if one is not None], dtype=int)
        if along.settled is None or not len(rows):
            return rows[:0], np.zeros((0, 0)), np.zeros((0, 0))
        return rows, along.settled.parameters[:, columns], along.settled.margin_scale[:, columns]

    def _motions(self, places: Floats) -> list[tuple[Whole, DrivenMotions]]:
        """Motions that come to their end, and at which places."""
        rows, parameters, scales = self._assembled(places)
        if self._system is None or not len(rows):
            return []
        batch = complete_motions(self._system, parameters, scales, self._run, self._series)
        return [(rows[which], motions) for which, motions in batch]

    def _costs(self, places: Floats) -> Floats:
        """What shall be small, shape (n,); infinite for what cannot be computed, or may not be."""
        result = np.full(len(places), np.inf)
        if self._aims:
            for which, found in self._aimed(places):
                result[which] = sum((each.residuals**2).sum(axis=1) for each in found)
            return result
        assert self._measured is not None
        goal, constraints = self._measured
        for which, motions in self._motions(places):
            value, *excesses = (reduced(each, motions).values for each in self._wanted)
            for each, excess in zip(constraints, excesses, strict=True):
                over = np.abs(excess) if each.equal else each.sign * excess
                value = np.where(each.equal | (over <= 0.0), value, np.nan)
            result[which] = np.nan_to_num(goal.sign * value, nan=np.inf, posinf=np.inf)
        return result

    def _aimed(self, places: Floats) -> list[tuple[Whole, list[_Aimed]]]:
        return [
            (which, [aim.of(motions) for aim in self._aims])
            for which, motions in self._motions(places)
        ]

    def _slopes(self, places: Floats, found: list[_Aimed]) -> Floats:
        """Derivatives of residuals by places, shape (n, m, paths); nan where there are none."""
        count, paths = places.shape
        steps = np.where(places > 0.5, -_STEP, _STEP)
        moved = places[:, None] + steps[:, :, None] * np.eye(paths)
        both = np.concatenate([places[:, None], moved], axis=1).reshape(-1, paths)
        rows, parameters, _ = self._assembled(both)
        parts = []
        for aim, one in zip(self._aims, found, strict=True):
            times = np.repeat(one.times, paths + 1, axis=0)[rows]
            values = np.full((len(aim.names), len(both), times.shape[1]), np.nan)
            assert self._system is not None
            series = {name: self._series[name] for name in aim.names}
            values[:, rows] = [*values_at(self._system, series, parameters, times).values()]
            apart = values.reshape(len(values), count, paths + 1, -1)
            changes = apart[:, :, 1:] - apart[:, :, :1]
            for row, name in enumerate(aim.names):
                if self._series[name].angle:
                    changes[row] -= 2 * np.pi * np.round(changes[row] / (2 * np.pi))
            changes /= steps[:, :, None]
            parts.append(aim.along(changes, one.tangent[:, None]))
        return np.concatenate(parts, axis=-1).transpose(0, 2, 1)

    def _improved(self, places: Floats, costs: Floats, count: int) -> tuple[Floats, Floats]:
        """Places with smaller sums of squares, and these; `count` of them are wanted.

        Of those that are improved, the worse half is left as it is, again and again.
        """
        places, costs = places.copy(), costs.copy()
        known = self._linear(places, np.full(len(places), np.inf))
        damping, open_ = np.full(len(places), _DAMPING), np.array([*map(bool, known)])
        for turn in range(_ROUNDS):
            if turn and turn % _HALVED == 0:
                some = max(open_.sum() // 2, 2 * count)
                open_[np.argsort(np.where(open_, costs, np.inf), kind="stable")[some:]] = False
            lanes = np.flatnonzero(open_)
            if not len(lanes):
                break
            residuals, slopes = (np.array([known[k][i] for k in lanes]) for i in range(2))
            trial = _stepped(places[lanes], residuals, slopes, damping[lanes])
            for k, place, found in zip(
                lanes, trial, self._linear(trial, costs[lanes]), strict=True
            ):
                damping[k] *= 0.2 if found else 5.0
                open_[k] = damping[k] < _STUCK
                if found:
                    reached = float(found[0] @ found[0])
                    open_[k] = reached < (1.0 - _GAINED) * costs[k]
                    places[k], costs[k], known[k] = place, reached, found
        return places, costs

    def _linear(self, places: Floats, below: Floats) -> list[tuple[Floats, ...]]:
        """Residuals and their derivatives at each place with a smaller sum of squares, else ()."""
        if len(places) > TOGETHER:
            both = zip(_parts(places), _parts(below), strict=True)
            return [each for part in both for each in self._linear(*part)]
        result: list[tuple[Floats, ...]] = [()] * len(places)
        for which, aimed in self._aimed(places):
            residuals = np.concatenate([each.residuals for each in aimed], axis=1)
            lower = (residuals**2).sum(axis=1) < below[which]
            if not lower.any():
                continue
            some = [_Aimed(*(part[lower] for part in each)) for each in aimed]
            slopes = self._slopes(places[which[lower]], some)
            for k, own, rates in zip(which[lower], residuals[lower], slopes, strict=True):
                if np.isfinite(rates).all():
                    result[k] = own, rates
        return result


def _parts(rows: Floats) -> list[Floats]:
    return [rows[k : k + TOGETHER] for k in range(0, len(rows), TOGETHER)]


def _worth(costs: Floats, order: Whole) -> Whole:
    """Which of ordered places are worth a search: each leads to another sum of squares."""
    result: list[int] = []
    for k in order:
        if costs[k] > _WORTH * costs[order[0]]:
            break
        if not result or costs[k] > (1.0 + _ALIKE) * costs[result[-1]]:
            result.append(k)
    return np.array(result, dtype=int)


def _stepped(places: Floats, residuals: Floats, slopes: Floats, damping: Floats) -> Floats:
    """Places after a step in the box; numbers at bounds that would leave it stay there."""
    gradient = np.einsum("nmp,nm->np", slopes, residuals)
    held = ((places <= 0.0) & (gradient > 0.0)) | ((places >= 1.0) & (gradient < 0.0))
    slopes = np.where(held[:, None], 0.0, slopes)
    matrix = slopes.transpose(0, 2, 1) @ slopes
    sizes = np.einsum("npp->np", matrix)
    added = damping[:, None] * (sizes + _FLAT * sizes.max(axis=1, keepdims=True))
    row = np.arange(places.shape[1])
    matrix[:, row, row] += np.where(added > 0.0, added, 1.0)
    step = np.linalg.solve(matrix, -np.where(held, 0.0, gradient)[..., None])[..., 0]
    return np.clip(places + step, 0.0, 1.0)
