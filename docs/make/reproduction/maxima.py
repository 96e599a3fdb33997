"""The paper's five maxima from any initial condition, and over a grid of all the open ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

import linkages
from linkages.plots.motion.curves import turning_points
from linkages.sweeps.running import Executor, Threads
from make.reproduction.reported import ANGLE, CRANKS, OUTPUTS, PRINTED, REPORTED

Floats = NDArray[np.float64]

SAMPLES = 4001
"""Half a millisecond: a twentieth of a libration."""

RTOL = 1e-8
"""Of a scan. Rotating motions are predictable for 1 s then: single ones change, bands do not."""


@dataclass(frozen=True)
class Maxima:
    """What is compared with the paper, for one initial condition or (with a leading axis) many."""

    values: Floats  # largest magnitudes of the five quantities and when, shape (…, 5)
    times: Floats
    # largest deviation of the slider from the ideal mechanism, in units of the stroke and of the
    # largest acceleration of that mechanism
    position: Floats
    acceleration: Floats
    # largest difference of the torque of crank 1 from that of the ideal mechanism, in units of
    # the latter's largest magnitude
    torque: Floats
    # how often that torque turns between rising and falling, in units of the ideal mechanism
    turns: Floats


def maxima(
    mechanism: linkages.Mechanism, samples: int = SAMPLES, rtol: float | None = None, **solver
) -> Maxima:
    """Simulate one period (2 s) with and without the clearance."""
    outputs = [*OUTPUTS, "slider_position", "slider_acceleration"]
    run = linkages.simulate(mechanism, samples=samples, rtol=rtol, outputs=outputs, **solver)
    data, time = run.data, run.data.time.to_numpy()
    values, times = np.empty(len(REPORTED)), np.empty(len(REPORTED))
    for index, quantity in enumerate(REPORTED):
        array = data[quantity.output]
        magnitude = np.abs(array.sel({array.dims[1]: quantity.element}).to_numpy())
        place = int(np.argmax(magnitude))
        values[index], times[index] = magnitude[place], time[place]
    position, acceleration = (
        (data[name] - data[f"{name}_error"]).to_numpy()
        for name in ("slider_position", "slider_acceleration")
    )
    ideal = linkages.simulate(mechanism.ideal(), samples=samples, outputs=["drive_effort"]).data
    torque, ideal_torque = (
        one.drive_effort.sel(drive="crank1").to_numpy() for one in (data, ideal)
    )
    return Maxima(
        values=values,
        times=times,
        position=values[0] / np.ptp(position),
        acceleration=values[2] / np.abs(acceleration).max(),
        torque=np.abs(torque - ideal_torque).max() / np.abs(ideal_torque).max(),
        turns=np.array(turning_points(torque) / turning_points(ideal_torque)),
    )


Start = tuple[float, float, float]
"""θ1, θ4 and α in degrees."""


def grid(cranks: float, clearance: float) -> list[Start]:
    """All initial conditions at rest in the clearance at multiples of these angles, in degrees."""
    whole, turn = np.arange(0.0, 360.0, cranks), np.arange(-180.0, 180.0, clearance)
    return [(float(a), float(b), float(c)) for a in whole for b in whole for c in turn]


def from_start(mechanism: linkages.Mechanism, start: Start) -> linkages.Mechanism:
    """The same mechanism from other initial angles."""
    paths = (*CRANKS, ANGLE)
    return mechanism.with_values(
        {path: f"{angle:g} deg" for path, angle in zip(paths, start, strict=True)}
    )


def scan(
    mechanism: linkages.Mechanism, starts: Sequence[Start], executor: Executor | None = None
) -> Maxima:
    """The five maxima from every initial condition; all of the grids can be assembled."""
    outcomes = sorted(
        (executor or Threads()).run(
            lambda start: maxima(from_start(mechanism, start), rtol=RTOL), starts
        ),
        key=lambda outcome: outcome.index,
    )
    failed = [outcome.reason for outcome in outcomes if outcome.reason]
    if failed:
        raise linkages.LinkagesError(
            f"{len(failed)} initial conditions failed, the first one: {failed[0]}"
        )
    found = [outcome.value for outcome in outcomes]
    return Maxima(*(np.array([getattr(o, f.name) for o in found]) for f in fields(Maxima)))


def ranks(found: Maxima, values: Floats = PRINTED) -> Floats:
    """Share of initial conditions below these values, shape (5,): 0 or 1 is out of the band."""
    return np.asarray((found.values < values).mean(axis=0))


def nearest(found: Maxima) -> tuple[int, float]:
    """The initial condition nearest to the paper's maxima, and the factor of its worst one."""
    apart = np.abs(np.log(found.values / PRINTED)).max(axis=1)
    index = int(np.argmin(apart))
    return index, float(np.exp(apart[index]))


def torque_ratio(values: Floats) -> Floats:
    """Torque of crank 1 in units of that of crank 4."""
    return np.asarray(values[..., 3] / values[..., 4])
