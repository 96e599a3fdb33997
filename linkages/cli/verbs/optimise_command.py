"""``optimise``: the best numbers of a definition, as a file, tables and figures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console

from linkages.cli.requests import File, Request
from linkages.cli.terminal import number, print_notes, table
from linkages.spec.units import unit

if TYPE_CHECKING:
    import xarray as xr

    from linkages.design.optimise import Optimum


def run(
    request: Request,
    vary: Sequence[str],
    minimise: str | None,
    maximise: str | None,
    subject_to: Sequence[str] | None,
    search: str,
    starts: int,
    seed: int,
    runs: int | None,
    cores: int | None,
) -> int:
    """Search, and write what was found; returns the exit code."""
    from linkages.design.optimise import optimise

    with request.computing("optimising", "of the runs") as update:

        def watch(done: int, value: float) -> None:
            share = done / runs if runs else 0.0
            update(share, f"{done} runs, best {number(value)}")

        found = optimise(
            request.mechanism, [*vary], minimise=minimise, maximise=maximise,
            subject_to=subject_to or (), search=str(search), starts=starts, seed=seed, runs=runs,
            cores=cores, watch=watch, **request.given,
        )  # fmt: skip
    content = _content(found.data)
    files = request.write(_files(found, request.figures))
    return request.report(content, files, lambda screen: _print(content, screen))


def _files(found: Optimum, figures: bool) -> Iterator[File]:
    yield "optimised.yaml", found.text
    yield "optimise", found.data
    yield "optimise", _columns(found.data)
    if figures:
        from linkages.plots.study_figures import convergence, fit_curves

        yield "optimise_convergence", convergence(found.data)
        yield "optimise_curves", fit_curves(found.data)


def _columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each run."""
    columns: dict[str, Any] = {"run": np.arange(1, data.sizes["run"] + 1)}
    for path, name in zip(data["path"].to_numpy(), data["path_unit"].to_numpy(), strict=True):
        values = data["history_number"].sel(path=path).to_numpy()
        columns[f"{path} ({name})" if name else str(path)] = values / _scale(str(name))
    goal = str(data["history"].attrs["long_name"])
    columns[_head(goal, str(data["history"].attrs["units"]))] = data["history_value"].to_numpy()
    columns["violation"] = data["history_violation"].to_numpy()
    return columns


def _head(name: str, units: str) -> str:
    return f"{name} ({units})" if units else name


def _scale(name: str) -> float:
    return unit(name).scale if name else 1.0


def _content(data: xr.Dataset) -> dict[str, Any]:
    numbers = [
        {
            "path": str(path),
            "start": float(data["number"][0, place]) / scale,
            "optimum": float(data["number"][1, place]) / scale,
            "lower": float(data["lower"][place]) / scale,
            "upper": float(data["upper"][place]) / scale,
            "units": str(data["path_unit"][place].item()),
            "bound": str(data["bound"][place].item()),
        }
        for place, path in enumerate(data["path"].to_numpy())
        for scale in [_scale(str(data["path_unit"][place].item()))]
    ]
    constraints = [
        {
            "constraint": str(text),
            "start": float(data["constraint_value"][0, place]),
            "optimum": float(data["constraint_value"][1, place]),
            "units": str(data["constraint_units"][place].item()),
            "active": bool(data["active"][place]),
        }
        for place, text in enumerate(data["constraint"].to_numpy())
    ]
    return {
        "mechanism": data.attrs["name"],
        "goal": data.attrs["goal"],
        "start": float(data["value"][0]),
        "optimum": float(data["value"][1]),
        "units": data["value"].attrs["units"],
        "runs": int(data.attrs["runs"]),
        "runs_missing": int(data.attrs["runs_missing"]),
        "search": data.attrs["search"],
        "plateau": bool(data.attrs["plateau"]),
        "optimality": _finite(float(data.attrs["optimality"])),
        "notes": [*data.attrs["notes"]],
        "numbers": numbers,
        "constraints": constraints,
    }


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _print(content: dict[str, Any], screen: Console) -> None:
    missing = content["runs_missing"]
    failed = f", {missing} of which could not be computed" if missing else ""
    title = f"{content['mechanism']}: {content['goal']}, {content['runs']} runs{failed}"
    screen.print(title, markup=False)
    rows = [
        [row[key] for key in ("path", "start", "optimum", "lower", "upper", "units", "bound")]
        for row in content["numbers"]
    ]
    heads = ["number", "start", "optimum", "from", "to", "unit", "at bound"]
    screen.print(table("Numbers", heads, rows))
    goal = [content["goal"], content["start"], content["optimum"], content["units"], ""]
    limits = [
        [
            row["constraint"],
            row["start"],
            row["optimum"],
            row["units"],
            "yes" if row["active"] else "",
        ]
        for row in content["constraints"]
    ]
    heads = ["measure", "start", "optimum", "unit", "active"]
    screen.print(table("Goal and constraints", heads, [goal, *limits]))
    if content["optimality"] is not None:
        screen.print(f"first-order optimality {content['optimality']:.1e}")
    print_notes(content["notes"], screen)
