"""``poincare``: points of a section, a table of where they lie, and a figure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli.requests import File, Request
from linkages.cli.swept import contact_content, free_columns, remarks
from linkages.errors import InputError, Problem
from linkages.reports.report import Report, Table, number

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

    def figures() -> Iterator[File]:
        from linkages.plots.chaos.section_figures import impact_map_figure, section_figure

        yield "poincare", impact_map_figure(data) if of_touches else section_figure(data, zooms)

    rows, warning = _rows(data), data.attrs["warning"]
    notes = [warning] if warning else []
    if zooms and of_touches:
        notes.append("diagrams of touches have no enlarged parts: --zoom was left out")
    columns = {
        "long_name": "quantity", "element": "of", "units": "unit", "least": "least",
        "greatest": "greatest", "last": "last",
    }  # fmt: skip
    report = Report(
        name=data.attrs["name"],
        summary=_taken(data),
        parts=[Table("Where the points lie", columns, rows, numbers=3), *remarks(data, notes)],
        data={
            "mechanism": data.attrs["name"],
            "points": data.sizes["crossing"],
            "taken": {k: data.attrs[k] for k in TAKEN if k in data.attrs},
            "first": float(data["time"][0]),
            "last": float(data["time"][-1]),
            "coordinates": rows,
            "contact": contact_content(data),
            "warning": warning or None,
        },
    )
    points = {"time (s)": data["time"].to_numpy(), **free_columns(data)}
    return request.publish(report, [("poincare", data), ("poincare", points)], figures)


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


def _taken(data: xr.Dataset) -> str:
    """How many points there are, and where they were taken."""
    time, count = data["time"].to_numpy(), data.sizes["crossing"]
    points = f"{count} point{'' if count == 1 else 's'}"
    span = f"from t = {number(float(time[0]))} s to {number(float(time[-1]))} s"
    if "period" in data.attrs:
        return f"{points}, one per period of {number(data.attrs['period'])} s, {span}"
    ways = {"up": "upwards", "down": "downwards", "both": "both ways"}
    way = ways[data.attrs["direction"]]
    return f"{points}, where {data.attrs['section']} is crossed {way}, {span}"


def _rows(data: xr.Dataset) -> list[dict[str, Any]]:
    """Range and last value of every free coordinate and its rate."""
    return [
        {
            "variable": str(name),
            "element": str(element),
            "least": float(np.min(values)),
            "greatest": float(np.max(values)),
            "last": float(values[-1]),
            "units": array.attrs["units"],
            "long_name": array.attrs["long_name"],
        }
        for name, array in data.data_vars.items()
        if "crossing" in array.dims
        for element in data[array.dims[1]].values
        for values in [array.sel({array.dims[1]: element}).to_numpy()]
    ]
