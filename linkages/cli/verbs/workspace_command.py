"""``workspace``: where two drives can move a point, and the singular curves there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli.requests import File, Request
from linkages.reports.report import Notes, Report, Table

if TYPE_CHECKING:
    import xarray as xr

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

    rows = _rows(data)
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
    return request.publish(report, [("workspace", data), ("workspace", _columns(data))], figures)


def _rows(data: xr.Dataset) -> list[dict[str, Any]]:
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


def _columns(data: xr.Dataset) -> dict[str, list[Any]]:
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
