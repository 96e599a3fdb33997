"""``bifurcation``: section points over a parameter, with figures and tables."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.markup import escape

from linkages.cli.requests import Request, initial_states, ranges
from linkages.cli.results import free_columns, save_figures, save_netcdf, save_table
from linkages.cli.swept import (
    close_report,
    contact_columns,
    contact_content,
    coordinate_head,
    counted,
    failure_notes,
    failures,
    publish_sweep,
    swept,
)
from linkages.cli.terminal import console, number, table

if TYPE_CHECKING:
    import xarray as xr

    from linkages.chaos.sweeps.varied import Axis

BOTH = "both"


def run_bifurcation(
    request: Request, vary: Sequence[str], start: str, initial: Sequence[str], cores: int | None
) -> int:
    """Sweep over a parameter; returns the exit code."""
    axis, states = ranges("--vary", vary), initial_states(initial)
    data = _compute(request, axis, states, start, cores)
    values = _values(data)

    def save(folder: Path) -> None:
        save_netcdf(data, folder / "bifurcation.nc")
        save_table(_points(data), folder / "bifurcation.csv")
        save_table(values, folder / "bifurcation_values.csv")
        if request.figures:
            from linkages.plots.chaos.bifurcations import figure

            drawn = {"bifurcation": figure(data), "bifurcation_rates": figure(data, rates=True)}
            save_figures(drawn, folder, request.format)

    content = {
        "mechanism": data.attrs["name"],
        "varied": data.attrs["varied"],
        "starts": [str(name) for name in data["start"].values],
        "interrupted": bool(data.attrs["interrupted"]),
        "values": {head: np.asarray(column).tolist() for head, column in values.items()},
        "failures": failures(data),
        "warnings": counted(_warnings(data)),
        "contact": contact_content(data),
    }
    show = partial(_print, data, values)
    return publish_sweep(request, data, "value", save, content, show)


def _compute(
    request: Request, axis: Axis, states: Sequence[dict[str, object]], start: str, cores: int | None
) -> xr.Dataset:
    """One sweep, or one in either direction put together; starts have names."""
    import xarray as xr

    from linkages.chaos.sweeps.bifurcation import bifurcation
    from linkages.chaos.sweeps.sweep import Threads

    starts = ("forward", "backward") if start == BOTH else (str(start),)
    parts: list[xr.Dataset] = []
    for one in starts:
        if parts and parts[-1].attrs["interrupted"]:
            break
        given = {**request.given, "start": one, "initial": states, "executor": Threads(cores)}
        task = partial(bifurcation, request.mechanism, axis, **given)
        data = swept(request, axis.label, "value", task)
        parts.append(data.assign_coords(start=_names(one if len(starts) > 1 else "", states)))
    whole = parts[0] if len(parts) == 1 else xr.concat(parts, "start", data_vars="all")
    whole.attrs["interrupted"] = max(part.attrs["interrupted"] for part in parts)
    return whole


def _names(start: str, states: Sequence[dict[str, object]]) -> np.ndarray:
    texts = [", ".join(f"{path}={value}" for path, value in state.items()) for state in states]
    if len(states) == 1:
        texts = [""]
    return np.array([": ".join(t for t in (start, text) if t) for text in texts], dtype=object)


def _parameters(data: xr.Dataset) -> dict[str, np.ndarray]:
    """Head → values of what is varied, shape (values,)."""
    return {
        coordinate_head(name, array): array.to_numpy()
        for name, array in data.coords.items()
        if array.dims == ("value",)
    }


def _points(data: xr.Dataset) -> dict[str, Any]:
    """Columns of all points that there are."""
    free = free_columns(data)
    starts, values, crossings = (data.sizes[dim] for dim in ("start", "value", "crossing"))
    place = np.indices((starts, values, crossings)).reshape(3, -1)
    there = np.isfinite(next(iter(free.values())))
    columns: dict[str, Any] = {"start": place[0][there] + 1}
    columns |= {head: array[place[1][there]] for head, array in _parameters(data).items()}
    columns["point"] = place[2][there] + 1
    return columns | {head: array[there] for head, array in free.items()}


def _values(data: xr.Dataset) -> dict[str, Any]:
    """Columns with a row for each start and value: points, exponent, contact, reason."""
    starts, values = data.sizes["start"], data.sizes["value"]
    columns: dict[str, Any] = {"start": np.repeat(np.arange(starts) + 1, values)}
    columns |= {head: np.tile(array, starts) for head, array in _parameters(data).items()}
    columns["points"] = _counts(data).ravel()
    if "exponent" in data:
        columns["exponent (1/s)"] = data["exponent"].to_numpy().ravel()
        columns["error (1/s)"] = data["error"].to_numpy().ravel()
    columns |= contact_columns(data)
    columns["reason"] = data["reason"].to_numpy().ravel()
    columns["stopped (s)"] = data["stop_time"].to_numpy().ravel()
    return columns


def _counts(data: xr.Dataset) -> np.ndarray:
    """How many points there are, shape (starts, values)."""
    first = next(array for array in data.data_vars.values() if "crossing" in array.dims)
    return np.asarray(np.isfinite(first.to_numpy()[..., 0]).sum(axis=2))


def _print(data: xr.Dataset, values: dict[str, Any], written: Sequence[Path]) -> None:
    screen = console()
    path = data.attrs["varied"]
    numbers, unit = data[path].to_numpy(), data[path].attrs.get("units", "")
    title = f"{data.attrs['name']}: {data.sizes['value']} values of {path}"
    ends = f"{number(float(numbers[0]))} to {number(float(numbers[-1]))} {unit}".rstrip()
    screen.print(f"{title} from {ends}", markup=False)
    heads = ["start", "values computed", "points"]
    rows = []
    for index, name in enumerate(data["start"].values):
        mine = values["start"] == index + 1
        done = int((values["points"][mine] > 0).sum())
        row = [escape(str(name)) or "of the file", str(done), str(values["points"][mine].sum())]
        if "exponent" in data:
            row.append(_chaotic(data["exponent"][index], data["error"][index]))
        rows.append(row)
    heads += ["exponent positive"] if "exponent" in data else []
    screen.print(table("Starts", heads, rows, numbers=len(heads) - 1))
    notes = [
        note
        for reasons in (failures(data), counted(_warnings(data)))
        for note in failure_notes(reasons, "value")
    ]
    close_report(data, notes, written)


def _warnings(data: xr.Dataset) -> list[str]:
    """What is said of values with fewer points than asked for."""
    return [str(text) for text in data["warning"].to_numpy().ravel() if text]


def _chaotic(exponent: Any, error: Any) -> str:
    """At how many values the exponent exceeds three standard errors."""
    from linkages.cli.verbs.lyapunov import BEYOND

    return f"at {int((exponent > BEYOND * error).sum())}"
