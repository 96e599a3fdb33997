"""Nothing that is not finite leaves a simulation without a word."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.outputs import VARIABLES, labels
from linkages.kernel.system import System
from linkages.reading.wording import TOO_LARGE
from linkages.solution.moving.motion import Motion

Values = dict[str, NDArray[np.float64]]


def sound_part(
    system: System, motion: Motion, values: Mapping[str, NDArray[np.float64]]
) -> tuple[Motion, Values]:
    """A motion up to the first sample with a value that is not finite, and why it ends there.

    Parameters
    ----------
    system, motion
        What moves, and how.
    values
        Output → values, shape (samples, …). An advantage may be infinite: where a drive does not
        move a body.
    """
    first: tuple[int, str] | None = None
    for name, array in values.items():
        sound = ~np.isnan(array) if VARIABLES[name].reciprocal else np.isfinite(array)
        samples, *elements = np.nonzero(~sound)  # in the order of the samples
        if samples.size and (first is None or samples[0] < first[0]):
            first = int(samples[0]), _name(system, name, [int(index[0]) for index in elements])
    if first is None:
        return motion, dict(values)
    sample, what = first
    time = float(motion.time[sample])
    failure = f"at t = {time:.9g} s: the {what} is not a finite number. {TOO_LARGE}"
    return (
        replace(motion.part(last=sample), failure=failure, stop_time=time),
        {name: array[:sample] for name, array in values.items()},
    )


def _name(system: System, name: str, index: Sequence[int]) -> str:
    """An output and the element that an index into its values belongs to."""
    variable = VARIABLES[name]
    _, long_name = variable.described(system.model)
    places = zip(variable.dims, index, strict=True)
    words = [labels(system.model, dim)[i] for dim, i in places if dim != "axis"]
    return f"{long_name} of {' and '.join(words)}" if words else long_name
