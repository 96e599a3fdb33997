"""What a verdict on a motion rests on, gathered from the analyses of this package."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.chaos.crossed import NeverCrossedError
from linkages.chaos.dimension import FEWEST_POINTS, Dimension, correlation_dimension
from linkages.chaos.free_states import PAIRS, free_names, labelled_states
from linkages.chaos.lyapunov import characteristic_period
from linkages.chaos.rotation import Rotation, classify_angle, refined
from linkages.chaos.section import poincare
from linkages.chaos.spectrum import PowerSpectrum, power_spectrum
from linkages.chaos.verdict import FEWEST_PERIODS
from linkages.chaos.zero_one import zero_one
from linkages.components.mechanism import Mechanism
from linkages.kernel.system import System
from linkages.solution.motion import Settings
from linkages.solution.simulate import simulate
from linkages.solution.solution import Solution

if TYPE_CHECKING:
    import xarray as xr

PER_PERIOD = 512
"""Samples of the motion within a period."""

Floats = NDArray[np.float64]
Watch = Callable[[float], None]


@dataclass(frozen=True, kw_only=True)
class Run:
    """What motion is judged.

    Parameters
    ----------
    system
        With a free coordinate.
    periods, skip
        As `linkages.chaos.report.chaos` takes them.
    settings
        How it is integrated.
    """

    system: System
    periods: int
    skip: int
    settings: Settings

    @property
    def mechanism(self) -> Mechanism:
        """What moves."""
        return self.system.mechanism


def section_of(run: Run) -> xr.Dataset:
    """Stroboscopic, or where the first free coordinate comes to rest; empty if it never does."""
    section = None
    try:
        common_period(run.mechanism)
    except NoPeriodError:
        dim, (name, *_) = next(iter(free_names(run.system).items()))
        section = f"{name}.{'velocity' if dim == 'slider' else 'speed'}=0"
    try:
        return poincare(
            run.mechanism,
            periods=run.periods,
            skip=run.skip,
            section=section,
            method=run.settings.method,
            rtol=run.settings.rtol,
        )
    except NeverCrossedError:
        return _no_points(run.system, str(section))


def _no_points(system: System, section: str) -> xr.Dataset:
    values = {
        output: np.empty((0, len(names)))
        for dim, names in free_names(system).items()
        for output in PAIRS[dim]
    }
    time = ("crossing", np.empty(0), {"units": "s", "long_name": "time"})
    attributes = {"section": section, "direction": "up", "warning": ""}
    return labelled_states(system, values, "crossing", {"time": time}, attributes)


def followed(run: Run, watch: Watch | None) -> Solution:
    """The motion over time: free coordinates and clearance forces."""
    outputs = [output for dim in free_names(run.system) for output in PAIRS[dim]]
    if "clearance_angle" in outputs:
        outputs.append("clearance_force")
    whole = run.periods + run.skip
    return simulate(
        run.mechanism,
        end=whole * characteristic_period(run.mechanism),
        samples=whole * PER_PERIOD + 1,
        method=run.settings.method,
        rtol=run.settings.rtol,
        outputs=outputs,
        watch=watch,
    )


def states_of(system: System, data: xr.Dataset) -> tuple[Floats, NDArray[np.bool_]]:
    """Free coordinates, then their rates, shape (points, 2n), and which entries are angles."""
    columns, rates, angles = [], [], []
    for dim, names in free_names(system).items():
        value, rate = PAIRS[dim]
        for name in names:
            columns.append(data[value].sel({dim: name}).to_numpy())
            rates.append(data[rate].sel({dim: name}).to_numpy())
            angles.append(dim != "slider")
    return np.array([*columns, *rates]).T, np.array([*angles, *[False] * len(rates)])


def zero_one_tests(
    system: System, points: Floats, angles: NDArray[np.bool_]
) -> dict[str, tuple[float, float]]:
    """Free coordinate → growth and spread of the 0–1 test; empty for too few points."""
    if len(points) < FEWEST_PERIODS:
        return {}
    names = [name for names in free_names(system).values() for name in names]
    return {name: _zero_one(points[:, i], bool(angles[i])) for i, name in enumerate(names)}


def _zero_one(series: Floats, angle: bool) -> tuple[float, float]:
    observed = np.cos(series) if angle else series
    if np.ptp(observed) <= 1e-12 * np.abs(observed).max():
        return 0.0, 0.0  # what does not change is regular
    found = zero_one(observed, lag=1)  # section points are not oversampled
    return found.growth, found.spread


def dimension_of(points: Floats, angles: NDArray[np.bool_]) -> Dimension | None:
    """Correlation dimension of the section; None for too few points.

    Not that of the motion between section points: along each turn of a torus samples lie on a
    curve, and only very long runs show more than that.
    """
    if len(points) < FEWEST_POINTS:
        return None
    return correlation_dimension(points, angles=angles)


def spectra_of(system: System, solution: Solution) -> dict[str, PowerSpectrum]:
    """Free coordinate → power spectrum of its rate."""
    interval = float(solution.data.time[1] - solution.data.time[0])
    found = {}
    for dim, names in free_names(system).items():
        rates = solution.data[PAIRS[dim][1]]
        for name in names:
            found[name] = power_spectrum(rates.sel({dim: name}).to_numpy(), interval)
    return found


def rotation_of(system: System, solution: Solution) -> dict[str, Rotation]:
    """Free angle → what it does."""
    found, time = {}, solution.data.time.to_numpy()
    for dim, names in free_names(system).items():
        if dim != "slider":
            values = solution.data[PAIRS[dim][0]]
            for name in names:
                found[name] = classify_angle(*refined(time, values.sel({dim: name}).to_numpy()))
    return found


def conservative(mechanism: Mechanism) -> bool:
    """Whether nothing dissipates: the flow then keeps volumes of states, and has no attractor.

    Drives and given forces may still put energy in and take it out.
    """
    return not any(load.dissipates for load in mechanism.loads)
