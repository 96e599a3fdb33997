"""What MuJoCo can express of a mechanism; the rest is refused by name."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.measures import BodyAxis, Coordinate, Load
from linkages.components.contributed.terms import Path
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.exports.trees.linear import Line, line_of
from linkages.kernel.system import System

Floats = NDArray[np.float64]

_TIMES = 11
_ROUND_OFF = 1e-12


def refuse(system: System) -> None:
    """Raise for all that MuJoCo cannot express.

    Raises
    ------
    InputError
        With everything at once.
    """
    found = [*_bodies(system.mechanism), *_laws(system)]
    if found:
        raise system.mechanism.error(found)


def _bodies(mechanism: Mechanism) -> Iterator[tuple[Path, str]]:
    for contact in mechanism.contacts:
        yield contact.path, "clearances that open are not exported to MuJoCo"
    for end in mechanism.ends:
        yield end.path, "ends at which bodies bounce are not exported to MuJoCo"
    for play in mechanism.plays:
        yield play.path, "clearances of guides are not exported to MuJoCo"
    for relation in mechanism.relations:
        if relation.profile is not None:
            yield relation.path, "cams are not exported to MuJoCo"


def _laws(system: System) -> Iterator[tuple[Path, str]]:
    for name, prescribed in system.mechanism.prescribed.items():
        if polynomial(system, name) is None and harmonic(system, name) is None:
            what = "polynomials of time up to degree 4, and harmonic motions"
            yield prescribed.path, f"MuJoCo follows drives with {what} only"
    for load in system.mechanism.loads:
        if not load.absent and line_in(load) is None:
            yield load.path, "only springs, dampers and forces of constant numbers go to MuJoCo"


def line_in(load: Load) -> Line | None:
    """The law of a load as MuJoCo has it: a spring and damper, or a constant; None if it cannot."""
    found = line_of(load)
    if found is None or load.states or load.bearing is not None or min(found[1:]) < 0.0:
        return None
    moving = found.stiffness or found.damping
    fixed = isinstance(load.measure, BodyAxis)
    return None if fixed or (moving and isinstance(load.measure, Coordinate)) else found


class Harmonic(NamedTuple):
    """A motion radius·sin(frequency·t + phase) about a middle."""

    radius: float
    frequency: float
    phase: float


def polynomial(system: System, name: str) -> tuple[float, ...] | None:
    """Coefficients of t to t⁴ of a drive; None if it is no such polynomial."""
    times, values = _probed(system, name)
    rate, accelerations = values[1, 0], values[2]
    powers = np.vander(times, 3, increasing=True)
    found = np.linalg.lstsq(powers, accelerations, rcond=None)[0]
    apart = np.abs(powers @ found - accelerations).max()
    if apart > _ROUND_OFF * max(1.0, np.abs(accelerations).max()):
        return None
    found[np.abs(found) <= _ROUND_OFF * np.abs(accelerations).max()] = 0.0
    return float(rate), *(found / (2.0, 6.0, 12.0)).tolist()


def harmonic(system: System, name: str) -> Harmonic | None:
    """A drive as a harmonic motion; None if it is none: then x″ is no line in x that falls."""
    _, (values, rates, accelerations) = _probed(system, name)
    line = np.stack([values, np.ones_like(values)], axis=1)
    (slope, constant), *_ = np.linalg.lstsq(line, accelerations, rcond=None)
    apart = np.abs(line @ (slope, constant) - accelerations).max()
    if apart > _ROUND_OFF * np.abs(accelerations).max() or not slope < 0.0:
        return None
    frequency = np.sqrt(-slope)
    along, across = values[0] + constant / slope, rates[0] / frequency
    return Harmonic(*map(float, (np.hypot(along, across), frequency, np.arctan2(along, across))))


def _probed(system: System, name: str) -> tuple[Floats, Floats]:
    """Times, the first zero, and a drive's coordinate, rate and acceleration there."""
    law, end = system.model.positions.laws[name], abs(system.mechanism.simulation.end)
    # at times that no period has in common
    times = np.append(0.0, np.random.default_rng(0).uniform(0.0, max(end, 1.0), _TIMES))
    state = np.repeat(system.state[:, None], len(times), axis=1)
    return times, system.evaluate([law.value, law.rate, law.acceleration], times, state)
