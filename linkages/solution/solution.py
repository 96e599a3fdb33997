"""What a simulation returns: labelled arrays, how they were computed, and a summary."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError
from linkages.kernel.outputs import VARIABLES, labels
from linkages.kernel.system import System
from linkages.solution.moving.motion import Motion, Settings
from linkages.solution.moving.switching import passes
from linkages.solution.values.peaks import even, largest

if TYPE_CHECKING:
    import xarray as xr

    from linkages.solution.moving.horizon import Horizon


@dataclass(frozen=True, kw_only=True, repr=False)
class Solution:
    """Results of a simulation.

    Parameters
    ----------
    data
        Dataset with dimensions time, bar, slider, clearance, joint, axis, drive; SI units, named
        in the attribute ``units`` of every variable.
    mechanism
        What was simulated, with the free coordinates that were chosen for it.
    system
        Its topology and equations.
    motion
        Free coordinates at the sample times, and how the computation ended.
    settings
        How it was computed.
    notes
        What could not be computed, or was assumed.
    events
        Event that was asked for → dataset of its crossings, ordered in time: the outputs of `data`
        at each. Angles that are not integrated lie within one turn there.
    asked
        Arguments `times`, `state` and `events` of `linkages.simulate`, where they were given.
    """

    data: xr.Dataset
    mechanism: Mechanism
    system: System
    motion: Motion
    settings: Settings
    notes: tuple[str, ...] = ()
    events: Mapping[str, xr.Dataset] = field(default_factory=dict)
    asked: Mapping[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"Solution({self.mechanism.name!r}, {self.summary})"

    def _repr_html_(self) -> str:
        """What notebooks show: how it was computed, largest values, notes."""
        return str(import_module("linkages.plots.notebook").solution_html(self))  # stands above

    @property
    def summary(self) -> str:
        """Samples, time and number of outputs, in words."""
        time, count = self.data["time"].to_numpy(), len(self.data.data_vars)
        span = f"t = {time[0]:g} s to {time[-1]:g} s" if len(time) else "no time"
        whole = "" if self.completed else f", stopped at t = {self.motion.stop_time:g} s"
        return f"{len(time)} samples from {span}, {count} outputs{whole}"

    @property
    def completed(self) -> bool:
        """Whether the motion was computed to its end."""
        return self.motion.failure is None

    @cached_property
    def maxima(self) -> list[dict[str, Any]]:
        """Largest absolute values with their times, like the paper's table.

        They are located between samples, by interpolation; at samples those of residuals, which are
        noise, and of loads, which may jump.

        Returns
        -------
        A row per series, of velocities, accelerations and reactions of joints per magnitude:
        ``variable, element, value, time, units, long_name``, and ``missed``: by what part of it
        the motion may exceed it, where samples do not resolve the peak.
        """
        return [
            row
            for name in self.data.data_vars
            for row in _maxima(self.data[name], _least_scale(self.data, str(name)))
        ]

    @cached_property
    def horizon(self) -> Horizon | None:
        """Until when the solution can be believed; computed when it is first asked for.

        That takes a second integration at a tolerance a hundred times tighter, at about 1.7 times
        the cost of the first one. None where nothing was integrated.
        """
        from linkages.solution.moving.horizon import find_horizon

        return find_horizon(self.system, self.settings, self.motion)

    def save(self, folder: str | Path) -> list[Path]:
        """Write ``simulate.nc`` (NetCDF 4) and ``simulate.csv``; returns their paths.

        The former says how it was computed, from what and by which version, so that
        `linkages.open` can compute it again. Events, if any were asked for, are in ``events.csv``,
        a crossing per row.
        """
        from linkages.solution.files import save_dataset, save_events
        from linkages.solution.origin import origin_of

        notes = json.dumps(self.notes, ensure_ascii=False)
        origin = {"verb": "simulate", **origin_of(self.mechanism, self.options), "notes": notes}
        paths = save_dataset(self.data.assign_attrs(origin), Path(folder), "simulate")
        times = {name: data["time"].to_numpy() for name, data in self.events.items()}
        return [*paths, save_events(times, Path(folder) / "events.csv")] if times else paths

    @property
    def options(self) -> dict[str, Any]:
        """How it was computed, as arguments of `linkages.simulate`."""
        settings = self.settings
        sampled = {"end": float(settings.times[-1]), "samples": len(settings.times)}
        return {
            **({} if "times" in self.asked else sampled),
            **self.asked,
            **settings.run.integration,
            "method": self.motion.method or settings.run.method,
            "change_points": "pass" if passes(self.system, settings.run) else "stop",
            "outputs": [str(name) for name in self.data.data_vars],
        }


class IncompleteError(ComputationError):
    """A motion that could not be computed to its end.

    Parameters
    ----------
    solution
        Everything up to there.
    """

    def __init__(self, solution: Solution) -> None:
        motion = solution.motion
        super().__init__(str(motion.failure), time=motion.stop_time)
        self.solution = solution


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


def _least_scale(data: xr.Dataset, name: str) -> float:
    """Size below which accelerations are small: that of speeds over the time between samples.

    A steady motion has accelerations that are round-off alone.
    """
    speeds = {VARIABLES[str(other)].rate: str(other) for other in data.data_vars}
    speed = speeds.get(VARIABLES[name].compared or name)
    if data.sizes["time"] < 2 or speed not in {found.rate for found in VARIABLES.values()}:
        return 0.0
    spacing = abs(float(data["time"][1] - data["time"][0]))
    return float(np.nanmax(np.abs(data[speed].to_numpy()), initial=0.0)) / spacing


def _maxima(array: xr.DataArray, least: float = 0.0) -> list[dict[str, Any]]:
    """A row for each series; of some vectors, for their magnitudes.

    `least` is a size of which small parts are round-off.
    """
    if not array.sizes["time"] or VARIABLES[str(array.name)].flags:
        return []
    values, dims = array.to_numpy(), array.dims[1:]
    variable = VARIABLES[str(array.name)]
    if variable.magnitude:
        values, dims = np.linalg.norm(values, axis=-1), dims[:-1]
    if len(dims) > 1:
        return []
    table = values.reshape(array.sizes["time"], -1)
    names = [str(n) for n in array[dims[0]].to_numpy()] if dims else [""]
    time = array["time"].to_numpy()
    finite = np.abs(table[np.isfinite(table)])
    smooth = variable.smooth and even(time)
    scale = max(least, float(finite.max(initial=0.0))) if smooth else np.inf
    rows = []
    for element, series in zip(names, table.T, strict=True):
        peak = largest(series, scale)
        rows.append(
            {
                "variable": str(array.name),
                "element": element,
                "value": peak.value,
                "time": float(np.interp(peak.time, np.arange(len(time)), time)),
                "units": array.attrs["units"],
                "long_name": array.attrs["long_name"],
                "missed": peak.missed,
            }
        )
    return rows
