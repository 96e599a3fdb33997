"""Orbits of an isoperiodic plane: of each point its state, its multipliers and its drives."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.common_period import common_period
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import LinkagesError
from linkages.kernel.varying import Varying
from linkages.options.analysis_options import OrbitOptions
from linkages.orbits.equations import Orbit
from linkages.orbits.search import at_start, found_from
from linkages.orbits.shooting import Shooting
from linkages.sweeps.axes import Axis
from linkages.sweeps.running import Executor, Threads

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

NEAR = 1e-3
"""Distance in amplitudes from a settled state beyond which an orbit is another one."""


@dataclass(frozen=True)
class PointOrbit:
    """What is known of a point.

    `period`: of drives and loads, in seconds.
    `state`: on the orbit if that was found, else where the motion was, shape (x,).
    `multipliers`: the largest first; nan if no orbit was found, shape (x,).
    """

    period: float
    state: Floats
    multipliers: NDArray[np.complex128]


def plane_orbits(
    mechanism: Mechanism,
    x: Axis,
    y: Axis,
    data: xr.Dataset,
    run: OrbitOptions,
    executor: Executor | None = None,
    watch: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Add the orbit at each point of a plane of periods that was computed with its states.

    Newton's method starts from the state in which the motion settled. An orbit that is not near it
    is another one, which is left out.

    Parameters
    ----------
    mechanism, x, y
        What `linkages.chaos_map` was asked.
    data
        What it returned, with ``states=True``.
    run
        How orbits are integrated.
    executor
        Where points are computed.
    watch
        Called with the fraction of points that are done.

    Returns
    -------
    The dataset with `state` (y, x, entry) on the orbits, `multiplier` (y, x, entry, part), the
    largest first and nan where no orbit was found, and `drive_period` (y, x) in seconds.
    """
    varying, states = Varying(mechanism), data["state"].transpose("y", "x", "entry").to_numpy()
    periods = data["indicator"].transpose("y", "x").to_numpy()
    there = np.argwhere(np.isfinite(states).all(axis=2))
    multipliers = np.full((*states.shape, 2), np.nan)
    drives = np.full(periods.shape, np.nan)
    result, names = states.copy(), tuple[str, ...]()
    if len(there):
        row, column = there[0]
        names = Shooting(varying.mechanism_at({**y.at(row), **x.at(column)}), (), run).names

    def task(place: NDArray[np.intp]) -> PointOrbit:
        row, column = place
        overrides = {**y.at(row), **x.at(column)}
        return _orbit(varying, overrides, states[row, column], periods[row, column], run)

    outcomes = (executor or Threads()).run(task, list(there))
    for done, outcome in enumerate(outcomes, 1):
        at = tuple(there[outcome.index])
        if (found := outcome.value) is not None:
            result[at], drives[at] = found.state, found.period
            multipliers[at] = np.stack([found.multipliers.real, found.multipliers.imag], axis=1)
        if watch is not None:
            watch(done / len(there))
    texts = {"units": "1", "long_name": "multiplier of the orbit"}
    own: dict[str, Any] = {
        "state": (("y", "x", "entry"), result, data["state"].attrs),
        "multiplier": (("y", "x", "entry", "part"), multipliers, texts),
        "drive_period": (("y", "x"), drives, {"units": "s", "long_name": "period of the drives"}),
    }
    parts = np.array(["real", "imaginary"], dtype=object)
    coordinates = {"part": parts, **({"entry": np.array(names, dtype=object)} if names else {})}
    return data.assign(own).assign_coords(coordinates)


def _orbit(
    varying: Varying,
    overrides: Mapping[str, object],
    settled: Floats,
    count: float,
    run: OrbitOptions,
) -> PointOrbit:
    """The orbit of a point whose motion repeats after so many periods; nan where it does not."""
    mechanism = varying.mechanism_at(overrides)
    unknown = np.full(len(settled), np.nan + 0j)
    nothing = PointOrbit(common_period(mechanism), settled, unknown)
    if not np.isfinite(count):
        return nothing
    shooting, periods = Shooting(mechanism, (), run), int(count)
    try:
        found = found_from(shooting, np.zeros(0), settled, periods=periods, skip=0, longest=periods)
        points, _, _ = at_start(found)
    except LinkagesError:
        return nothing
    assert isinstance(found.problem, Orbit)
    away = shooting.distances(points - settled)
    nearest = int(away.argmin())
    if not away[nearest] <= NEAR:
        return nothing
    spectrum = found.solution.at.spectrum
    order = np.argsort(-np.abs(spectrum), kind="stable")
    return PointOrbit(nothing.period, points[nearest], spectrum[order])
