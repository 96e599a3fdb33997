"""Measures of motions: their trees evaluated with NumPy."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, assert_never

import numpy as np
from numpy.typing import NDArray

from linkages.errors import ComputationError
from linkages.kernel.dual_numbers import plain_array
from linkages.solution.extremes import Extremes, largest_between
from linkages.solution.guards import bisected
from linkages.solution.interpolated import places_of
from linkages.solution.measure_names import Source, Window
from linkages.solution.quadrature import integrals
from linkages.spec.formulas import Call, Clock, Constant, Node, Sensed
from linkages.spec.measures import (
    AT,
    LAST_TURN,
    WINDOWS,
    Measure,
    harmonic,
    is_series,
    reduces,
)

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

_SIMPSON = 2.0 / 3.0


@dataclass
class Place:
    """Where series are taken: `which` motions, and places or times in them; else at all samples."""

    which: Whole | None = None
    places: Floats | None = None
    times: Floats | None = None
    values: dict[str, Floats] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Reduced:
    """Values of a measure."""

    values: Floats  # shape (motions,); nan where there is none
    divided: NDArray[np.bool_]  # where it divides by zero, shape (motions,)
    missing: Mapping[int, str]  # motion → which part of it that is asked for there is not
    text: str

    def reason(self, motion: int) -> str:
        """Why there is no value of a motion; empty if there is one."""
        own, known = f"measure {self.text!r}", self.values[motion] == self.values[motion]
        if motion in self.missing and not known:
            return f"{own}: {self.missing[motion]}"
        if self.divided[motion]:
            return f"{own} divides by zero"
        if known:
            return ""
        return f"{own} has no finite value"


def reduced(measure: Measure, source: Source, nominal: Source | None = None) -> Reduced:
    """A measure (as `resolved` has it) of every motion of a source."""
    if nominal is None:
        require_alone(measure)
    evaluation = Evaluation(measure, source, nominal)
    with np.errstate(all="ignore"):  # what is not finite is said of the motion that it is of
        values = np.broadcast_to(evaluation.number(measure.tree), (source.count,)).copy()
    values = np.where(np.isfinite(values), values, np.nan)
    return Reduced(values, evaluation.divided, evaluation.missing, measure.text)


def single(found: Measure, source: Source, nominal: Source | None = None) -> float:
    """A measure of the one motion of a source; raises ComputationError as `measure` does."""
    value = reduced(found, source, nominal)
    if reason := value.reason(0):
        raise ComputationError(reason, time=None)
    return float(value.values[0])


def require_alone(measure: Measure) -> None:
    """Raise ValueError for a measure of errors, which one motion by itself does not have."""
    if measure.compares:
        raise ValueError(
            f"measure {measure.text!r}: there is no other motion to compare with; errors are those "
            "of sweeps and tolerances, against the mechanism as it is defined"
        )


class Evaluation:
    """Numbers and series that a measure of the motions of a source consists of."""

    def __init__(self, measure: Measure, source: Source, nominal: Source | None = None) -> None:
        self.measure, self.source = measure, source
        self._nominal = None if nominal is None else Evaluation(measure, nominal)
        self.divided = np.zeros(source.count, dtype=bool)
        self.missing: dict[int, str] = {}
        self._samples = Place()
        self._found: dict[Node, Floats] = {}
        self._windows: dict[tuple[Node, ...], tuple[Evaluation, NDArray[np.bool_]]] = {}
        self._running: dict[Node, tuple[Whole, Floats, Floats]] = {}

    def number(self, node: Node) -> Floats:
        """What does not change with time, of shape (motions,) or one for all."""
        if node not in self._found:
            self._found[node] = self._number(node)
        return self._found[node]

    def _number(self, node: Node) -> Floats:
        match node:
            case Constant(value):
                return np.array(value)
            case Sensed("parameter", (path,)):
                return self.source.number(path)
            case Clock() | Sensed():
                raise AssertionError("a measure is no series")
            case Call(name, (*edges, inner)) if name in WINDOWS:
                part, sound = self._within(name, tuple(edges))
                return np.where(sound, part.number(inner), np.nan)
            case Call(name, arguments):
                if reduces(name, len(arguments)):
                    return self._over_time(name, arguments)
                return self._applied(name, [self.number(a) for a in arguments], None)
            case _:
                assert_never(node)

    def series(self, node: Node, at: Place) -> Floats:
        """What changes with time, at all samples, shape (motions, samples), or at places (n,)."""
        if not is_series(node):
            number = self.number(node)
            if not number.ndim:
                return number
            return number[:, None] if at.which is None else number[at.which]
        match node:
            case Clock():
                return self._time(at)
            case Sensed(name):
                return self._taken(name, at)
            case Call("error", (inner,)):
                return self.series(inner, at) - self._reference(inner, at)
            case Call("cumulative", (inner,)):
                return self._cumulative(inner, at)
            case Call(name, arguments):
                return self._applied(name, [self.series(a, at) for a in arguments], at)
            case _:
                raise AssertionError("constants are no series")

    def _reference(self, node: Node, at: Place) -> Floats:
        """The same of the nominal motion, at the same times."""
        other = self._nominal
        assert other is not None
        own, times = self.source.time, other.source.time
        if at.which is None and not isinstance(self.source, Window):
            if np.array_equal(own, times):
                return other.series(node, other._samples)
            places = places_of(times, own)
            return other.series(node, Place(np.zeros(len(own), dtype=int), places))[None]
        wanted = self._time(at)
        which = np.zeros(wanted.size, dtype=int)
        if at.times is not None or isinstance(self.source, Window):
            result = other.series(node, Place(which, times=wanted.ravel()))
            return np.broadcast_to(result, which.shape).reshape(wanted.shape)
        return other.series(node, Place(which, places_of(times, wanted)))

    def _time(self, at: Place) -> Floats:
        """Times of all samples, shape (motions or 1, samples), or of places."""
        source, time = self.source, self.source.time
        if at.times is not None:
            return at.times
        if at.places is None:
            return source.times if isinstance(source, Window) else time[None]
        if isinstance(source, Window):
            assert at.which is not None
            return source.at(at.which, at.places)
        return np.interp(at.places, np.arange(len(time)), time)

    @property
    def _ends(self) -> tuple[Floats, Floats]:
        """First and last times, shape (motions,) or one for all."""
        if isinstance(self.source, Window):
            return self.source.begin, self.source.end
        return self.source.time[0], self.source.time[-1]

    def _within(self, name: str, edges: tuple[Node, ...]) -> tuple[Evaluation, NDArray[np.bool_]]:
        """The evaluation of a part of each motion, and which motions have it; else of all."""
        key = (Constant(float(name == LAST_TURN)), *edges)
        if key not in self._windows:
            begin, end = self._edges(name, edges)
            first, last = self._ends
            sound = np.isfinite(begin) & np.isfinite(end)
            window = np.where(sound, begin, first), np.where(sound, end, last)
            result = Evaluation(self.measure, Window(self.source, *window))
            if self._nominal is not None:
                result._nominal, _ = self._nominal._within(name, edges)
            result.divided, result.missing = self.divided, self.missing
            self._windows[key] = result, sound
        return self._windows[key]

    def _edges(self, name: str, edges: tuple[Node, ...]) -> tuple[Floats, Floats]:
        """Begin and end of the windows; nan where a motion has none."""
        count = self.source.count
        first, last = (np.broadcast_to(each, (count,)) for each in self._ends)
        if name == LAST_TURN:
            return self._turn_begun(edges[0]), last
        given = [np.broadcast_to(self.number(each), (count,)) for each in edges]
        begin, end = given[0], given[1] if len(given) > 1 else last
        low, high = np.minimum(first, last), np.maximum(first, last)
        outside = ~((low <= begin) & (begin <= high) & (low <= end) & (end <= high))
        empty = ~((end - begin) * np.where(last >= first, 1.0, -1.0) > 0.0)
        for k in np.flatnonzero(outside | empty).tolist():
            window = f"the window from {begin[k]:g} s to {end[k]:g} s"
            span = f"{first[k]:g} s to {last[k]:g} s"
            what = f"is outside of the motion, from {span}" if outside[k] else "is empty"
            self.missing.setdefault(k, f"{window} {what}")
        sound = ~(outside | empty)
        return np.where(sound, begin, np.nan), np.where(sound, end, np.nan)

    def _turn_begun(self, node: Node) -> Floats:
        """Time since which an angle has made its last whole turn; nan where it makes none."""
        angles, count = self._whole(node), self.source.count
        turned = angles[:, -1:] - angles
        whole = np.abs(turned) >= 2.0 * math.pi
        found = np.flatnonzero(whole.any(axis=1))
        for k in np.flatnonzero(~whole.any(axis=1)).tolist():
            most = np.abs(turned[k]).max()
            self.missing.setdefault(
                k, f"the angle turns by {most:.4g} rad in all; expected a whole turn of it"
            )
        low = (angles.shape[1] - 1 - np.argmax(whole[found, ::-1], axis=1)).astype(float)
        sense = np.sign(turned[found, low.astype(int)])
        level = angles[found, -1] - sense * 2.0 * math.pi

        def early(places: Floats) -> NDArray[np.bool_]:
            here = np.broadcast_to(self.series(node, Place(found, places)), places.shape)
            return np.asarray(sense * (here - level) <= 0.0)

        begin, _ = bisected(low, low + 1.0, early)
        result = np.full(count, np.nan)
        result[found] = self._time(Place(found, begin))
        return result

    def _taken(self, name: str, at: Place) -> Floats:
        if name not in at.values:
            names, which = self.measure.series, at.which
            if which is not None and at.times is not None:
                result = self.source.during(names, which, at.times)
                at.values.update(zip(names, result, strict=True))
            elif which is not None and at.places is not None:
                result = self.source.between(names, which, at.places)
                at.values.update(zip(names, result, strict=True))
            else:
                at.values[name] = self.source.sampled(name)
        return at.values[name]

    def _applied(self, name: str, operands: list[Floats], at: Place | None) -> Floats:
        if name == "div":
            self._note(operands[1] == 0.0, at)
        if name == "power":
            return np.asarray(operands[0] ** int(operands[1]))
        return np.asarray(plain_array(name, *operands))

    def _note(self, zero: Any, at: Place | None) -> None:
        """Remember where the measure divides by zero."""
        if at is None:
            self.divided |= zero
        elif at.which is None:
            self.divided |= np.atleast_2d(zero).any(axis=1)
        else:
            self.divided[at.which[np.broadcast_to(zero, at.which.shape)]] = True

    def _over_time(self, name: str, arguments: tuple[Node, ...]) -> Floats:
        node = arguments[-1]
        match name:
            case "max" | "time_of_max":
                result = self._extremes(node, 1.0)
                return result.value if name == "max" else self._when(result)
            case "min" | "time_of_min":
                result = self._extremes(node, -1.0)
                return result.value if name == "min" else self._when(result)
            case "range" | "stroke":
                return self._extremes(node, 1.0).value - self._extremes(node, -1.0).value
            case "mean":
                return self._mean(node, 1)
            case "integral":
                return self._integral(node, 1)
            case "harmonic" | "phase":
                return self.number(harmonic(name, *arguments))
            case "first":
                return self._at(node, np.zeros(self.source.count))
            case "rms":
                return np.sqrt(self._mean(node, 2))
            case "final":
                return self._at(node, np.full(self.source.count, len(self.source.time) - 1.0))
            case _:
                assert name == AT
                return self._at_time(node, self.number(arguments[0]))

    def _at_time(self, node: Node, time: Floats) -> Floats:
        """A series at a time of each motion; nan where that lies outside of it."""
        times, count = self.source.time, self.source.count
        wanted = np.broadcast_to(time, (count,))
        ends = np.array([np.broadcast_to(each, (count,)) for each in self._ends])
        inside = (ends.min(axis=0) <= wanted) & (wanted <= ends.max(axis=0))
        for k in np.flatnonzero(~inside).tolist():
            span = f"from {ends[0, k]:g} s to {ends[1, k]:g} s"
            part = "window" if isinstance(self.source, Window) else "motion"
            self.missing.setdefault(k, f"t = {wanted[k]:g} s is outside of the {part}, {span}")
        if isinstance(self.source, Window):
            at = Place(np.arange(count), times=np.where(inside, wanted, ends[0]))
            result = np.broadcast_to(self.series(node, at), (count,))
        else:
            low = float(min(times[0], times[-1]))
            result = self._at(node, places_of(times, np.where(inside, wanted, low)))
        return np.where(inside, result, np.nan)

    def _at(self, node: Node, places: Floats) -> Floats:
        result = self.series(node, Place(np.arange(self.source.count), places))
        return np.broadcast_to(result, places.shape)

    def _whole(self, node: Node) -> Floats:
        shape = self.source.count, len(self.source.time)
        return np.broadcast_to(self.series(node, self._samples), shape)

    def _extremes(self, node: Node, sign: float) -> Extremes:
        result = largest_between(
            sign * self._whole(node),
            lambda which, places: sign * self.series(node, Place(which, places)),
        )
        return Extremes(sign * result.value + 0.0, result.place)

    def _when(self, found: Extremes) -> Floats:
        return self._time(Place(np.arange(self.source.count), found.place))

    def _mean(self, node: Node, power: int) -> Floats:
        """The mean of a power over time."""
        if len(self.source.time) < 2:
            return self._whole(node)[:, 0] ** power
        begin, end = self._ends
        return np.asarray(self._integral(node, power) / (end - begin))

    def _integral(self, node: Node, power: int) -> Floats:
        """The integral of a power over time."""
        if len(self.source.time) < 2:
            return np.zeros(self.source.count)
        result = self.source.intervals
        if result is None:
            return self._sampled_integral(node, power)
        which, begin, end = result
        parts = integrals(self._during(node, power, which), begin, end, which)
        # sums that do not depend on how many motions are side by side
        return np.asarray(np.bincount(which, parts, self.source.count), dtype=float)

    def _during(self, node: Node, power: int, which: Whole) -> Callable[[Whole, Floats], Floats]:
        """A power of a series at times in intervals, which are of some motions."""

        def of(interval: Whole, wanted: Floats) -> Floats:
            at = Place(which[interval], times=wanted)
            return np.broadcast_to(self.series(node, at) ** power, wanted.shape)

        return of

    def _sampled_integral(self, node: Node, power: int) -> Floats:
        """The same by Simpson's rule, with places half way between the samples."""
        values, count = self._whole(node) ** power, len(self.source.time)
        which = np.repeat(np.arange(self.source.count), count - 1)
        halves = np.tile(np.arange(count - 1) + 0.5, self.source.count)
        middle = self.series(node, Place(which, halves)) ** power
        middle = np.broadcast_to(middle, which.shape).reshape(-1, count - 1)
        steps = np.diff(self._time(self._samples))
        ends = 0.5 * (values[:, 1:] + values[:, :-1])
        steps = np.broadcast_to(steps, ends.shape)
        # a sum that does not depend on how many motions are side by side
        rows = zip(ends + _SIMPSON * (middle - ends), steps, strict=True)
        return np.array([np.sum(row * step) for row, step in rows])

    def _cumulative(self, node: Node, at: Place) -> Floats:
        """The integral from the begin of each motion to all samples, or to places."""
        count, samples = self.source.count, len(self.source.time)
        if samples < 2:
            return np.zeros((count, samples) if at.which is None else at.which.shape)
        which, begin, before = self._integrated(node)
        times = np.broadcast_to(
            self._time(at), (count, samples) if at.which is None else at.which.shape
        )
        motion = np.repeat(np.arange(count), samples) if at.which is None else at.which
        wanted = times.ravel()
        interval = np.empty(len(wanted), dtype=int)
        order = 1.0 if self.source.time[-1] >= self.source.time[0] else -1.0
        for k in np.unique(motion):
            own, there = np.flatnonzero(which == k), motion == k
            last = np.searchsorted(order * begin[own], order * wanted[there], side="right") - 1
            interval[there] = own[np.clip(last, 0, len(own) - 1)]
        part = integrals(self._during(node, 1, which[interval]), begin[interval], wanted, motion)
        return np.asarray(before[interval] + part).reshape(times.shape)

    def _integrated(self, node: Node) -> tuple[Whole, Floats, Floats]:
        """Motions and begins of intervals, and the integral up to the begin of each."""
        if node not in self._running:
            known = self.source.intervals
            if known is None:
                times = np.broadcast_to(
                    self._time(self._samples), (self.source.count, len(self.source.time))
                )
                which = np.repeat(np.arange(self.source.count), times.shape[1] - 1)
                known = which, times[:, :-1].ravel(), times[:, 1:].ravel()
            which, begin, end = known
            parts = integrals(self._during(node, 1, which), begin, end, which)
            before = np.zeros(len(parts))
            for k in np.unique(which):
                own = which == k
                before[own] = np.cumsum(parts[own]) - parts[own]
            self._running[node] = which, begin, before
        return self._running[node]
