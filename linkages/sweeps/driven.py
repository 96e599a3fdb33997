"""Motions that drives determine alone, of many mechanisms at once: nothing is integrated."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.closure.dyads import LEAST_MARGIN
from linkages.kernel.graph.scalars import Scalar, reachable
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.options.run import SimulationOptions
from linkages.solution.moving.limits import GRID_ANGLE, suspicious
from linkages.solution.values.series import TIME, Series

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

AT_ONCE = 8192
"""Values of a node that are computed at once: few enough to stay in the cache."""


def serves(system: System, series: Mapping[str, Series]) -> bool:
    """Whether a motion follows from drives alone, and series from the motion at one time."""
    topology, bodies = system.topology, system.mechanism.bodies
    if topology.coordinates or topology.redundant or not topology.driven:
        return False
    if not all(bodies[name].rotates for name in topology.driven):
        return False
    for each in series.values():
        if each.variable == TIME:
            continue
        variable = VARIABLES[each.variable]
        turned = variable.angle and next(iter(each.place.values())) not in topology.driven
        if variable.whole or turned:
            return False
    evaluated = [each for each in series.values() if each.variable != TIME]
    nodes = [node for each in evaluated for node in _nodes(system, each)]
    return not system.model.evaluator([*_checked(system), *nodes]).switched


class DrivenMotions:
    """Driven motions of many mechanisms of a structure: a source of measures.

    Parameters
    ----------
    system
        Of their structure.
    parameters
        Shape (p, motions).
    time
        Sample times, shape (samples,).
    series
        Name → series that measures name.
    """

    def __init__(
        self, system: System, parameters: Floats, time: Floats, series: Mapping[str, Series]
    ) -> None:
        self._system, self._parameters = system, parameters
        self._time, self._series = time, series
        self._sampled: dict[str, Floats] = {}

    @property
    def count(self) -> int:
        """Number of motions."""
        return self._parameters.shape[1]

    @property
    def time(self) -> Floats:
        """Sample times, shape (samples,)."""
        return self._time

    def sampled(self, series: str) -> Floats:
        """A series at the samples, shape (motions, samples)."""
        if series not in self._sampled:
            shape = self.count, len(self._time)
            if self._series[series].variable == TIME:
                self._sampled[series] = np.broadcast_to(self._time, shape)
                return self._sampled[series]
            nodes = _nodes(self._system, self._series[series])
            found = evaluated(self._system, nodes, self._parameters, self._time)
            self._sampled[series] = self._picked(series, found.reshape(len(nodes), -1))
            self._sampled[series] = self._sampled[series].reshape(shape)
        return self._sampled[series]

    def between(self, series: Sequence[str], which: Whole, places: Floats) -> list[Floats]:
        """Series anywhere in some of the motions, shape (places,) each."""
        interval = np.minimum(places.astype(int), len(self._time) - 2)
        step = self._time[interval + 1] - self._time[interval]
        times = self._time[interval] + (places - interval) * step
        nodes: list[Scalar] = []
        spans: dict[str, slice] = {}
        for name in series:
            if self._series[name].variable == TIME:
                continue
            own = _nodes(self._system, self._series[name])
            spans[name] = slice(len(nodes), len(nodes) + len(own))
            nodes += own
        values = np.empty((len(nodes), len(places)))
        for start in range(0, len(places), AT_ONCE):
            part = slice(start, start + AT_ONCE)
            inputs = self._parameters[:, which[part]], times[None, part]
            values[:, part] = _evaluated(self._system, nodes, *inputs)
        return [
            self._picked(name, values[spans[name]]) if name in spans else times for name in series
        ]

    def _picked(self, name: str, rows: Floats) -> Floats:
        """The series out of values of its nodes."""
        series = self._series[name]
        reduced = VARIABLES[series.variable].reduced
        if reduced is None:
            return rows[0]
        return reduced(rows)[series.index(self._system.model)]


def _nodes(system: System, series: Series) -> list[Scalar]:
    """What a series is computed from: its own node, or all of a variable that reduces them."""
    if VARIABLES[series.variable].reduced is None:
        return [series.node(system.model)]
    return VARIABLES[series.variable].evaluated(system.model)


def _checked(system: System) -> list[Scalar]:
    """What must be finite for a motion to go on."""
    model = system.model
    laws = [n for w in model.positions.laws.values() for n in (w.value, w.rate, w.acceleration)]
    return [*laws, *(n for load in model.loads for n in (*load.given, *load.doubtful[:1]))]


def undisturbed(
    system: System, parameters: Floats, scales: Floats, run: SimulationOptions
) -> NDArray[np.bool_]:
    """Which driven motions go on to their end without any doubt, shape (motions,).

    The others may stop, or pass change points: they are followed one by one.

    Parameters
    ----------
    system
        Of their structure.
    parameters, scales
        Of the motions, shape (p, motions), and sizes of their margins, (blocks, motions).
    run
        How long, and with how many samples.
    """
    model, count = system.model, parameters.shape[1]
    times = np.linspace(0.0, run.end, run.samples)
    turned = abs(run.end) * _fastest(system, parameters, run.end) / GRID_ANGLE
    if not turned <= min(run.most_steps, AT_ONCE * 8):
        return np.zeros(count, dtype=bool)
    if turned > len(times):
        grid = np.linspace(0.0, run.end, math.ceil(turned) + 1)
        times = np.unique(np.concatenate([times, grid]))[:: -1 if run.end < 0 else 1]
    radicands = [reach.radicand for reach in model.reaches]
    margins, rates = [*model.margins], [*model.margin_rates]
    finite = _checked(system)
    nodes = [*radicands, *margins, *rates, *finite]
    found = np.zeros(count, dtype=bool)
    for part in _blocks(count, len(times)):
        values = evaluated(system, nodes, parameters[:, part], times)
        ends = np.cumsum([len(radicands), len(margins), len(rates)])
        reach, margin, rate, other = np.split(values, ends)
        margin, rate = margin / scales[:, part, None], rate / scales[:, part, None]
        with np.errstate(invalid="ignore"):
            sound = (reach >= 0.0).all(axis=(0, 2)) & np.isfinite(other).all(axis=(0, 2))
            sound &= (np.abs(margin) >= LEAST_MARGIN).all(axis=(0, 2))
            if len(margin):
                sound &= ~suspicious(times, margin, rate).any(axis=-1)
        found[part] = sound
    return found


def evaluated(system: System, nodes: Sequence[Scalar], parameters: Floats, times: Floats) -> Floats:
    """Values of nodes of all motions at all times, shape (nodes, motions, times)."""
    found = np.empty((len(nodes), parameters.shape[1], len(times)))
    for part in _blocks(parameters.shape[1], len(times)):
        found[:, part] = _evaluated(system, nodes, parameters[:, part, None], times[None, None, :])
    return found


def _blocks(count: int, samples: int) -> list[slice]:
    size = max(1, AT_ONCE // samples)
    return [slice(start, min(start + size, count)) for start in range(0, count, size)]


def _evaluated(
    system: System, nodes: Sequence[Scalar], parameters: Floats, times: Floats
) -> Floats:
    nothing = np.zeros((0, *np.broadcast_shapes(parameters.shape[1:], times.shape[1:])))
    values = system.model.evaluator(nodes)(t=times, y=nothing, a=nothing, p=parameters)
    found = np.empty((len(nodes), *nothing.shape[1:]))
    for row, value in zip(found, values, strict=True):
        row[...] = value
    return found


def _fastest(system: System, parameters: Floats, end: float) -> float:
    """Highest speed of a drive of any motion."""
    nodes = [system.model.known_rates[name] for name in system.topology.driven]
    inputs = {node.arguments[0] for node in reachable(nodes) if node.operation == "input"}
    times = np.linspace(0.0, end, 20001) if "t" in inputs else np.zeros(1)
    largest = 0.0
    for part in _blocks(parameters.shape[1], len(times)):
        values = np.abs(evaluated(system, nodes, parameters[:, part], times))
        largest = max(largest, float(values.max(initial=0.0)))
    return largest
