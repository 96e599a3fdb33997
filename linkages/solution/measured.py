"""Measures of motions: their trees evaluated with NumPy."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol, assert_never

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError
from linkages.kernel.dual_numbers import plain_array
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.reading.paths import split
from linkages.solution.extremes import Extremes, largest_between
from linkages.solution.interpolated import InterpolatedMotions, places_of, resolved_motion
from linkages.solution.quadrature import integrals
from linkages.solution.series import (
    TIME,
    Series,
    example_series,
    find_series,
    requested,
    system_series,
)
from linkages.spec.formulas import Call, Clock, Constant, Node, Sensed
from linkages.spec.grammar import NumberError
from linkages.spec.measures import AT, Measure, is_series, read_measure, reduces, spelled

if TYPE_CHECKING:
    from linkages.solution.solution import Solution

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

_SIMPSON = 2.0 / 3.0


class Source(Protocol):
    """Motions with the same sample times."""

    @property
    def count(self) -> int:
        """Number of motions."""
        ...

    @property
    def time(self) -> Floats:
        """Sample times, shape (samples,)."""
        ...

    def sampled(self, series: str) -> Floats:
        """A series at the samples, shape (motions, samples)."""
        ...

    def between(self, series: Sequence[str], which: Whole, places: Floats) -> list[Floats]:
        """Series anywhere in some of the motions, shape (places,) each."""
        ...

    @property
    def intervals(self) -> tuple[Whole, Floats, Floats] | None:
        """Intervals between known jumps: motion, begin and end in s, shape (intervals,) each.

        None where no more is known than the samples.
        """
        ...

    def during(self, series: Sequence[str], which: Whole, times: Floats) -> list[Floats]:
        """Series at times in some of the motions, shape (times,) each."""
        ...


@dataclass
class _Place:
    """Where series are taken: `which` motions, and places or times in them; else at all samples."""

    which: Whole | None = None
    places: Floats | None = None
    times: Floats | None = None
    values: dict[str, Floats] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Reduced:
    """Values of a measure; `span` are the first and the last time of the motions."""

    values: Floats  # shape (motions,); nan where there is none
    divided: NDArray[np.bool_]  # where it divides by zero, shape (motions,)
    # A time that it asks for and the motion does not reach, shape (motions,); nan for none
    outside: Floats
    text: str
    span: tuple[float, float]

    def reason(self, motion: int) -> str:
        """Why there is no value of a motion; empty if there is one."""
        own = f"measure {self.text!r}"
        if self.divided[motion]:
            return f"{own} divides by zero"
        if self.values[motion] == self.values[motion]:
            return ""
        time, (begin, end) = self.outside[motion], self.span
        if time == time:
            return f"{own}: t = {time:g} s is outside of the motion, from {begin:g} s to {end:g} s"
        return f"{own} has no finite value"


def reduced(measure: Measure, source: Source, nominal: Source | None = None) -> Reduced:
    """A measure of every motion of a source."""
    if nominal is None:
        require_alone(measure)
    evaluation = _Evaluation(measure, source, nominal)
    with np.errstate(all="ignore"):  # what is not finite is said of the motion that it is of
        values = np.broadcast_to(evaluation.number(measure.tree), (source.count,)).copy()
    values = np.where(np.isfinite(values), values, np.nan)
    span = float(source.time[0]), float(source.time[-1])
    return Reduced(values, evaluation.divided, evaluation.outside, measure.text, span)


def require_alone(measure: Measure) -> None:
    """Raise ValueError for a measure of errors, which one motion by itself does not have."""
    if measure.compares:
        raise ValueError(
            f"measure {measure.text!r}: there is no other motion to compare with; errors are those "
            "of sweeps and tolerances, against the mechanism as it is defined"
        )


class _Evaluation:
    def __init__(self, measure: Measure, source: Source, nominal: Source | None = None) -> None:
        self.measure, self.source = measure, source
        self._nominal = None if nominal is None else _Evaluation(measure, nominal)
        self.divided = np.zeros(source.count, dtype=bool)
        self.outside = np.full(source.count, np.nan)
        self._samples = _Place()
        self._found: dict[Node, Floats] = {}

    def number(self, node: Node) -> Floats:
        """What does not change with time, of shape (motions,) or one for all."""
        if node not in self._found:
            self._found[node] = self._number(node)
        return self._found[node]

    def _number(self, node: Node) -> Floats:
        match node:
            case Constant(value):
                return np.array(value)
            case Clock() | Sensed():
                raise AssertionError("a measure is no series")
            case Call(name, arguments):
                if reduces(name, len(arguments)):
                    return self._over_time(name, arguments)
                return self._applied(name, [self.number(a) for a in arguments], None)
            case _:
                assert_never(node)

    def series(self, node: Node, at: _Place) -> Floats:
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
            case Call(name, arguments):
                return self._applied(name, [self.series(a, at) for a in arguments], at)
            case _:
                raise AssertionError("constants are no series")

    def _reference(self, node: Node, at: _Place) -> Floats:
        """The same of the nominal motion, at the same times."""
        other = self._nominal
        assert other is not None
        own, times = self.source.time, other.source.time
        if at.which is None:
            if np.array_equal(own, times):
                return other.series(node, other._samples)
            places = places_of(times, own)
            return other.series(node, _Place(np.zeros(len(own), dtype=int), places))[None]
        wanted, which = self._time(at), np.zeros(len(at.which), dtype=int)
        if at.times is not None:
            return other.series(node, _Place(which, times=wanted))
        return other.series(node, _Place(which, places_of(times, wanted)))

    def _time(self, at: _Place) -> Floats:
        time = self.source.time
        if at.times is not None:
            return at.times
        if at.places is None:
            return time[None]
        return np.interp(at.places, np.arange(len(time)), time)

    def _taken(self, name: str, at: _Place) -> Floats:
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

    def _applied(self, name: str, operands: list[Floats], at: _Place | None) -> Floats:
        if name == "div":
            self._note(operands[1] == 0.0, at)
        if name == "power":
            return np.asarray(operands[0] ** int(operands[1]))
        return np.asarray(plain_array(name, *operands))

    def _note(self, zero: Any, at: _Place | None) -> None:
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
            case "rms":
                return np.sqrt(self._mean(node, 2))
            case "final":
                return self._at(node, np.full(self.source.count, len(self.source.time) - 1.0))
            case _:
                assert name == AT
                return self._at_time(node, self.number(arguments[0]))

    def _at_time(self, node: Node, time: Floats) -> Floats:
        """A series at a time of each motion; nan where that lies outside of it."""
        times = self.source.time
        wanted = np.broadcast_to(time, (self.source.count,))
        low, high = sorted((float(times[0]), float(times[-1])))
        inside = (low <= wanted) & (wanted <= high)
        self.outside = np.where(inside | ~np.isnan(self.outside), self.outside, wanted)
        result = self._at(node, places_of(times, np.where(inside, wanted, low)))
        return np.where(inside, result, np.nan)

    def _at(self, node: Node, places: Floats) -> Floats:
        result = self.series(node, _Place(np.arange(self.source.count), places))
        return np.broadcast_to(result, places.shape)

    def _whole(self, node: Node) -> Floats:
        shape = self.source.count, len(self.source.time)
        return np.broadcast_to(self.series(node, self._samples), shape)

    def _extremes(self, node: Node, sign: float) -> Extremes:
        result = largest_between(
            sign * self._whole(node),
            lambda which, places: sign * self.series(node, _Place(which, places)),
        )
        return Extremes(sign * result.value + 0.0, result.place)

    def _when(self, found: Extremes) -> Floats:
        return np.interp(found.place, np.arange(len(self.source.time)), self.source.time)

    def _mean(self, node: Node, power: int) -> Floats:
        """The mean of a power over time."""
        times, result = self.source.time, self.source.intervals
        if result is None or len(times) < 2:
            return self._sampled_mean(node, power)
        which, begin, end = result

        def of(interval: Whole, wanted: Floats) -> Floats:
            at = _Place(which[interval], times=wanted)
            return np.broadcast_to(self.series(node, at) ** power, wanted.shape)

        # sums that do not depend on how many motions are side by side
        whole = np.bincount(which, integrals(of, begin, end, which), self.source.count)
        return np.asarray(whole / (times[-1] - times[0]))

    def _sampled_mean(self, node: Node, power: int) -> Floats:
        """The same by Simpson's rule, with places half way between the samples."""
        values, count = self._whole(node) ** power, len(self.source.time)
        if count < 2:
            return values[:, 0]
        which = np.repeat(np.arange(self.source.count), count - 1)
        halves = np.tile(np.arange(count - 1) + 0.5, self.source.count)
        middle = self.series(node, _Place(which, halves)) ** power
        middle = np.broadcast_to(middle, which.shape).reshape(-1, count - 1)
        steps = np.diff(self.source.time)
        ends = 0.5 * (values[:, 1:] + values[:, :-1])
        # a sum that does not depend on how many motions are side by side
        whole = np.array([np.sum(row * steps) for row in ends + _SIMPSON * (middle - ends)])
        return whole / (self.source.time[-1] - self.source.time[0])


def measure(solution: Solution, text: str) -> float:
    """A number out of a motion, such as ``"max(abs(crank.effort))"``.

    Series are named as on axes: ``crank.effort``, ``piston.position``, ``B.x velocity``,
    ``kinetic_energy``. They are reduced by ``max``, ``min``, ``mean``, ``rms``, ``range``,
    ``stroke``, ``final``, ``time_of_max``, ``time_of_min`` and ``at(0.2 s, …)``; arithmetic and the
    functions of formulas go within and around. Extremes are located between samples.

    Parameters
    ----------
    solution
        From `linkages.simulate`; what is computed from more than the motion at one time, such as
        reactions of joints, must be among its outputs.
    text
        The measure.

    Returns
    -------
    In SI.

    Raises
    ------
    ValueError
        If the text is no measure, or names no output of the mechanism.
    ComputationError
        If the measure has no finite value, as where it divides by zero, or asks for a time outside
        of the motion.
    """
    result = read_measure(text)
    series = measured_series(solution.system, result)
    for name, each in series.items():
        whole = each.variable in VARIABLES and VARIABLES[each.variable].whole
        if whole and each.variable not in solution.data:
            raise ValueError(
                f"measure {text!r}: {name} was not computed; expected outputs that have "
                f"{each.variable!r}"
            )
    measure_unit(solution.system, result, series)
    system, settings = solution.system, solution.settings
    motion, time, _ = resolved_motion(system, solution.motion, settings, result.integrates)
    source = InterpolatedMotions(
        [system], [motion], series, time, data=solution.data, settings=settings
    )
    return single(result, source)


def single(found: Measure, source: Source, nominal: Source | None = None) -> float:
    """A measure of the one motion of a source; raises ComputationError as `measure` does."""
    value = reduced(found, source, nominal)
    if reason := value.reason(0):
        raise ComputationError(reason, time=None)
    return float(value.values[0])


def measured_series(system: System, found: Measure) -> dict[str, Series]:
    """Name → series that a measure names; spaces in names may be written as underscores."""
    try:
        return known_series(system, found.series)
    except ValueError as error:
        raise ValueError(f"measure {found.text!r}: {error}") from None


def known_series(system: System, names: Iterable[str]) -> dict[str, Series]:
    """Name → series of a mechanism; raises ValueError for a name that is none of them."""
    known = system_series(system)
    result = {}
    for name in names:
        try:
            result[name] = find_series(known, name, spelled)
        except ValueError:
            if system.mechanism.definition.value(split(name) or ("",)) is None:
                raise
            example = spelled(example_series(system))
            raise ValueError(
                f"{name!r} is a value of the definition; expected an output, such as {example!r}"
            ) from None
    return result


def example_measure(mechanism: Mechanism) -> str:
    """A measure of this mechanism, for messages."""
    return f"max({spelled(example_series(System(mechanism)))})"


def measure_unit(system: System, found: Measure, series: dict[str, Series]) -> str:
    """The unit of a measure of a mechanism, in SI."""
    try:
        return found.units(lambda name: series_unit(system, series[name]))
    except NumberError as error:
        raise ValueError(f"measure {found.text!r}: {error.message}{error.hint}") from None


def measure_units(system: System, measures: Mapping[str, Measure]) -> dict[str, str]:
    """Name → unit of each measure, in SI; raises ValueError for what is no measure of it."""
    return {
        name: measure_unit(system, each, measured_series(system, each))
        for name, each in measures.items()
    }


def unit_of(solution: Solution, text: str) -> str:
    """The unit of a measure of a solution, in SI; empty for a pure number."""
    result = read_measure(text)
    return measure_unit(solution.system, result, measured_series(solution.system, result))


def with_measured(
    mechanism: Mechanism, outputs: Sequence[str] | None, texts: Iterable[str]
) -> Sequence[str]:
    """Outputs with those that measures need besides; checks the texts."""
    system = System(mechanism)
    result = [read_measure(text) for text in texts]
    for one in result:
        measure_unit(system, one, measured_series(system, one))
        require_alone(one)
    needed = [name for name in needed_outputs(system, result) if VARIABLES[name].whole]
    return list(dict.fromkeys([*requested(system, outputs), *needed]))


def needed_outputs(system: System, measures: Iterable[Measure]) -> list[str]:
    """Outputs that measures are made of."""
    result = [each.variable for one in measures for each in measured_series(system, one).values()]
    return [name for name in dict.fromkeys(result) if name != TIME]


def series_unit(system: System, series: Series) -> str:
    """The unit of a series, in SI."""
    if series.variable == TIME:
        return "s"
    variable = VARIABLES[series.variable]
    if variable.unit_of is not None:
        return variable.unit_of(system.model)[series.index(system.model)]
    name = series.place.get("drive")
    pushed = variable.pushed is not None and name is not None
    if pushed and variable.pushed and not system.mechanism.twisting(str(name)):
        return variable.pushed[0]
    return variable.units


def measured_rows(solution: Solution, texts: Iterable[str]) -> list[dict[str, Any]]:
    """A row for each measure: its text, value, unit, and why it has no value."""
    rows: list[dict[str, Any]] = []
    for text in texts if len(solution.time) else ():
        value, why = None, None
        try:
            value = measure(solution, text)
        except ComputationError as error:
            why = str(error)
        units = unit_of(solution, text)
        rows.append({"measure": text, "value": value, "units": units, "reason": why})
    return rows
