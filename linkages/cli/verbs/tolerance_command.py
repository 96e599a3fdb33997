"""``tolerance``: contributions of tolerances, the worst case, and the yield of random copies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli import swept
from linkages.cli.requests import File, Request
from linkages.plots.style import scale_of
from linkages.reports.report import Notes, Part, Report, Table, headed

if TYPE_CHECKING:
    import xarray as xr

MANY = 12
"""Contributors that a table has; the rest is a line."""


def run(
    request: Request,
    of: Sequence[str],
    limits: Sequence[str] | None,
    store: Path | None,
    **how: Any,
) -> int:
    """Compute tolerances; returns the exit code."""
    from linkages.design.tolerance import tolerance

    how |= {"limits": tuple(limits or ()), "store": store, **request.given}
    task = partial(tolerance, request.mechanism, list(of), **how)
    data = swept.result(request, "tolerances", "draw", task)

    def figures() -> Iterator[File]:
        from linkages.plots.study_figures import tolerance_figure

        for stem, name in swept.numbered("tolerance", _measures(data)):
            yield stem, tolerance_figure(data, name)

    files: list[File] = [("tolerance", data), ("tolerance", _columns(data))]
    return swept.publish(request, _report(data), data, "draw", files, figures, store)


def _measures(data: xr.Dataset) -> list[str]:
    return [str(name) for name in data["measure"].to_numpy()]


def _columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each draw."""
    columns = {"draw": data["draw"], **swept.varied_columns(data, "draw")}
    for name in _measures(data):
        own = data["sample"].sel(measure=name)
        columns[headed(name, own["units"].values)] = own.drop_vars(["measure", "units"])
    columns |= {"outcome": swept.outcomes(data)[0], **swept.failure_columns(data)}
    return swept.flattened(columns, data["outcome"])


def _measure(data: xr.Dataset, name: str) -> dict[str, Any]:
    own = data.sel(measure=name)
    contributors = [
        {
            "path": str(path),
            "half_width": float(own["half_width"].sel(contributor=path)),
            "units": str(own["contributor_units"].sel(contributor=path).values),
            **{
                key: float(own[key].sel(contributor=path))
                for key in ("sensitivity", "contribution", "share")
            },
        }
        for path in own["contributor"].to_numpy()
    ]
    keys = (
        "nominal", "linear_mean", "linear_deviation", "linear_spread", "mean", "error_of_mean",
        "deviation", "skewness",
    )  # fmt: skip
    return {
        "measure": name,
        "units": str(own["units"].values),
        **{key: swept.known(float(own[key])) for key in keys},
        "worst": [float(value) for value in own["worst"]],
        "worst_in_truth": [swept.known(float(value)) for value in own["corner"]],
        **swept.finite_range(own["sample"].to_numpy()),
        "contributors": sorted(contributors, key=lambda row: -float(row["share"])),
    }


def _yields(data: xr.Dataset) -> list[dict[str, Any]]:
    if "within" not in data:
        return []
    return [
        {"limits": str(name), **{str(b): float(own.sel(bound=b)) for b in own["bound"].to_numpy()}}
        for name, own in zip(data["limit"].to_numpy(), data["within"], strict=True)
    ]


def _report(data: xr.Dataset) -> Report:
    outcomes, yields = swept.outcomes(data)[1], _yields(data)
    draws, computed = int(data["outcome"].size), int((data["outcome"] == 0).sum())
    measures = [_measure(data, name) for name in _measures(data)]
    notes = str(data.attrs["remarks"]).splitlines()
    parts = [part for measure in measures for part in _parts(measure)]
    if yields:
        rows = [
            [row["limits"], f"{row['share']:.2%}", f"{row['low']:.2%} to {row['high']:.2%}"]
            for row in yields
        ]
        parts.append(Table("Yield", ["limits", "yield", "95 % confidence"], rows, numbers=1))
    return Report(
        name=data.attrs["name"],
        summary=f"{computed} of {draws} draws",
        parts=[*parts, Notes(notes)],
        data={
            "mechanism": data.attrs["name"],
            "draws": draws,
            "computed": computed,
            "interrupted": bool(data.attrs["interrupted"]),
            "outcomes": outcomes,
            "measures": measures,
            "yields": yields,
            "remarks": notes,
            "failures": swept.failures(data),
        },
    )


def _parts(measure: dict[str, Any]) -> Iterator[Part]:
    """What contributes to the variance of a measure, and its distribution."""
    units = measure["units"]
    spread = [measure["linear_deviation"], measure["deviation"] or 0.0]
    sizes = [row["contribution"] for row in measure["contributors"]]
    changes = scale_of(sizes + spread, units)
    rows = [
        [
            row["path"],
            scale_of([row["half_width"]], row["units"]).text(row["half_width"]),
            f"{row['sensitivity']:.4g} {_ratio(units, row['units'])}".rstrip(),
            changes.text(row["contribution"]),
            f"{row['share']:.1%}",
        ]
        for row in measure["contributors"][:MANY]
    ]
    heads = ["contributor", "tolerance ±", "sensitivity", "contribution ±", "share of variance"]
    yield Table(measure["measure"], heads, rows, numbers=1)
    left = measure["contributors"][MANY:]
    if left:
        share = sum(row["share"] for row in left)
        yield f"and {len(left)} others with {share:.1%} of the variance"
    yield Table("", ["", "linear", "random copies"], _compared(measure), numbers=1)


def _compared(measure: dict[str, Any]) -> list[list[str]]:
    nominal, units = measure["nominal"], measure["units"]
    low, high = measure["worst"]
    real = [value if value is not None else float("nan") for value in measure["worst_in_truth"]]
    changes = [abs(v - nominal) for v in (low, high, *real) if np.isfinite(v)]
    scale, small = scale_of([nominal, low, high], units), scale_of(changes, units)

    def shown(value: float | None) -> str:
        if value is None or not np.isfinite(value):
            return "none"
        if nominal == 0.0:
            return scale.text(value)
        sign = "+" if value >= nominal else "−"
        return f"{scale.text(nominal)} {sign} {small.text(abs(value - nominal))}"

    spreads = [small.text(measure[key]) for key in ("linear_spread", "deviation")]
    return [
        ["mean", shown(measure["linear_mean"]), shown(measure["mean"])],
        ["standard deviation", *spreads],
        ["least", shown(low), shown(measure["least"])],
        ["greatest", shown(high), shown(measure["greatest"])],
        ["in truth at the linear worst case", f"{shown(real[0])} to {shown(real[1])}", ""],
    ]


def _ratio(units: str, other: str) -> str:
    if units == other:
        return ""
    return f"{units or '1'}/{other}" if other else units
