"""Measures of a motion with their derivatives: the chain rule over the trees of measures.

The largest value of a series changes as the series does where it is largest (the envelope theorem);
the time of it as the slope there does, by implicit differentiation.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, assert_never

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebpts1, chebval, chebvander
from numpy.typing import NDArray

from linkages.design.sensitivity.moved import Moved
from linkages.errors import ComputationError
from linkages.operations import COMPOSITE, ELEMENTARY
from linkages.solution.measuring.located import largest_between
from linkages.spec.formulas import Call, Clock, Constant, Node, Sensed
from linkages.spec.measures import AT, Measure, is_series, reduces

Floats = NDArray[np.float64]

_SIMPSON = 2.0 / 3.0

_STEPS, _CLOSE, _SAME = 3, 0.1, 1e-13
"""Newton steps to where a slope is zero, how many samples each of them may go, and round-off."""

_ON = 1e-6
"""How many samples from a jump a place is on it."""

_WIDEST = 16.0
"""Part of a motion, to either side of a place, that a polynomial is asked to follow first."""

_BESIDE, _CORNER = 1e-2, 0.1
_ONE_SIDED: Floats = np.array([11.0, -18.0, 9.0, -2.0]) / (6.0 * _BESIDE)
_END: Floats = np.array([3.0, -3.0, 1.0])
"""How many samples beside a place it is looked at; how large the rates on both sides of a corner
are, as a part of the largest; the rate from four values and the value from three on one side."""

_DEGREE = 24
_NODES = chebpts1(_DEGREE + 1)
_FIT: Floats = np.asarray(np.linalg.inv(chebvander(_NODES, _DEGREE)), dtype=float)
_EXACT = 1e-13
"""Relative size of the last coefficients of a polynomial that says all of a function."""


class Varied(NamedTuple):
    """Values, shape (…), and their derivatives, shape (P, …); None where there are none."""

    value: Floats
    slopes: Floats | None


def differentiated(measure: Measure, moved: Moved) -> Varied:
    """A measure of a motion: a number, and its derivatives, shape (P,).

    Raises
    ------
    ComputationError
        If the measure or a derivative of it has no finite value.
    ValueError
        If a series in it has no derivative, or a time lies outside of the motion.
    """
    with np.errstate(all="ignore"):
        found = _Differentiation(measure, moved).number(measure.tree)
    value, slopes = float(found.value), _filled(found, moved.count)
    if not np.isfinite(value):
        raise ComputationError(f"measure {measure.text!r} has no finite value", time=None)
    if not np.isfinite(slopes).all():
        raise ComputationError(f"measure {measure.text!r} has no finite derivative", time=None)
    return Varied(np.array(value), slopes)


def inner(measure: Measure) -> Node:
    """What changes with time in a measure that reduces one series."""
    assert isinstance(measure.tree, Call)
    return measure.tree.arguments[-1]


def sampled(node: Node, moved: Moved, places: Floats | None = None) -> Floats:
    """What changes with time, at places or all samples of a motion, without derivatives."""
    with np.errstate(all="ignore"):
        found = _Differentiation(Measure("", node), moved).series(node, places, slopes=False)
    return np.broadcast_to(found.value, moved.time.shape if places is None else places.shape)


def followed(node: Node, moved: Moved, places: Floats) -> Varied:
    """What changes with time at places in a motion, shapes (T,) and (P, T)."""
    if moved.count:
        moved.require_followed(places)
    with np.errstate(all="ignore"):
        found = _Differentiation(Measure("", node), moved).series(node, places, slopes=True)
    slopes = np.broadcast_to(_filled(found, moved.count), (moved.count, len(places)))
    return Varied(np.broadcast_to(found.value, places.shape), slopes)


def _filled(found: Varied, count: int) -> Floats:
    nothing = np.zeros((count, *np.shape(found.value)))
    return nothing if found.slopes is None else nothing + found.slopes


class _Near(NamedTuple):
    """Polynomials about a place, in samples: Chebyshev coefficients, shape (degree + 1, rows)."""

    middle: float
    half: float
    coefficients: Floats

    @property
    def exact(self) -> bool:
        """Whether they say all of what they are of."""
        size = np.abs(self.coefficients)
        return bool((size[-3:] <= _EXACT * size.max(axis=0)).all())

    def rate(self, place: float, order: int) -> Floats:
        """Derivatives at a place, by places, shape (rows,)."""
        found = chebval((place - self.middle) / self.half, chebder(self.coefficients, order))
        return np.asarray(found / self.half**order)


class _Corner(NamedTuple):
    """Where two branches meet: rate and change of the first one, and how the place moves."""

    rate: float
    left: Floats
    moved: Floats


class _Differentiation:
    def __init__(self, measure: Measure, moved: Moved) -> None:
        self._measure, self._moved = measure, moved
        self._last = len(moved.time) - 1

    def number(self, node: Node) -> Varied:
        """What does not change with time."""
        match node:
            case Constant(value):
                return Varied(np.array(value), None)
            case Clock() | Sensed():
                raise AssertionError("a measure is no series")
            case Call(name, arguments):
                if reduces(name, len(arguments)):
                    return self._over_time(name, arguments)
                return _applied(name, [self.number(argument) for argument in arguments])
            case _:
                assert_never(node)

    def series(self, node: Node, places: Floats | None, slopes: bool) -> Varied:
        """What changes with time: at places, or at all samples without derivatives."""
        if not is_series(node):
            found = self.number(node)
            if found.slopes is None or not slopes:
                return Varied(found.value, None)
            return Varied(found.value, found.slopes[:, None])
        match node:
            case Clock():
                return Varied(self._time(places), None)
            case Sensed(name):
                (values,) = self._moved.values([name], places)
                if not slopes or places is None or not self._moved.count:
                    return Varied(values, None)
                return Varied(values, self._moved.slopes([name], places)[0])
            case Call(name, arguments):
                return _applied(name, [self.series(a, places, slopes) for a in arguments])
            case _:
                raise AssertionError("constants are no series")

    def _time(self, places: Floats | None) -> Floats:
        time = self._moved.time
        return time if places is None else np.interp(places, np.arange(len(time)), time)

    def _over_time(self, name: str, arguments: tuple[Node, ...]) -> Varied:
        node = arguments[-1]
        match name:
            case "max" | "min":
                return self._largest(node, name)
            case "time_of_max" | "time_of_min":
                return self._time_of(node, self._extreme(node, name.removeprefix("time_of_")))
            case "range" | "stroke":
                high, low = (self._largest(node, each) for each in ("max", "min"))
                return _applied("sub", [high, low])
            case "mean":
                return self._mean(node, 1)
            case "rms":
                return _applied("sqrt", [self._mean(node, 2)])
            case "final":
                self._require_steady(name, node, float(self._last), _ON)
                return self._at(node, float(self._last))
            case _:
                assert name == AT
                return self._at_time(node, self.number(arguments[0]))

    def _at(self, node: Node, place: float) -> Varied:
        found = self.series(node, np.array([place]), slopes=True)
        return Varied(
            np.ravel(found.value)[0], _filled(found, self._moved.count).reshape(-1, 1)[:, 0]
        )

    def _require_steady(
        self, name: str, node: Node, place: float | None = None, near: float = 1.0
    ) -> None:
        """Raise where a series jumps, near a place or anywhere, at a time that numbers move."""
        if not self._moved.count:
            return
        names = list(dict.fromkeys(_sensed(node)))
        for series, time in self._moved.jumps(names):
            where = float(self._moved.places(np.array([time]))[0])
            if place is None or abs(where - place) <= near:
                message = (
                    f"measure {self._measure.text!r}: {series} jumps at t = {time:.6g} s, "
                    "where a law does, and numbers move that time; "
                    f"no derivative of {name!r} is known"
                )
                raise ComputationError(message, time=None)

    def _require_one(self, node: Node, place: float) -> None:
        """Raise where a series is as large elsewhere: nothing says how the time of it moves."""
        values = np.broadcast_to(self.series(node, None, slopes=False).value, (self._last + 1,))
        largest = self.series(node, np.array([place]), slopes=False).value
        equal = np.flatnonzero(np.abs(values - largest) <= _SAME * np.abs(values).max())
        if self._moved.count and (np.abs(equal - place) > 1.0).any():
            other = self._time(equal[np.abs(equal - place) > 1.0].astype(float))[0]
            message = (
                f"measure {self._measure.text!r}: the extreme is reached at "
                f"t = {self._time(np.array([place]))[0]:.6g} s and at t = {other:.6g} s; no "
                "derivative is known of its time"
            )
            raise ComputationError(message, time=None)

    def _largest(self, node: Node, which: str) -> Varied:
        """An extreme: it changes as the series does there, or as the corner moves that it is."""
        place = self._extreme(node, which)
        self._require_steady(which, node, place)
        found, corner = self._at(node, place), self._corner(node, place)
        if corner is None:
            return found
        return Varied(found.value, corner.left + corner.rate * corner.moved)

    def _corner(self, node: Node, place: float) -> _Corner | None:
        """How a corner moves in which a series is extreme; None where it is smooth there."""
        if not self._moved.count or not 3 * _BESIDE < place < self._last - 3 * _BESIDE:
            return None
        around = np.linspace(place - 3 * _BESIDE, place + 3 * _BESIDE, 7)
        beside = self.series(node, around, slopes=True)
        before, behind = (
            float(side * (_ONE_SIDED @ beside.value[3 - side * np.arange(4)])) for side in (1, -1)
        )
        # those of a smooth extreme are zero
        least = _CORNER * np.ptp(beside.value) / _BESIDE
        if before * behind >= 0.0 or abs(before - behind) < least:
            return None
        slopes = _filled(beside, self._moved.count)
        left, right = (slopes[:, 3 - side * np.arange(1, 4)] @ _END for side in (1, -1))
        return _Corner(before, left, -(left - right) / (before - behind))

    def _extreme(self, node: Node, which: str) -> float:
        """Where a series is largest or least, in samples from the first one."""
        sign = 1.0 if which == "max" else -1.0
        whole = sign * self.series(node, None, slopes=False).value
        whole = np.broadcast_to(whole, (1, self._last + 1))

        def look(_: object, places: Floats) -> Floats:
            return np.asarray(sign * self.series(node, places, slopes=False).value)

        return self._settled(node, float(largest_between(whole, look).place[0]), sign)

    def _settled(self, node: Node, start: float, sign: float) -> float:
        """The place at which the slope is zero; values alone tell it to half the digits."""
        if not 0.0 < start < self._last:
            return start
        place, near = start, self._near(node, start)
        for _ in range(_STEPS):
            slope, bend = (near.rate(place, order)[0] for order in (1, 2))
            step = -slope / bend
            if not abs(step) < _CLOSE:  # a corner, or a series that does not change
                return start
            place = float(np.clip(place + step, 0.0, self._last))
        before, behind = sign * self.series(node, np.array([start, place]), slopes=False).value
        return place if behind >= before - _SAME * abs(before) else start

    def _time_of(self, node: Node, place: float) -> Varied:
        """An extreme within the motion moves so that the slope stays zero; one at an end stays."""
        time = self._time(np.array([place]))[0]
        self._require_one(node, place)
        if not 0.0 < place < self._last:
            return Varied(time, None)
        self._require_steady("time of an extreme", node, place)
        corner = self._corner(node, place)
        if corner is not None:
            return Varied(time, corner.moved * self._step(place))
        near = self._near(node, place)
        moved = self._near(node, place, near.half).rate(place, 1)
        # places are samples, and so is what they move by
        return Varied(time, -moved / near.rate(place, 2)[0] * self._step(place))

    def _at_time(self, node: Node, time: Varied) -> Varied:
        try:
            place = float(self._moved.places(np.array([float(time.value)]))[0])
        except ValueError as error:
            raise ValueError(f"measure {self._measure.text!r}: {error}") from None
        self._require_steady(AT, node, place, _ON)
        self._moved.require_followed(np.array([place]))
        found = self._at(node, place)
        if time.slopes is None:
            return found
        rate = self._near(node, place).rate(place, 1)[0] / self._step(place)
        return Varied(found.value, _filled(found, self._moved.count) + rate * time.slopes)

    def _step(self, place: float) -> float:
        """Seconds from the sample before a place to the one behind it."""
        before = min(int(place), self._last - 1)
        return float(self._moved.time[before + 1] - self._moved.time[before])

    def _near(self, node: Node, place: float, half: float | None = None) -> _Near:
        """A series near a place, or with half the width of the interval given its derivatives."""
        reach = max(1.0, self._last / _WIDEST)
        while True:
            low, high = max(0.0, place - reach), min(float(self._last), place + reach)
            wanted = 0.5 * (high - low) if half is None else half
            middle = float(np.clip(place, wanted, self._last - wanted))
            found = self.series(node, middle + wanted * _NODES, half is not None)
            rows = found.value[None] if half is None else _filled(found, self._moved.count)
            near = _Near(middle, wanted, _FIT @ np.broadcast_to(rows, (len(rows), len(_NODES))).T)
            if half is not None or near.exact or reach == 1.0:
                return near
            reach = max(1.0, reach / 2.0)

    def _mean(self, node: Node, power: int) -> Varied:
        """The mean over time by Simpson's rule, with places half way between the samples."""
        self._require_steady("mean" if power == 1 else "rms", node)
        steps = np.diff(self._moved.time)
        places = np.arange(2 * len(steps) + 1) / 2
        found = self.series(node, places, slopes=True)
        if power == 2:
            found = _applied("mul", [found, found])
        if not len(steps):
            return Varied(np.ravel(found.value)[0], _filled(found, self._moved.count)[:, 0])
        span = self._moved.time[-1] - self._moved.time[0]

        def mean(rows: Floats) -> Floats:
            rows = np.broadcast_to(rows, (*rows.shape[:-1], len(places)))
            ends = 0.5 * (rows[..., 2::2] + rows[..., :-1:2])
            return ((ends + _SIMPSON * (rows[..., 1::2] - ends)) @ steps) / span

        slopes = None if found.slopes is None else mean(found.slopes)
        return Varied(mean(np.atleast_1d(found.value)), slopes)


def _sensed(node: Node) -> list[str]:
    """Names of the series in something that changes with time."""
    match node:
        case Sensed(name):
            return [name]
        case Call(_, arguments):
            return [name for argument in arguments for name in _sensed(argument)]
        case _:
            return []


def _applied(name: str, operands: Sequence[Varied | float]) -> Varied:
    """An operation of formulas on values with derivatives."""
    given = [o if isinstance(o, Varied) else Varied(np.array(o), None) for o in operands]
    if name == "power":
        base, exponent = given[0], int(given[1].value)
        slope = exponent * base.value ** (exponent - 1) if exponent else np.zeros(())
        changed = None if base.slopes is None else slope * base.slopes
        return Varied(base.value**exponent, changed)
    if name in COMPOSITE:
        found: Varied = COMPOSITE[name].expanded(lambda own, *each: _applied(own, each), *given)
        return found
    if name not in ELEMENTARY:
        raise ValueError(f"no derivative is known of {name!r}")
    values = [operand.value for operand in given]
    value = np.asarray(_plain(name, *values))
    slopes: Floats | None = None
    if any(operand.slopes is not None for operand in given):
        partials = ELEMENTARY[name].partials(_plain, value, *values)
        for operand, partial in zip(given, partials, strict=True):
            if operand.slopes is not None:
                part = partial * operand.slopes
                slopes = part if slopes is None else slopes + part
    return Varied(value, slopes)


def _plain(name: str, *operands: Any) -> Any:
    """An operation of formulas on arrays."""
    if name not in ELEMENTARY:
        return COMPOSITE[name].expanded(_plain, *operands)
    function = ELEMENTARY[name].numpy
    return (getattr(np, function) if isinstance(function, str) else function)(*operands)
