"""Commands that find attractors of many starts: ``basins``, and ``bifurcation --starts``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli import swept
from linkages.cli.requests import File, Request, each_read, ranges
from linkages.reports.report import Column, Notes, Part, Report, Table, headed

if TYPE_CHECKING:
    import xarray as xr

    from linkages.sweeps.axes import Axis


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
        from linkages.plots.chaos.attractor_figures import basin_figure

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
    from linkages.plots.chaos.attractor_figures import attractor_words

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


def many_starts(
    request: Request,
    axis: Axis,
    starts: int,
    within: Sequence[str],
    seed: int,
    given: Mapping[str, Any],
    store: Path | None,
    **where: Any,
) -> int:
    """A diagram over a parameter of the attractors of many starts; returns the exit code."""
    from linkages.attractors.hysteresis import attractor_diagram, basin_options
    from linkages.sweeps.axes import parse_range

    def side(text: str) -> Axis:
        """A range of a box needs no number of values."""
        return parse_range(text if text.count(":") > 1 else f"{text}:2")

    box = each_read("--within", within, side)

    def task(**watch: Any) -> xr.Dataset:
        own = basin_options({**given, **request.given})
        how = {"within": box, "seed": seed, "store": store, **where, **watch, **own}
        return attractor_diagram(request.mechanism, axis, starts=starts, **how)

    data = swept.result(request, axis.label, "start", task)

    def figures() -> Iterator[File]:
        from linkages.plots.chaos.attractor_figures import hysteresis_figure

        yield "bifurcation", hysteresis_figure(data)
        yield "bifurcation_rates", hysteresis_figure(data, rates=True)

    files: list[File] = [
        ("bifurcation", data),
        ("bifurcation", _diagram_points(data)),
        ("bifurcation_values", _diagram_values(data)),
    ]
    return swept.publish(request, _diagram_report(data), data, "start", files, figures, store)


def _diagram_points(data: xr.Dataset) -> dict[str, Any]:
    """A row for each section point of each attractor at each value."""
    from linkages.attractors.hysteresis import found_arrays

    found = found_arrays(data)
    columns = {
        head: array.to_numpy()[found["value"]]
        for head, array in swept.varied_columns(data, "value").items()
    }
    columns |= {
        "attractor": data["attractor"].to_numpy()[found["attractor"]],
        "point": found["point"] + 1,
    }
    for index, name in enumerate(_texts(data["state"])):
        columns[headed(name, data["state_units"].to_numpy()[index])] = found["states"][:, index]
    return columns


def _diagram_values(data: xr.Dataset) -> dict[str, Any]:
    """A row for each attractor at each value at which there is one."""
    there = (data["exists"] > 0).to_numpy().ravel()
    words = np.array(["", "met", "followed"], dtype=object)
    columns = {
        **swept.varied_columns(data, "value"),
        "attractor": data["attractor"],
        "kind": data["kind"],
        "exists": data["exists"].copy(data=words[data["exists"].to_numpy()]),
        "period (s)": data["period"],
        "starts": data["found"],
        "share": data["fraction"],
        "from": data["low"],
        "to": data["high"],
    }
    rows = swept.flattened(columns, data["exists"])
    return {head: column[there] for head, column in rows.items()}


def _diagram_report(data: xr.Dataset) -> Report:
    from linkages.attractors.hysteresis import coexisting
    from linkages.plots.chaos.attractor_figures import attractor_words

    said, path = data.attrs, data.attrs["varied"]
    values, exists = data[path].to_numpy(), data["exists"].to_numpy()
    unit = data[path].attrs.get("units", "")
    kinds = [str(kind) for kind in data["kind"].to_numpy()]
    decided = np.array([kind != "undecided" for kind in kinds], dtype=bool)
    attractors = []
    for index, kind in enumerate(kinds):
        there = np.flatnonzero(exists[:, index])
        attractors.append(
            {
                "number": index + 1,
                "kind": kind,
                "cycle": int(data["cycle"][index]),
                "from": float(values[there].min()),
                "to": float(values[there].max()),
                "values": len(there),
                "followed": int((exists[:, index] == 2).sum()),
                "period": [swept.known(float(period)) for period in data["period"][there, index]],
                "fraction": [swept.known(float(part)) for part in data["fraction"][:, index]],
            }
        )
    rows = [
        [
            row["number"],
            attractor_words(data, index),
            row["from"],
            row["to"],
            row["values"],
            row["followed"],
        ]
        for index, row in enumerate(attractors)
    ]
    stretches = [
        {"from": float(values[first]), "to": float(values[last]), "attractors": list(which)}
        for first, last, which in coexisting(exists[:, decided])
    ]
    jumps = [
        {
            "attractor": int(data["lost"][jump]),
            "last": float(data["last"][jump]),
            "lost": float(data["behind"][jump]),
            "becomes": int(data["became"][jump]) if data["became"][jump] > 0 else None,
        }
        for jump in range(data.sizes["jump"])
    ]
    failures = swept.failures(data)
    notes = [
        f"{said['starts']} states at each value, drawn from the box {said['box']} "
        f"(seed {said['seed']})",
        *swept.failure_notes(failures, "start"),
    ]
    ends = [headed("from", unit), headed("to", unit)]
    parts: list[Part] = [
        Table("Attractors", ["attractor", "motion", *ends, "values", "followed"], rows, numbers=4)
    ]
    if stretches:
        cells = [[s["attractors"], s["from"], s["to"]] for s in stretches]
        parts.append(Table("Several coexist", ["attractors", *ends], cells, numbers=2))
    if jumps:
        heads = ["attractor", headed("exists at", unit), headed("lost at", unit), "becomes"]
        parts.append(Table("Where they are lost", heads, [[*jump.values()] for jump in jumps], 3))
    return Report(
        name=said["name"],
        summary=f"{int(decided.sum())} attractors over {len(values)} values of {path}",
        parts=[*parts, Notes(notes)],
        data={
            "mechanism": said["name"],
            "varied": path,
            "box": said["box"],
            "starts": said["starts"],
            "seed": said["seed"],
            "values": values.tolist(),
            "attractors": attractors,
            "coexisting": stretches,
            "jumps": jumps,
            "interrupted": bool(said["interrupted"]),
            "failures": failures,
        },
    )


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
