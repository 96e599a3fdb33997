"""Integrals over time with their derivatives, where numbers move jumps and the ends of a window."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from linkages.design.moved import JUMP, Moved, Near
from linkages.kernel.dual_numbers import Varied, applied, filled
from linkages.solution.guards import bisected
from linkages.spec.formulas import Call, Node
from linkages.spec.measures import is_series

Floats = NDArray[np.float64]

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_POINTS, _WEIGHTS = 0.5 * (1.0 + _POINTS), 0.5 * _WEIGHTS


def simpson(grid: Floats) -> tuple[Floats, Floats]:
    """Simpson's rule between samples, for a series that is smooth: places and weights."""
    steps = np.diff(grid)
    places = np.empty(2 * len(steps) + 1)
    places[::2], places[1::2] = grid, 0.5 * (grid[1:] + grid[:-1])
    weights = np.zeros(len(places))
    weights[:-1:2] += steps / 6.0
    weights[1::2] += steps * (2.0 / 3.0)
    weights[2::2] += steps / 6.0
    return places, weights


def gauss(grid: Floats, sides: Floats) -> tuple[Floats, Floats]:
    """Gauss's rule between samples, for a series that is smooth between changes.

    Next to a change it may depend on the root of the time from there, as derivatives of Hertz's
    force do: there the integration variable is its square. `sides` are just before and after
    changes.
    """
    before, behind = np.isin(grid, sides[:, 0]), np.isin(grid, sides[:, 1])
    whole = ~before[:-1]
    starts, steps = grid[:-1][whole, None], np.diff(grid)[whole, None]
    early, late = behind[:-1][whole, None], before[1:][whole, None]
    part = np.where(early, _POINTS**2, np.where(late, 1.0 - _POINTS**2, _POINTS))
    rate = np.where(early | late, 2.0 * _POINTS, 1.0)
    return (starts + steps * part).ravel(), (steps * rate * _WEIGHTS).ravel()


_ASIDE = 1e-5
"""How many samples beside a zero of something what is measured is looked at."""


def _conditions(node: Node) -> list[Node]:
    """What decides between branches in something that changes with time."""
    if not isinstance(node, Call) or not is_series(node):
        return []
    own: list[Node] = []
    match node.name, node.arguments:
        case ("abs" | "sign", (inner,)) | ("where", (inner, _, _)):
            own = [inner]
        case "min" | "max", (one, other):
            own = [Call("sub", (one, other))]
    within = [each for argument in node.arguments for each in _conditions(argument)]
    return [each for each in own if is_series(each)] + within


class Course(Protocol):
    """What changes with time in a window of a motion, with its derivatives."""

    moved: Moved
    window: tuple[Varied, Varied] | None  # when it begins and ends; None for the whole motion
    span: tuple[float, float]  # places where it begins and ends

    @property
    def ends(self) -> tuple[Varied, Varied]:
        """When the window begins and ends, in seconds."""
        ...

    @property
    def grid(self) -> Floats:
        """Places between which the window is looked at."""
        ...

    def series(self, node: Node, places: Floats | None, slopes: bool) -> Varied:
        """What changes with time at places, or at all samples."""
        ...

    def near(self, node: Node, place: float) -> Near:
        """A series near a place."""
        ...

    def step(self, place: float) -> float:
        """Seconds from the sample before a place to the one behind it."""
        ...


class Integrals:
    """Integrals over a window; `parts` is how many times as close a rule looks at it."""

    def __init__(self, course: Course, parts: int) -> None:
        self.course, self.moved, self._parts = course, course.moved, parts
        self.last = len(self.moved.time) - 1

    def _values(self, node: Node, places: Floats) -> Floats:
        return self.course.series(node, places, slopes=False).value

    def mean(self, node: Node, power: int) -> Varied:
        """The mean over time of a power, with contributions of jumps that numbers move."""
        moved = self.moved
        whole = float(len(moved.time) - 1)
        if not whole:
            result = self._power(node, power, np.zeros(1))
            return Varied(np.ravel(result.value)[0], filled(result, moved.count)[:, 0])
        if self.course.window is not None:
            begin, end = self.course.window
            return applied("div", [self._part(node, power), applied("sub", [end, begin])])
        value, slopes, jumps = self._summed(node, power)
        if slopes is None:
            return Varied(value / whole, None)
        jumps = jumps / (moved.time[-1] - moved.time[0])
        return Varied(value / whole, slopes / whole + jumps)

    def whole(self, node: Node) -> Varied:
        """The integral over the window."""
        if not self.last:
            return Varied(np.array(0.0), None)
        return self._part(node, 1)

    def _part(self, node: Node, power: int) -> Varied:
        """The integral of a power over the window, whose ends numbers may move."""
        value, slopes, jumps = self._summed(node, power)
        if not self.moved.count:
            return Varied(value * self._second, None)
        moved = jumps if slopes is None else slopes * self._second + jumps
        return Varied(value * self._second, moved + self._pushed_ends(node, power))

    def _pushed_ends(self, node: Node, power: int, both: bool = True) -> Floats:
        """What moving ends (or the begin) of the window add to an integral, shape (P,)."""
        result = np.zeros(self.moved.count)
        for sign, place, time in zip(
            (-1.0, 1.0)[: 1 + both], self.course.span, self.course.ends, strict=False
        ):
            if time.slopes is not None:
                value = self.course.series(node, np.array([place]), slopes=False).value
                result += sign * float(np.ravel(value)[0]) ** power * time.slopes
        return result

    @property
    def _second(self) -> float:
        """Seconds from one sample to the next."""
        return float(self.moved.time[-1] - self.moved.time[0]) / self.last

    def _summed(self, node: Node, power: int) -> tuple[Any, Floats | None, Floats]:
        """An integral in samples, that of derivatives, and what jumps add to that in seconds."""
        moved = self.moved
        kinks, added = self._kinks(node, power)
        smooth = not (moved.breaks or len(kinks)) and moved.integrated
        if smooth and self.course.window is None and self._parts == 1:
            places, weights = simpson(moved.grid)
        else:
            places, weights = gauss(self._refined(kinks), moved.sides)
        result = self._power(node, power, places)
        value = np.broadcast_to(result.value, places.shape) @ weights
        if result.slopes is None:
            return value, None, np.zeros(moved.count)
        size = float(np.abs(result.value).max())
        jumps = np.concatenate([added, self._jumps(node, power, size)])
        slopes = np.broadcast_to(result.slopes, (moved.count, len(places)))
        return value, slopes @ weights, jumps.sum(axis=0)

    def _refined(self, further: Floats) -> Floats:
        """The grid with further places, close enough for the highest order of harmonics."""
        grid, parts = self.course.grid, self._parts
        count = len(grid) - 1
        if parts > 1:
            grid = np.interp(np.arange(count * parts + 1) / parts, np.arange(count + 1), grid)
        return np.union1d(grid, further)

    def cumulative(self, node: Node, places: Floats | None, slopes: bool) -> Varied:
        """The integral from the begin of the window to places, or to all samples."""
        moved, slopes = self.moved, slopes and bool(self.moved.count)
        wanted = np.arange(self.last + 1.0) if places is None else places
        if not self.last:
            return Varied(np.zeros(wanted.shape), None)
        wanted = np.clip(wanted, *self.course.span)
        kinks, pushed = self._kinks(node, 1)
        grid = self._refined(np.concatenate([kinks, wanted]))
        at, weights = gauss(grid, moved.sides)
        after = np.flatnonzero(~np.isin(grid[:-1], moved.sides[:, 0])) + 1
        result = self.course.series(node, at, slopes)
        where = np.searchsorted(grid, wanted)

        def summed(rows: Floats) -> Floats:
            parts = (np.broadcast_to(rows, (*rows.shape[:-1], len(at))) * weights).reshape(
                *rows.shape[:-1], -1, len(_POINTS)
            )
            steps = np.zeros((*rows.shape[:-1], len(grid)))
            steps[..., after] = parts.sum(axis=-1)
            return np.asarray(np.cumsum(steps, axis=-1)[..., where] * self._second)

        value = summed(np.broadcast_to(result.value, at.shape))
        if not slopes:
            return Varied(value, None)
        rates = summed(np.broadcast_to(filled(result, moved.count), (moved.count, len(at))))
        size = float(np.abs(result.value).max())
        breaks = zip(moved.sides[:, 1].tolist(), self._jumps(node, 1, size), strict=True)
        for place, jump in [*zip(kinks.tolist(), pushed, strict=True), *breaks]:
            rates += jump[:, None] * (wanted >= place)
        return Varied(value, rates + self._pushed_ends(node, 1, both=False)[:, None])

    def _kinks(self, node: Node, power: int) -> tuple[Floats, Floats]:
        """Places of corners and jumps, and the contributions (places, P) of jumps that move.

        They are zeros of the conditions of ``abs``, ``sign``, ``where``, ``min`` and ``max``.
        """
        moved, grid = self.moved, self.course.grid
        steady = ~np.isin(grid[:-1], moved.sides[:, 0])
        kinks, added = [np.zeros(0)], [np.zeros((0, moved.count))]
        for decides in dict.fromkeys(_conditions(node)):
            values = np.broadcast_to(self._values(decides, grid), grid.shape)
            crossed = steady & ((values[:-1] < 0.0) != (values[1:] < 0.0))
            low, high, below = grid[:-1][crossed], grid[1:][crossed], values[:-1][crossed] < 0.0
            if not len(low):
                continue

            def early(
                places: Floats, decides: Node = decides, below: NDArray[np.bool_] = below
            ) -> NDArray[np.bool_]:
                return np.asarray((self._values(decides, places) < 0.0) == below)

            _, high = bisected(low, high, early)
            kinks.append(high)
            added.append(self._pushed(node, decides, power, high))
        return np.concatenate(kinks), np.concatenate(added)

    def _pushed(self, node: Node, decides: Node, power: int, places: Floats) -> Floats:
        """What jumps where something else is zero add to an integral, shape (places, P)."""
        whole = np.zeros((len(places), self.moved.count))
        if not self.moved.count:
            return whole
        around = places + _ASIDE * np.array([[-2.0], [-1.0], [1.0], [2.0]])
        around = np.clip(around, 0.0, float(self.last))
        result = self._power(node, power, around.ravel()).value.reshape(around.shape)
        beside = 2.0 * result[1:3] - result[::3]  # both sides at the place itself
        slopes = filled(self.course.series(decides, places, slopes=True), self.moved.count)
        for row, jump, slope, place in zip(
            whole, beside[0] - beside[1], slopes.T, places, strict=True
        ):
            if abs(jump) > JUMP * np.abs(beside).max():
                pace = self.course.near(decides, place).rate(place, 1)[0] / self.course.step(place)
                row -= jump * slope / pace
        return whole

    def _power(self, node: Node, power: int, places: Floats) -> Varied:
        result = self.course.series(node, places, slopes=True)
        return applied("mul", [result, result]) if power == 2 else result

    def _jumps(self, node: Node, power: int, size: float) -> Floats:
        """What moving jumps add to an integral, (x⁻ − x⁺) ∂t*/∂p each, shape (breaks, P)."""
        sides, (low, high) = self.moved.sides, self.course.span
        whole = np.zeros((len(sides), self.moved.count))
        if not len(sides):
            return whole
        values = np.broadcast_to(self._power(node, power, sides.ravel()).value, sides.size)
        apart = -np.diff(values.reshape(-1, 2))[:, 0]
        inside = (sides[:, 0] > low) & (sides[:, 1] < high)
        for row, each, jump, there in zip(whole, self.moved.breaks, apart, inside, strict=True):
            if there and abs(jump) > JUMP * size:
                row += jump * each.moved
        return whole
