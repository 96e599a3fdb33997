"""Driven motions of many mechanisms at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.dyads import LEAST_MARGIN
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.scalars import Scalar, reachable
from linkages.kernel.system import System
from linkages.options.run import SimulationOptions
from linkages.solution.driven import turned_by
from linkages.solution.driven_limits import GRID_ANGLE, may_vanish
from linkages.solution.interpolated import (
    Samples,
    driven_looks,
    evenly,
    joined_intervals,
    smooth_parts,
)
from linkages.solution.interpolation import conditions_with_rates
from linkages.solution.series import TIME, Series

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

AT_ONCE = 16384
"""Values of a node that are computed at once: few enough to stay in the cache."""


def serves(system: System, series: Mapping[str, Series]) -> bool:
    """Whether a motion follows from drives alone, and series from the motion at one time."""
    topology, bodies = system.topology, system.mechanism.bodies
    if topology.coordinates or topology.redundant or not topology.driven:
        return False
    if not all(bodies[name].rotates for name in topology.driven):
        return False
    if any(each.variable != TIME and VARIABLES[each.variable].whole for each in series.values()):
        return False
    nodes = [*_checked(system), *_Wanted(system, series).nodes]
    return not system.model.evaluator(nodes).switched


class _Wanted:
    """Nodes of which series consist, evaluated side by side."""

    def __init__(self, system: System, series: Mapping[str, Series]) -> None:
        self._model, self._series = system.model, series
        self.nodes: list[Scalar] = []
        self._spans: dict[str, slice] = {}
        for name, each in series.items():
            own = [] if each.variable == TIME else _nodes(system, each)
            self._spans[name] = slice(len(self.nodes), len(self.nodes) + len(own))
            self.nodes += own

    def of(self, values: Floats, times: Floats) -> dict[str, Floats]:
        """Name → series, angles within one turn, from values of shape (nodes, …)."""
        result = {}
        for name, each in self._series.items():
            rows = values[self._spans[name]]
            if each.variable == TIME:
                result[name] = np.broadcast_to(times, values.shape[1:])
            elif (reduced := VARIABLES[each.variable].reduced) is None:
                result[name] = rows[0]
            else:
                flat = reduced(rows.reshape(len(rows), -1))[each.index(self._model)]
                result[name] = flat.reshape(rows.shape[1:])
        return result


def _turning(system: System, series: Mapping[str, Series]) -> dict[str, Scalar]:
    """Angles whose whole turns are counted, and the nodes of their rates."""
    bodies = {name: next(iter(each.place.values())) for name, each in series.items() if each.angle}
    counted = system.topology.counted
    turning = system.model.velocities.turning
    return {name: turning(body) for name, body in bodies.items() if body in counted}


def _nodes(system: System, series: Series) -> list[Scalar]:
    """Its own node, or all of a variable that reduces them."""
    if VARIABLES[series.variable].reduced is None:
        return [series.node(system.model)]
    return VARIABLES[series.variable].evaluated(system.model)


class DrivenMotions:
    """Driven motions of many mechanisms of a structure: a source of measures.

    `parameters` has shape (p, motions), each `sampled` series (motions, samples), `highest` is the
    speed of the fastest drive in rad/s, shape (motions,).
    """

    def __init__(
        self,
        system: System,
        parameters: Floats,
        time: Floats,
        series: Mapping[str, Series],
        sampled: Mapping[str, Floats],
        highest: Floats,
    ) -> None:
        self._system, self._parameters = system, _Parameters(parameters)
        self._series, self._sampled = series, sampled
        self.count, self.time = parameters.shape[1], time
        self._highest = highest
        # Path of a number of the definition → its values, shape (motions,)
        self.numbers: Callable[[str], Floats] | None = None

    def number(self, path: str) -> Floats:
        """A number of the definition, in SI, shape (motions,)."""
        assert self.numbers is not None
        return self.numbers(path)

    def sampled(self, series: str) -> Floats:
        """A series at the samples, shape (motions, samples)."""
        return self._sampled[series]

    def between(self, series: Sequence[str], which: Whole, places: Floats) -> list[Floats]:
        """Series anywhere in some of the motions, shape (places,) each."""
        interval = np.minimum(places.astype(int), len(self.time) - 2)
        step = self.time[interval + 1] - self.time[interval]
        times = self.time[interval] + (places - interval) * step
        wanted = _Wanted(self._system, {name: self._series[name] for name in series})
        result = {name: np.empty(len(places)) for name in series}
        for start in range(0, len(places), AT_ONCE):
            part = slice(start, start + AT_ONCE)
            values = _evaluated(
                self._system, wanted.nodes, self._parameters.of(which[part]), times[part]
            )
            for name, row in wanted.of(values, times[part]).items():
                result[name][part] = row
        for name in _turning(self._system, {name: self._series[name] for name in series}):
            begin, end = (self._sampled[name][which, at] for at in (interval, interval + 1))
            result[name] += _whole(begin + (places - interval) * (end - begin) - result[name])
        return [result[name] for name in series]

    def during(self, series: Sequence[str], which: Whole, times: Floats) -> list[Floats]:
        """Series at times in some of the motions, shape (times,) each."""
        return self.between(series, which, Samples(self.time, self.time).at(times))

    @cached_property
    def intervals(self) -> tuple[Whole, Floats, Floats]:
        """Intervals of a quadrature: numbers of their motions, and where they begin and end."""
        result = [evenly(self.time, highest) for highest in self._highest.tolist()]
        conditions = conditions_with_rates(
            self._system.model, _Wanted(self._system, self._series).nodes
        )
        for motion, (begin, end) in enumerate(result) if conditions else ():
            own = self._parameters.of(slice(motion, motion + 1))

            def look(times: Floats, own: list[Floats] = own) -> Floats:
                return _evaluated(self._system, conditions, own, times)

            result[motion] = smooth_parts(begin, end, look)
        return joined_intervals(result)


def values_at(
    system: System, series: Mapping[str, Series], parameters: Floats, times: Floats
) -> dict[str, Floats]:
    """Name → series at times of motions, shape (motions, times), angles within one turn."""
    wanted = _Wanted(system, series)
    result = {name: np.empty(times.shape) for name in series}
    rows = _Parameters(parameters[:, :, None])
    for part in _blocks(*times.shape):
        values = _evaluated(system, wanted.nodes, rows.of(part), times[part])
        for name, row in wanted.of(values, times[part]).items():
            result[name][part] = row
    return result


class _Parameters:
    """Parameters of many motions, shape (p, motions); those that all share are stored once.

    What follows from these and from time alone is therefore computed once for all motions.
    """

    def __init__(self, values: Floats) -> None:
        bits = values.view(np.int64)
        shared = (bits == bits[:, :1]).all(axis=1)
        self._rows = [row[:1] if one else row for row, one in zip(values, shared, strict=True)]

    def of(self, which: Whole | slice) -> list[Floats]:
        """Those of some motions, of shape (motions,) or (1,) each."""
        return [row if len(row) == 1 else row[which] for row in self._rows]


def _checked(system: System) -> list[Scalar]:
    """What must be finite for a motion to go on."""
    model = system.model
    laws = [n for w in model.positions.laws.values() for n in (w.value, w.rate, w.acceleration)]
    return [*laws, *(n for load in model.loads for n in (*load.given, *load.doubtful[:1]))]


def complete_motions(
    system: System,
    parameters: Floats,
    scales: Floats,
    run: SimulationOptions,
    series: Mapping[str, Series],
) -> Iterator[tuple[Whole, DrivenMotions]]:
    """Driven motions that certainly go on to their end, and which they are, shape (motions,).

    The others may stop, or pass change points: they are computed one by one. `scales` are sizes of
    margins, shape (blocks, motions). Motions that are looked at equally often come together.
    """
    highest = _fastest(system, parameters, run.end)
    turned = abs(run.end) * highest
    looks = np.where(turned <= run.most_steps * GRID_ANGLE, driven_looks(turned), 0)
    for many in np.unique(looks[looks > 0]).tolist():
        own = np.flatnonzero(looks == many)
        times = np.linspace(0.0, run.end, many + 1)
        sound, motions = _complete(
            system, parameters[:, own], scales[:, own], times, series, highest[own]
        )
        if sound.any():
            yield own[sound], motions


def _complete(
    system: System,
    parameters: Floats,
    scales: Floats,
    times: Floats,
    series: Mapping[str, Series],
    highest: Floats,
) -> tuple[NDArray[np.bool_], DrivenMotions]:
    """Which of some motions go on to the last of some times, and these."""
    model, count = system.model, parameters.shape[1]
    sound = np.zeros(count, dtype=bool)
    rows = {name: np.empty((count, len(times))) for name in series}
    radicands = [reach.radicand for reach in model.reaches]
    margins, rates, finite = model.margins, model.margin_rates, _checked(system)
    wanted = _Wanted(system, series)
    turning = _turning(system, series)
    nodes = [*radicands, *margins, *rates, *finite, *turning.values(), *wanted.nodes]
    ends = np.cumsum([len(part) for part in (radicands, margins, rates, finite, turning)])
    split = _Parameters(parameters[:, :, None])
    for part in _blocks(count, len(times)):
        result = _evaluated(system, nodes, split.of(part), times[None])
        # motions that do not differ at all are evaluated as one
        shape = len(nodes), len(range(count)[part]), len(times)
        values = np.broadcast_to(result, shape)
        reach, margin, rate, other, speeds, asked = np.split(values, ends)
        relative = margin / scales[:, part, None], rate / scales[:, part, None]
        sound[part] = _goes_on(times, reach, *relative, other)
        series_rows = wanted.of(asked, times)
        for name, speed in zip(turning, speeds, strict=True):
            series_rows[name], sure = _counted(series_rows[name], speed, times)
            sound[part] &= sure
        for name, row in series_rows.items():
            rows[name][part] = row
    kept = rows if sound.all() else {name: row[sound] for name, row in rows.items()}
    return sound, DrivenMotions(system, parameters[:, sound], times, series, kept, highest[sound])


def _goes_on(
    times: Floats, radicands: Floats, margins: Floats, rates: Floats, finite: Floats
) -> NDArray[np.bool_]:
    """Where nothing is in doubt, shape (motions,); the others have (…, motions, times)."""
    with np.errstate(invalid="ignore"):
        good = (radicands >= 0.0).all(axis=(0, 2)) & np.isfinite(finite).all(axis=(0, 2))
        least = np.abs(margins).min(axis=2, initial=np.inf)
        good &= (least >= LEAST_MARGIN).all(axis=0)
        # by no more can a margin change within an interval, as `may_vanish` has it
        most = (
            1.1 * np.abs(np.diff(times)).max(initial=0.0) * np.abs(rates).max(axis=2, initial=0.0)
        )
        doubtful = good & ~(least > most).all(axis=0)
        if doubtful.any():
            headed = may_vanish(times, margins[:, doubtful], rates[:, doubtful])
            good[doubtful] = ~headed.any(axis=-1)
    return np.asarray(good)


def _counted(angles: Floats, speeds: Floats, times: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Angles with all their turns, shape (motions, times), and where these are beyond doubt."""
    turned = np.stack([angles[:, :-1], angles[:, 1:]])
    rates = np.stack([speeds[:, :-1], speeds[:, 1:]])
    change, sure = turned_by(turned, rates, np.diff(times))
    reached = angles[:, :1] + np.cumsum(np.insert(change, 0, 0.0, axis=1), axis=1)
    return angles + _whole(reached - angles), np.asarray(sure.all(axis=1))


def _whole(angles: Floats) -> Floats:
    """The nearest whole turns."""
    return np.asarray(2 * np.pi * np.round(angles / (2 * np.pi)))


def _blocks(count: int, samples: int) -> list[slice]:
    """Motions that are evaluated at once; none without samples."""
    size = max(1, AT_ONCE // max(1, samples))
    return [slice(start, start + size) for start in range(0, count if samples else 0, size)]


def _evaluated(
    system: System, nodes: Sequence[Scalar], parameters: Sequence[Floats], times: Floats
) -> Floats:
    """Values of nodes, shape (nodes, …), from parameters and times that broadcast to that."""
    shape = np.broadcast_shapes(*(row.shape for row in parameters), times.shape)
    nothing = np.zeros((0, *shape))
    values = system.model.evaluator(nodes)(t=times[None], y=nothing, a=nothing, p=parameters)
    result = np.empty((len(nodes), *shape))
    for row, value in zip(result, values, strict=True):
        row[...] = value
    return result


def _fastest(system: System, parameters: Floats, end: float) -> Floats:
    """Highest speed of a drive, shape (motions,)."""
    nodes = [system.model.known_rates[name] for name in system.topology.driven]
    inputs = {node.arguments[0] for node in reachable(nodes) if node.operation == "input"}
    times = np.linspace(0.0, end, 20001) if "t" in inputs else np.zeros(1)
    largest, rows = np.zeros(parameters.shape[1]), _Parameters(parameters[:, :, None])
    for part in _blocks(parameters.shape[1], len(times)):
        values = np.abs(_evaluated(system, nodes, rows.of(part), times[None]))
        largest[part] = values.max(axis=(0, 2), initial=0.0)
    return largest
