"""Command that finds attractors and their basins: ``basins``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli import swept
from linkages.cli.requests import File, Request, each_read, ranges
from linkages.reports.report import Column, Notes, Report, Table

if TYPE_CHECKING:
    import xarray as xr


def run_basins(
    request: Request,
    x: Sequence[str],
    y: Sequence[str],
    also: Sequence[str] | None,
    draws: int,
    seed: int,
    store: Path | None,
    cores: int | None,
    device: str,
) -> int:
    """Find attractors and their basins; returns the exit code."""
    from linkages.attractors.basins import basins
    from linkages.sweeps.axes import parse_range
    from linkages.sweeps.running import Threads

    axes = ranges("--x", x), ranges("--y", y)
    further = each_read("--also", also or (), parse_range)
    how = {**request.given, "executor": Threads(cores), "device": device, "store": store}
    how |= {"also": further, "draws": draws, "seed": seed}
    task = partial(basins, request.mechanism, *axes, **how)
    data = swept.result(request, "basins", "start", task)

    def figures() -> Iterator[File]:
        from linkages.plots.chaos.basin_figures import basin_figure

        yield "basins", basin_figure(data)

    files: list[File] = [
        ("basins", data),
        ("basins", _cells(data)),
        ("basins_attractors", attractor_points(data)),
    ]
    return swept.publish(request, _report(data), data, "start", files, figures, store)


def _cells(data: xr.Dataset) -> dict[str, np.ndarray]:
    """A row for each point of the grid."""
    columns = swept.varied_columns(data, "x", "y") | {"attractor": data["basin"]}
    columns |= {"known after (s)": data["lasted"], **swept.failure_columns(data)}
    return swept.flattened(columns, data["basin"])


def attractor_points(data: xr.Dataset) -> dict[str, Any]:
    """A row for each section point of each attractor."""
    values = data["points"].to_numpy()
    there = np.isfinite(values).all(axis=2)
    numbers, places = np.nonzero(there)
    columns: dict[str, Any] = {
        "attractor": data["attractor"].to_numpy()[numbers],
        "kind": data["kind"].to_numpy()[numbers],
        "point": places + 1,
    }
    for index, name in enumerate(data["state"].to_numpy()):
        units = data["state_units"].to_numpy()[index]
        columns[f"{name} ({units})" if units else str(name)] = values[there][:, index]
    return columns


def attractor_rows(data: xr.Dataset) -> list[dict[str, Any]]:
    """What is found of each attractor, as JSON has it."""
    rows = []
    for index in range(data.sizes["attractor"]):
        one = data.isel(attractor=index)
        points = one["points"].to_numpy()
        rows.append(
            {
                "number": int(one["attractor"]),
                "kind": str(one["kind"].item()),
                "period": swept.known(float(one["period"])),
                "fraction": swept.known(float(one["fraction"])),
                "interval": [float(one["low"]), float(one["high"])],
                "found": int(one["found"]),
                "cycle": int(one["cycle"]),
                "family": bool(one["family"].item()),
                "turns": dict(
                    zip(_texts(one["coordinate"]), one["turns"].values.tolist(), strict=True)
                ),
                "touches": {
                    name: swept.known(number)
                    for name, number in zip(
                        _texts(one["touch"]), one["touches"].values, strict=True
                    )
                },
                "points": points[np.isfinite(points).all(axis=1)].tolist(),
            }
        )
    return rows


def _texts(names: xr.DataArray) -> list[str]:
    return [str(name) for name in names.to_numpy()]


def attractor_table(data: xr.Dataset, further: dict[str, list[Any]]) -> Table:
    """Attractors with their shares; further columns before these."""
    from linkages.plots.chaos.basin_figures import attractor_words

    drawn = bool(np.isfinite(data["fraction"]).all()) and data.sizes["attractor"] > 0
    rows = []
    for index, row in enumerate(attractor_rows(data)):
        low, high = row["interval"]
        words = attractor_words(data, index)
        cells = [row["number"], words, *(column[index] for column in further.values())]
        shown = [f"{100 * part:.2f}" for part in (row["fraction"], low, high)] if drawn else []
        rows.append([*cells, *shown])
    heads = ["attractor", "motion", *further]
    heads += ["share (%)", "from", "to"] if drawn else []
    columns = [Column(head) for head in heads]
    return Table("Attractors", columns, rows, numbers=len(heads) - 2)


def _report(data: xr.Dataset) -> Report:
    from linkages.attractors.basins import reasons_of

    said, basin = data.attrs, data["basin"].to_numpy()
    failures = swept.counted_texts(reasons_of(data))
    cells = [int((basin == number).sum()) for number in data["attractor"].to_numpy()]
    rows = attractor_rows(data)
    kinds = [row["kind"] for row in rows]
    decided = len(kinds) - kinds.count("undecided")
    started = int((data["draw_basin"] > 0).sum())
    notes = [str(said["warning"])] if said["warning"] else []
    if said["draws"]:
        notes.append(
            f"shares of {started} states drawn from the box {said['box']} (seed {said['seed']}), "
            f"with exact binomial intervals of {100 * said['confidence']:.0f} %"
        )
    notes += swept.failure_notes(failures, "start")
    found = f"{decided} attractor{'' if decided == 1 else 's'}"
    return Report(
        name=said["name"],
        summary=f"{found}, {basin.size} starts over {said['x']} and {said['y']}",
        parts=[attractor_table(data, {"cells": cells}), Notes(notes)],
        data={
            "mechanism": said["name"],
            "x": said["x"],
            "y": said["y"],
            "box": said["box"],
            "draws": started,
            "seed": said["seed"],
            "confidence": said["confidence"],
            "attractors": rows,
            "cells": cells,
            "states": _texts(data["state"]),
            "interrupted": bool(said["interrupted"]),
            "warning": said["warning"] or None,
            "failures": failures,
        },
    )
