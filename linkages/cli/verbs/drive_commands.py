"""``duty``: what drives must give over a cycle; ``workspace``: where two can move a point."""

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

    rows = _duty_rows(data)
    cycle = data.attrs["cycle"]
    report = Report(
        parts=[
            *_duty_parts(data, rows, cycle),
            Notes([t for t in [str(data.attrs["warning"])] if t]),
        ],
        data={"mechanism": data.attrs["name"], "cycle": cycle, "drives": rows},
    )
    numbers = data.drop_vars(["effort", "speed", "time", "turns"])
    columns = {headed(str(n), str(numbers[n].attrs["units"])): numbers[n].values.tolist()
               for n in numbers.data_vars}  # fmt: skip
    table = {"drive": data["drive"].values.tolist(), **columns}
    return request.publish(report, [("duty", data), ("duty", table)], figures)


def _duty_rows(data: xr.Dataset) -> list[dict[str, Any]]:
    """A row for each drive; what does not exist is None."""
    names = [str(name) for name in data.data_vars if data[name].dims == ("drive",)]
    result = []
    for drive in data["drive"].values:
        own = {name: float(data[name].sel(drive=drive)) for name in names}
        known = {name: value if np.isfinite(value) else None for name, value in own.items()}
        result.append({"drive": str(drive), **known})
    return result


def _duty_parts(data: xr.Dataset, rows: Sequence[dict[str, Any]], cycle: float) -> Iterator[Part]:
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


MEANING = (
    "inverse: the point cannot leave in some direction, for which drives would be infinitely fast; "
    "forward: it can move with drives that stand still, so that efforts are unbounded; limit: a "
    "range ends"
)


def run_workspace(
    request: Request,
    point: str | None,
    ranges: Sequence[str] | None,
    samples: int | None,
    own: bool | None,
) -> int:
    """Locate the curves, draw and print them; returns the exit code."""
    from linkages.design.workspace import workspace

    with request.computing("workspace of"):
        given: dict[str, Any] = {"samples": samples, "own": own, "ranges": ranges}
        asked = {name: value for name, value in given.items() if value is not None}
        data = workspace(request.mechanism, point, **asked)

    def figures() -> Iterator[File]:
        from linkages.plots.mechanism.workspace_figure import workspace_figure

        yield "workspace", workspace_figure(data, request.mechanism)

    rows = _curve_rows(data)
    report = Report(
        parts=[
            Table.of(
                f"Curves of the workspace of {data.attrs['point']}", rows,
                "curve", "kind", "branch", "points", "length: length (m)", "least_x: least x (m)",
                "largest_x: largest x (m)", "least_y: least y (m)", "largest_y: largest y (m)",
            ),
            Notes([MEANING]),
        ],
        data={"mechanism": data.attrs["name"], "point": data.attrs["point"], "curves": rows},
    )  # fmt: skip
    return request.publish(
        report, [("workspace", data), ("workspace", _curve_columns(data))], figures
    )


def _curve_rows(data: xr.Dataset) -> list[dict[str, Any]]:
    """A row for each curve."""
    result = []
    for number in np.unique(data["curve"]):
        one = data.isel(node=np.flatnonzero(data["curve"] == number))
        x, y = one["curve_x"].to_numpy(), one["curve_y"].to_numpy()
        result.append(
            {
                "curve": int(number),
                "kind": str(one["kind"].values[0]),
                "branch": str(one["curve_branch"].values[0]),
                "points": len(x),
                "length": float(np.hypot(np.diff(x), np.diff(y)).sum()),
                "least_x": float(x.min()),
                "largest_x": float(x.max()),
                "least_y": float(y.min()),
                "largest_y": float(y.max()),
            }
        )
    return result


def _curve_columns(data: xr.Dataset) -> dict[str, list[Any]]:
    """A row for each point of a curve."""
    drives = data["curve_drive"]
    return {
        "curve": data["curve"].values.tolist(),
        "kind": data["kind"].values.tolist(),
        "branch": data["curve_branch"].values.tolist(),
        "x (m)": data["curve_x"].values.tolist(),
        "y (m)": data["curve_y"].values.tolist(),
        **{
            f"{name} ({units})": drives.sel(drive=name).values.tolist()
            for name, units in zip(
                data["drive"].values, (data[d].attrs["units"] for d in ("first", "second")),
                strict=True,
            )
        },
    }  # fmt: skip
