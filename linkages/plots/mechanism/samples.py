"""The positions of a mechanism at the samples of a solution's data."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.mechanism.pose import Pose

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]


class Poses:
    """Positions at all samples, in metres, as far as the data tell them.

    Parameters
    ----------
    data, mechanism
        A motion, and what moves.
    size
        Of the picture in metres, the same for all of them; what joints span at each if not given.

    Attributes
    ----------
    places
        Of all joints, shape (time, joints, 2).
    """

    def __init__(self, data: xr.Dataset, mechanism: Mechanism, size: float | None = None) -> None:
        self.mechanism, self._size = mechanism, size
        self._joints, self.places = _named(data, "joint_position", "joint", "axis")
        self._bars, self._angles = _named(data, "bar_angle", "bar")
        self._travel = _travel(data)

    def at(self, index: int) -> Pose:
        """The position at one sample."""
        there = len(self.places) > 0
        positions = {
            name: (float(x), float(y))
            for name, (x, y) in zip(self._joints, self.places[index] if there else (), strict=there)
            if np.isfinite((x, y)).all()
        }
        angles = dict(zip(self._bars, self._angles[index].tolist() if there else (), strict=there))
        return Pose(self.mechanism, positions, angles, self._travel, size=self._size)


def pose_at(data: xr.Dataset, mechanism: Mechanism, index: int) -> Pose:
    """The position of a mechanism at one sample."""
    return Poses(data, mechanism).at(index)


def _named(data: xr.Dataset, variable: str, *dims: str) -> tuple[list[str], Array]:
    """Names along the first of some dimensions, and values over time; none where there are none."""
    if variable not in data:
        return [], np.empty((data.sizes["time"], 0, *(2 for _ in dims[1:])))
    array = data[variable].transpose("time", *dims)
    return [str(name) for name in array[dims[0]].values], np.asarray(array, dtype=float)


def _travel(data: xr.Dataset) -> dict[str, tuple[float, float]]:
    """Slider → its least and largest displacement in metres."""
    names, values = _named(data, "slider_position", "slider")
    finite = {
        name: column[np.isfinite(column)] for name, column in zip(names, values.T, strict=True)
    }
    return {name: (float(v.min()), float(v.max())) for name, v in finite.items() if v.size}
