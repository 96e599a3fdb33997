"""The motion of a solution between its samples."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.errors import ComputationError
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.solution.driven import fastest
from linkages.solution.evaluation import (
    Numbers,
    Values,
    ValuesOf,
    can_be_compiled,
    compiled_values,
    evaluate_nodes,
    evaluate_variables,
)
from linkages.solution.interpolation import InterpolatedPiece, branch_changes, conditions_with_rates
from linkages.solution.march import compute_motion
from linkages.solution.motion import Motion, Piece, Settings
from linkages.solution.run_options import MOST_SAMPLES
from linkages.solution.series import INTEGRATED, OF_CONTACTS, REACTIONS, TIME, Series

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

PER_STEP = 4
"""Samples per step with which quintic polynomials are as good as the steps."""

MOST_REPEATED = 1_000_000
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

LOOKS, _LOOK, _DOUBLED, _CLOSE = 720, math.radians(1.0), 7, 4
"""Intervals in which a motion that drives determine is looked at for extremes: the fewest, the most
that a drive turns by in one of them, how often their number is doubled for that, and how many times
as many there are where it passes change points."""

_AT_ONCE = 16384
"""States that are evaluated at once, about: few enough for their outputs to fit into memory."""

_FIVE = range(5)
"""Samples that a polynomial goes through, of series that are not evaluated between samples."""


def can_be_batched(motion: Motion, series: Mapping[str, Series]) -> bool:
    """Whether a motion can be interpolated beside others, with the bits that it has alone."""
    own = [each for each in series.values() if each.variable != TIME]
    simple = all(evaluable(each) and each.variable not in REACTIONS for each in own)
    whole = len(motion.pieces) == 1 and len(motion.time) > 1
    return simple and whole and can_be_compiled(motion.pieces[0])


class InterpolatedMotions:
    """Motions of one structure as a `linkages.solution.measure_names.Source` of measures.

    Between samples outputs are evaluated from the interpolated state, see `InterpolatedPiece`.
    There may be several motions if all of them `can_be_batched`. Outputs of a single one that need
    more than the motion at one time (`data`) are interpolated themselves: by polynomials through
    five samples, or linearly if they may jump. With `settings`, what is compared with the ideal
    mechanism is evaluated in both motions.
    """

    def __init__(
        self,
        systems: Sequence[System],
        motions: Sequence[Motion],
        series: Mapping[str, Series],
        time: Floats | None = None,
        *,
        data: xr.Dataset | None = None,
        settings: Settings | None = None,
    ) -> None:
        own = {} if settings is None else {n: compared_series(one) for n, one in series.items()}
        self._compared = {name: one for name, one in own.items() if one is not None}
        self._series, self._settings = {**series, **self._compared}, settings
        self._system, self._model, self._data = systems[0], systems[0].model, data
        self._systems = systems
        self._motions, self._motion = motions, motions[0]
        self.count = len(motions)
        self.time: Floats = self._motion.time if time is None else time
        self._samples = [Samples(motion.time, self.time) for motion in motions]
        self._lengths = np.array([len(motion.time) for motion in motions])
        self._numbers = Numbers(systems, np.arange(0))
        self._sampled: dict[str, Floats] = {}

    def sampled(self, series: str) -> Floats:
        """The series at the samples, shape (motions, samples)."""
        if series not in self._sampled:
            result = self._series[series]
            if result.variable == TIME:
                values = np.tile(self.time, (self.count, 1))
            elif evaluable(result):
                values = self._at_samples(result)
            elif self._steps(result):
                values = self._stepped(series)[self._samples[0].even][None]
            else:
                assert self._data is not None
                values = self._between_samples(result.of(self._data).to_numpy(), result)[None]
            if series in self._compared:
                values = values - self._ideal_at([series], self.time)[0]
            self._sampled[series] = np.asarray(values, dtype=float)
        return self._sampled[series]

    def _at_samples(self, series: Series) -> Floats:
        """A series that is evaluated, in a few motions at once for lack of memory for all."""
        if self.count == 1:
            values = self._evaluated(self._motion, [series])[0]
            return values[self._samples[0].even][None]
        ((_, course),) = self.pieces
        count, result = len(self.time), []
        every = [
            begin + np.arange(length)[samples.even]
            for begin, length, samples in zip(
                self._begin, self._lengths, self._samples, strict=True
            )
        ]
        step = max(1, _AT_ONCE // count)
        for first in range(0, self.count, step):
            rows = np.concatenate(every[first : first + step])
            numbers = self._numbers_of(first + np.arange(len(rows)) // count)
            motion = Motion(pieces=(course.piece.part(rows),))
            result.append(self._evaluated(motion, [series], numbers)[0])
        return np.concatenate(result).reshape(self.count, count)

    def between(self, series: Sequence[str], which: Whole, places: Floats) -> list[Floats]:
        """Series at places in some of the motions, shape (places,) each."""
        result = self._at(series, which, self._inner(which, places, Samples.inner), places)
        if not self._compared:
            return result
        times = np.interp(places, np.arange(len(self.time)), self.time)
        return self._less_ideal(series, result, times)

    def during(self, series: Sequence[str], which: Whole, times: Floats) -> list[Floats]:
        """Series at times in some of the motions, shape (times,) each."""
        inner, places = self._inner(which, times, Samples.at), places_of(self.time, times)
        return self._less_ideal(series, self._at(series, which, inner, places), times)

    def number(self, path: str) -> Floats:
        """A number of the definition, in SI, shape (motions,)."""
        from linkages.kernel.number_effects import number_value

        return np.array([number_value(one.mechanism, path) for one in self._systems], dtype=float)

    def _inner(
        self, which: Whole, wanted: Floats, of: Callable[[Samples, Floats], Floats]
    ) -> Floats:
        """Places among all samples of the motions that they are in."""
        if self.count == 1:
            return of(self._samples[0], wanted)
        result = np.empty(len(wanted))
        for motion in np.unique(which):
            own = which == motion
            result[own] = of(self._samples[motion], wanted[own])
        return result

    def _less_ideal(self, series: Sequence[str], own: list[Floats], times: Floats) -> list[Floats]:
        """The same, where it is compared less that of the ideal mechanism."""
        names = [name for name in series if name in self._compared]
        other = dict(zip(names, self._ideal_at(names, times) if names else [], strict=True))
        return [v - other[n] if n in other else v for n, v in zip(series, own, strict=True)]

    def _ideal_at(self, series: Sequence[str], times: Floats) -> list[Floats]:
        return self._ideal.during(series, np.zeros(len(times), dtype=int), times)

    @cached_property
    def _ideal(self) -> InterpolatedMotions:
        """The motion of the mechanism without clearances, which comes as far."""
        assert self._settings is not None
        system, plain = System(self._system.mechanism.ideal()), self._settings.plain(self.time)
        motion, time, _ = resolved_motion(system, compute_motion(system, plain), plain, True)
        return InterpolatedMotions([system], [motion], self._compared, time)

    def _steps(self, series: Series) -> bool:
        """Whether a series follows from the samples of the motion and its changes of mode."""
        lost = series.variable in INTEGRATED
        return series.variable in OF_CONTACTS and not (lost and self._motion.losses is None)

    @cached_property
    def intervals(self) -> tuple[Whole, Floats, Floats]:
        """Intervals of a quadrature: numbers of their motions, and where they begin and end."""
        return joined_intervals(self._smooth_intervals(motion) for motion in self._motions)

    def _smooth_intervals(self, motion: Motion) -> tuple[Floats, Floats]:
        system = self._system
        if motion.method:
            begin, end = between_changes(motion)
        else:
            begin, end = evenly(motion.time, fastest(system, float(motion.time[-1])))
        if system.layout.moved:
            return begin, end
        nodes = [n for each in self._series.values() for n in _nodes(each, system)]
        conditions = conditions_with_rates(self._model, nodes)
        if not conditions:
            return begin, end
        return smooth_parts(begin, end, lambda times: self._looked(conditions, times))

    def _looked(self, nodes: list[Scalar], times: Floats) -> Floats:
        """Nodes at some times, shape (nodes, times); nan where no piece of the motion is."""
        result = np.full((len(nodes), len(times)), np.nan)
        for inside, piece in self.within(self._samples[0].at(times)):
            result[:, inside] = evaluate_nodes(piece, nodes)
        return result

    def _at(
        self, series: Sequence[str], which: Whole, inner: Floats, places: Floats
    ) -> list[Floats]:
        """Series at places among all samples of motions, and among those evenly spaced."""
        rows = [k for k, name in enumerate(series) if evaluable(self._series[name])]
        chosen = [self._series[series[k]] for k in rows]
        result = np.empty((len(series), len(places)))
        left = np.ones(len(places), dtype=bool)  # of series that are evaluated
        for begin in range(0, len(places) if rows else 0, _AT_ONCE):
            some = slice(begin, begin + _AT_ONCE)
            for inside, piece in self.within(inner[some], which[some]):
                numbers = self._numbers_of(which[some][inside])
                values = self._evaluated(Motion(pieces=(piece,)), chosen, numbers)
                for k, row in zip(rows, values, strict=True):
                    result[k, begin + inside] = row
                left[begin + inside] = False
        for k, name in enumerate(series):
            open_ = left if k in rows else np.ones_like(left)
            if open_.any():
                result[k, open_] = self._interpolated(name, inner[open_], places[open_])
        return list(result)

    def _numbers_of(self, which: Whole) -> Numbers | None:
        """Parameters of states; the pieces of a single motion have those of their own systems."""
        return None if self.count == 1 else self._numbers.of(which)

    def _evaluated(
        self, motion: Motion, series: Sequence[Series], numbers: Numbers | None = None
    ) -> list[Floats]:
        names = list(dict.fromkeys(each.variable for each in series))
        with np.errstate(over="ignore", invalid="ignore"):
            result = evaluate_outputs(motion, names, partial(compiled_values, numbers=numbers))
        return [each.picked(result, self._model) for each in series]

    def _interpolated(self, name: str, inner: Floats, places: Floats) -> Floats:
        """From values at samples alone."""
        if self._steps(self._series[name]):
            return np.interp(inner, np.arange(len(self._motion.time)), self._stepped(name))
        return through(self.sampled(name)[0], places, smooth(self._series[name]))

    def _stepped(self, name: str) -> Floats:
        """What jumps at changes of mode, at all samples of the motion."""
        from linkages.solution.contact_notes import CONTACT_OUTPUTS

        series = self._series[name]
        result = np.asarray(CONTACT_OUTPUTS[series.variable](self._motion), dtype=float)
        return series.picked({series.variable: result}, self._model)

    def _between_samples(self, values: Floats, series: Series) -> Floats:
        """What the data have, at the samples of the motion that is followed."""
        assert self._data is not None
        given = self._data["time"].to_numpy()
        if np.array_equal(given, self.time):
            return values
        return through(values, places_of(given, self.time), smooth(series))

    @cached_property
    def _begin(self) -> Whole:
        """The first sample of each motion among those of all, shape (motions,)."""
        return np.cumsum(self._lengths) - self._lengths

    @cached_property
    def pieces(self) -> list[tuple[int, InterpolatedPiece]]:
        """Pieces that can be followed, with the number of their first sample in their motions."""
        if self.count > 1:
            own = [InterpolatedPiece.of(motion, motion.pieces[0]) for motion in self._motions]
            return [(0, InterpolatedPiece.joined(own))]
        result, begin = [], 0
        for piece in self._motion.pieces:
            if piece.samples is None and len(piece.time) > 1:
                result.append((begin, InterpolatedPiece.of(self._motion, piece)))
            begin += len(piece.wanted)
        return result

    def within(
        self, places: Floats, which: Whole | None = None
    ) -> Iterator[tuple[NDArray[np.intp], Piece]]:
        """Places among all samples of motions that lie in a piece, and the motions there."""
        which = np.zeros(len(places), dtype=int) if which is None else which
        for begin, course in self.pieces:
            last = (np.minimum(len(course.piece.time), self._lengths - begin) - 1)[which]
            part = places - begin
            inside, own = np.flatnonzero((part >= 0.0) & (part <= last) & (last > 0)), which
            if len(inside) < len(places):
                last, part, own = last[inside], part[inside], which[inside]
            local = np.minimum(part.astype(int), last - 1)
            interval = self._begin[own] + local
            for chosen, piece in course.between(interval, part - local, self._numbers_of(own)):
                yield inside[chosen], piece


def resolves_steps(motion: Motion, samples: int) -> bool:
    """Whether quintic polynomials through so many samples are as good as the steps of a motion."""
    return samples - 1 >= PER_STEP * motion.cost.get("steps", 0)


def factor_of(motion: Motion, samples: int) -> int:
    """How many times as close samples must be for quintic polynomials; a power of two."""
    count = samples - 1
    if count < 1 or not can_be_repeated(motion):
        return 1
    factor = 1
    while not resolves_steps(motion, factor * count + 1) and 2 * factor * count <= MOST_SAMPLES:
        factor *= 2
    return factor


def denser(times: Floats, factor: int) -> Floats:
    """Times with others evenly between them."""
    count = len(times) - 1
    return np.interp(np.arange(count * factor + 1) / factor, np.arange(count + 1), times)


def can_be_repeated(motion: Motion) -> bool:
    """Whether a motion can be computed again at other samples."""
    return not motion.interrupted and motion.cost.get("steps", 0) <= MOST_REPEATED


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
    What drives determine is evaluated at other times, which do not depend on its own samples.
    """
    if not motion.method and len(motion.time) > 1 and can_be_repeated(motion):
        time = looks_of(system, motion)
        again = compute_motion(system, replace(settings, times=time, events=()))
        return Resolved(again, time, settings)
    factor = factor_of(motion, len(motion.time))
    time = times = denser(motion.time, factor)
    if integrated and can_be_repeated(motion):
        times = times_around_modes(motion, time)
    if len(times) > len(motion.time):
        # what is integrated along takes part in the choice of steps: changes stay where they were
        motion = compute_motion(system, replace(settings, times=times, events=()))
    return Resolved(motion, time, settings)


def times_around_modes(motion: Motion, times: Floats) -> Floats:
    """Sample times with both sides of the changes of a motion, and enough between two changes."""
    sides = mode_change_sides(motion)
    if not len(sides):
        return times
    more = times_between_changes(times, sides)
    order = 1 if times[-1] >= times[0] else -1
    return np.unique(np.concatenate([times, sides.ravel(), more]))[::order]


def mode_change_sides(motion: Motion) -> Floats:
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


def times_between_changes(times: Floats, sides: Floats) -> Floats:
    """Further times between changes with few samples: a touch may be as short as a step."""
    stretches = np.concatenate([times[:1], sides.ravel(), times[-1:]]).reshape(-1, 2)
    parts = int(np.clip(_MORE // len(stretches), _FEWEST_PARTS, _PARTS))
    order = 1 if times[-1] >= times[0] else -1
    inside = np.abs(np.diff(np.searchsorted(order * times, order * stretches), axis=1)[:, 0])
    part = np.arange(parts + 1) / parts
    return np.asarray(stretches[inside < parts] @ np.array([1.0 - part, part])).ravel()


def between_changes(motion: Motion) -> tuple[Floats, Floats]:
    """Intervals of a few samples each, of which none has a change of mode in it."""
    from linkages.solution.contact_episodes import unrecorded

    if result := unrecorded(motion):
        message = f"{result}; expected a shorter motion for a mean over time"
        raise ComputationError(message, time=None)
    times, sides = motion.time, mode_change_sides(motion)
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


def smooth_parts(
    begin: Floats, end: Floats, look: Callable[[Floats], Floats]
) -> tuple[Floats, Floats]:
    """Intervals of which those around a change of branch are cut on both sides of it."""
    part = np.arange(_LOOKS) / _LOOKS
    times = np.append((begin[:, None] + part * (end - begin)[:, None]).ravel(), end[-1])
    order = 1 if end[-1] >= begin[0] else -1
    edges = np.concatenate([begin, end[-1:], branch_changes(times, look).ravel()])
    edges = np.unique(edges)[::order]
    return edges[:-1], edges[1:]


def joined_intervals(
    found: Iterable[tuple[Floats, Floats]],
) -> tuple[Whole, Floats, Floats]:
    """Numbers of motions, begins and ends of intervals, from those of each motion."""
    begins, ends = zip(*found, strict=True)
    which = np.repeat(np.arange(len(begins)), [len(begin) for begin in begins])
    return which, np.concatenate(begins), np.concatenate(ends)


def driven_looks(turned: Floats | np.float64) -> Whole:
    """Intervals in which drives are looked at that turn by some angles, at their highest speeds."""
    parts = np.maximum(np.nan_to_num(turned) / _LOOK, LOOKS) / LOOKS
    return LOOKS * 2 ** np.clip(np.ceil(np.log2(parts)), 0, _DOUBLED).astype(int)


def driven_times(system: System, end: float) -> Floats:
    """Times up to `end` that show what a motion does that drives determine."""
    return np.linspace(0.0, end, int(driven_looks(np.abs(end * fastest(system, end)))) + 1)


def looks_of(system: System, motion: Motion) -> Floats:
    """The same from the first to the last sample of a motion."""
    begin, end = (float(each) for each in motion.time[[0, -1]])
    highest = fastest(system, max(begin, end, key=abs))
    count = int(driven_looks(np.abs((end - begin) * highest)))
    return np.linspace(begin, end, count * (_CLOSE if len(motion.pieces) > 1 else 1) + 1)


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


def evaluate_outputs(
    motion: Motion, names: Sequence[str], values: ValuesOf | None = None
) -> Values:
    """Outputs that follow from the motion at one time, reactions of joints among them."""
    result = evaluate_variables(motion, [n for n in names if n not in REACTIONS], values)
    if not {*REACTIONS}.isdisjoint(names):
        from linkages.solution.joint_reactions import reactions

        result |= {name: forces for name, forces in reactions(motion).items() if name in names}
    return {name: result[name] for name in names}


def _nodes(series: Series, system: System) -> list[Scalar]:
    """Nodes that a series is computed from at one time."""
    if not evaluable(series) or series.variable == TIME:
        return []
    if series.variable in REACTIONS:
        from linkages.solution.joint_reactions import reaction_nodes

        return reaction_nodes(system.model)
    return VARIABLES[series.variable].evaluated(system.model)
