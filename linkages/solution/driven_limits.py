"""How far a driven motion can go: reach, singular positions and change points."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.dyads import LEAST_MARGIN
from linkages.kernel.system import System
from linkages.solution.motion import Settings

GRID_ANGLE = math.radians(1.0)
_CHUNK = 8192
_REFINEMENT, _DEPTH = 65, 8
_NEAR = 0.06
"""Relative margins between which outputs are interpolated across a change point."""
_CONTINUES = 0.5
"""How much the rate of a margin may change across a change point, relative to itself."""

BOTH_SIDES = np.array([-1.0, -0.8, -0.6, -0.4, -0.25, 0.25, 0.4, 0.6, 0.8, 1.0])
"""Where positions beside a change point are evaluated, as parts of its neighbourhood."""

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Stop:
    """Where a motion cannot go on, or may go on in two ways."""

    time: float
    block: int
    singular: bool


@dataclass(frozen=True)
class DrivenPassage:
    """A change point, the time that outputs are interpolated over on each side, and its blocks."""

    crossing: float
    beside: float
    blocks: tuple[int, ...]


def looks(span: float, fastest: float, angle: float, most: float) -> int:
    """Number of places to look at within a time, so that no drive turns further than an angle."""
    turned = abs(span) * fastest / angle
    if not turned <= most:
        raise ValueError(
            f"drives turn by {math.degrees(turned * angle):.3g} degrees, and {turned:.3g} places "
            f"are looked at on the way; expected a slower drive, a shorter time, or max_steps "
            f"beyond {most:g}"
        )
    return max(1, math.ceil(turned))


def chunks(
    times: Floats,
    fastest: float,
    begun: float,
    angle: float = GRID_ANGLE,
    most: float = math.inf,
) -> Iterator[Floats]:
    """Times from `begun` to the last sample between which no drive turns further than `angle`.

    They come in chunks that share their ends, so that a long motion needs no more memory than a
    short one. More than `most` times are refused.
    """
    end = float(times[-1]) if len(times) else 0.0
    intervals = looks(end - begun, fastest, angle, most)
    ordered = np.sort(times)
    if intervals < len(times) and not begun:
        yield from (times[i : i + _CHUNK + 1] for i in range(0, max(1, len(times) - 1), _CHUNK))
        return
    for first in range(0, intervals, _CHUNK):
        last = min(first + _CHUNK, intervals)
        places = begun + (end - begun) * (np.arange(first, last + 1) / intervals)
        low, high = sorted((places[0], places[-1]))
        inside = slice(np.searchsorted(ordered, low), np.searchsorted(ordered, high, "right"))
        chunk = np.union1d(places, ordered[inside])
        yield chunk if end >= 0 else chunk[::-1]


class Limits:
    """Finds the first time at which a system cannot go on."""

    def __init__(self, system: System, flipped: tuple[int, ...], fastest: float) -> None:
        self._system = system
        self._flipped = flipped
        self._fastest = fastest
        model = system.model
        self._reach_blocks = [reach.block for reach in model.reaches]
        self._margin_blocks = list(model.positions.dyads)
        self._scales = system.evaluate(model.margin_scales)[:, :1]
        reaches = [reach.radicand for reach in model.reaches]
        self._nodes = [*reaches, *model.margins, *model.margin_rates]

    def _values(self, times: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        """Radicands, relative margins and their rates, shape (…, times)."""
        flipped = {block: np.ones(len(times), dtype=bool) for block in self._flipped}
        values = self._system.evaluate(self._nodes, times, flipped=flipped)
        reaches, blocks = len(self._reach_blocks), len(self._margin_blocks)
        margins = values[reaches : reaches + blocks] / self._scales
        rates = values[reaches + blocks :] / self._scales
        return values[:reaches], margins, rates

    def first_stop(self, settings: Settings, begun: float) -> Stop | None:
        """Search the motion in order, a chunk at a time."""
        if not self._margin_blocks:
            return None
        for chunk in chunks(settings.times, self._fastest, begun, most=settings.run.most_steps):
            stop = self._stop_in(chunk, depth=0)
            if stop is not None:
                return stop
            if settings.watch is not None:
                settings.watch(min(1.0, float(abs(chunk[-1] / settings.times[-1]))))
        return None

    def _stop_in(self, times: NDArray[np.float64], depth: int) -> Stop | None:
        """The first stop at some times or between them."""
        radicands, margins, rates = self._values(times)
        failing = ~(radicands >= 0).all(axis=0)
        reached = int(np.argmax(failing)) if failing.any() else len(times)
        aligned = (np.abs(margins[:, :reached]) < LEAST_MARGIN).any(axis=0)
        passed = int(np.argmax(aligned)) if aligned.any() else reached
        for index in np.flatnonzero(may_vanish(times, margins, rates)):
            if index + 1 >= passed:
                break
            stop = self._inspect(times[index], times[index + 1], depth)
            if stop is not None:
                return stop
        if passed < reached:
            block = int(np.argmin(np.abs(margins[:, passed])))
            return Stop(float(times[passed]), self._margin_blocks[block], singular=True)
        return self._unreachable(times, reached) if reached < len(times) else None

    def passage(self, stop: Stop) -> DrivenPassage | None:
        """The change point at a stop, if the motion goes on smoothly behind it."""
        direction = math.copysign(1.0, stop.time)
        index = self._margin_blocks.index(stop.block)
        before = stop.time - direction * 1e-3 / max(self._fastest, 1e-300)
        for _ in range(3):  # the time at which the margin would vanish, from closer and closer
            _, margins, rates = self._values(np.array([before]))
            left = -margins[index, 0] / rates[index, 0]
            if not left * direction > 0:
                return None
            crossing = before + left
            beside = _NEAR / abs(rates[index, 0])
            before = crossing - direction * 0.3 * beside
        for near in (beside, 0.5 * beside, 0.25 * beside):
            blocks = self._vanishing(crossing, near, direction)
            if not all(("side", b) in self._system.model.inputs.parameters for b in blocks):
                return None
            if self._smooth(crossing, near, blocks):
                return DrivenPassage(crossing, near, blocks)
        return None

    def _vanishing(self, crossing: float, beside: float, direction: float) -> tuple[int, ...]:
        """Blocks whose margins go through zero within a passage."""
        _, margins, rates = self._values(np.array([crossing - direction * 0.5 * beside]))
        ahead = margins[:, 0] + direction * beside * rates[:, 0]
        changing = margins[:, 0] * ahead < 0
        return tuple(b for b, c in zip(self._margin_blocks, changing, strict=True) if c)

    def _smooth(self, crossing: float, beside: float, blocks: tuple[int, ...]) -> bool:
        """Whether margins go on with the rates that they had, in the other branch."""
        direction = math.copysign(1.0, crossing)
        radicands, margins, rates = self._values(np.array([crossing - direction * beside]))
        other = Limits(self._system, tuple(set(self._flipped) ^ set(blocks)), self._fastest)
        beyond = other._values(np.array([crossing + direction * beside]))
        if not (radicands >= 0).all() or not (beyond[0] >= 0).all():
            return False
        changed = margins[:, 0] * beyond[1][:, 0] < 0
        wanted = np.array([b in blocks for b in self._margin_blocks])
        steady = np.abs(beyond[2] - rates)[:, 0] <= _CONTINUES * np.abs(rates[:, 0])
        if not ((changed == wanted).all() and steady[wanted].all()):
            return False
        return self._vanish(crossing, beside, blocks)

    def _vanish(self, crossing: float, beside: float, blocks: tuple[int, ...]) -> bool:
        """Whether margins are zero at a crossing, seen from both of its sides."""
        from linkages.solution.change_points import vanishes

        times = crossing + beside * BOTH_SIDES * math.copysign(1.0, crossing)
        _, margins, _ = self._values(times)
        rows = [margins[self._margin_blocks.index(block)] for block in blocks]
        return all(vanishes(times, row, crossing) for row in rows)

    def _inspect(self, start: float, end: float, depth: int) -> Stop | None:
        """Look closer, until the interval cannot be divided or no margin heads for zero."""
        if depth > _DEPTH or abs(end - start) <= 1e-14 * max(abs(start), abs(end)):
            _, margins, _ = self._values(np.array([start, end]))
            block = int(np.argmin(np.abs(margins).min(axis=1)))
            return Stop(start, self._margin_blocks[block], singular=True)
        return self._stop_in(np.linspace(start, end, _REFINEMENT), depth + 1)

    def _unreachable(self, times: NDArray[np.float64], index: int) -> Stop:
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
        return Stop(float(bad), self._reach_blocks[first], singular=False)


def may_vanish(times: Floats, margins: Floats, rates: Floats) -> NDArray[np.bool_]:
    """Per interval: whether a margin approaches zero from both ends; margins (blocks, …, times)."""
    span = np.diff(times)
    sign = np.sign(margins[..., :-1])
    with np.errstate(invalid="ignore"):  # at a change point rates are infinite
        ahead = sign * (margins[..., :-1] + 1.1 * rates[..., :-1] * span)
        behind = sign * (margins[..., 1:] - 1.1 * rates[..., 1:] * span)
    return np.any((ahead < 0) & (behind < 0), axis=0)
