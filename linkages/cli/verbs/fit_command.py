"""``fit``: numbers with which the motion goes as it was measured, with their standard errors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console

from linkages.cli.requests import File, Request, overrides
from linkages.cli.terminal import number, print_notes, table
from linkages.spec.units import unit

if TYPE_CHECKING:
    import xarray as xr

    from linkages.design.fit import Fitted


def run(
    request: Request,
    to: Path,
    vary: Sequence[str],
    sigma: Sequence[str] | None,
    starts: int,
    seed: int,
) -> int:
    """Fit, and write what was found; returns the exit code."""
    from linkages.design.fit import fit

    spread = overrides("--sigma", sigma or ())
    with request.computing("fitting", "of the runs") as update:
        found = fit(
            request.mechanism, to, [*vary], sigma=spread, starts=starts, seed=seed,
            watch=lambda done, best: update(0.0, f"{done} runs, chi-square {number(best)}"),
            **request.given,
        )  # fmt: skip
    content = _content(found.data)
    files = request.write(_files(found, request.figures))
    return request.report(content, files, lambda screen: _print(content, screen))


def _files(found: Fitted, figures: bool) -> Iterator[File]:
    yield "fitted.yaml", found.text
    yield "fit", found.data
    yield "fit", _columns(found.data)
    if figures:
        from linkages.plots.study_figures import fit_figure

        yield "fit", fit_figure(found.data)


def _columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each time."""
    columns: dict[str, Any] = {"time (s)": data["time"].to_numpy()}
    names = data["series"].to_numpy(), data["series_units"].to_numpy()
    for place, (name, units) in enumerate(zip(*names, strict=True)):
        head = f" ({units})" if units else ""
        for kind in ("measured", "computed"):
            columns[f"{kind} {name}{head}"] = data[kind].to_numpy()[place]
        columns[f"residual {name} (sigma)"] = data["residual"].to_numpy()[place]
    return columns


def _content(data: xr.Dataset) -> dict[str, Any]:
    rows = []
    for place, path in enumerate(data["path"].to_numpy()):
        units = str(data["path_unit"][place].item())
        scale = unit(units).scale if units else 1.0
        error = float(data["standard_error"][place]) / scale
        rows.append(
            {
                "path": str(path),
                "start": float(data["number"][0, place]) / scale,
                "fit": float(data["number"][1, place]) / scale,
                "standard_error": error if np.isfinite(error) else None,
                "units": units,
            }
        )
    attrs = data.attrs
    chance = float(attrs["probability"])
    return {
        "mechanism": attrs["name"],
        "values": int(attrs["values"]),
        "runs": int(attrs["runs"]),
        "numbers": rows,
        "correlation": data["correlation"].to_numpy().tolist(),
        "chi_square": float(attrs["chi_square"]),
        "degrees_of_freedom": int(attrs["degrees_of_freedom"]),
        "probability": chance if np.isfinite(chance) else None,
        "sigma_known": bool(attrs["sigma_known"]),
        "notes": [*attrs["notes"]],
    }


def _print(content: dict[str, Any], screen: Console) -> None:
    title = f"{content['mechanism']}: {content['values']} values, {content['runs']} runs"
    screen.print(title, markup=False)
    keys = ("path", "start", "fit", "standard_error", "units")
    rows = [[row[key] for key in keys] for row in content["numbers"]]
    screen.print(table("Numbers", ["number", "start", "fit", "standard error", "unit"], rows))
    if len(rows) > 1 and np.isfinite(content["correlation"]).any():
        paths = [row["path"] for row in content["numbers"]]
        cells = [
            [path, *(None if value != value else f"{value:.3f}" for value in line)]
            for path, line in zip(paths, content["correlation"], strict=True)
        ]
        screen.print(table("Correlation", ["", *paths], cells, numbers=len(paths)))
    freedom, square = content["degrees_of_freedom"], content["chi_square"]
    words = f"sum of squares {number(square)}"
    if content["sigma_known"]:
        words = f"chi-square {number(square)}"
        if content["probability"] is not None:
            words += f", as large by chance: {content['probability']:.3g}"
    screen.print(f"{words}; {freedom} degrees of freedom", markup=False)
    print_notes(content["notes"], screen)
