"""Which way drives and loads act during a run: values of laws of time, and their signs."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.components.contributed.functions import Table
from linkages.components.contributed.measures import BodyAxis, Coordinate, Load
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.numbers.laws import law_values

Array = NDArray[np.float64]

SAMPLES = 721
BOTH = 2
NEGLIGIBLE = 1e-9  # of the largest magnitude


def run_times(mechanism: Mechanism) -> Array:
    """Times over the run that the definition asks for, shape (`SAMPLES`,), in seconds."""
    return np.linspace(0.0, mechanism.simulation.end, SAMPLES)


def sense_of(values: ArrayLike) -> int:
    """The sign that all values have: 1, −1, 0 if all are zero, `BOTH` if they differ."""
    array = np.asarray(values, dtype=float)
    array = array[np.isfinite(array)]
    least = NEGLIGIBLE * float(np.abs(array).max(initial=0.0))
    rises, falls = bool((array > least).any()), bool((array < -least).any())
    return BOTH if rises and falls else rises - falls


def load_sense(load: Load, mechanism: Mechanism) -> int:
    """Which way a force or torque acts during the run.

    One that depends on the motion acts both ways, unless all values of its table have one sign.
    """
    if load.given:
        return sense_of(law_values(load.law, run_times(mechanism)))
    return sense_of(load.law.values) if isinstance(load.law, Table) else BOTH


def drive_sense(mechanism: Mechanism, name: str) -> int:
    """Which way a drive moves its body during the run."""
    return sense_of(np.diff(law_values(mechanism.prescribed[name].law, run_times(mechanism))))


def force_direction(
    force: Iterable[tuple[Coordinate | BodyAxis, Load]], mechanism: Mechanism
) -> tuple[float, int]:
    """Direction of a force where it is largest, in radians, and its sense along that (or 0).

    That of a force that turns with a body is the one in the body's own frame.

    One that depends on the motion acts both ways along the first axis in which it does.
    """
    times = run_times(mechanism)
    vectors = np.zeros((len(times), 2))
    for measure, load in force:
        if not load.given:
            return 0.5 * np.pi * measure.axis, BOTH
        vectors[:, measure.axis] += law_values(load.law, times)
    vectors = vectors[np.isfinite(vectors).all(axis=1)]
    if not vectors.any():
        return 0.0, 0
    largest = vectors[np.argmax(np.hypot(*vectors.T))]
    return float(np.arctan2(largest[1], largest[0])), sense_of(vectors @ largest)
