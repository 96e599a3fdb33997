"""Arrays of a motion as a dataset: coordinates, units, names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.outputs import VARIABLES, labels
from linkages.kernel.system import System
from linkages.solution.moving.motion import Motion

if TYPE_CHECKING:
    import xarray as xr


def labelled(system: System, motion: Motion, values: dict[str, NDArray[np.float64]]) -> xr.Dataset:
    """Put arrays into a dataset with coordinates, units and names."""
    import xarray as xr

    variables = {}
    dims: dict[str, None] = {}
    for name, array in values.items():
        entry = VARIABLES[name]
        dims |= dict.fromkeys(entry.dims)
        units, long_name = entry.described(system.model)
        attrs: dict[str, Any] = {"units": units, "long_name": long_name}
        if entry.flags:
            attrs["flag_values"] = np.arange(len(entry.flags), dtype=np.int8)
            attrs["flag_meanings"] = " ".join(entry.flags)
        variables[name] = (("time", *entry.dims), array, attrs)
    coordinates: dict[str, Any] = {
        "time": ("time", motion.time, {"units": "s", "long_name": "time"})
    }
    for dim in dims:
        coordinates[dim] = (dim, np.array(labels(system.model, dim), dtype=object))
    attrs = {"name": system.mechanism.name, "source": system.mechanism.file_name}
    if system.topology.free:
        attrs["free"] = " ".join(system.topology.free)
    return xr.Dataset(variables, coordinates, attrs)
