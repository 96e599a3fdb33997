"""The motion of a solution between its samples."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.errors import ComputationError
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.solution.compiled_outputs import compiled_values
from linkages.solution.contact_episodes import losses_of_impacts, states, touches_so_far
from linkages.solution.contact_notes import dissipated
from linkages.solution.driven import fastest
from linkages.solution.evaluation import evaluate_nodes, evaluate_variables
from linkages.solution.interpolation import Course, brackets, watched
from linkages.solution.joint_reactions import reaction_nodes, reactions
from linkages.solution.march import compute_motion
from linkages.solution.motion import Changed, Motion, Piece, Settings
from linkages.solution.run_options import MOST_SAMPLES
from linkages.solution.series import DISSIPATION, LOSS, REACTIONS, STATE, TIME, TOUCHES, Series

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

PER_STEP = 4
"""Samples per step with which quintic polynomials are as good as the steps."""

MOST_STEPS = 1_000_000
"""A motion that took more is not computed again: that would take seconds."""

APART = 8
"""How many roundings of a time lie between it and where laws are on one side for certain."""

_PARTS, _FEWEST_PARTS, _MORE = 40, 4, 40_000
"""Samples between two changes, of which a swing in a stop has some ten steps; the fewest of very
many, and how many samples are added in all."""

_SAMPLES = 6
"""Intervals between samples in one interval of a quadrature: a step and a half."""

_FEWEST, _MOST, _ANGLE, _LOOKS = 16, 20_000, 0.5 * math.pi, 32
"""Intervals of a quadrature where nothing is integrated: the fewest, the most, the angle that a
drive turns by in one of them, and how often it is looked for changes of branch there."""

_CLOSE = 2000
"""Intervals between samples of a motion that is not integrated and passes change points."""

_STEPS: dict[str, Callable[[Motion], NDArray[Any]]] = {
    STATE: states,
    TOUCHES: touches_so_far,
    LOSS: lambda motion: np.sum(losses_of_impacts(motion), axis=0),
    DISSIPATION[0]: lambda motion: dissipated(motion)[0],
    DISSIPATION[1]: lambda motion: dissipated(motion)[1],
}
"""Outputs that jump at changes of mode, and what computes them at samples of a motion."""

_FIVE = range(5)
"""Samples that a polynomial goes through, of series that are not evaluated between samples."""


class Followed:
    """A solution as a source of measures, see `linkages.solution.measured.Source`.

    Between samples outputs are evaluated from the interpolated state, see `Course`. Outputs that
    need more than the motion at one time (`data`) are interpolated themselves: by polynomials
    through five samples, or linearly if they may jump. With `settings`, what is compared with the
    ideal mechanism is evaluated in both motions.
    """

    count = 1

    def __init__(
        self,
        system: System,
        motion: Motion,
        series: Mapping[str, Series],
        data: xr.Dataset | None = None,
        time: Floats | None = None,
        settings: Settings | None = None,
    ) -> None:
        own = {} if settings is None else {n: compared_series(one) for n, one in series.items()}
        self._compared = {name: one for name, one in own.items() if one is not None}
        self._system, self._model, self._data = system, system.model, data
        self._series, self._settings = {**series, **self._compared}, settings
        self._motion = motion
        self._own = Samples(motion.time, motion.time if time is None else time)
        self.time: Floats = self._own.time
        self._sampled: dict[str, Floats] = {}

    def sampled(self, series: str) -> Floats:
        """The series at the samples, shape (1, samples)."""
        if series not in self._sampled:
            result = self._series[series]
            if result.variable == TIME:
                values = self.time
            elif evaluable(result):
                values = result.picked(self._evaluated(self._motion, [result]), self._model)
                values = values[self._own.even]
            elif self._steps(result):
                values = self._stepped(series)[self._own.even]
            else:
                assert self._data is not None
                values = self._between_samples(result.of(self._data).to_numpy(), result)
            if series in self._compared:
                values = values - self._ideal.during([series], np.empty(0, int), self.time)[0]
            self._sampled[series] = np.asarray(values, dtype=float)[None]
        return self._sampled[series]

    def between(self, series: Sequence[str], which: Whole, places: Floats) -> list[Floats]:  # noqa: ARG002
        """The series at places, shape (places,) each."""
        times = np.interp(places, np.arange(len(self.time)), self.time)
        return self._less_ideal(series, self._at(series, self._own.inner(places), places), times)

    def during(self, series: Sequence[str], which: Whole, times: Floats) -> list[Floats]:  # noqa: ARG002
        """The series at times, shape (times,) each."""
        result = self._at(series, self._own.at(times), places_of(self.time, times))
        return self._less_ideal(series, result, times)

    def _less_ideal(self, series: Sequence[str], own: list[Floats], times: Floats) -> list[Floats]:
        """The same, where it is compared less that of the ideal mechanism."""
        names = [name for name in series if name in self._compared]
        ideal = self._ideal.during(names, np.empty(0, int), times) if names else []
        other = dict(zip(names, ideal, strict=True))
        return [v - other[n] if n in other else v for n, v in zip(series, own, strict=True)]

    @cached_property
    def _ideal(self) -> Followed:
        """The motion of the mechanism without clearances, which comes as far."""
        assert self._settings is not None
        system, own = System(self._system.mechanism.ideal()), self._settings
        plain = replace(own, times=self.time, work=False, losses=False, watch=None, events=())
        motion, time, _ = resolved_motion(system, compute_motion(system, plain), plain, True)
        return Followed(system, motion, self._compared, time=time)

    def _steps(self, series: Series) -> bool:
        """Whether a series follows from the samples of the motion and its changes of mode."""
        lost = series.variable in DISSIPATION
        return series.variable in _STEPS and not (lost and self._motion.losses is None)

    @cached_property
    def intervals(self) -> tuple[Whole, Floats, Floats]:
        """Intervals of a quadrature: numbers of their motions, and where they begin and end."""
        motion, system = self._motion, self._system
        if motion.method:
            begin, end = between_changes(motion)
        else:
            begin, end = evenly(motion.time, fastest(system, float(motion.time[-1])))
        nodes = [n for each in self._series.values() for n in _nodes(each, system)]
        conditions = [] if system.layout.moved else watched(self._model, nodes)
        if conditions:
            result = brackets(looks(begin, end), lambda times: self._looked(conditions, times))
            begin, end = parted(begin, end, result)
        return np.zeros(len(begin), dtype=int), begin, end

    def _looked(self, nodes: list[Scalar], times: Floats) -> Floats:
        """Nodes at some times, shape (nodes, times); nan where no piece of the motion is."""
        result = np.full((len(nodes), len(times)), np.nan)
        for inside, piece in self.within(self._own.at(times)):
            result[:, inside] = evaluate_nodes(piece, nodes)
        return result

    def _at(self, series: Sequence[str], inner: Floats, places: Floats) -> list[Floats]:
        """The series at places among the samples of the motion, and among those evenly spaced."""
        followed = [k for k, name in enumerate(series) if evaluable(self._series[name])]
        result = np.empty((len(series), len(places)))
        left = np.ones(result.shape, dtype=bool)
        chosen = [self._series[series[k]] for k in followed]
        for inside, piece in self.within(inner) if followed else []:
            values = self._evaluated(Motion(pieces=(piece,)), chosen)
            for k, each in zip(followed, chosen, strict=True):
                result[k, inside] = each.picked(values, self._model)
                left[k, inside] = False
        for row, name, open_ in zip(result, series, left, strict=True):
            if open_.any():
                row[open_] = self._interpolated(name, inner[open_], places[open_])
        return list(result)

    def _evaluated(self, motion: Motion, series: Sequence[Series]) -> dict[str, Floats]:
        names = list(dict.fromkeys(each.variable for each in series))
        with np.errstate(over="ignore", invalid="ignore"):
            plain = [name for name in names if name not in REACTIONS]
            result = evaluate_variables(motion, plain, compiled_values)
            if len(plain) < len(names):
                result |= reactions(motion)
        return result

    def _interpolated(self, name: str, inner: Floats, places: Floats) -> Floats:
        """From values at samples alone."""
        if self._steps(self._series[name]):
            return np.interp(inner, np.arange(len(self._motion.time)), self._stepped(name))
        (values,) = self.sampled(name)
        return through(values, places, smooth(self._series[name]))

    def _stepped(self, name: str) -> Floats:
        """What jumps at changes of mode, at all samples of the motion."""
        series = self._series[name]
        result = np.asarray(_STEPS[series.variable](self._motion), dtype=float)
        return series.picked({series.variable: result}, self._model)

    def _between_samples(self, values: Floats, series: Series) -> Floats:
        """What the data have, at the samples of the motion that is followed."""
        assert self._data is not None
        given = self._data["time"].to_numpy()
        if len(given) == len(self.time):
            return values
        order = 1 if given[-1] >= given[0] else -1
        places = np.interp(self.time, given[::order], np.arange(len(given))[::order].astype(float))
        return through(values, places, smooth(series))

    @cached_property
    def courses(self) -> list[tuple[int, Course]]:
        """Pieces that can be followed, with the number of their first sample."""
        result, begin = [], 0
        for piece in self._motion.pieces:
            if piece.samples is None and len(piece.time) > 1:
                result.append((begin, Course.of(self._motion, piece)))
            begin += len(piece.wanted)
        return result

    def within(self, places: Floats) -> list[tuple[NDArray[np.intp], Piece]]:
        """Places that lie in a piece, and the motion there."""
        result = []
        for begin, course in self.courses:
            last = min(len(course.piece.time), len(self._motion.time) - begin) - 1
            inside = np.flatnonzero((places >= begin) & (places <= begin + last))
            if last < 1:
                continue
            interval = np.minimum((places[inside] - begin).astype(int), last - 1)
            part = places[inside] - begin - interval
            result += [(inside[which], piece) for which, piece in course.between(interval, part)]
        return result


def enough(motion: Motion, samples: int) -> bool:
    """Whether quintic polynomials through so many samples are as good as the steps of a motion."""
    return samples - 1 >= PER_STEP * motion.cost.get("steps", 0)


def factor_of(motion: Motion, samples: int) -> int:
    """How many times as close samples must be for quintic polynomials; a power of two."""
    count = samples - 1
    if count < 1 or not can_be_repeated(motion):
        return 1
    factor = 1
    while not enough(motion, factor * count + 1) and 2 * factor * count <= MOST_SAMPLES:
        factor *= 2
    return factor


def denser(times: Floats, factor: int) -> Floats:
    """Times with others evenly between them."""
    count = len(times) - 1
    return np.interp(np.arange(count * factor + 1) / factor, np.arange(count + 1), times)


def can_be_repeated(motion: Motion) -> bool:
    """Whether a motion can be computed again at other samples."""
    return not motion.interrupted and motion.cost.get("steps", 0) <= MOST_STEPS


class Resolved(NamedTuple):
    """A motion, evenly spaced samples among its own, and how it was computed if that is known."""

    motion: Motion
    time: Floats
    settings: Settings | None = None


def resolved_motion(
    system: System, motion: Motion, settings: Settings, integrated: bool = False
) -> Resolved:
    """A motion with samples as close as `factor_of` says, computed again if need be.

    Where it is to be integrated over time, it has samples on both sides of all changes of mode.
    """
    factor = factor_of(motion, len(motion.time))
    if integrated and not motion.method and len(motion.pieces) > 1:
        factor = math.ceil(_CLOSE / max(1, len(motion.time) - 1))
    time = times = denser(motion.time, factor)
    if integrated and can_be_repeated(motion):
        times = close_times(motion, time)
    if len(times) > len(motion.time):
        # what is integrated along takes part in the choice of steps: changes stay where they were
        motion = compute_motion(system, replace(settings, times=times, events=()))
    return Resolved(motion, time, settings)


def close_times(motion: Motion, times: Floats) -> Floats:
    """Sample times with both sides of the changes of a motion, and enough between two changes."""
    sides = sides_of(motion)
    if not len(sides):
        return times
    more = between_sides(times, sides)
    order = 1 if times[-1] >= times[0] else -1
    return np.unique(np.concatenate([times, sides.ravel(), more]))[::order]


def sides_of(motion: Motion) -> Floats:
    """Times before and after mode changes, shape (changes, 2); simultaneous ones are merged."""
    result = [changes.time for changes in motion.changes.values() if changes.pieces]
    order = 1.0 if motion.time[-1] >= motion.time[0] else -1.0
    times = np.sort(order * np.concatenate([*result, np.zeros(0)]))
    low, high = np.sort(order * motion.time[[0, -1]])
    apart = APART * float(np.spacing(max(abs(low), abs(high))))
    times = times[(times - apart > low) & (times + apart < high)]
    if not len(times):
        return np.zeros((0, 2))
    parted = np.diff(times) > 2.0 * apart
    first, last = np.append(True, parted), np.append(parted, True)
    return order * np.stack([times[first] - apart, times[last] + apart], axis=1)


def between_sides(times: Floats, sides: Floats) -> Floats:
    """Further times between changes with few samples: a touch may be as short as a step."""
    stretches = np.concatenate([times[:1], sides.ravel(), times[-1:]]).reshape(-1, 2)
    parts = int(np.clip(_MORE // len(stretches), _FEWEST_PARTS, _PARTS))
    order = 1 if times[-1] >= times[0] else -1
    inside = np.abs(np.diff(np.searchsorted(order * times, order * stretches), axis=1)[:, 0])
    part = np.arange(parts + 1) / parts
    return np.asarray(stretches[inside < parts] @ np.array([1.0 - part, part])).ravel()


def unrecorded(motion: Motion) -> str:
    """Which impacts of a motion are not all recorded, in words; empty if all are."""
    for contact in motion.pieces[0].system.model.walls.contacts:
        changed = motion.changes.get(contact.touch, Changed.none())
        known = len(changed.rises)
        if changed.count > known:
            return f"'{contact.touch}' changes {changed.count} times, of which {known} are recorded"
    return ""


def between_changes(motion: Motion) -> tuple[Floats, Floats]:
    """Intervals of a few samples each, of which none has a change of mode in it."""
    if result := unrecorded(motion):
        message = f"{result}; expected a shorter motion for a mean over time"
        raise ComputationError(message, time=None)
    times, sides = motion.time, sides_of(motion)
    stretches = np.concatenate([times[:1], sides.ravel(), times[-1:]]).reshape(-1, 2)
    order = 1 if times[-1] >= times[0] else -1
    places = np.searchsorted(order * times, order * stretches)
    edges = [
        np.concatenate([stretch[:1], times[first + _SAMPLES : last : _SAMPLES], stretch[1:]])
        for stretch, (first, last) in zip(stretches, places, strict=True)
    ]
    return np.concatenate([e[:-1] for e in edges]), np.concatenate([e[1:] for e in edges])


def evenly(times: Floats, highest: float) -> tuple[Floats, Floats]:
    """Intervals of a motion that drives determine, from their highest speed; at least a few."""
    turned = abs(float(times[-1] - times[0])) * highest / _ANGLE
    edges = np.linspace(
        times[0], times[-1], int(np.clip(np.nan_to_num(turned), _FEWEST, _MOST)) + 1
    )
    return edges[:-1], edges[1:]


def looks(begin: Floats, end: Floats) -> Floats:
    """Times in intervals at which it is looked for changes of branch."""
    part = np.arange(_LOOKS) / _LOOKS
    return np.append((begin[:, None] + part * (end - begin)[:, None]).ravel(), end[-1])


def parted(begin: Floats, end: Floats, found: Floats) -> tuple[Floats, Floats]:
    """Intervals of which those around a change of branch are cut on both sides of it."""
    order = 1 if end[-1] >= begin[0] else -1
    edges = np.unique(np.concatenate([begin, end[-1:], found.ravel()]))[::order]
    return edges[:-1], edges[1:]


def driven_factor(system: System, end: float, samples: int, angle: float, few: int) -> int:
    """How many times as close samples must be for drives to turn by `angle` (rad) between them."""
    turned = abs(end) * fastest(system, end) / angle
    return math.ceil(np.clip(np.nan_to_num(turned), few, MOST_SAMPLES) / max(1, samples - 1))


class Samples:
    """All sample times of a motion (`own`), and evenly spaced ones among them (`time`)."""

    def __init__(self, own: Floats, time: Floats) -> None:
        self.time, self._own = time, own
        self._order = 1.0 if own[-1] >= own[0] else -1.0
        self._all = len(own) == len(time)
        self.even: slice | Whole = slice(None)
        if not self._all:
            self.even = np.searchsorted(self._order * own, self._order * time)

    def inner(self, places: Floats) -> Floats:
        """Places among the evenly spaced samples as places among all."""
        if self._all:
            return places
        return self.at(np.interp(places, np.arange(len(self.time)), self.time))

    def at(self, times: Floats) -> Floats:
        """Places of times among all samples, between the two of the interval that begins there."""
        own, last = self._own, max(len(self._own) - 2, 0)
        result = np.searchsorted(self._order * own, self._order * times, side="right") - 1
        result = np.clip(result, 0, last)
        step = own[np.minimum(result + 1, len(own) - 1)] - own[result]
        return np.asarray(result + (times - own[result]) / step)


def places_of(times: Floats, wanted: Floats) -> Floats:
    """Places of some times among samples, in samples from the first one."""
    order = 1 if times[-1] >= times[0] else -1
    return np.interp(wanted, times[::order], np.arange(len(times))[::order].astype(float))


def smooth(series: Series) -> bool:
    """Whether polynomials go through its samples."""
    return series.variable in VARIABLES and VARIABLES[series.variable].smooth


def through(values: Floats, places: Floats, smoothly: bool) -> Floats:
    """Values at places, by polynomials through five samples or linearly."""
    if not smoothly or len(values) < len(_FIVE):
        return np.interp(places, np.arange(len(values)), values)
    first = np.clip(np.rint(places).astype(int) - 2, 0, len(values) - len(_FIVE))
    result = np.zeros(len(places))
    for node in range(len(_FIVE)):
        others = [other for other in range(len(_FIVE)) if other != node]
        weight = np.prod([(places - first - other) / (node - other) for other in others], axis=0)
        result += weight * values[first + node]
    return result


def evaluable(series: Series) -> bool:
    """Whether it can be computed from the motion at one time."""
    return series.variable in REACTIONS or (
        series.variable in VARIABLES and not VARIABLES[series.variable].whole
    )


def compared_series(series: Series) -> Series | None:
    """What a series compares with that of the mechanism without clearances, if it does."""
    variable = VARIABLES.get(series.variable)
    if variable is None or not variable.compared:
        return None
    return replace(series, variable=variable.compared)


def _nodes(series: Series, system: System) -> list[Scalar]:
    """Nodes that a series is computed from at one time."""
    if not evaluable(series) or series.variable == TIME:
        return []
    if series.variable in REACTIONS:
        return reaction_nodes(system.model)
    return VARIABLES[series.variable].evaluated(system.model)
