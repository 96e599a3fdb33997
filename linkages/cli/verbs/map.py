"""``map``: an indicator of chaos over two parameters or a plane of initial states."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.markup import escape

from linkages.cli.requests import Request, ranges
from linkages.cli.results import save_figures, save_netcdf, save_table
from linkages.cli.swept import (
    close_report,
    contact_columns,
    contact_content,
    coordinate_head,
    failure_notes,
    failures,
    publish_sweep,
    swept,
)
from linkages.cli.terminal import console, number, table

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def run_map(request: Request, x: Sequence[str], y: Sequence[str], cores: int | None) -> int:
    """Compute a map; returns the exit code."""
    from linkages.chaos.sweeps.maps import chaos_map
    from linkages.chaos.sweeps.sweep import Threads

    axes = ranges("--x", x), ranges("--y", y)
    task = partial(chaos_map, request.mechanism, *axes, executor=Threads(cores), **request.given)
    data = swept(request, "map", "point", task)

    def save(folder: Path) -> None:
        save_netcdf(data, folder / "map.nc")
        save_table(_columns(data), folder / "map.csv")
        if request.figures:
            save_figures(_figures(data), folder, request.format)

    content = _content(data)
    show = partial(_print, content, data)
    return publish_sweep(request, data, "point", save, content, show)


def _figures(data: xr.Dataset) -> dict[str, Figure | None]:
    from linkages.plots.chaos import maps

    drawn: dict[str, Figure | None] = {"map": maps.figure(data)}
    names = [str(name) for name in data["coordinate"].values]
    for index, name in enumerate(names):
        stem = "map_rotation" if len(names) == 1 else f"map_rotation_{index + 1}"
        drawn[stem] = maps.class_figure(data, name)
    return drawn


def _columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each point."""
    height, width = data.sizes["y"], data.sizes["x"]
    columns: dict[str, Any] = {}
    for name, array in data.coords.items():
        head = coordinate_head(name, array)
        if array.dims == ("x",):
            columns[head] = np.tile(array.to_numpy(), height)
        elif array.dims == ("y",):
            columns[head] = np.repeat(array.to_numpy(), width)
    units = data["indicator"].attrs["units"]
    kind = str(data.attrs["kind"])
    columns[f"{kind} ({units})" if units else kind] = data["indicator"].to_numpy().ravel()
    if "error" in data:
        columns["error (1/s)"] = data["error"].to_numpy().ravel()
        columns["sign"] = data["sign"].to_numpy().ravel()
    columns |= contact_columns(data)
    for name in data["coordinate"].values:
        columns[f"motion of {name}"] = data["rotation"].sel(coordinate=name).to_numpy().ravel()
    columns["reason"] = data["reason"].to_numpy().ravel()
    columns["stopped (s)"] = data["stop_time"].to_numpy().ravel()
    return columns


def _kinds(data: xr.Dataset, name: str) -> dict[str, int]:
    """What a free angle does → at how many points."""
    words = data["rotation"].sel(coordinate=name).to_numpy().ravel()
    return dict(Counter(str(word) for word in words if word))


def _content(data: xr.Dataset) -> dict[str, Any]:
    values = data["indicator"].to_numpy()
    finite = values[np.isfinite(values)]
    return {
        "mechanism": data.attrs["name"],
        "indicator": data.attrs["kind"],
        "long_name": data["indicator"].attrs["long_name"],
        "units": data["indicator"].attrs["units"],
        "x": data.attrs["x"],
        "y": data.attrs["y"],
        "points": int(values.size),
        "computed": int(finite.size),
        "interrupted": bool(data.attrs["interrupted"]),
        "least": float(finite.min()) if finite.size else None,
        "greatest": float(finite.max()) if finite.size else None,
        "signs": _signs(data),
        "rotation": {str(name): _kinds(data, str(name)) for name in data["coordinate"].values},
        "contact": contact_content(data),
        "failures": failures(data),
    }


def _signs(data: xr.Dataset) -> dict[str, int] | None:
    """At how many points the exponent is positive, negative, or cannot be told from zero."""
    if "sign" not in data:
        return None
    signs = data["sign"].to_numpy()[np.isfinite(data["indicator"].to_numpy())]
    words = {"positive": 1, "negative": -1, "zero within its error": 0}
    return {word: int((signs == sign).sum()) for word, sign in words.items()}


def _print(content: dict[str, Any], data: xr.Dataset, files: Sequence[Path]) -> None:
    screen = console()
    title = f"{content['mechanism']}: {content['computed']} of {content['points']} points"
    screen.print(f"{title}, {content['x']} and {content['y']}", markup=False)
    if content["computed"]:
        low, high = number(content["least"]), number(content["greatest"])
        unit = content["units"]
        screen.print(f"{content['long_name']} from {low} to {high} {unit}".rstrip(), markup=False)
    if content["signs"] and content["computed"]:
        said = [f"{word} at {count}" for word, count in content["signs"].items() if count]
        screen.print(f"the exponent is {', '.join(said)}", markup=False)
    rows = [
        [escape(name), word, str(count)]
        for name, kinds in content["rotation"].items()
        for word, count in sorted(kinds.items())
    ]
    if rows:
        screen.print(table("What free angles do", ["angle", "motion", "points"], rows, numbers=1))
    close_report(data, failure_notes(content["failures"], "point"), files)
