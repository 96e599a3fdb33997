"""Maps of an indicator of chaos over two parameters or initial states."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Unpack

import numpy as np

from linkages.chaos.contact_log import ContactLog
from linkages.chaos.deviation_vectors import LinkageTangents
from linkages.chaos.diagram import free_angles, map_data, map_fields, touchable
from linkages.chaos.exponents import BEYOND, Exponents, lyapunov_spectrum, start_tangents
from linkages.chaos.free_states import require_free
from linkages.chaos.indicators import CHAOTIC_POWER, fast_indicators
from linkages.chaos.isoperiodic import Integers, MapQuestion, Plane, computed_plane, plane_data
from linkages.chaos.lyapunov import Grown, characteristic_period, grow_together
from linkages.chaos.periods import Kind
from linkages.chaos.sections import stroboscopic_period
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.outputs import links
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.options.analysis_options import MapKeywords, MapOptions
from linkages.options.option import OptionError, takes
from linkages.solution.many import cpu_only
from linkages.solution.plan import Plan
from linkages.sweeps.axes import Vary, axis_of, coordinates, require_different, require_feasible
from linkages.sweeps.engine import (
    Answer,
    Computed,
    Field,
    Watch,
    attempted,
    begun,
    end_when_stopping,
)
from linkages.sweeps.places import swept
from linkages.sweeps.points import Points
from linkages.sweeps.running import Executor

if TYPE_CHECKING:
    import xarray as xr

PARTS = 16
"""Intervals within a period."""

ONE_SENSE = 0.9
"""Net angle of a rotation, in units of all that it turned."""

UNSEEN = "forces in massless links were not looked at: other indicators do that"


class _Begun(NamedTuple):
    """A point before it moves: its tangents, a period in seconds, and what looks at forces."""

    tangents: LinkageTangents
    period: float
    log: ContactLog | None


@dataclass(frozen=True, eq=False)
class _Mapped(MapQuestion):
    """An indicator of chaos."""

    @cached_property
    def fields(self) -> Mapping[str, Field]:
        """The indicator, what free angles do, forces in clearances."""
        return map_fields(self.first)

    @property
    def tangents(self) -> int:
        """How many tangents the indicator needs."""
        return 2 if self.options.indicator == "gali" else 1

    @property
    def cpu_only(self) -> str:
        """What of it is computed on the CPU only."""
        return cpu_only(self.first, self.options, self.tangents)

    def answers(self, first: int, last: int) -> list[Answer]:
        """What is found at some points."""
        _ = self.first  # all points are built upon the same one, wherever they are computed
        along = self.varying.along(self.points.overrides(first, last))
        made, result = begun(along, lambda _, system: self._begun(system))
        grown = grow_together(
            [each.tangents for each in made.values()],
            self.options.periods * PARTS,
            [each.period / PARTS for each in made.values()],
            orthogonal=self.options.indicator == "exponent",
            skip=self.options.skip * PARTS,
            watch=end_when_stopping,
        )
        for (place, each), motion in zip(made.items(), grown, strict=True):
            result[place] = attempted(partial(self._judged, each, motion))
        return [result[place] for place in range(len(along))]

    def _begun(self, system: System) -> _Begun:
        """A mechanism with its tangents, before it moves."""
        log = ContactLog.of(system)
        period = characteristic_period(system.mechanism)
        if log is not None:
            log.restart(since=system.time + self.options.skip * period)
        options = self.options_at(system.mechanism)
        tangents = LinkageTangents(system, self.tangents, options, log=log)
        start_tangents(tangents, self.tangents)
        return _Begun(tangents, period, log)

    def _judged(self, begun: _Begun, grown: Grown) -> Answer:
        """The indicator, what every free angle does, and forces in clearances."""
        system, log, skip = begun.tangents.system, begun.log, self.options.skip * PARTS
        steps = self.options.periods * PARTS, begun.period / PARTS
        error, told = math.nan, 0
        if self.options.indicator == "exponent":
            exponents = lyapunov_spectrum(
                grown, intervals=steps[0], interval=steps[1], count=1, skip=skip
            )
            value, error = exponents.largest
            told = sign_of(exponents)
        else:
            deque(grown.grow(skip, steps[1]), maxlen=0)
            series = fast_indicators(
                grown, intervals=steps[0], interval=steps[1], count=self.tangents
            )
            value = float((series.fli if self.options.indicator == "fli" else series.gali)[-1])
        contacts = () if log is None else log.contacts
        looked = 0.0 if log is None else log.interval
        result: dict[str, Any] = {"indicator": value, "error": error}
        result |= {"sign": told, "interval": looked}
        if names := touchable(system):
            counts = begun.tangents.touches(system.time + self.options.skip * begun.period)
            result["touches"] = [counts.get(name, 0) / self.options.periods for name in names]
        result |= free_angles(system, kinds(begun.tangents), contacts)
        return Answer(result, evaluations=begun.tangents.march.cost["evaluations"])

    @property
    def attributes(self) -> dict[str, Any]:
        """What was asked for, as attributes of a dataset."""
        run, mechanism = self.options, self.varying.mechanism
        y, x = self.points.axes
        return {
            "name": mechanism.name,
            "source": mechanism.file_name,
            "kind": run.indicator,
            "x": x.label,
            "y": y.label,
            "periods": run.periods,
            "skip": run.skip,
            **run.how,
            "max_steps": run.most_steps,
        }


def sign_of(exponents: Exponents) -> int:
    """The sign of the largest exponent; 0 where it cannot be told from zero.

    It differs from zero if it exceeds three standard errors, and if the logarithm of the tangent's
    length changes by more than that of a power of time while time doubles: regular motions have
    such tangents, and finite-time exponents that are positive but fall to zero.
    """
    if not exponents.some:
        return -1
    growth = exponents.growth[:, 0] * np.diff(exponents.times)
    doubling = float(growth[len(growth) // 2 :].sum()) / math.log(2.0)
    value, error = exponents.largest
    if abs(value) <= BEYOND * error or abs(doubling) <= CHAOTIC_POWER or doubling * value < 0:
        return 0
    return 1 if value > 0 else -1


def kinds(tangents: LinkageTangents) -> dict[str, str]:
    """Free angle → libration (within a turn), rotation (nearly one sense) or mixed."""
    if not tangents.angles.any():
        return {}
    places = tangents.turned
    moved = np.abs(np.diff(places, axis=0)).sum(axis=0)
    net, extent = np.abs(places[-1] - places[0]), np.ptp(places, axis=0)
    result = {}
    for index, name in enumerate(tangents.system.topology.free):
        if tangents.angles[index]:
            turning = Kind.ROTATION if net[index] >= ONE_SENSE * moved[index] else Kind.MIXED
            result[name] = str(Kind.LIBRATION if extent[index] < 2 * np.pi else turning)
    return result


@takes(MapOptions)
def chaos_map(
    mechanism: Mechanism,
    x: Vary,
    y: Vary,
    *,
    device: str = "cpu",
    executor: Executor | None = None,
    store: str | Path | None = None,
    watch: Watch | None = None,
    states: bool = False,
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
    device, executor, store, watch
        As `linkages.bifurcation` takes them.
    states
        Of the indicator ``"period"``: keep where each motion was at its last whole period.
    options
        As `MapOptions` describes them.

    Returns
    -------
    Dataset with `indicator` (y, x), `rotation` (y, x, coordinate): what each free angle does, in
    mechanisms that touch `touches` (y, x, touch): how often a period, on average, and
    `reason` (y, x) where nothing could be computed, with the `stop_time` (y, x) of the motion.
    Exponents have a standard `error` (y, x) and a `sign` (y, x): 1 or −1, or 0 where they cannot be
    told from zero. What is varied is a coordinate, in the unit of its attribute ``units``. With
    clearances, `contact_lost` and `least_force` (y, x, clearance) as `linkages.poincare` has them.
    `outcome` (y, x) is a code for what became of a point.

    Of the indicator ``"period"``, `indicator` is the period in periods of the drives, nan where
    none was found, and `regime` (y, x) a code: periodic, chaotic, undecided, or not computed.
    `contraction` (y, x) is the factor by which distances from the cycle shrink in its period, nan
    where only errors of the integration are left, and `lasted` (y, x) how many periods of the
    drives the motion was followed. `touches` and `rotation_number` (y, x, coordinate), turns of
    each free angle, are per period of the drives: over the cycle, or else over the last half of
    the motion. `filled` (y, x) is 1 for points between equal ones that were not computed. With
    `states`, `state` (y, x, entry) has free coordinates, their rates and internal states in SI.

    Raises
    ------
    InputError
        If a path names nothing or nothing is free.
    ValueError, TypeError
        For arguments that make no sense; `NoPeriodError` for ``"period"`` where drives have no
        common period.
    Interrupted
        After Ctrl-C; ``kept["map"]`` has the points so far.
    """
    axes = axis_of(x), axis_of(y)
    given = {name: value for name, value in options.items() if value is not None}
    across, up = axes
    asked = Varying(mechanism), Points((up, across), {}, 1, 0, "random"), given
    question = _Mapped(*asked)
    indicator = question.options.indicator
    if states and (indicator != "period" or question.options.refine > 1):
        message = "states are kept of the indicator 'period' with refine = 1"
        raise OptionError("states", message)
    require_different(axes)
    require_feasible(question.count)
    first = question.first
    require_free(first)
    varied_along = {**coordinates(mechanism, across, "x"), **coordinates(mechanism, up, "y")}
    if indicator == "period":
        plane = Plane(*asked, states=states)
        stroboscopic_period(first)
        Plan.of(first).bind(first)  # compiled here, once
        own: dict[str, Any] = {"start": plane.options.start, "refine": plane.options.refine}
        own |= {"warning": UNSEEN if links(first.model) else ""}

        def labelled(found: Computed, source: Integers) -> xr.Dataset:
            attributes = {**question.attributes, **own, "interrupted": int(found.interrupted)}
            shape = plane.points.shape
            return plane_data(first, found.arrays, source, shape, varied_along, attributes)

        where: dict[str, Any] = {"device": device, "executor": executor}
        return computed_plane(plane, mechanism, labelled, store=store, watch=watch, **where)
    Plan.of(first, tangents=question.tangents).bind(first)  # compiled here, once
    shape = question.points.shape
    made = partial(map_data, first, shape, indicator, varied_along, question.attributes)
    return swept(
        question, mechanism, "map", "points", made,
        device=device, executor=executor, store=store, watch=watch,
    )  # fmt: skip
