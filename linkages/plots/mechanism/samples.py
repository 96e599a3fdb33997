"""The position of a mechanism at a sample of a solution's data."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.mechanism.pose import Pose

if TYPE_CHECKING:
    import xarray as xr


def positions_at(data: xr.Dataset, index: int) -> dict[str, tuple[float, float]]:
    """Where joints are at one sample, in metres; empty if the data do not say."""
    if "joint_position" not in data or data.sizes["time"] == 0:
        return {}
    array = data["joint_position"].transpose("time", "joint", "axis")[index]
    places = np.asarray(array, dtype=float)
    names = [str(name) for name in array["joint"].values]
    return {
        name: (float(x), float(y))
        for name, (x, y) in zip(names, places, strict=True)
        if np.isfinite((x, y)).all()
    }


def pose_at(data: xr.Dataset, mechanism: Mechanism, index: int) -> Pose:
    """The position of a mechanism at one sample, in metres, as far as the data tell it."""
    angles: dict[str, float] = {}
    if "bar_angle" in data and data.sizes["time"]:
        row = np.asarray(data["bar_angle"].transpose("time", "bar")[index], dtype=float)
        angles = {str(n): float(a) for n, a in zip(data["bar"].values, row, strict=True)}
    return Pose(mechanism, positions_at(data, index), angles, travel_of(data))


def travel_of(data: xr.Dataset) -> dict[str, tuple[float, float]]:
    """Slider → its least and largest displacement in metres, as far as the data tell them."""
    travel: dict[str, tuple[float, float]] = {}
    if "slider_position" in data:
        for name in data["slider"].values:
            values = np.asarray(data["slider_position"].sel(slider=name), dtype=float)
            values = values[np.isfinite(values)]
            if values.size:
                travel[str(name)] = float(values.min()), float(values.max())
    return travel
