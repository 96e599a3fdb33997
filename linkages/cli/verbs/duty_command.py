"""``duty``: what drives must give over a cycle, flywheels, and motors beside what is needed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli.requests import File, Request
from linkages.reports.report import Notes, Part, Report, Table, headed

if TYPE_CHECKING:
    import xarray as xr


def run_duty(request: Request, fluctuation: float | None, motors: Sequence[str] | None) -> int:
    """Compute a cycle, write, draw and print it; returns the exit code."""
    from linkages.design.duty import duty

    with request.computing("duty of"):
        data = duty(request.mechanism, fluctuation=fluctuation, motors=motors or ())

    def figures() -> Iterator[File]:
        from linkages.plots.study_figures import duty_figure

        yield "duty", duty_figure(data)

    rows = _rows(data)
    cycle = data.attrs["cycle"]
    report = Report(
        parts=[*_parts(data, rows, cycle), Notes([t for t in [str(data.attrs["warning"])] if t])],
        data={"mechanism": data.attrs["name"], "cycle": cycle, "drives": rows},
    )
    numbers = data.drop_vars(["effort", "speed", "time", "turns"])
    columns = {headed(str(n), str(numbers[n].attrs["units"])): numbers[n].values.tolist()
               for n in numbers.data_vars}  # fmt: skip
    table = {"drive": data["drive"].values.tolist(), **columns}
    return request.publish(report, [("duty", data), ("duty", table)], figures)


def _rows(data: xr.Dataset) -> list[dict[str, Any]]:
    """A row for each drive; what does not exist is None."""
    names = [str(name) for name in data.data_vars if data[name].dims == ("drive",)]
    result = []
    for drive in data["drive"].values:
        own = {name: float(data[name].sel(drive=drive)) for name in names}
        known = {name: value if np.isfinite(value) else None for name, value in own.items()}
        result.append({"drive": str(drive), **known})
    return result


def _parts(data: xr.Dataset, rows: Sequence[dict[str, Any]], cycle: float) -> Iterator[Part]:
    def columns(*names: str) -> list[str]:
        units = {n: str(data[n].attrs["units"]) for n in names}
        return [f"{n}: {headed(n.replace('_', ' '), units[n])}" for n in names]

    yield Table.of(
        f"Duty over a cycle of {cycle:.6g} s", rows, "drive",
        *columns("effort_peak", "effort_rms", "effort_mean", "speed_peak", "power_peak",
                 "power_mean", "energy_given", "energy_returned"),
    )  # fmt: skip
    steady = [row for row in rows if row["energy_fluctuation"] is not None]
    if steady:
        names = ["energy_fluctuation"]
        names += ["flywheel"] if steady[0]["flywheel"] is not None else []
        yield Table.of("Drives that turn steadily", steady, "drive", *columns(*names))
    fitted = [row for row in rows if row["margin"] is not None]
    if fitted:
        yield Table.of("Motors", fitted, "drive", *columns("margin", "margin_time"))
