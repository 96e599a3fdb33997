"""``fit``: numbers with which the motion goes as it was measured, with their standard errors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli.requests import File, Request, overrides
from linkages.cli.swept import known
from linkages.reports.report import Notes, Part, Report, Table, headed, number
from linkages.spec.units import scale_to_si

if TYPE_CHECKING:
    import xarray as xr


def run(
    request: Request, to: Path, vary: Sequence[str], sigma: Sequence[str] | None, **how: Any
) -> int:
    """Fit, and write what was found; returns the exit code."""
    from linkages.design.fit import fit

    spread = overrides("--sigma", sigma or ())
    with request.computing("fitting", "of the runs") as update:
        found = fit(
            request.mechanism, to, [*vary], sigma=spread, **how, **request.given,
            watch=lambda done, best: update(0.0, f"{done} runs, chi-square {number(best)}"),
        )  # fmt: skip
    data = found.data

    def figures() -> Iterator[File]:
        from linkages.plots.study_figures import fit_figure

        yield "fit", fit_figure(data)

    files: list[File] = [("fitted.yaml", found.text), ("fit", data), ("fit", _columns(data))]
    return request.publish(_report(data), files, figures)


def _columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each time."""
    columns: dict[str, Any] = {"time (s)": data["time"].to_numpy()}
    names = data["series"].to_numpy(), data["series_units"].to_numpy()
    for place, (name, units) in enumerate(zip(*names, strict=True)):
        for kind in ("measured", "computed"):
            columns[headed(f"{kind} {name}", units)] = data[kind].to_numpy()[place]
        columns[f"residual {name} (sigma)"] = data["residual"].to_numpy()[place]
    return columns


def _report(data: xr.Dataset) -> Report:
    rows = [
        {
            "path": str(path),
            "start": float(data["number"][0, place]) / scale,
            "fit": float(data["number"][1, place]) / scale,
            "standard_error": known(float(data["standard_error"][place]) / scale),
            "units": units,
        }
        for place, path in enumerate(data["path"].to_numpy())
        for units in [str(data["path_unit"][place].item())]
        for scale in [scale_to_si(units)]
    ]
    columns = {
        "path": "number", "start": "start", "fit": "fit", "standard_error": "standard error",
        "units": "unit",
    }  # fmt: skip
    said, correlation = data.attrs, data["correlation"].to_numpy()
    name, freedom, chance = (
        said["name"],
        int(said["degrees_of_freedom"]),
        known(said["probability"]),
    )
    parts: list[Part] = [Table("Numbers", columns, rows)]
    if len(rows) > 1 and np.isfinite(correlation).any():
        paths = [str(row["path"]) for row in rows]
        cells: list[list[str | None]] = [
            [path, *(None if np.isnan(value) else f"{value:.3f}" for value in line)]
            for path, line in zip(paths, correlation, strict=True)
        ]
        parts.append(Table("Correlation", ["", *paths], cells, numbers=len(paths)))
    words = f"sum of squares {number(said['chi_square'])}"
    if said["sigma_known"]:
        by_chance = "" if chance is None else f", as large by chance: {chance:.3g}"
        words = f"chi-square {number(said['chi_square'])}{by_chance}"
    return Report(
        name=name,
        summary=f"{said['values']} values, {said['runs']} runs",
        parts=[*parts, f"{words}; {freedom} degrees of freedom", Notes(said["notes"])],
        data={
            "mechanism": name,
            "values": int(said["values"]),
            "runs": int(said["runs"]),
            "numbers": rows,
            "correlation": correlation.tolist(),
            "chi_square": float(said["chi_square"]),
            "degrees_of_freedom": freedom,
            "probability": chance,
            "sigma_known": bool(said["sigma_known"]),
            "notes": [*said["notes"]],
        },
    )
