"""``poincare``: points of a section, a table of where they lie, and a figure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.markup import escape

from linkages.cli.requests import File, Request
from linkages.cli.swept import contact_content, free_columns, print_remarks
from linkages.cli.terminal import number, table
from linkages.errors import InputError, Problem

if TYPE_CHECKING:
    import xarray as xr

    from linkages.plots.chaos.section_figures import Zoom

TAKEN = ("period", "phase", "section", "direction")
"""Attributes that say how points are taken."""


def run(request: Request, zoom: Sequence[str] | None) -> int:
    """Compute a section; returns the exit code."""
    from linkages.chaos.sections import poincare

    zooms = _rectangles(request, zoom or ())
    with request.computing("section of") as watch:
        data = poincare(request.mechanism, watch=watch, **request.given)
    of_touches = "touch_rate" in data
    columns = {"time (s)": data["time"].to_numpy(), **free_columns(data)}

    def made() -> Iterator[File]:
        yield "poincare", data
        yield "poincare", columns
        if request.figures:
            from linkages.plots.chaos.section_figures import impact_map_figure, section_figure

            drawn = impact_map_figure(data) if of_touches else section_figure(data, zooms)
            yield "poincare", drawn

    files = request.write(made())
    rows, warning = section_rows(data), data.attrs["warning"]
    notes = [warning] if warning else []
    if zooms and of_touches:
        notes.append("diagrams of touches have no enlarged parts: --zoom was left out")

    def show(screen: Console) -> None:
        screen.print(f"[bold]{escape(data.attrs['name'])}[/bold]: {escape(taken(data))}")
        keys = ("long_name", "element", "units", "least", "greatest", "last")
        heads = ["quantity", "of", "unit", "least", "greatest", "last"]
        cells = [[row[key] for key in keys] for row in rows]
        screen.print(table("Where the points lie", heads, cells, numbers=3))
        print_remarks(data, notes, screen)

    content = {
        "mechanism": data.attrs["name"],
        "points": data.sizes["crossing"],
        "taken": {k: data.attrs[k] for k in TAKEN if k in data.attrs},
        "first": float(data["time"][0]),
        "last": float(data["time"][-1]),
        "coordinates": rows,
        "contact": contact_content(data),
        "warning": warning or None,
    }
    return request.report(content, files, show)


def _rectangles(request: Request, texts: Sequence[str]) -> list[Zoom]:
    """Parts of the section that are enlarged, checked before anything is computed."""
    if not texts:
        return []
    from linkages.kernel.system import System
    from linkages.plots.chaos.section_figures import coordinate_of, read_zoom

    try:
        found = [read_zoom(text) for text in texts]
        coordinate_of(found, System(request.mechanism).topology.free)
    except ValueError as error:
        raise InputError("--zoom", [Problem(message=str(error))]) from None
    return found


def taken(data: xr.Dataset) -> str:
    """How many points there are, and where they were taken."""
    time, count = data["time"].to_numpy(), data.sizes["crossing"]
    points = f"{count} point{'' if count == 1 else 's'}"
    span = f"from t = {number(float(time[0]))} s to {number(float(time[-1]))} s"
    if "period" in data.attrs:
        return f"{points}, one per period of {number(data.attrs['period'])} s, {span}"
    ways = {"up": "upwards", "down": "downwards", "both": "both ways"}
    way = ways[data.attrs["direction"]]
    return f"{points}, where {data.attrs['section']} is crossed {way}, {span}"


def section_rows(data: xr.Dataset) -> list[dict[str, Any]]:
    """Range and last value of every free coordinate and its rate."""
    rows = []
    for name, array in data.data_vars.items():
        if "crossing" not in array.dims:
            continue
        dim = str(array.dims[1])
        for element in data[dim].values:
            values = array.sel({dim: element}).to_numpy()
            rows.append(
                {
                    "variable": str(name),
                    "element": str(element),
                    "least": float(np.min(values)),
                    "greatest": float(np.max(values)),
                    "last": float(values[-1]),
                    "units": array.attrs["units"],
                    "long_name": array.attrs["long_name"],
                }
            )
    return rows
