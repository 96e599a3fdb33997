"""Linear measures of a mechanism, from exact derivatives of its motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.sensitivity.differentiated import Differentiated, Evaluated
from linkages.design.tolerances.contributors import Contributors
from linkages.design.tolerances.linear import ErrorMeasure, LinearMeasure, SmoothMeasure
from linkages.errors import ComputationError
from linkages.kernel.system import System
from linkages.options.run import SimulationOptions
from linkages.solution.measuring.followed import (
    Followed,
    denser,
    driven_factor,
    evaluable,
    resolved_motion,
)
from linkages.solution.measuring.measure import measured_series, single
from linkages.solution.moving.march import compute_motion
from linkages.solution.moving.motion import Settings
from linkages.solution.options import options_of
from linkages.solution.values.series import TIME
from linkages.spec.measures import Measure

Floats = NDArray[np.float64]

Slopes = Callable[[Mechanism, Sequence[str]], Floats]
"""Mechanism, paths → derivatives at its numbers, shape (…, paths)."""

INTEGRATED_ANGLE, FEWEST_INTEGRATED = math.radians(5.0), 256
"""What a drive turns by between samples of errors of which an integral is taken by Simpson's rule,
and the fewest of these."""

VANISHING = 1e-6
"""Of its size: a clearance where its effect is differentiated, for without length it is no bar."""


def linearised(
    contributors: Contributors, measures: Mapping[str, Measure], given: Mapping[str, Any]
) -> dict[str, LinearMeasure]:
    """Name → linear measure.

    Parameters
    ----------
    contributors
        What varies.
    measures
        Name → what is measured.
    given
        Options of the simulation.

    Raises
    ------
    InputError, ValueError, ComputationError
        If a derivative is not known or not finite, or the nominal motion stops.
    """
    smooth = {name: each for name, each in measures.items() if not each.compares}
    errors = {name: each for name, each in measures.items() if each.compares}
    motion = _nominal(contributors.nominal, [*measures.values()], given)
    found: dict[str, LinearMeasure] = {}
    if smooth:
        found |= _with_gradients(contributors, smooth, motion, given)
    if errors:
        found |= _of_errors(contributors, errors, motion, given)
    return {name: found[name] for name in measures}


def _with_gradients(
    contributors: Contributors,
    measures: Mapping[str, Measure],
    motion: Followed,
    given: Mapping[str, Any],
) -> dict[str, LinearMeasure]:
    texts = [each.text for each in measures.values()]
    values = [single(each, motion) for each in measures.values()]

    def of(mechanism: Mechanism, paths: Sequence[str]) -> Floats:
        differentiated = Differentiated(mechanism, texts, paths, run=given)
        return _found(differentiated.at(differentiated.values))

    slopes = _slopes(contributors, of, (len(texts),))
    pushes = _pushes(contributors, of, (len(texts),))
    return {
        name: SmoothMeasure(contributors, values[k], slopes[k], pushes[k])
        for k, name in enumerate(measures)
    }


def _of_errors(
    contributors: Contributors,
    measures: Mapping[str, Measure],
    motion: Followed,
    given: Mapping[str, Any],
) -> dict[str, LinearMeasure]:
    names = list(dict.fromkeys(name for each in measures.values() for name in each.series))

    def along(mechanism: Mechanism, paths: Sequence[str]) -> Floats:
        differentiated = Differentiated(mechanism, (), paths, run=given)
        found = differentiated.along(differentiated.values, names, motion.time)
        return _found(found).transpose(0, 2, 1)

    shape = len(names), len(motion.time)
    slopes = dict(zip(names, _slopes(contributors, along, shape), strict=True))
    pushes = dict(zip(names, _pushes(contributors, along, shape), strict=True))
    return {
        name: ErrorMeasure(
            contributors,
            each,
            motion,
            {series: slopes[series] for series in each.series},
            {series: pushes[series] for series in each.series},
        )
        for name, each in measures.items()
    }


def _found(evaluated: Evaluated) -> Floats:
    assert evaluated.derivatives is not None
    return evaluated.derivatives


def _slopes(contributors: Contributors, slopes: Slopes, shape: tuple[int, ...]) -> Floats:
    """Derivatives by the numbers, shape (…, numbers)."""
    if not contributors.zones:
        return np.zeros((*shape, 0))
    return slopes(contributors.nominal, [*contributors.zones])


def _pushes(contributors: Contributors, slopes: Slopes, shape: tuple[int, ...]) -> Floats:
    """Derivatives by displacements of pins and blocks, shape (…, clearances, 2)."""
    found = np.zeros((*shape, len(contributors.clearances), 2))
    for axis, angle in enumerate((0.0, np.pi / 2)):
        values: dict[str, object] = {}
        for each in contributors.clearances:
            values |= {each.size_path: VANISHING * each.size, each.angle_path: float(angle)}
        if values:
            turned = contributors.varied.with_values(values)
            sizes = [each.size_path for each in contributors.clearances]
            found[..., axis] = slopes(turned, sizes)
    for k, each in enumerate(contributors.clearances):
        found[..., k, :] = each.felt(found[..., k, :])
    return found


def _nominal(
    mechanism: Mechanism, measures: Sequence[Measure], given: Mapping[str, Any]
) -> Followed:
    system = System(mechanism)
    series = {n: s for each in measures for n, s in measured_series(system, each).items()}
    whole = [n for n, each in series.items() if each.variable != TIME and not evaluable(each)]
    if whole:
        raise ValueError(
            f"{whole[0]} follows from the whole motion, so that it has no derivatives; expected "
            "an output that follows from the motion at one time"
        )
    run = options_of(SimulationOptions, mechanism, given)
    counting = any(each.angle for each in series.values())
    integrated = any(each.integrates for each in measures)
    times = np.linspace(0.0, run.end, run.samples)
    if not system.layout.moved and any(each.compares and each.integrates for each in measures):
        close = INTEGRATED_ANGLE, FEWEST_INTEGRATED
        times = denser(times, driven_factor(system, run.end, run.samples, *close))
    settings = Settings(times=times, run=run, counting=counting)
    motion = compute_motion(system, settings)
    if motion.failure is not None:
        raise ComputationError(f"the nominal motion: {motion.failure}", time=motion.stop_time)
    motion, time, _ = resolved_motion(system, motion, settings, integrated)
    return Followed(system, motion, series, time=time)
