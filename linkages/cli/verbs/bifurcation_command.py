"""``bifurcation``: section points over a parameter, with figures and tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from linkages.cli import swept
from linkages.cli.requests import File, Request, initial_states, ranges
from linkages.reports.report import Report, Table, number
from linkages.reports.verdict_report import BEYOND

if TYPE_CHECKING:
    from linkages.sweeps.axes import Axis


def run(
    request: Request,
    vary: Sequence[str],
    start: str,
    initial: Sequence[str],
    store: Path | None,
    cores: int | None,
    device: str,
) -> int:
    """Sweep over a parameter; returns the exit code."""
    from linkages.sweeps.running import Threads

    axis, states = ranges("--vary", vary), initial_states(initial or [])
    where: dict[str, Any] = {"store": store, "executor": Threads(cores), "device": device}
    data = _compute(request, axis, states, start, **where)
    values = _values(data)

    def figures() -> Iterator[File]:
        from linkages.plots.chaos.diagrams import bifurcation_figure

        yield "bifurcation", bifurcation_figure(data)
        yield "bifurcation_rates", bifurcation_figure(data, rates=True)

    files: list[File] = [
        ("bifurcation", data),
        ("bifurcation", _points(data)),
        ("bifurcation_values", values),
    ]
    report = _report(data, values)
    return swept.publish(request, report, data, "value", files, figures, store)


def _compute(
    request: Request,
    axis: Axis,
    states: Sequence[dict[str, object]],
    start: str,
    store: Path | None,
    **where: Any,
) -> xr.Dataset:
    """One sweep, or one in either direction put together; starts have names, and their stores."""
    from linkages.chaos.bifurcation import bifurcation
    from linkages.chaos.diagram import BOTH, put_together, ways

    parts: list[xr.Dataset] = []
    for one in ways(start):
        if parts and parts[-1].attrs["interrupted"]:
            break
        kept = store / one if store is not None and start == BOTH else store
        given = {**request.given, "start": one, "initial": states, "store": kept, **where}
        task = partial(bifurcation, request.mechanism, axis, **given)
        parts.append(swept.result(request, axis.label, "value", task))
    return put_together(parts, start, states)


def _numbered(data: xr.Dataset, dim: str) -> xr.DataArray:
    return xr.DataArray(np.arange(data.sizes[dim]) + 1, dims=dim)


def _points(data: xr.Dataset) -> dict[str, Any]:
    """Columns of all points that there are."""
    free = swept.free_columns(data)
    columns = {
        "start": _numbered(data, "start"),
        **swept.varied_columns(data, "value"),
        "point": _numbered(data, "crossing"),
    }
    there = np.isfinite(next(iter(free.values())))
    found = swept.flattened(columns, _first(data)) | free
    return {head: array[there] for head, array in found.items()}


def _values(data: xr.Dataset) -> dict[str, np.ndarray]:
    """A row for each initial condition and value: points, exponent, contact, reason."""
    columns = {
        "start": _numbered(data, "start"),
        **swept.varied_columns(data, "value"),
        "points": _first(data).notnull().sum("crossing"),
    }
    if "exponent" in data:
        columns |= {"exponent (1/s)": data["exponent"], "error (1/s)": data["error"]}
    columns |= swept.contact_columns(data) | swept.failure_columns(data)
    return swept.flattened(columns, data["reason"])


def _first(data: xr.Dataset) -> xr.DataArray:
    """One of the numbers of every point."""
    return next(array for array in data.data_vars.values() if "crossing" in array.dims)[..., 0]


def _report(data: xr.Dataset, values: dict[str, Any]) -> Report:
    name, path = data.attrs["name"], data.attrs["varied"]
    numbers, unit = data[path].to_numpy(), data[path].attrs.get("units", "")
    ends = f"{number(float(numbers[0]))} to {number(float(numbers[-1]))} {unit}".rstrip()
    starts = [str(name) for name in data["start"].values]
    heads, rows = ["initial condition", "values computed", "points"], []
    for index, start in enumerate(starts):
        points = values["points"][values["start"] == index + 1]
        row = [start or "of the file", int((points > 0).sum()), points.sum()]
        if "exponent" in data:
            positive = data["exponent"][index] > BEYOND * data["error"][index]
            row.append(f"at {int(positive.sum())}")
        rows.append(row)
    heads += ["Lyapunov exponent positive"] if "exponent" in data else []
    # values with fewer points than asked for
    warnings = swept.counted(str(text) for text in data["warning"].to_numpy().ravel() if text)
    failures = swept.failures(data)
    notes = [n for reasons in (failures, warnings) for n in swept.failure_notes(reasons, "value")]
    return Report(
        name=name,
        summary=f"{data.sizes['value']} values of {path} from {ends}",
        parts=[
            Table("Initial conditions", heads, rows, numbers=len(heads) - 1),
            *swept.remarks(data, notes),
        ],
        data={
            "mechanism": name,
            "varied": path,
            "starts": starts,
            "interrupted": bool(data.attrs["interrupted"]),
            "values": {head: column.tolist() for head, column in values.items()},
            "failures": failures,
            "warnings": warnings,
            "contact": swept.contact_content(data),
        },
    )
