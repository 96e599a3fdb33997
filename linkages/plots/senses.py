"""Which way drives and loads act during a run: values of laws of time, and their signs."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.components.functions import Function
from linkages.components.mechanism import Mechanism
from linkages.kernel.laws import law_values

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


def load_sense(function: Function, mechanism: Mechanism) -> int:
    """Which way a force or torque acts during the run."""
    return sense_of(law_values(function, run_times(mechanism)))


def drive_sense(mechanism: Mechanism, name: str) -> int:
    """Which way a drive moves its body during the run."""
    return sense_of(np.diff(law_values(mechanism.prescribed[name].law, run_times(mechanism))))


def force_direction(force: tuple[Function, Function], mechanism: Mechanism) -> tuple[float, int]:
    """Direction of a force where it is largest, in radians, and its sense along that (or 0)."""
    times = run_times(mechanism)
    vectors = np.column_stack([law_values(part, times) for part in force])
    vectors = vectors[np.isfinite(vectors).all(axis=1)]
    if not vectors.any():
        return 0.0, 0
    largest = vectors[np.argmax(np.hypot(*vectors.T))]
    return float(np.arctan2(largest[1], largest[0])), sense_of(vectors @ largest)
