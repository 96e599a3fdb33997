"""Maps: an indicator of chaos over two parameters, or over a plane of initial states."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.chaos.contact_log import ContactLog, check_interval
from linkages.chaos.exponents import Exponents, lyapunov_spectrum
from linkages.chaos.free_states import require_free
from linkages.chaos.indicators import CHAOTIC_POWER, fast_indicators
from linkages.chaos.lyapunov import characteristic_period
from linkages.chaos.map_data import INDICATORS, MapPoint, map_data
from linkages.chaos.section import how, section_settings
from linkages.chaos.sweep import STEPS_PER_PERIOD, Executor, Progress, sweep
from linkages.chaos.tangents import LinkageTangents
from linkages.chaos.varied import (
    Axis,
    Vary,
    axis_of,
    coordinates,
    first_possible,
    require_different,
)
from linkages.components.mechanism import Mechanism
from linkages.errors import Interrupted
from linkages.kernel.system import System
from linkages.solution.arguments import whole_number
from linkages.solution.flows import Flows
from linkages.solution.motion import Settings

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
    mechanism: Mechanism
    x: Axis
    y: Axis
    indicator: str
    periods: int
    method: str | None
    rtol: float | None
    max_steps: int | None

    def at(self, point: tuple[int, int]) -> Mechanism:
        """The mechanism at a column and a row."""
        column, row = point
        return self.mechanism.with_values({**self.x.at(column), **self.y.at(row)})

    @property
    def tangents(self) -> int:
        """How many tangents the indicator needs."""
        return 2 if self.indicator == "gali" else 1

    def system(self, point: tuple[int, int]) -> System:
        """The same, assembled."""
        return System(self.at(point))

    def compute(self, point: tuple[int, int]) -> MapPoint:
        """The indicator, what every free angle does, and forces in clearances."""
        mechanism = self.at(point)
        settings = self.settings(mechanism)
        count = self.tangents
        system = System(mechanism)
        looked = check_interval(system)
        log = None if looked is None else ContactLog(system, looked)
        tangents = _Followed(
            system,
            count,
            settings.method,
            settings.rtol,
            settings.atol,
            settings.step,
            settings.max_steps,
            log=log,
        )
        intervals = self.periods * PARTS
        interval = characteristic_period(mechanism) / PARTS
        error, told = math.nan, 0
        if self.indicator == "exponent":
            exponents = lyapunov_spectrum(tangents, intervals=intervals, interval=interval, count=1)
            value, error = float(exponents.values[0]), float(exponents.errors[0])
            told = sign_of(exponents)
        else:
            series = fast_indicators(tangents, intervals=intervals, interval=interval, count=count)
            value = float((series.fli if self.indicator == "fli" else series.gali)[-1])
        contacts = () if log is None else log.contacts
        return MapPoint(value, error, told, tangents.kinds(), contacts, looked or 0.0)

    @property
    def attributes(self) -> dict[str, Any]:
        """What was asked for, as attributes of a dataset."""
        settings = self.settings(self.mechanism)
        return {
            "name": self.mechanism.name,
            "source": self.mechanism.source,
            "kind": self.indicator,
            "x": self.x.label,
            "y": self.y.label,
            "periods": self.periods,
            **how(settings),
            "max_steps": settings.max_steps,
        }

    def settings(self, mechanism: Mechanism) -> Settings:
        """How a point is integrated."""
        steps = STEPS_PER_PERIOD * self.periods if self.max_steps is None else self.max_steps
        return section_settings(mechanism, self.method, self.rtol, steps)


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


class _Followed(LinkageTangents):
    """Tangents that remember where free angles were."""

    def __init__(self, *arguments: Any, **given: Any) -> None:
        super().__init__(*arguments, **given)
        self._places = [self.unwrapped]

    def advance(self, interval: float) -> None:
        """Integrate, and note where angles are."""
        super().advance(interval)
        self._places.append(self.unwrapped)

    def kinds(self) -> dict[str, str]:
        """Free angle → swing (less than a turn in all), rotation (nearly one sense) or mixed."""
        places = np.array(self._places)
        moved = np.abs(np.diff(places, axis=0)).sum(axis=0)
        net, extent = np.abs(places[-1] - places[0]), np.ptp(places, axis=0)
        found = {}
        for index, name in enumerate(self.system.topology.free):
            if self.angles[index]:
                turning = "rotation" if net[index] >= ONE_SENSE * moved[index] else "mixed"
                found[name] = "swing" if extent[index] < 2 * np.pi else turning
        return found


def chaos_map(
    mechanism: Mechanism,
    x: Vary,
    y: Vary,
    *,
    indicator: str = "exponent",
    periods: int = 100,
    method: str | None = None,
    rtol: float | None = None,
    max_steps: int | None = None,
    executor: Executor | None = None,
    watch: Callable[[Progress], None] | None = None,
) -> xr.Dataset:
    """An indicator of chaos over a grid: of two parameters, or of an initial state.

    Parameters
    ----------
    mechanism
        From a file or made in Python.
    x, y
        As `linkages.bifurcation` takes what is varied: two parameters, or ``clearances.r1.angle``
        and ``clearances.r1.speed`` for the plane of initial states.
    indicator
        ``"exponent"`` (1/s), ``"fli"`` (grows in proportion to time where motion is chaotic) or
        ``"gali"`` (shrinks to zero there, for motions that conserve energy).
    periods
        Length of each run.
    method, rtol
        As `linkages.simulate` takes them.
    max_steps
        Steps of the integration that a point may take; one that needs more is left out, with this
        as its reason. 100,000 for each period if not given.
    executor, watch
        As `linkages.bifurcation` takes them.

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
    if indicator not in INDICATORS:
        raise ValueError(f"indicator must be one of {', '.join(INDICATORS)}, found {indicator!r}")
    periods = whole_number("periods", periods)
    max_steps = None if max_steps is None else whole_number("max_steps", max_steps)
    if periods < 4:
        raise ValueError(f"a map needs at least 4 periods, found {periods}")
    axes = axis_of(x), axis_of(y)
    request = _Request(mechanism, *axes, indicator, periods, method, rtol, max_steps)
    require_different(axes)
    points = [(column, row) for row in range(len(request.y)) for column in range(len(request.x))]
    first = first_possible(request.system, points)  # what is wrong everywhere shows here
    require_free(first)
    Flows(first, tangents=request.tangents).flow()  # compiled here, once
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
