"""Measures with their derivatives: the chain rule over measure trees.

The largest value of a series changes as the series does where it is largest (the envelope theorem);
the time of it as the slope there does, by implicit differentiation.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import NamedTuple, NoReturn, assert_never

import numpy as np
from numpy.typing import NDArray

from linkages.design.law_breaks import Break
from linkages.design.moved import JUMP, NODES, Moved, Near
from linkages.design.moving_integrals import Integrals
from linkages.errors import ComputationError
from linkages.kernel.dual_numbers import Varied, applied, filled
from linkages.solution.extremes import largest_between
from linkages.solution.guards import bisected
from linkages.spec.formulas import Call, Clock, Constant, Node, Sensed
from linkages.spec.measures import (
    AT,
    LAST_TURN,
    WINDOWS,
    Measure,
    harmonic,
    highest_order,
    is_series,
    reduces,
)

Floats = NDArray[np.float64]

_WIDEST = 16.0
"""Part of a motion, to either side of a place, that a polynomial is asked to follow first."""


_STEPS, _CLOSE, _SAME = 3, 0.1, 1e-13
"""Newton steps to where a slope is zero, how many samples each of them may go, and round-off."""

_ON, _REACHED, _BENT = 1e-6, 1e-11, 1e-6
"""How many samples from a jump a place is on it; by which part less a value is as large; and what
derivatives differ by on both sides, as a part, where they jump."""

_BESIDE, _NARROWEST, _CORNER = 1e-2, 1e-5, 0.1
_ONE_SIDED: Floats = np.array([11.0, -18.0, 9.0, -2.0]) / 6.0
_END: Floats = np.array([3.0, -3.0, 1.0])
"""How many samples beside a place it is looked at, at most and at least; how large the rates on
both sides of a corner are, as a part of the largest; the rate from four values and the value from
three on one side."""


def differentiated(measure: Measure, moved: Moved) -> Varied:
    """A measure of a motion: a number, and its derivatives, shape (P,)."""
    result, missing = as_far_as_finite(measure, moved)
    if missing:
        raise ComputationError(missing, time=None)
    return result


def as_far_as_finite(measure: Measure, moved: Moved) -> tuple[Varied, str]:
    """The same with nan where it is not finite, and a sentence about that, else empty."""
    with np.errstate(all="ignore"):
        result = _Differentiation(measure, moved).number(measure.tree)
    value, slopes = float(result.value), filled(result, moved.count)
    sound, own = np.isfinite(slopes), f"measure {measure.text!r} has no finite"
    if not np.isfinite(value):
        return Varied(np.array(np.nan), np.full_like(slopes, np.nan)), f"{own} value"
    missing = "" if sound.all() else f"{own} derivative"
    return Varied(np.array(value), np.where(sound, slopes, np.nan)), missing


def sampled(node: Node, moved: Moved, places: Floats | None = None) -> Floats:
    """What changes with time, at places or all samples of a motion, without derivatives."""
    with np.errstate(all="ignore"):
        result = _Differentiation(Measure("", node), moved).values(node, places)
    return np.broadcast_to(result, moved.time.shape if places is None else places.shape)


def looked_at(measure: Measure, moved: Moved) -> tuple[Floats, Floats, Callable[[Floats], Floats]]:
    """Places over the window of what a measure reduces, its values there, and at any places."""

    def values(places: Floats | None) -> Floats:
        with np.errstate(all="ignore"):
            shape = grid.shape if places is None else places.shape
            return np.broadcast_to(own.values(node, places), shape)

    with np.errstate(all="ignore"):
        own, node = _entered(measure, moved)
        grid = np.arange(own.last + 1.0) if own.window is None else own.grid
    return grid, values(None if own.window is None else grid), values


def _entered(measure: Measure, moved: Moved) -> tuple[_Differentiation, Node]:
    """The window of a measure that is one reduction, and what it reduces."""
    own, tree = _Differentiation(measure, moved), measure.tree
    while isinstance(tree, Call) and tree.name in WINDOWS:
        *edges, inner = tree.arguments
        own, tree = own.within(tree.name, edges), inner
    assert isinstance(tree, Call)
    return own, tree.arguments[-1]


def followed(node: Node, moved: Moved, places: Floats) -> Varied:
    """What changes with time at places in a motion, shapes (T,) and (P, T)."""
    with np.errstate(all="ignore"):
        result = _Differentiation(Measure("", node), moved).varied(node, places)
    slopes = np.broadcast_to(filled(result, moved.count), (moved.count, len(places)))
    return Varied(np.broadcast_to(result.value, places.shape), slopes)


def peaks(measure: Measure, moved: Moved, places: Floats, sign: float) -> Varied:
    """Local maxima of what a measure reduces, or of its negative: they move with the numbers."""
    with np.errstate(all="ignore"):
        own, node = _entered(measure, moved)
        result = [own.peak(node, place, sign) for place in places.tolist()]
    slopes = np.array([filled(each, moved.count) for each in result]).T
    return Varied(np.array([each.value for each in result]), slopes)


class _Corner(NamedTuple):
    """Where two branches meet: rate and change of the first one, and how the place moves."""

    rate: float
    left: Floats
    moved: Floats


class _Differentiation:
    """A measure of a motion with its derivatives."""

    def __init__(
        self, measure: Measure, moved: Moved, window: tuple[Varied, Varied] | None = None
    ) -> None:
        self.measure, self.moved, self.window = measure, moved, window
        self.last = len(moved.time) - 1
        self.span = (0.0, float(self.last)) if window is None else self._span(*window)
        self.integrals = Integrals(self, highest_order(measure))

    def number(self, node: Node) -> Varied:
        """What does not change with time."""
        match node:
            case Constant(value):
                return Varied(np.array(value), None)
            case Sensed("parameter", (path,)):
                return self.moved.numbers[path]
            case Clock() | Sensed():
                raise AssertionError("a measure is no series")
            case Call(name, (*edges, inner)) if name in WINDOWS:
                return self.within(name, edges).number(inner)
            case Call(name, arguments):
                if reduces(name, len(arguments)):
                    return self._over_time(name, arguments)
                return applied(name, [self.number(argument) for argument in arguments])
            case _:
                assert_never(node)

    def _over_time(self, name: str, arguments: tuple[Node, ...]) -> Varied:
        node = arguments[-1]
        match name:
            case "max" | "min":
                return self.extreme(node, name)
            case "time_of_max" | "time_of_min":
                return self.time_of_extreme(node, name.removeprefix("time_of_"))
            case "range" | "stroke":
                return applied("sub", [self.extreme(node, each) for each in ("max", "min")])
            case "mean" | "rms" | "integral":
                self._require_whole(name, node)
                if name == "integral":
                    return self.integrals.whole(node)
                result = self.integrals.mean(node, 1 if name == "mean" else 2)
                return result if name == "mean" else applied("sqrt", [result])
            case "harmonic" | "phase":
                return self.number(harmonic(name, *arguments))
            case "first" | "final" if self.window is not None:
                return self.at_time(node, self.window[name == "final"])
            case "first" | "final":
                place = float(self.last) if name == "final" else 0.0
                self._require_steady(name, node, place)
                return self.at(node, place)
            case _:
                assert name == AT
                return self.at_time(node, self.number(arguments[0]))

    def series(self, node: Node, places: Floats | None, slopes: bool) -> Varied:
        """What changes with time: at places, or at all samples without derivatives."""
        if not is_series(node):
            result = self.number(node)
            if result.slopes is None or not slopes:
                return Varied(result.value, None)
            return Varied(result.value, result.slopes[:, None])
        match node:
            case Clock():
                return Varied(self.time(places), None)
            case Sensed(name):
                (values,) = self.moved.values([name], places)
                if not slopes or places is None or not self.moved.count:
                    return Varied(values, None)
                return Varied(values, self.moved.slopes([name], places)[0])
            case Call("cumulative", (inner,)):
                return self.integrals.cumulative(inner, places, slopes)
            case Call(name, arguments):
                return applied(name, [self.series(a, places, slopes) for a in arguments])
            case _:
                raise AssertionError("constants are no series")

    @property
    def ends(self) -> tuple[Varied, Varied]:
        """When the window begins and ends, in seconds."""
        if self.window is not None:
            return self.window
        return Varied(self.moved.time[0], None), Varied(self.moved.time[-1], None)

    def _span(self, begin: Varied, end: Varied) -> tuple[float, float]:
        """Places of a window, on the inner side of changes at its ends."""
        times = np.array([float(begin.value), float(end.value)])
        low, high = self.moved.places(times).tolist()
        for before, behind in self.moved.sides.tolist():
            if before <= low < behind:
                low = behind
            if before < high <= behind:
                high = before
        return low, high

    def within(self, name: str, edges: Sequence[Node]) -> _Differentiation:
        """The same in a part of the motion."""
        first, last = self.ends
        if name == LAST_TURN:
            begin, end = self._turn_begun(edges[0]), last
        else:
            begin = self.number(edges[0])
            end = self.number(edges[1]) if len(edges) > 1 else last
        low, high = float(begin.value), float(end.value)
        span = float(first.value), float(last.value)
        window = f"the window from {low:g} s to {high:g} s"
        if not span[0] <= min(low, high) <= max(low, high) <= span[1]:
            where = f"from {span[0]:g} s to {span[1]:g} s"
            self._missing(f"{window} is outside of the motion, {where}")
        if not low < high:
            self._missing(f"{window} is empty")
        return _Differentiation(self.measure, self.moved, (begin, end))

    def _missing(self, what: str) -> NoReturn:
        raise ComputationError(f"measure {self.measure.text!r}: {what}", time=None)

    def _turn_begun(self, node: Node) -> Varied:
        """The time since which an angle has made its last whole turn."""
        grid, (_, last) = self.grid, self.ends
        angles = np.broadcast_to(self.values(node, grid), grid.shape)
        turned = angles[-1] - angles
        whole = np.flatnonzero(np.abs(turned) >= 2.0 * math.pi)
        if not len(whole):
            most = np.abs(turned).max()
            self._missing(f"the angle turns by {most:.4g} rad in all; expected a whole turn of it")
        low = int(whole[-1])
        sense = np.sign(turned[low])
        level = angles[-1] - sense * 2.0 * math.pi

        def early(places: Floats) -> NDArray[np.bool_]:
            return np.asarray(sense * (self.values(node, places) - level) <= 0.0)

        begin, _ = bisected(grid[low : low + 1], grid[low + 1 : low + 2], early)
        place = float(begin[0])
        time = self.time(begin)[0]
        if not self.moved.count:
            return Varied(time, None)
        ends = self._moving_value(node, float(grid[-1]), last)
        rate = self.near(node, place).rate(place, 1)[0] / self.step(place)
        slopes = filled(ends, self.moved.count) - filled(self.at(node, place), self.moved.count)
        return Varied(time, slopes / rate)

    def _moving_value(self, node: Node, place: float, time: Varied) -> Varied:
        """What changes with time at a place whose time is moved by numbers."""
        result = self.at(node, place)
        if time.slopes is None:
            return result
        rate = self.near(node, place).rate(place, 1)[0] / self.step(place)
        return Varied(result.value, filled(result, self.moved.count) + rate * time.slopes)

    @cached_property
    def grid(self) -> Floats:
        """Places between which a window is looked at: samples, and in a part of them more."""
        if self.window is None:
            return self.moved.grid
        low, high = self.span
        inner = self.moved.grid[(self.moved.grid > low) & (self.moved.grid < high)]
        return np.union1d(inner, np.linspace(low, high, self.last + 1))

    def values(self, node: Node, places: Floats | None) -> Floats:
        """What changes with time at places, or at all samples, without derivatives."""
        return self.series(node, places, slopes=False).value

    def varied(self, node: Node, places: Floats) -> Varied:
        """What changes with time at places."""
        return self.series(node, places, slopes=True)

    def time(self, places: Floats | None) -> Floats:
        """Times of places, or of all samples, in seconds."""
        time = self.moved.time
        return time if places is None else np.interp(places, np.arange(len(time)), time)

    def at(self, node: Node, place: float) -> Varied:
        """What changes with time at one place: a number."""
        result = self.varied(node, np.array([place]))
        return Varied(
            np.ravel(result.value)[0], filled(result, self.moved.count).reshape(-1, 1)[:, 0]
        )

    def step(self, place: float) -> float:
        """Seconds from the sample before a place to the one behind it."""
        before = min(int(place), self.last - 1)
        return float(self.moved.time[before + 1] - self.moved.time[before])

    def near(self, node: Node, place: float, half: float | None = None) -> Near:
        """A series near a place, or with half the width of the interval given its derivatives."""
        reach, (first, last) = max(1.0, self.last / _WIDEST), self.moved.stretch(place)
        place = float(np.clip(place, first, last))
        while True:
            low, high = max(first, place - reach), min(last, place + reach)
            wanted = 0.5 * (high - low) if half is None else half
            middle = float(np.clip(place, first + wanted, last - wanted))
            result = self.series(node, middle + wanted * NODES, half is not None)
            rows = result.value[None] if half is None else filled(result, self.moved.count)
            near = Near.through(middle, wanted, rows)
            if half is not None or near.exact or reach == 1.0:
                return near
            reach = max(1.0, reach / 2.0)

    def _require_whole(self, name: str, node: Node) -> None:
        """Raise where a series jumps at an end of the window that numbers part from the jump."""
        if self.window is None:
            self._require_inside(name, node)
            return
        for place, time in zip(self.span, self.window, strict=True):
            self._require_inside(name, node, place)
            moved = np.zeros(self.moved.count) if time.slopes is None else time.slopes
            for each, sides in zip(self.moved.breaks, self.moved.sides, strict=True):
                if np.abs(sides - place).min() <= _ON and not np.allclose(each.moved, moved):
                    values = self.values(node, sides)
                    if abs(np.diff(values)[0]) > JUMP * np.abs(values).max():
                        self._refuse(name, "what is measured", each.time)

    def _require_inside(self, name: str, node: Node, place: float | None = None) -> None:
        """Raise where a series jumps at an end of the motion, or at one of them, for certain."""
        for series, time in self.moved.jumps_at_ends(Measure("", node).series):
            where = float(self.moved.places(np.array([time]))[0])
            if place is None or abs(where - place) <= _ON:
                self._refuse(name, series, time)

    def _require_steady(self, name: str, node: Node, place: float, moves: bool = False) -> None:
        """Raise where series or derivatives jump at a place that `moves`, or a break that does."""
        self._require_inside(name, node, place)
        for each, sides in zip(self.moved.breaks, self.moved.sides, strict=True):
            if (moves or each.moved.any()) and np.abs(sides - place).min() <= _ON:
                result = self.varied(node, sides)
                slopes = filled(result, self.moved.count)
                size = np.abs(self.values(node, None)).max()
                if (
                    abs(np.diff(result.value)[0]) > JUMP * size
                    or (np.abs(np.diff(slopes)) > _BENT * np.abs(slopes).max()).any()
                ):
                    self._refuse(name, "what is measured", each.time)

    def _refuse(self, name: str, what: str, time: float) -> NoReturn:
        message = (
            f"measure {self.measure.text!r}: {what} jumps at t = {time:.6g} s, and numbers move "
            f"that time; there is no derivative of {name!r}"
        )
        raise ComputationError(message, time=None)

    def _require_one(self, node: Node, place: float) -> None:
        """Raise where a series is as large elsewhere: nothing says how the time of it moves."""
        grid = np.arange(self.last + 1.0) if self.window is None else self.grid
        values = np.broadcast_to(
            self.values(node, None if self.window is None else grid), grid.shape
        )
        largest = self.values(node, np.array([place]))
        equal = grid[np.abs(values - largest) <= _SAME * np.abs(values).max()]
        if self.moved.count and (np.abs(equal - place) > 1.0).any():
            other = self.time(equal[np.abs(equal - place) > 1.0])[0]
            message = (
                f"measure {self.measure.text!r}: the extreme is reached at "
                f"t = {self.time(np.array([place]))[0]:.6g} s and at t = {other:.6g} s; no "
                "derivative is known of its time"
            )
            raise ComputationError(message, time=None)

    def extreme(self, node: Node, which: str) -> Varied:
        """It changes as the series does there, or as the corner moves that it is."""
        place, edge = self._extreme(node, which)
        self._require_inside(which, node, place)
        return self._led(node, place, edge)

    def peak(self, node: Node, place: float, sign: float) -> Varied:
        """The same of a local extreme whose place is known."""
        value = sign * float(np.ravel(self.values(node, np.array([place])))[0])
        return self._led(node, *(self._edge(node, place, value, sign) or (place, None)))

    def _led(self, node: Node, place: float, edge: Break | None) -> Varied:
        """An extreme with its derivatives."""
        result = self.at(node, place)
        if edge is not None:
            assert result.slopes is not None
            rate = self.near(node, place).rate(place, 1)[0] / self.step(place)
            return Varied(result.value, result.slopes + rate * edge.moved)
        corner = self._corner(node, place)
        if corner is None:
            return result
        return Varied(result.value, corner.left + corner.rate * corner.moved)

    def _corner(self, node: Node, place: float) -> _Corner | None:
        """How a corner moves in which a series is extreme; None where it is smooth there."""
        low, high = self.moved.stretch(place)
        step = min(_BESIDE, (place - low) / 3.0, (high - place) / 3.0)
        if not self.moved.count or step < _NARROWEST:
            return None
        around: Floats = place + step * np.arange(-3.0, 4.0)
        beside = self.varied(node, around)
        before, behind = (
            float(side * (_ONE_SIDED @ beside.value[3 - side * np.arange(4)])) / step
            for side in (1, -1)
        )
        # those of a smooth extreme are zero
        least = _CORNER * np.ptp(beside.value) / step
        if before * behind >= 0.0 or abs(before - behind) < least:
            return None
        slopes = filled(beside, self.moved.count)
        left, right = (slopes[:, 3 - side * np.arange(1, 4)] @ _END for side in (1, -1))
        return _Corner(before, left, -(left - right) / (before - behind))

    def _extreme(self, node: Node, which: str) -> tuple[float, Break | None]:
        """Where a series is largest or least, and the time of change that it is so at, if any."""
        sign, grid = 1.0 if which == "max" else -1.0, self.grid
        inner = np.arange(len(grid))
        samples = grid if self.moved.breaks or self.window is not None else None
        whole = sign * self.values(node, samples)
        whole = np.broadcast_to(whole, (1, len(grid)))

        def look(_: object, between: Floats) -> Floats:
            places: Floats = np.asarray(np.interp(between, inner, grid), dtype=float)
            return np.asarray(sign * self.values(node, places))

        result = largest_between(whole, look)
        place = float(np.interp(result.place[0], inner, grid))
        edge = self._edge(node, place, float(result.value[0]), sign)
        return edge or (self._settled(node, place, sign), None)

    def _edge(
        self, node: Node, place: float, largest: float, sign: float
    ) -> tuple[float, Break] | None:
        """The side of a change that a series is largest at, towards which it grows.

        An end of the window that numbers move is one.
        """
        for end, time in zip(self.span, self.ends, strict=True):
            if time.slopes is not None and time.slopes.any() and abs(place - end) <= _ON:
                at = float(time.value)
                return end, Break(at, at, at, time.slopes)
        for each, sides in zip(self.moved.breaks, self.moved.sides, strict=True):
            if np.abs(sides - place).min() > _ON or not each.moved.any():
                continue
            values = sign * self.values(node, sides)
            for side, value, way in zip(sides.tolist(), values, (1.0, -1.0), strict=True):
                if value < largest - _REACHED * abs(largest):
                    continue
                if sign * way * self.near(node, side).rate(side, 1)[0] > 0.0:
                    return side, each
        return None

    def _settled(self, node: Node, start: float, sign: float) -> float:
        """The place at which the slope is zero; values alone tell it to half the digits."""
        if not self.span[0] < start < self.span[1]:
            return start
        place, near = start, self.near(node, start)
        low, high = self.moved.stretch(start)
        low, high = max(low, self.span[0]), min(high, self.span[1])
        for _ in range(_STEPS):
            slope, bend = (near.rate(place, order)[0] for order in (1, 2))
            step = -slope / bend
            if not abs(step) < _CLOSE:  # a corner, or a series that does not change
                return start
            place = float(np.clip(place + step, low, high))
        before, behind = sign * self.values(node, np.array([start, place]))
        return place if behind >= before - _SAME * abs(before) else start

    def time_of_extreme(self, node: Node, which: str) -> Varied:
        """An extreme within the motion moves so that the slope stays zero; one at an end stays."""
        place, edge = self._extreme(node, which)
        time = self.time(np.array([place]))[0]
        self._require_one(node, place)
        self._require_inside("time of an extreme", node, place)
        if edge is not None:
            return Varied(time, edge.moved)
        if not self.span[0] < place < self.span[1]:
            return Varied(time, None)
        corner = self._corner(node, place)
        if corner is not None:
            return Varied(time, corner.moved * self.step(place))
        near = self.near(node, place)
        moved = self.near(node, place, near.half).rate(place, 1)
        # places are samples, and so is what they move by
        return Varied(time, -moved / near.rate(place, 2)[0] * self.step(place))

    def at_time(self, node: Node, time: Varied) -> Varied:
        first, last = (float(end.value) for end in self.ends)
        if self.window is not None and not first <= float(time.value) <= last:
            span = f"from {first:g} s to {last:g} s"
            self._missing(f"t = {float(time.value):g} s is outside of the window, {span}")
        try:
            place = float(self.moved.places(np.array([float(time.value)]))[0])
        except ValueError as error:
            message = f"measure {self.measure.text!r}: {error}"
            raise ComputationError(message, time=None) from None
        place = float(np.clip(place, *self.span))
        moves = time.slopes is not None and bool(np.any(time.slopes))
        self._require_steady(AT, node, place, moves)
        return self._moving_value(node, place, time)
