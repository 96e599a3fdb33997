"""Options of a run, and the number of samples that resolves every oscillation."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.options.option import OptionError, Options, given_options
from linkages.options.run import RunOptions, SimulationOptions
from linkages.solvers.integration import FIXED_STEP_METHODS, LEAST_RTOL, METHODS
from linkages.solvers.job import AUTO

MAX_SAMPLES = 10_000_000
"""More would not fit into memory as tables."""


def options_of(kind: type[Options], mechanism: Mechanism, given: Mapping[str, Any]) -> Options:
    """Options of a run of a mechanism; a step only where the method has a fixed one."""
    result = given_options(kind, given, mechanism.simulation)
    for refusal in (_integration(result), _span(result)):
        if refusal is not None:
            key, message, asked = refusal
            if given.get(asked) is None:
                raise mechanism.error([(("simulate", key), message)])
            raise OptionError(asked, message)
    return result if result.method in FIXED_STEP_METHODS else replace(result, step=None)


def _integration(run: RunOptions) -> tuple[str, str, str] | None:
    """What is wrong with how a motion is integrated: key, message, option that asks for it."""
    if not LEAST_RTOL <= run.rtol < 1:
        return "rtol", f"rtol must be from {LEAST_RTOL:.3g} to 1, found {run.rtol:g}", "rtol"
    if run.method not in (*METHODS, AUTO):
        known = ", ".join([*METHODS, AUTO])
        return "method", f"unknown method {run.method!r}; expected one of: {known}", "method"
    if run.method in FIXED_STEP_METHODS and run.step is None:
        message = f"method {run.method!r} needs a step; expected a time in seconds"
        return "step", message, "method"
    return None


def _span(run: RunOptions) -> tuple[str, str, str] | None:
    """What is wrong with the times of a simulation, in the same way."""
    if not isinstance(run, SimulationOptions):
        return None
    if run.end == 0:
        return "end", "end must be a time in seconds other than 0, found 0", "end"
    if not 2 <= run.samples <= MAX_SAMPLES:
        limits = f"at least 2 and at most {MAX_SAMPLES}"
        return "samples", f"samples must be {limits}, found {run.samples:g}", "samples"
    step = run.step if run.method in FIXED_STEP_METHODS else None
    if step is not None and abs(run.end) > run.most_steps * step:
        what = f"step {step:g} s needs more than {run.most_steps} steps to reach {run.end:g} s"
        return "step", what, "step"
    return None


PER_SWING = 40.0
"""Samples per oscillation with which its peak is at most 0.3 % above the highest sample."""

MOST_SAMPLES = 100_000
"""Of a motion that measures look at; one with more would take seconds."""

STEADY = 1e-6
"""Of the largest magnitude: what changes less between samples does not move."""


def turning_points(values: NDArray[np.float64]) -> int:
    """How often a series changes between rising and falling; round-off does not count."""
    finite = values[np.isfinite(values)]
    if len(finite) < 3:
        return 0
    steps = np.diff(finite)
    slopes = np.sign(steps[np.abs(steps) > STEADY * np.abs(finite).max()])
    return int(np.count_nonzero(slopes[1:] * slopes[:-1] < 0))


def swings(series: Iterable[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Samples per oscillation of each element of series (samples, …); inf without two turns."""
    result = []
    for values in series:
        for column in values.reshape(len(values), -1).T if values.size else ():
            turns = turning_points(column)
            result.append(2.0 * len(values) / turns if turns > 1 else np.inf)
    return np.array(result)


def samples_per_swing(series: Iterable[NDArray[np.float64]]) -> float:
    """Samples per oscillation of the element that oscillates most, like `swings`."""
    return float(np.min(swings(series), initial=np.inf))
