"""Free coordinates of a dataset, and axes that show their values and rates."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import XAxis, YAxis
from matplotlib.ticker import MultipleLocator
from numpy.typing import ArrayLike, NDArray

from linkages.kernel.outputs import VARIABLES
from linkages.plots.prefixes import axis_scale

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

ROUND_OFF = 1e-12
"""SI units; smaller values are zero, and get no prefix of their own."""


class Output(NamedTuple):
    """A variable of a dataset and what its axis is called."""

    variable: str
    label: str


class Free(NamedTuple):
    """A free coordinate: ``name`` along ``dimension``."""

    dimension: str
    name: str

    @property
    def value(self) -> Output:
        """The coordinate itself."""
        return _KINDS[self.dimension][0]

    @property
    def rate(self) -> Output:
        """Its rate."""
        return _KINDS[self.dimension][1]


def _named(variable: str) -> Output:
    return Output(variable, VARIABLES[variable].long_name)


_KINDS = {
    **{
        dimension: (_named(value), _named(VARIABLES[value].rate))
        for dimension, value in {
            "clearance": "clearance_angle",
            "offset": "offset_position",
            "tilt": "tilt_angle",
            "bar": "bar_angle",
            "slider": "slider_position",
        }.items()
    },
    "touch": (Output("touch_phase", "phase of touches"), Output("touch_rate", "rate of touches")),
}


KINDS = [
    (value.variable, rate.variable)
    for value, rate in _KINDS.values()
    if value.variable in VARIABLES
]
"""Free coordinates and their rates, among the outputs."""


def free_coordinates(data: xr.Dataset) -> list[Free]:
    """All free coordinates that a dataset has values and rates of; only touches if it has those."""
    found = [
        Free(dimension, str(name))
        for dimension, outputs in _KINDS.items()
        if {output.variable for output in outputs} <= set(data.data_vars)
        for name in data[dimension].values
    ]
    return [free for free in found if free.dimension == "touch"] or found


def values_of(data: xr.Dataset, coordinate: Free, output: Output) -> Array:
    """Values of one output in SI, in the shape of the other dimensions."""
    chosen = data[output.variable].sel({coordinate.dimension: coordinate.name})
    return np.asarray(chosen, dtype=float)


def show_output(ax: Axes, along: str, data: xr.Dataset, output: Output, values: Array) -> float:
    """Label and ticks of an axis; returns what SI values are multiplied by on it."""
    units = str(data[output.variable].attrs.get("units", ""))
    clear = np.where(np.abs(values) < ROUND_OFF, 0.0, values)
    scale = axis_scale(clear, units)
    if units == "rad":
        show_degrees(ax, scale.factor * values, along)
    (ax.set_xlabel if along == "x" else ax.set_ylabel)(scale.label(output.label))
    return scale.factor


NEARLY_ALL = 240.0
"""Degrees; angles within a turn that fill more of it get the whole turn."""

SMALL = 2.0
"""Degrees; a smaller range has ticks like any other number."""

ROOM = {"x": 0.55, "y": 0.3}
"""Inches that a label needs along an axis."""

_STEPS = (1, 2, 5, 10, 15, 30, 45, 90, 180)


def show_degrees(ax: Axes, degrees: ArrayLike, along: str = "x") -> None:
    """Limits and ticks of an axis of angles.

    Parameters
    ----------
    ax
        Where the angles are drawn.
    degrees
        As drawn; what is not finite is passed over.
    along
        ``"x"`` or ``"y"``.
    """
    axis: XAxis | YAxis = ax.xaxis if along == "x" else ax.yaxis
    array = np.asarray(degrees, dtype=float)
    finite = array[np.isfinite(array)]
    span = float(np.ptp(finite)) if finite.size else 0.0
    if span > NEARLY_ALL and np.abs(finite).max() <= 180.0 + 1e-9:
        (ax.set_xlim if along == "x" else ax.set_ylim)(-180.0, 180.0)
        span = 360.0
    if span <= SMALL:
        return
    inches = (ax.bbox.width if along == "x" else ax.bbox.height) / ax.figure.dpi
    most = inches / ROOM[along] + 1e-9  # labels that fit; panels of one height must agree
    turns = 360 * ceil(span / most / 360)
    axis.set_major_locator(MultipleLocator(next((s for s in _STEPS if span <= most * s), turns)))
