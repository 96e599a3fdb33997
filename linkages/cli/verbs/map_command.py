"""``map``: an indicator of chaos over two parameters or a plane of initial states."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console

from linkages.cli import swept
from linkages.cli.requests import File, Request, ranges
from linkages.cli.terminal import number, table

if TYPE_CHECKING:
    import xarray as xr


def run(
    request: Request,
    x: Sequence[str],
    y: Sequence[str],
    store: Path | None,
    cores: int | None,
    device: str,
) -> int:
    """Compute a map; returns the exit code."""
    from linkages.chaos.maps import chaos_map
    from linkages.sweeps.running import Threads

    axes = ranges("--x", x), ranges("--y", y)
    how = {**request.given, "executor": Threads(cores), "device": str(device), "store": store}
    task = partial(chaos_map, request.mechanism, *axes, **how)
    data = swept.result(request, "map", "point", task)

    content, made = _content(data), _files(data, request.figures)
    show = partial(_print, content, data)
    return swept.publish(request, data, "point", made, content, show, store=store)


def _files(data: xr.Dataset, figures: bool) -> Iterator[File]:
    yield "map", data
    yield "map", _columns(data)
    if figures:
        from linkages.plots.chaos.diagrams import class_figure, map_figure, touch_figure

        yield "map", map_figure(data)
        touched = [str(name) for name in data["touch"].values] if "touches" in data else []
        for index, name in enumerate(touched):
            stem = "map_touches" if len(touched) == 1 else f"map_touches_{index + 1}"
            yield stem, touch_figure(data, name)
        names = [str(name) for name in data["coordinate"].values]
        for index, name in enumerate(names):
            stem = "map_rotation" if len(names) == 1 else f"map_rotation_{index + 1}"
            yield stem, class_figure(data, name)


def _columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each point."""
    kind, units = str(data.attrs["kind"]), data["indicator"].attrs["units"]
    columns = swept.varied_columns(data, "x", "y")
    columns[f"{kind} ({units})" if units else kind] = data["indicator"]
    if "error" in data:
        columns |= {"error (1/s)": data["error"], "sign": data["sign"]}
    for name in data["touch"].values if "touches" in data else ():
        columns[f"touches of {name} per period"] = data["touches"].sel(touch=name)
    columns |= swept.contact_columns(data)
    for name in data["coordinate"].values:
        columns[f"motion of {name}"] = data["rotation"].sel(coordinate=name)
    return swept.flattened(columns | swept.failure_columns(data), data["indicator"])


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
        "touches": _touches(data),
        "contact": swept.contact_content(data),
        "failures": swept.failures(data),
    }


def _touches(data: xr.Dataset) -> dict[str, list[float]]:
    """Name of what is touched → how often a period, at least and at most."""
    found = {}
    for name in data["touch"].values if "touches" in data else ():
        values = data["touches"].sel(touch=name).to_numpy()
        if np.isfinite(values).any():
            found[str(name)] = [float(np.nanmin(values)), float(np.nanmax(values))]
    return found


def _signs(data: xr.Dataset) -> dict[str, int] | None:
    """At how many points the exponent is positive, negative, or cannot be told from zero."""
    if "sign" not in data:
        return None
    signs = data["sign"].to_numpy()[np.isfinite(data["indicator"].to_numpy())]
    words = {"positive": 1, "negative": -1, "zero within its error": 0}
    return {word: int((signs == sign).sum()) for word, sign in words.items()}


def _print(content: dict[str, Any], data: xr.Dataset, screen: Console) -> None:
    title = f"{content['mechanism']}: {content['computed']} of {content['points']} points"
    screen.print(f"{title}, {content['x']} and {content['y']}", markup=False)
    if content["computed"]:
        low, high = number(content["least"]), number(content["greatest"])
        unit = content["units"]
        screen.print(f"{content['long_name']} from {low} to {high} {unit}".rstrip(), markup=False)
    if content["signs"] and content["computed"]:
        said = [f"{word} at {count}" for word, count in content["signs"].items() if count]
        screen.print(f"the Lyapunov exponent is {', '.join(said)}", markup=False)
    for name, (low, high) in content["touches"].items():
        screen.print(
            f"{name} is touched {number(low)} to {number(high)} times a period", markup=False
        )
    rows = [
        [name, word, count]
        for name, kinds in content["rotation"].items()
        for word, count in sorted(kinds.items())
    ]
    if rows:
        screen.print(table("What free angles do", ["angle", "motion", "points"], rows, numbers=1))
    swept.print_remarks(data, swept.failure_notes(content["failures"], "point"), screen)
