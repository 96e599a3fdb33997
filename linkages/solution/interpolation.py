"""Interpolation of a motion between its samples, and branch changes of driven motions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.differentiation import derivative_along
from linkages.kernel.model import Model
from linkages.kernel.scalars import Level, Scalar, reachable
from linkages.solution.evaluation import Numbers, compiled_accelerated
from linkages.solution.motion import Motion, Piece, Tangents

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class InterpolatedPiece:
    """A piece of a motion anywhere between its samples.

    Between two samples the state is a quintic polynomial of the time. Where modes change there,
    rates of some order jump: up to the first change the polynomial of the interval before goes on,
    and from there on that of the interval after it, or as the sample beside it determines where
    that interval cannot be used. Where a body comes to rest in ever smaller bounces between two
    samples, it rests from the first of these on.
    """

    piece: Piece  # sampled; of several motions their samples one behind the other
    smooth: Flags  # whether no mode changes between a sample and the next, shape (samples − 1,)
    first: Floats  # when one does so first, in seconds, shape (samples − 1,)

    @classmethod
    def of(cls, motion: Motion, piece: Piece) -> InterpolatedPiece:
        """Of a piece of a motion; changes not recorded count as half way between samples."""
        order = 1.0 if piece.time[-1] >= piece.time[0] else -1.0
        times = [item.time for item in motion.changes.values() if item.pieces]
        changes = np.sort(order * np.concatenate([*times, [np.inf]]))
        changes[-1] = np.inf
        early, late = order * piece.time[:-1], order * piece.time[1:]
        first = changes[np.searchsorted(changes, early, side="left")]
        known = first <= late
        smooth = ~known & unchanged(piece)
        return cls(piece, smooth, order * np.where(known, first, 0.5 * (early + late)))

    @cached_property
    def _same_branch(self) -> Flags:
        """Whether the assembly branch stays between a sample and the next, shape (samples − 1,)."""
        return unchanged(self.piece, contacts=False)

    @classmethod
    def joined(cls, courses: Sequence[InterpolatedPiece]) -> InterpolatedPiece:
        """Those of several motions of one structure, which are integrated and assembled alike."""
        pieces = [course.piece for course in courses]
        first, gap = pieces[0], np.zeros(1, dtype=bool)  # gaps are between motions
        held = [piece.held for piece in pieces if piece.held is not None]
        piece = Piece(
            system=first.system,
            time=np.concatenate([piece.time for piece in pieces]),
            state=np.concatenate([piece.state for piece in pieces], axis=1),
            turns=np.concatenate([piece.turns for piece in pieces], axis=1),
            acceleration=np.concatenate([piece.acceleration for piece in pieces], axis=1),
            counted={
                name: np.concatenate([piece.counted[name] for piece in pieces])
                for name in first.counted
            },
            held=np.concatenate(held, axis=1) if held else None,
        )
        smooth = [flags for course in courses for flags in (course.smooth, gap)]
        changes = [times for course in courses for times in (course.first, [np.nan])]
        return cls(piece, np.concatenate(smooth)[:-1], np.concatenate(changes)[:-1])

    def between(
        self, interval: Whole, part: Floats, numbers: Numbers | None = None
    ) -> Iterator[tuple[NDArray[np.intp], Piece]]:
        """The motion at times between samples: pieces, and indices of times at which each is.

        Left out are intervals in which the assembly branch changes.
        """
        piece, smooth = self.piece, self.smooth[interval]
        if smooth.any():
            own = None if numbers is None else numbers.part(smooth)
            yield np.flatnonzero(smooth), between(piece, interval[smooth], part[smooth], own)
        broken = np.flatnonzero(~smooth & self._same_branch[interval])
        if not len(broken):
            return
        before, part = interval[broken], part[broken]
        step = piece.time[before + 1] - piece.time[before]
        time = piece.time[before] + part * step
        early = (time - self.first[before]) * step < 0.0
        sample = np.where(early, before, before + 1)
        beside = np.clip(np.where(early, before - 1, before + 1), 0, len(self.smooth) - 1)
        length = piece.time[beside + 1] - piece.time[beside]
        reached = (time - piece.time[beside]) / length
        usable = self.smooth[beside] & (np.abs(reached - 0.5) <= 1.5)
        for which in (usable, ~usable):
            if not which.any():
                continue
            own = None if numbers is None else numbers.part(broken[which])
            if which is usable:
                moved = between(piece, beside[which], reached[which], own)
            else:
                moved = _onward(piece, sample[which], time[which], own)
            yield broken[which], moved


def unchanged(piece: Piece, contacts: bool = True) -> NDArray[np.bool_]:
    """Whether no mode changes between a sample and the next, shape (samples - 1,).

    Without those of `contacts`, whether the assembly branch stays.
    """
    kept = np.ones(max(0, len(piece.time) - 1), dtype=bool)
    held = () if piece.held is None or not contacts else piece.held
    for row in (*piece.flipped.values(), *held):
        kept &= row[:-1] == row[1:]
    return kept


def between(piece: Piece, interval: Whole, part: Floats, numbers: Numbers | None = None) -> Piece:
    """A piece of a motion between its samples: at the `part` of each `interval`, shape (times,)."""
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


def _onward(piece: Piece, sample: Whole, time: Floats, numbers: Numbers | None) -> Piece:
    """A piece of a motion at times beside samples, with the accelerations that it has there."""
    begun = piece.part(sample)
    step = time - begun.time
    position, speed = np.split(begun.state, 2)
    gained = step * begun.acceleration
    tangents = begun.tangents
    if tangents is not None:
        free, rise = len(piece.system.topology.free), step * tangents.rate
        places, rates, internal = np.split(tangents.state, [free, 2 * free])
        moved = places + step * (rates + 0.5 * rise[:free]), rates + rise[:free]
        tangents = replace(tangents, state=np.concatenate([*moved, internal + rise[free:]]))
    moved_on = replace(
        begun,
        time=time,
        state=np.concatenate([position + step * (speed + 0.5 * gained), speed + gained]),
        work=None,
        losses=None,
        tangents=tangents,
    )
    return compiled_accelerated(moved_on, numbers)


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


_CLOSER = 64
"""Parts into which an interval is cut where two changes may hide in it."""


def conditions_of(nodes: Sequence[Scalar], *levels: Level) -> list[Scalar]:
    """What decides between branches below nodes and depends on no more than some level."""
    result = {
        node.operands[0]
        for node in reachable(nodes)
        if node.operation == "select" and node.operands[0].level in levels
    }
    return sorted(result, key=lambda node: node.index)


def conditions_with_rates(model: Model, nodes: Sequence[Scalar]) -> list[Scalar]:
    """All conditions below nodes, then their rates where drives determine the motion."""
    conditions = conditions_of(nodes, Level.TIME, Level.STATE)
    rates = derivative_along(conditions, [{model.inputs.time.index: model.graph.one}])
    return [*conditions, *(rate for (rate,) in rates)]


def branch_changes(times: Floats, look: Callable[[Floats], Floats]) -> Floats:
    """Times just before and just after each change of a branch, shape (changes, 2).

    `look` gives conditions and then their rates, shape (2 conditions, times).
    """
    values, rates = np.split(look(times), 2)
    more = times_near_dips(times, values, rates)
    if len(more):
        order = 1 if times[-1] >= times[0] else -1
        times = np.union1d(times, more)[::order]
        values = np.split(look(times), 2)[0]
    crossed = ((values[:, :-1] < 0.0) != (values[:, 1:] < 0.0)).any(axis=0)
    return np.stack([times[:-1][crossed], times[1:][crossed]], axis=1)


def times_near_dips(times: Floats, values: Floats, rates: Floats) -> Floats:
    """Further times to look at, where a function may dip below zero between two of them.

    There both tangents meet below zero; a curve that bends one way lies above them. `values` and
    `rates` have shape (functions, times).
    """
    sides = np.where(values < 0.0, -1.0, 1.0)
    size, rate, steps = sides * values, sides * rates, np.diff(times)
    with np.errstate(divide="ignore", invalid="ignore"):
        falls, rises = -rate[:, :-1], rate[:, 1:]
        meet = (size[:, 1:] - size[:, :-1] - rises * steps) / (-falls - rises)
        lowest = size[:, :-1] - falls * meet
    hidden = (sides[:, :-1] == sides[:, 1:]) & (falls > 0.0) & (rises > 0.0) & (lowest < 0.0)
    within = np.flatnonzero(hidden.any(axis=0))
    parts = np.arange(1, _CLOSER) / _CLOSER
    return np.asarray(times[within, None] + steps[within, None] * parts).ravel()
