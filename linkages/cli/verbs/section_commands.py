"""Commands that analyse one motion: ``poincare``, ``lyapunov`` and ``chaos``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli.requests import INTEGRATION, File, Request
from linkages.cli.swept import contact_content, free_columns, remarks
from linkages.cli.terminal import json_text
from linkages.errors import ComputationError, InputError, Problem
from linkages.reading.wording import to_error
from linkages.reports.report import Notes, Part, Report, Table, number

if TYPE_CHECKING:
    import xarray as xr

    from linkages.chaos.findings import ChaosReport
    from linkages.components.mechanisms.mechanism import Mechanism
    from linkages.plots.chaos.chaos_figures import Zoom


TAKEN = ("period", "phase", "section", "direction")
"""Attributes that say how points are taken."""


def run_poincare(request: Request, zoom: Sequence[str] | None) -> int:
    """Compute a section; returns the exit code."""
    from linkages.chaos.sections import poincare

    zooms = _rectangles(request, zoom or ())
    with request.computing("section of") as watch:
        data = poincare(request.mechanism, watch=watch, **request.given)
    of_touches = "touch_rate" in data

    def figures() -> Iterator[File]:
        from linkages.plots.chaos.chaos_figures import impact_map_figure, section_figure

        yield "poincare", impact_map_figure(data) if of_touches else section_figure(data, zooms)

    rows, warning = _rows(data), data.attrs["warning"]
    notes = [warning] if warning else []
    if zooms and of_touches:
        notes.append("diagrams of touches have no enlarged parts: --zoom was left out")
    columns = "long_name: quantity", "element: of", "units: unit", "least", "greatest", "last"
    report = Report(
        name=data.attrs["name"],
        summary=_taken(data),
        parts=[Table.of("Where the points lie", rows, *columns, numbers=3), *remarks(data, notes)],
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
    from linkages.plots.chaos.chaos_figures import coordinate_of, read_zoom

    try:
        result = [read_zoom(text) for text in texts]
        coordinate_of(result, System(request.mechanism).topology.free)
    except ValueError as error:
        raise InputError("--zoom", [Problem(message=str(error))]) from None
    return result


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


def run_lyapunov(request: Request) -> int:
    """Compute exponents; returns the exit code."""
    from linkages.chaos.exponents import certificate_rows, exponent_rows
    from linkages.chaos.lyapunov import lyapunov
    from linkages.reports.verdict_report import certificate_tables

    with request.computing("exponents of") as watch:
        data = lyapunov(request.mechanism, watch=watch, **request.given)
    columns = {"time (s)": data["time"].to_numpy()} | {
        f"exponent {index} (1/s)": data["history"].sel(index=index).to_numpy()
        for index in data["index"].to_numpy()
    }

    def figures() -> Iterator[File]:
        from linkages.plots.chaos.chaos_figures import exponents
        from linkages.plots.style import figure_of

        yield "lyapunov", figure_of(exponents(data))

    rows, known, said = exponent_rows(data), certificate_rows(data), data.attrs
    end, lost = float(data["time"][-1]), int(said["lost"])
    over = ""
    if request.given.get("interval") is not None:
        over = f" over {said['periods']} intervals of {number(said['period'])} s,"
    parts: list[Part] = []
    if rows:
        heads = ["exponent", "sign", "value (1/s)", "standard error"]
        cells = [[r["index"], r["sign"], *to_error(r["value"], r["error"])] for r in rows]
        total, by = to_error(said["sum"], said["sum_error"])
        parts = [Table("Lyapunov exponents", heads, cells, 2), f"sum of these: {total} ± {by} 1/s"]
    if lost:
        parts.append(
            f"{lost}{' more' if rows else ''} {'is' if lost == 1 else 'are'} −∞: where "
            "rigid contacts close or friction sticks, motions merge with their neighbours"
        )
    if "least_touch" in said:
        parts.append(
            f"slowest touch: {number(said['least_touch'])} in {said['least_touch_of']} at t = "
            f"{number(said['least_touch_time'])} s; exponents converge slowly where that tends to "
            "zero"
        )
    report = Report(
        name=said["name"],
        summary=f"Lyapunov exponents{over} up to t = {number(end)} s",
        parts=[
            *parts,
            *certificate_tables(known),
            *remarks(data, [said["warning"]] if said["warning"] else []),
        ],
        data={
            "mechanism": said["name"],
            "end": end,
            "periods": int(said["periods"]),
            "period": float(said["period"]),
            "exponents": rows,
            "sum": {"value": said["sum"], "error": said["sum_error"]},
            "lost": lost,
            "least_touch": said.get("least_touch"),
            "certificate": known,
            "contact": contact_content(data),
            "settled": bool(said["settled"]),
            "warning": said["warning"] or None,
        },
    )
    return request.publish(report, [("lyapunov", data), ("lyapunov", columns)], figures)


def run_chaos(request: Request, periods: int | None, quick: bool) -> int:
    """Judge a motion; returns the exit code."""
    from linkages.chaos.findings import verdict
    from linkages.chaos.judge import FEWEST_PERIODS
    from linkages.reports.verdict_report import verdict_report

    mechanism, length = request.mechanism, FEWEST_PERIODS if periods is None and quick else periods
    with request.computing("judging") as watch:
        result = verdict(mechanism, watch=watch, **{**request.given, "periods": length})
    if quick and periods is None and result.verdict == "undecided":
        with request.computing("judging longer") as watch:
            result = verdict(mechanism, watch=watch, **{**request.given, "periods": None})

    orbit, words = _orbit_of(mechanism, result, request)

    def reported(figures: Mapping[str, Any]) -> Report:
        report = verdict_report(result, mechanism, figures)
        return replace(report, parts=[*report.parts, *words], data={**report.data, **orbit})

    def made() -> Iterator[File]:
        from linkages.plots.chaos.chaos_figures import chaos_figures
        from linkages.reports.pages import page

        yield "chaos.json", json_text({**result.to_dict(), **orbit})
        yield "chaos_section", result.section
        yield "chaos_exponents", result.exponents
        figures = chaos_figures(result) if request.figures else {}
        yield from figures.items()
        yield "chaos.html", page(reported(figures), mechanism)

    files = request.write(made(), {**request.asked, "periods": result.run["periods"]})
    return request.report(reported({}), files)


def _orbit_of(
    mechanism: Mechanism, result: ChaosReport, request: Request
) -> tuple[dict[str, Any], list[Part]]:
    """The orbit of a periodic motion of drives, as data and as words; nothing of others."""
    if result.verdict != "periodic" or result.period is None or "section" in result.section.attrs:
        return {}, []
    from linkages.orbits.orbit import multiplier_texts, orbit

    run = {name: request.given[name] for name in INTEGRATION if name in request.given}
    if result.run["skip"]:
        run["skip"] = int(result.run["skip"])
    try:
        data = orbit(mechanism, periods=result.period, **run)
    except (ComputationError, InputError) as error:
        return {}, [Notes([f"the orbit itself was not located: {error}"])]
    names = data["coordinate"].to_numpy().tolist()
    own = {
        "period": data.attrs["period"],
        "periods": data.attrs["periods"],
        "state": dict(zip(names, data["state"].to_numpy().tolist(), strict=True)),
        "multipliers": data["multiplier"].to_numpy().tolist(),
        "stable": bool(data.attrs["stable"]),
        "contacts": data.attrs["contacts"],
    }
    texts = multiplier_texts(data)
    state = ", ".join(f"{name} = {number(value)}" for name, value in own["state"].items())
    text = (
        f"orbit: period {number(own['period'])} s, at its beginning {state}; multipliers "
        f"{', '.join(texts)}"
    )
    return {"orbit": own}, [text]
