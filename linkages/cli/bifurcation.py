"""``bifurcation``: section points over a parameter, with figures and tables."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.markup import escape

from linkages.cli.published import EndedError
from linkages.cli.requests import Request, initial_states, ranges
from linkages.cli.results import free_columns, save_figures, save_netcdf, save_table
from linkages.cli.swept import (
    contact_columns,
    contact_content,
    counted,
    failure_notes,
    failures,
    finished,
    watched,
)
from linkages.cli.terminal import console, number, print_json, print_notes, progress, table
from linkages.components.mechanism import Mechanism

if TYPE_CHECKING:
    import xarray as xr

    from linkages.chaos.varied import Axis

BOTH = "both"
INTERRUPTED = "interrupted: what was computed up to then is in"
TOO_EARLY = "interrupted before anything was computed"


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """What is varied, and from where each value starts.

    Parameters
    ----------
    vary, initial
        Ranges and initial states as on the command line.
    start
        ``"same"``, ``"forward"``, ``"backward"`` or ``"both"`` of the latter.
    cores
        Number of threads; all cores if None.
    """

    vary: Sequence[str]
    initial: Sequence[str] = ()
    start: str = "same"
    cores: int | None = None


def run_bifurcation(request: Request, swept: Sweep, **run: Any) -> int:
    """Sweep with the arguments of `linkages.bifurcation`; returns the exit code."""
    request = request.asks("bifurcation", **vars(swept), **run)
    mechanism = request.mechanism()
    axis = ranges("--vary", swept.vary)
    states = initial_states(swept.initial)
    with request.answering():
        data = _compute(request, mechanism, axis, states, swept, run)
    failed = failures(data)
    interrupted = bool(data.attrs["interrupted"])
    nothing = not _counts(data).any()
    if interrupted and nothing:
        raise EndedError(TOO_EARLY)
    with request.publishing(complete=not nothing, interrupted=interrupted) as (aside, place):
        _save(data, aside)
    written = place.files
    if request.json:
        _print_json(data, written, failed)
    else:
        _print(data, written, failed)
    if interrupted:
        raise EndedError(f"{INTERRUPTED} {written[0].parent}")
    if nothing:
        print(f"no value could be computed: {next(iter(failed))}", file=sys.stderr)
    return int(nothing)


def _compute(
    request: Request,
    mechanism: Mechanism,
    axis: Axis,
    states: Sequence[dict[str, object]],
    swept: Sweep,
    run: dict[str, Any],
) -> xr.Dataset:
    """One sweep, or one in either direction put together; starts have names."""
    import xarray as xr

    from linkages.chaos.bifurcation import bifurcation
    from linkages.chaos.sweep import Threads

    starts = ("forward", "backward") if swept.start == BOTH else (swept.start,)
    parts: list[xr.Dataset] = []
    for start in starts:
        if parts and parts[-1].attrs["interrupted"]:
            break
        label = f"{escape(axis.label)} of {escape(mechanism.name)}"
        with progress(label, shown=not request.json, what="of values") as update:
            task = partial(
                bifurcation,
                mechanism,
                axis,
                start=start,
                initial=states,
                rtol=request.rtol,
                executor=Threads(swept.cores),
                watch=watched(update),
                **run,
            )
            data = finished(task)
        parts.append(data.assign_coords(start=_names(start if len(starts) > 1 else "", states)))
    whole = parts[0] if len(parts) == 1 else xr.concat(parts, "start", data_vars="all")
    whole.attrs["interrupted"] = max(part.attrs["interrupted"] for part in parts)
    return whole


def _names(start: str, states: Sequence[dict[str, object]]) -> np.ndarray:
    texts = [", ".join(f"{path}={value}" for path, value in state.items()) for state in states]
    if len(states) == 1:
        texts = [""]
    return np.array([": ".join(t for t in (start, text) if t) for text in texts], dtype=object)


def _save(data: xr.Dataset, request: Request) -> None:
    folder = request.folder
    save_netcdf(data, folder / "bifurcation.nc")
    save_table(_points(data), folder / "bifurcation.csv")
    save_table(_values(data), folder / "bifurcation_values.csv")
    if request.figures:
        from linkages.plots import bifurcations

        drawn = {
            "bifurcation": bifurcations.figure(data),
            "bifurcation_rates": bifurcations.figure(data, rates=True),
        }
        save_figures(drawn, folder, request.format)


def _parameters(data: xr.Dataset) -> dict[str, np.ndarray]:
    """Head → values of what is varied, shape (values,)."""
    found = {}
    for name, array in data.coords.items():
        if array.dims == ("value",):
            unit = array.attrs.get("units", "")
            found[f"{name} ({unit})" if unit else str(name)] = array.to_numpy()
    return found


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


def _print_json(data: xr.Dataset, written: list[Any], failed: dict[str, int]) -> None:
    values = _values(data)
    print_json(
        {
            "mechanism": data.attrs["name"],
            "varied": data.attrs["varied"],
            "starts": [str(name) for name in data["start"].values],
            "interrupted": bool(data.attrs["interrupted"]),
            "values": {head: np.asarray(column).tolist() for head, column in values.items()},
            "failures": failed,
            "warnings": counted(_warnings(data)),
            "contact": contact_content(data),
            "files": [str(path) for path in written],
        }
    )


def _print(data: xr.Dataset, written: list[Any], failed: dict[str, int]) -> None:
    from linkages.chaos.contact_log import contact_kept, contact_sentences

    screen = console()
    path = data.attrs["varied"]
    numbers, unit = data[path].to_numpy(), data[path].attrs.get("units", "")
    title = f"{data.attrs['name']}: {data.sizes['value']} values of {path}"
    ends = f"{number(float(numbers[0]))} to {number(float(numbers[-1]))} {unit}".rstrip()
    screen.print(f"{title} from {ends}", markup=False)
    heads = ["start", "values computed", "points"]
    rows = []
    values = _values(data)
    for index, name in enumerate(data["start"].values):
        mine = values["start"] == index + 1
        done = int((values["points"][mine] > 0).sum())
        row = [escape(str(name)) or "of the file", str(done), str(values["points"][mine].sum())]
        if "exponent" in data:
            row.append(_chaotic(data["exponent"][index], data["error"][index]))
        rows.append(row)
    heads += ["exponent positive"] if "exponent" in data else []
    screen.print(table("Starts", heads, rows, numbers=len(heads) - 1))
    notes = failure_notes(failed, "value") + failure_notes(counted(_warnings(data)), "value")
    print_notes([*contact_sentences(data), *notes], screen)
    if kept := contact_kept(data):
        screen.print(kept, markup=False)
    screen.print(f"{len(written)} files in {written[0].parent}", markup=False)


def _warnings(data: xr.Dataset) -> list[str]:
    """What is said of values with fewer points than asked for."""
    return [str(text) for text in data["warning"].to_numpy().ravel() if text]


def _chaotic(exponent: Any, error: Any) -> str:
    """At how many values the exponent exceeds three standard errors."""
    from linkages.cli.lyapunov import BEYOND

    return f"at {int((exponent > BEYOND * error).sum())}"
