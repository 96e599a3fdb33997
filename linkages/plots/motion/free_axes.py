"""Free coordinates of a dataset, and axes that show their values and rates."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from linkages.kernel.outputs import VARIABLES
from linkages.plots.motion.angles import show_degrees
from linkages.plots.prefixes import Scale, scale_of

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

ROUND_OFF = 1e-12
"""SI units; smaller values are zero, and get no prefix of their own."""

DEGREES = 180.0 / np.pi


class Output(NamedTuple):
    """A variable of a dataset and what its axis is called."""

    variable: str
    label: str


class Free(NamedTuple):
    """A free coordinate: ``name`` along ``dimension``, with its value and its rate."""

    dimension: str
    name: str
    value: Output
    rate: Output


_KINDS = {
    "clearance": (Output("clearance_angle", "angle α"), Output("clearance_speed", "speed dα/dt")),
    "offset": (Output("offset_position", "offset e"), Output("offset_rate", "rate de/dt")),
    "bar": (Output("bar_angle", "angle θ"), Output("bar_speed", "speed dθ/dt")),
    "slider": (
        Output("slider_position", "displacement s"),
        Output("slider_velocity", "velocity ds/dt"),
    ),
}


def free_coordinates(data: xr.Dataset) -> list[Free]:
    """All free coordinates that a dataset has values and rates of."""
    return [
        Free(dimension, str(name), *outputs)
        for dimension, outputs in _KINDS.items()
        if {output.variable for output in outputs} <= set(data.data_vars)
        for name in data[dimension].values
    ]


def values_of(data: xr.Dataset, coordinate: Free, output: Output) -> Array:
    """Values of one output in SI, in the shape of the other dimensions."""
    chosen = data[output.variable].sel({coordinate.dimension: coordinate.name})
    return np.asarray(chosen, dtype=float)


def show_output(ax: Axes, along: str, data: xr.Dataset, output: Output, values: Array) -> float:
    """Label and ticks of an axis; returns what SI values are multiplied by on it."""
    angle = VARIABLES[output.variable].angle
    clear = np.where(np.abs(values) < ROUND_OFF, 0.0, values)
    scale = scale_of(clear, str(data[output.variable].attrs.get("units", "")))
    if angle:
        scale = Scale(DEGREES, "°")
        show_degrees(ax, scale.factor * values, along)
    (ax.set_xlabel if along == "x" else ax.set_ylabel)(scale.label(output.label))
    return scale.factor
