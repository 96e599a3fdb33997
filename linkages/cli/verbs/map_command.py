"""``map``: an indicator of chaos over two parameters or a plane of initial states."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli import swept
from linkages.cli.requests import File, Request, ranges
from linkages.reports.report import Part, Report, Table, headed, number

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
    how = {**request.given, "executor": Threads(cores), "device": device, "store": store}
    task = partial(chaos_map, request.mechanism, *axes, **how)
    data = swept.result(request, "map", "point", task)

    def figures() -> Iterator[File]:
        from linkages.plots.chaos.diagrams import class_figure, map_figure, touch_figure

        yield "map", map_figure(data)
        for stem, name in swept.numbered("map_touches", _touched(data)):
            yield stem, touch_figure(data, name)
        for stem, name in swept.numbered("map_rotation", _coordinates(data)):
            yield stem, class_figure(data, name)

    files: list[File] = [("map", data), ("map", _columns(data))]
    return swept.publish(request, _report(data), data, "point", files, figures, store)


def _touched(data: xr.Dataset) -> list[str]:
    """Names of what is touched, if that was counted."""
    return [str(name) for name in data["touch"].values] if "touches" in data else []


def _coordinates(data: xr.Dataset) -> list[str]:
    return [str(name) for name in data["coordinate"].values]


def _columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each point."""
    columns = swept.varied_columns(data, "x", "y")
    columns[headed(data.attrs["kind"], data["indicator"].attrs["units"])] = data["indicator"]
    if "error" in data:
        columns |= {"error (1/s)": data["error"], "sign": data["sign"]}
    for name in _touched(data):
        columns[f"touches of {name} per period"] = data["touches"].sel(touch=name)
    columns |= swept.contact_columns(data)
    for name in _coordinates(data):
        columns[f"motion of {name}"] = data["rotation"].sel(coordinate=name)
    return swept.flattened(columns | swept.failure_columns(data), data["indicator"])


def _signs(data: xr.Dataset) -> dict[str, int] | None:
    """At how many points the exponent is positive, negative, or cannot be told from zero."""
    if "sign" not in data:
        return None
    signs = data["sign"].to_numpy()[np.isfinite(data["indicator"].to_numpy())]
    words = {"positive": 1, "negative": -1, "zero within its error": 0}
    return {word: int((signs == sign).sum()) for word, sign in words.items()}


def _report(data: xr.Dataset) -> Report:
    said, indicator = data.attrs, data["indicator"]
    values, unit, title = (
        indicator.to_numpy(),
        indicator.attrs["units"],
        indicator.attrs["long_name"],
    )
    computed, ends, signs = int(np.isfinite(values).sum()), swept.finite_range(values), _signs(data)
    failures = swept.failures(data)
    touches = {
        name: [ends["least"], ends["greatest"]]
        for name in _touched(data)
        for ends in [swept.finite_range(data["touches"].sel(touch=name).to_numpy())]
        if ends["least"] is not None
    }
    rotation = {
        name: dict(Counter(str(word) for word in words.to_numpy().ravel() if word))
        for name in _coordinates(data)
        for words in [data["rotation"].sel(coordinate=name)]
    }
    parts: list[Part] = []
    if computed:
        low, high = (number(float(end or 0.0)) for end in ends.values())
        parts.append(f"{title} from {low} to {high} {unit}".rstrip())
        if signs:
            found = [f"{word} at {count}" for word, count in signs.items() if count]
            parts.append(f"the Lyapunov exponent is {', '.join(found)}")
    for name, (least, greatest) in touches.items():
        parts.append(f"{name} is touched {least:.6g} to {greatest:.6g} times a period")
    rows = [[name, *kind] for name, kinds in rotation.items() for kind in sorted(kinds.items())]
    if rows:
        parts.append(Table("What free angles do", ["angle", "motion", "points"], rows, numbers=1))
    return Report(
        name=said["name"],
        summary=f"{computed} of {values.size} points, {said['x']} and {said['y']}",
        parts=[*parts, *swept.remarks(data, swept.failure_notes(failures, "point"))],
        data={
            "mechanism": said["name"],
            "indicator": said["kind"],
            "long_name": title,
            "units": unit,
            "x": said["x"],
            "y": said["y"],
            "points": int(values.size),
            "computed": computed,
            "interrupted": bool(said["interrupted"]),
            **ends,
            "signs": signs,
            "rotation": rotation,
            "touches": touches,
            "contact": swept.contact_content(data),
            "failures": failures,
        },
    )
