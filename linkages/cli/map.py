"""``map``: an indicator of chaos over two parameters or a plane of initial states."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.markup import escape

from linkages.cli.bifurcation import INTERRUPTED, TOO_EARLY, watched
from linkages.cli.published import EndedError
from linkages.cli.requests import Request, ranges
from linkages.cli.results import save_figures, save_netcdf, save_table
from linkages.cli.terminal import console, number, print_json, print_notes, progress, table

if TYPE_CHECKING:
    import xarray as xr


def run_map(
    request: Request, x: Sequence[str], y: Sequence[str], cores: int | None, **run: Any
) -> int:
    """Compute a map with the arguments of `linkages.chaos_map`; returns the exit code."""
    from linkages.chaos.maps import chaos_map
    from linkages.chaos.sweep import Threads

    request = request.asks("map", x=x, y=y, cores=cores, **run)
    mechanism = request.mechanism()
    along, up = ranges("--x", x), ranges("--y", y)
    label = f"map of {escape(mechanism.name)}"
    shown = not request.json
    with request.answering(), progress(label, shown=shown, what="of points") as update:
        data = chaos_map(
            mechanism,
            along,
            up,
            rtol=request.rtol,
            executor=Threads(cores),
            watch=watched(update),
            **run,
        )
    reasons = data["reason"].to_numpy().ravel()
    failed = Counter(str(reason) for reason in reasons if reason)
    nothing = sum(failed.values()) == reasons.size
    interrupted = bool(data.attrs["interrupted"])
    if interrupted and nothing:
        raise EndedError(TOO_EARLY)
    with request.publishing(complete=not (interrupted or nothing)) as (aside, place):
        _save(data, aside)
    content = _content(data, failed, place.files)
    if request.json:
        print_json(content)
    else:
        _print(content, place.files[0].parent)
    if interrupted:
        raise EndedError(f"{INTERRUPTED} {place.files[0].parent}")
    if nothing:
        print(f"no point could be computed: {next(iter(failed))}", file=sys.stderr)
    return int(nothing)


def _save(data: xr.Dataset, request: Request) -> None:
    folder = request.folder
    save_netcdf(data, folder / "map.nc")
    save_table(_columns(data), folder / "map.csv")
    if request.figures:
        from linkages.plots import maps

        drawn = {"map": maps.figure(data)}
        names = [str(name) for name in data["coordinate"].values]
        for index, name in enumerate(names):
            stem = "map_rotation" if len(names) == 1 else f"map_rotation_{index + 1}"
            drawn[stem] = maps.class_figure(data, name)
        save_figures(drawn, folder, request.format)


def _columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each point."""
    height, width = data.sizes["y"], data.sizes["x"]
    columns: dict[str, Any] = {}
    for name, array in data.coords.items():
        unit = array.attrs.get("units", "")
        head = f"{name} ({unit})" if unit else str(name)
        if array.dims == ("x",):
            columns[head] = np.tile(array.to_numpy(), height)
        elif array.dims == ("y",):
            columns[head] = np.repeat(array.to_numpy(), width)
    units = data["indicator"].attrs["units"]
    kind = str(data.attrs["kind"])
    columns[f"{kind} ({units})" if units else kind] = data["indicator"].to_numpy().ravel()
    for name in data["coordinate"].values:
        columns[f"motion of {name}"] = data["rotation"].sel(coordinate=name).to_numpy().ravel()
    columns["reason"] = data["reason"].to_numpy().ravel()
    return columns


def _content(data: xr.Dataset, failed: Counter[str], written: list[Path]) -> dict[str, Any]:
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
        "rotation": {
            str(name): dict(
                Counter(
                    str(word)
                    for word in data["rotation"].sel(coordinate=name).to_numpy().ravel()
                    if word
                )
            )
            for name in data["coordinate"].values
        },
        "failures": dict(failed),
        "files": [str(path) for path in written],
    }


def _print(content: dict[str, Any], folder: Path) -> None:
    screen = console()
    title = f"{content['mechanism']}: {content['computed']} of {content['points']} points"
    screen.print(f"{title}, {content['x']} and {content['y']}", markup=False)
    if content["computed"]:
        low, high = number(content["least"]), number(content["greatest"])
        unit = content["units"]
        screen.print(f"{content['long_name']} from {low} to {high} {unit}".rstrip(), markup=False)
    rows = [
        [escape(name), word, str(count)]
        for name, kinds in content["rotation"].items()
        for word, count in sorted(kinds.items())
    ]
    if rows:
        screen.print(table("What free angles do", ["angle", "motion", "points"], rows, numbers=1))
    notes = [
        f"{count} point{'s' * (count > 1)}: {why}" for why, count in content["failures"].items()
    ]
    print_notes(notes, screen)
    screen.print(f"{len(content['files'])} files in {folder}", markup=False)
