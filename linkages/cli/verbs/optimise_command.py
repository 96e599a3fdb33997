"""``optimise``: the best numbers of a definition, as a file, tables and figures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli.requests import File, Request
from linkages.cli.swept import known
from linkages.reports.report import Notes, Part, Report, Table, headed, number
from linkages.spec.units import scale_to_si

if TYPE_CHECKING:
    import xarray as xr


def run(
    request: Request,
    vary: Sequence[str],
    subject_to: Sequence[str] | None,
    runs: int | None,
    **how: Any,
) -> int:
    """Search, and write what was found; returns the exit code."""
    from linkages.design.optimise import optimise

    with request.computing("optimising", "of the runs") as update:

        def watch(done: int, value: float) -> None:
            update(done / runs if runs else 0.0, f"{done} runs, best {number(value)}")

        found = optimise(
            request.mechanism, [*vary], subject_to=subject_to or (), runs=runs,
            watch=watch, **how, **request.given,
        )  # fmt: skip
    data = found.data

    def figures() -> Iterator[File]:
        from linkages.plots.study_figures import convergence, fit_curves

        yield "optimise_convergence", convergence(data)
        yield "optimise_curves", fit_curves(data)

    files: list[File] = [
        ("optimised.yaml", found.text),
        ("optimise", data),
        ("optimise", _columns(data)),
    ]
    return request.publish(_report(data), files, figures)


def _columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each run."""
    columns: dict[str, Any] = {"run": np.arange(1, data.sizes["run"] + 1)}
    for path, name in zip(data["path"].to_numpy(), data["path_unit"].to_numpy(), strict=True):
        values = data["history_number"].sel(path=path).to_numpy()
        columns[headed(path, name)] = values / scale_to_si(str(name))
    goal = data["history"].attrs
    columns[headed(goal["long_name"], goal["units"])] = data["history_value"].to_numpy()
    columns["violation"] = data["history_violation"].to_numpy()
    return columns


def _report(data: xr.Dataset) -> Report:
    said, value = data.attrs, data["value"]
    numbers = [
        {
            "path": str(path),
            "start": float(data["number"][0, place]) / scale,
            "optimum": float(data["number"][1, place]) / scale,
            "lower": float(data["lower"][place]) / scale,
            "upper": float(data["upper"][place]) / scale,
            "units": units,
            "bound": str(data["bound"][place].item()),
        }
        for place, path in enumerate(data["path"].to_numpy())
        for units in [str(data["path_unit"][place].item())]
        for scale in [scale_to_si(units)]
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
    goal = {
        "goal": said["goal"],
        "start": float(value[0]),
        "optimum": float(value[1]),
        "units": value.attrs["units"],
    }
    missing, optimality = int(said["runs_missing"]), known(said["optimality"])
    failed = f", {missing} of which could not be computed" if missing else ""
    varied = {
        "path": "number", "start": "start", "optimum": "optimum", "lower": "from", "upper": "to",
        "units": "unit", "bound": "at bound",
    }  # fmt: skip
    measured = {
        "constraint": "measure", "start": "start", "optimum": "optimum", "units": "unit",
        "active": "active",
    }  # fmt: skip
    limits = [{**goal, "constraint": said["goal"]}, *constraints]
    parts: list[Part] = [
        Table("Numbers", varied, numbers),
        Table("Goal and constraints", measured, limits),
        *([] if optimality is None else [f"first-order optimality {optimality:.1e}"]),
    ]
    return Report(
        name=said["name"],
        summary=f"{said['goal']}, {said['runs']} runs{failed}",
        parts=[*parts, Notes(said["notes"])],
        data={
            "mechanism": said["name"],
            **goal,
            "runs": int(said["runs"]),
            "runs_missing": missing,
            "search": said["search"],
            "plateau": bool(said["plateau"]),
            "optimality": optimality,
            "notes": [*said["notes"]],
            "numbers": numbers,
            "constraints": constraints,
        },
    )
