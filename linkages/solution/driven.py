"""Motions without free coordinates: positions follow from time, nothing is integrated.

Only whether the mechanism can get from one sample to the next has to be found out. A grid that is
at least as fine as one degree of every drive is searched for positions that cannot be assembled,
and for margins that head for zero on one side of an interval and come from zero on the other.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.dyads import LEAST_MARGIN
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.solution.motion import Motion, Settings, block_failure

_GRID_ANGLE = math.radians(1.0)
_CHUNK = 8192
_REFINEMENT, _DEPTH = 65, 8
_MOST_PLACES = 1e12  # a day of computing
_QUADRATURE_ANGLE = math.radians(30.0)
_REFINEMENTS = 7


@dataclass(frozen=True)
class _Stop:
    time: float
    block: int
    singular: bool


def driven_motion(system: System, settings: Settings) -> Motion:
    """Follow a fully driven system along the sample times as far as it can go."""
    times = settings.times
    stop = _Limits(system).first_stop(settings)
    reached = times
    failure = None
    if stop is not None:
        passed = np.abs(times) < abs(stop.time)
        reached = times[passed]
        failure = block_failure(system.model, stop.block, stop.time, stop.singular)
    return Motion(
        time=reached,
        state=np.zeros((0, len(reached))),
        turns=np.zeros((0, len(reached))),
        acceleration=np.zeros((0, len(reached))),
        work=_work(system, reached) if settings.work else None,
        failure=failure,
        stop_time=float(times[-1]) if stop is None else stop.time,
        cost={},
    )


def _fastest(system: System) -> float:
    return max((abs(d.speed.value) for d in system.mechanism.prescribed.values()), default=0.0)


def _chunks(system: System, times: NDArray[np.float64]) -> Iterator[NDArray[np.float64]]:
    """Times to look at, from 0 to the last sample, in the order of the motion; ends are shared.

    A chunk at a time, so that a long motion needs no more memory than a short one.
    """
    end = float(times[-1]) if len(times) else 0.0
    turned = abs(end) * _fastest(system) / _GRID_ANGLE
    if turned > _MOST_PLACES:
        raise ValueError(f"drives would turn by {turned:.3g} degrees; expected a shorter time")
    intervals = max(1, math.ceil(turned))
    ordered = np.sort(times)
    if intervals < len(times):
        yield from (times[i : i + _CHUNK + 1] for i in range(0, max(1, len(times) - 1), _CHUNK))
        return
    for first in range(0, intervals, _CHUNK):
        last = min(first + _CHUNK, intervals)
        places = end * (np.arange(first, last + 1) / intervals)
        low, high = sorted((places[0], places[-1]))
        inside = slice(np.searchsorted(ordered, low), np.searchsorted(ordered, high, "right"))
        chunk = np.union1d(places, ordered[inside])
        yield chunk if end >= 0 else chunk[::-1]


class _Limits:
    """Finds the first time at which a system cannot go on."""

    def __init__(self, system: System) -> None:
        self._system = system
        model = system.model
        self._reach_blocks = [reach.block for reach in model.reaches]
        self._margin_blocks = list(model.positions.dyads)
        self._scales = system.evaluate(model.margin_scales)[:, :1]
        reaches = [reach.radicand for reach in model.reaches]
        self._nodes = [*reaches, *model.margins, *model.margin_rates]

    def _values(self, times: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        """Radicands, relative margins and their rates, shape (…, times)."""
        values = self._system.evaluate(self._nodes, times)
        reaches, blocks = len(self._reach_blocks), len(self._margin_blocks)
        margins = values[reaches : reaches + blocks] / self._scales
        rates = values[reaches + blocks :] / self._scales
        return values[:reaches], margins, rates

    def first_stop(self, settings: Settings) -> _Stop | None:
        """Search the motion in order, a chunk at a time."""
        if not self._margin_blocks:
            return None
        for chunk in _chunks(self._system, settings.times):
            stop = self._stop_in(chunk, depth=0)
            if stop is not None:
                return stop
            if settings.watch is not None:
                settings.watch(min(1.0, float(abs(chunk[-1] / settings.times[-1]))))
        return None

    def _stop_in(self, times: NDArray[np.float64], depth: int) -> _Stop | None:
        """The first stop at some times or between them."""
        radicands, margins, rates = self._values(times)
        failing = ~(radicands >= 0).all(axis=0)
        reached = int(np.argmax(failing)) if failing.any() else len(times)
        aligned = (np.abs(margins[:, :reached]) < LEAST_MARGIN).any(axis=0)
        passed = int(np.argmax(aligned)) if aligned.any() else reached
        for index in np.flatnonzero(self._suspicious(times, margins, rates)):
            if index + 1 >= passed:
                break
            stop = self._inspect(times[index], times[index + 1], depth)
            if stop is not None:
                return stop
        if passed < reached:
            block = int(np.argmin(np.abs(margins[:, passed])))
            return _Stop(float(times[passed]), self._margin_blocks[block], singular=True)
        return self._unreachable(times, reached) if reached < len(times) else None

    @staticmethod
    def _suspicious(
        times: NDArray[np.float64], margins: NDArray[np.float64], rates: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        """Per interval: whether a margin heads for zero within it, seen from both of its ends."""
        span = np.diff(times)
        sign = np.sign(margins[:, :-1])
        ahead = sign * (margins[:, :-1] + 1.1 * rates[:, :-1] * span)
        behind = sign * (margins[:, 1:] - 1.1 * rates[:, 1:] * span)
        return np.any((ahead < 0) & (behind < 0), axis=0)

    def _inspect(self, start: float, end: float, depth: int) -> _Stop | None:
        """Look closer, until the interval cannot be divided or no margin heads for zero."""
        if depth > _DEPTH or abs(end - start) <= 1e-14 * max(abs(start), abs(end)):
            _, margins, _ = self._values(np.array([start, end]))
            block = int(np.argmin(np.abs(margins).min(axis=1)))
            return _Stop(start, self._margin_blocks[block], singular=True)
        return self._stop_in(np.linspace(start, end, _REFINEMENT), depth + 1)

    def _unreachable(self, times: NDArray[np.float64], index: int) -> _Stop:
        """Bisect for the time at which the first radicand turns negative."""
        good, bad = (times[index - 1], times[index]) if index else (times[0], times[0])
        for _ in range(200):
            middle = 0.5 * (good + bad)
            if middle in (good, bad):
                break
            radicands, _, _ = self._values(np.array([middle]))
            if (radicands >= 0).all():
                good = middle
            else:
                bad = middle
        radicands, _, _ = self._values(np.array([bad]))
        first = int(np.argmax(~(radicands[:, 0] >= 0)))
        return _Stop(float(bad), self._reach_blocks[first], singular=False)


def _work(system: System, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Work of drives and loads since t = 0: Gauss–Legendre quadrature, refined until it settles."""
    from linkages.kernel.outputs import VARIABLES

    nodes = VARIABLES["drive_power"].nodes(system.model) + VARIABLES["load_power"].nodes(
        system.model
    )
    points, weights = np.polynomial.legendre.leggauss(8)
    edges = np.concatenate([[0.0], times])
    longest = float(np.abs(np.diff(edges)).max(initial=0.0))
    parts = max(1, math.ceil(longest * _fastest(system) / _QUADRATURE_ANGLE))
    result = np.zeros(len(edges) - 1)
    for refinement in range(_REFINEMENTS):
        pieces = _integrals(system, nodes, edges, parts * 2**refinement, points, weights)
        previous, result = result, np.cumsum(pieces)
        scale = np.abs(pieces).sum()
        if refinement and np.abs(result - previous).max(initial=0.0) <= 1e-13 * scale:
            break
    return result


def _integrals(
    system: System,
    nodes: list[Scalar],
    edges: NDArray[np.float64],
    parts: int,
    points: NDArray[np.float64],
    weights: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Integral of the sum of nodes over every interval, each cut into equal parts."""
    lengths = np.diff(edges) / parts
    result = np.zeros(len(lengths))
    for start in range(0, len(lengths) * parts, _CHUNK):
        interval, part = np.divmod(
            np.arange(start, min(start + _CHUNK, result.size * parts)), parts
        )
        half = 0.5 * lengths[interval]
        places = (edges[interval] + (2 * part + 1) * half)[:, None] + half[:, None] * points
        power = system.evaluate(nodes, places.ravel()).sum(axis=0).reshape(places.shape)
        np.add.at(result, interval, power @ weights * half)
    return result
