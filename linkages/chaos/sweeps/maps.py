"""Maps: an indicator of chaos over two parameters, or over a plane of initial states."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from linkages.chaos.growth.exponents import Exponents, lyapunov_spectrum
from linkages.chaos.growth.indicators import CHAOTIC_POWER, fast_indicators
from linkages.chaos.growth.lyapunov import characteristic_period
from linkages.chaos.growth.tangents import LinkageTangents
from linkages.chaos.sections.contact_log import ContactLog, check_interval
from linkages.chaos.sections.free_states import require_free
from linkages.chaos.sweeps.map_data import MapPoint, map_data
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import Interrupted
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.options.exponents import MapKeywords, MapOptions
from linkages.options.signature import takes
from linkages.solution.moving.plan import Plan
from linkages.solution.options import options_of
from linkages.sweeps.axes import (
    Axis,
    Vary,
    axis_of,
    coordinates,
    first_possible,
    require_different,
)
from linkages.sweeps.running import Executor, Progress, per_period, sweep

if TYPE_CHECKING:
    import xarray as xr

BEYOND = 3.0
"""Standard errors beyond which an exponent differs from zero."""

PARTS = 16
"""Intervals within a period."""

ONE_SENSE = 0.9
"""Net angle of a rotation, in units of all that it turned."""


@dataclass(frozen=True)
class _Request:
    varying: Varying
    x: Axis
    y: Axis
    given: Mapping[str, Any]

    @cached_property
    def options(self) -> MapOptions:
        """What is asked for where nothing is varied."""
        return self.options_at(self.varying.mechanism)

    def options_at(self, mechanism: Mechanism) -> MapOptions:
        """The same at a point, in the steps that it may take."""
        options = options_of(MapOptions, mechanism, self.given)
        return per_period(options, options.periods)

    def system(self, point: tuple[int, int]) -> System:
        """The mechanism at a column and a row, assembled."""
        column, row = point
        return self.varying.at({**self.x.at(column), **self.y.at(row)})

    @property
    def tangents(self) -> int:
        """How many tangents the indicator needs."""
        return 2 if self.options.indicator == "gali" else 1

    def compute(self, point: tuple[int, int]) -> MapPoint:
        """The indicator, what every free angle does, and forces in clearances."""
        system = self.system(point)
        options, count = self.options_at(system.mechanism), self.tangents
        looked = check_interval(system)
        log = None if looked is None else ContactLog(looked)
        tangents = LinkageTangents(system, count, options, log=log)
        intervals = options.periods * PARTS
        interval = characteristic_period(system.mechanism) / PARTS
        error, told = math.nan, 0
        if options.indicator == "exponent":
            exponents = lyapunov_spectrum(tangents, intervals=intervals, interval=interval, count=1)
            value, error = float(exponents.values[0]), float(exponents.errors[0])
            told = sign_of(exponents)
        else:
            series = fast_indicators(tangents, intervals=intervals, interval=interval, count=count)
            value = float((series.fli if options.indicator == "fli" else series.gali)[-1])
        contacts = () if log is None else log.contacts
        return MapPoint(value, error, told, kinds(tangents), contacts, looked or 0.0)

    @property
    def attributes(self) -> dict[str, Any]:
        """What was asked for, as attributes of a dataset."""
        run, mechanism = self.options, self.varying.mechanism
        return {
            "name": mechanism.name,
            "source": mechanism.source,
            "kind": run.indicator,
            "x": self.x.label,
            "y": self.y.label,
            "periods": run.periods,
            **run.how,
            "max_steps": run.most_steps,
        }


def sign_of(exponents: Exponents) -> int:
    """The sign of the largest exponent; 0 where it cannot be told from zero.

    It differs from zero if it exceeds three standard errors, and if the logarithm of the tangent's
    length changes by more than that of a power of time while time doubles: regular motions have
    such tangents, and finite-time exponents that are positive but fall to zero.
    """
    growth = exponents.growth[:, 0] * np.diff(exponents.times)
    doubling = float(growth[len(growth) // 2 :].sum()) / math.log(2.0)
    value, error = exponents.values[0], exponents.errors[0]
    if abs(value) <= BEYOND * error or abs(doubling) <= CHAOTIC_POWER or doubling * value < 0:
        return 0
    return 1 if value > 0 else -1


def kinds(tangents: LinkageTangents) -> dict[str, str]:
    """Free angle → swing (less than a turn in all), rotation (nearly one sense) or mixed."""
    places = tangents.turned
    moved = np.abs(np.diff(places, axis=0)).sum(axis=0)
    net, extent = np.abs(places[-1] - places[0]), np.ptp(places, axis=0)
    found = {}
    for index, name in enumerate(tangents.system.topology.free):
        if tangents.angles[index]:
            turning = "rotation" if net[index] >= ONE_SENSE * moved[index] else "mixed"
            found[name] = "swing" if extent[index] < 2 * np.pi else turning
    return found


@takes(MapOptions)
def chaos_map(
    mechanism: Mechanism,
    x: Vary,
    y: Vary,
    *,
    executor: Executor | None = None,
    watch: Callable[[Progress], None] | None = None,
    **options: Unpack[MapKeywords],
) -> xr.Dataset:
    """An indicator of chaos over a grid: of two parameters, or of an initial state.

    Parameters
    ----------
    mechanism
        From a file or made in Python.
    x, y
        As `linkages.bifurcation` takes what is varied: two parameters, or ``clearances.r1.angle``
        and ``clearances.r1.speed`` for the plane of initial states.
    executor, watch
        As `linkages.bifurcation` takes them.
    options
        As `MapOptions` describes them.

    Returns
    -------
    Dataset with `indicator` (y, x), `rotation` (y, x, coordinate): what each free angle does, and
    `reason` (y, x) where nothing could be computed, with the `stop_time` (y, x) of the motion.
    Exponents have a standard `error` (y, x) and a `sign` (y, x): 1 or −1, or 0 where they cannot be
    told from zero. What is varied is a coordinate, in the unit of its attribute ``units``. With
    clearances, `contact_lost` and `least_force` (y, x, clearance) as `linkages.poincare` has them.

    Raises
    ------
    InputError
        If a path names nothing or nothing is free.
    ValueError, TypeError
        For arguments that make no sense.
    Interrupted
        After Ctrl-C; ``kept["map"]`` has the points so far.
    """
    axes = axis_of(x), axis_of(y)
    request = _Request(Varying(mechanism), *axes, options)
    indicator = request.options.indicator
    require_different(axes)
    points = [(column, row) for row in range(len(request.y)) for column in range(len(request.x))]
    first = first_possible(request.system, points)  # what is wrong everywhere shows here
    require_free(first)
    Plan.of(first, tangents=request.tangents).bind(first)  # compiled here, once
    swept = sweep(request.compute, points, executor=executor, watch=watch)
    shape = len(request.y), len(request.x)
    varied_along = {
        **coordinates(mechanism, request.x, "x"),
        **coordinates(mechanism, request.y, "y"),
    }
    attributes = {**request.attributes, "interrupted": int(swept.interrupted)}
    data = map_data(first, swept, shape, indicator, varied_along, attributes)
    if swept.interrupted:
        done = sum(outcome is not None for outcome in swept.outcomes)
        message = f"interrupted after {done} of {len(points)} points"
        raise Interrupted(message, kept={"map": data})
    return data
