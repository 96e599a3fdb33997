"""``sweep``: measures of the motion at many values, with tables and a store."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli import swept
from linkages.cli.requests import File, Request, each_read
from linkages.cli.terminal import present
from linkages.errors import InputError, Problem
from linkages.reading.overrides import parse_assignment
from linkages.reports.report import Notes, Part, Report, Table, headed

if TYPE_CHECKING:
    import xarray as xr

OWN = ("outcome", "reason", "stop_time", "evaluations")


def run(
    request: Request,
    measure: Sequence[str] | None,
    vary: Sequence[str] | None,
    sample: Sequence[str] | None,
    store: Path | None,
    status: bool,
    **how: Any,
) -> int:
    """Compute a sweep, or say what a store holds; returns the exit code."""
    if status:
        return _status(request)
    from linkages.solution.measured import example_measure
    from linkages.sweeps.sweep import sweep

    if not measure:
        example = example_measure(request.mechanism)
        raise _refused("--measure", f"nothing is measured; expected {example!r}")
    twice = next((text for text in measure if measure.count(text) > 1), None)
    over = _over(vary or (), sample or ())
    if twice is not None:
        raise _refused("--measure", f"{twice!r} is asked for twice")
    how |= {"store": store, **request.given}
    task = partial(sweep, request.mechanism, over, list(measure), **how)
    data = swept.result(request, "sweep", "point", task)

    def figures() -> Iterator[File]:
        from linkages.plots.study_figures import sweep_figure

        for stem, name in swept.numbered("sweep", _measures(data)):
            yield stem, sweep_figure(data, name)

    files: list[File] = [("sweep", data), ("sweep", _columns(data))]
    return swept.publish(request, _report(data), data, "point", files, figures, store)


def _refused(option: str, message: str) -> InputError:
    return InputError(option, [Problem(message=message)])


def _over(vary: Sequence[str], sample: Sequence[str]) -> dict[Any, Any]:
    """What is varied, as `linkages.sweep` takes it."""
    if not vary and not sample:
        raise _refused("--vary", "nothing is varied; expected --vary or --sample")
    from linkages.sweeps.axes import parse_axis

    found: dict[Any, Any] = {}
    for axis in each_read("--vary", vary, parse_axis):
        found[axis.paths if len(axis.paths) > 1 else axis.label] = axis
    for path, text in each_read("--sample", sample, parse_assignment):
        if path in found:
            raise _refused("--sample", f"{path} is varied by --vary as well; expected one of them")
        found[path] = text
    return found


def _status(request: Request) -> int:
    from linkages.sweeps.store import status

    found = status(request.file)
    state = "finished" if found["finished"] else f"{found['left']} left"
    rows = [[word.replace("_", " "), count] for word, count in found["outcomes"].items()]
    table = [Table("Outcomes", ["outcome", "points"], rows, numbers=1)] if rows else []
    notes = swept.failure_notes(swept.counted_texts(found["reasons"]), "point")
    report = Report(
        name=found["store"],
        summary=f"{found['done']} of {found['points']} points, {state}",
        parts=[*table, Notes(notes)],
        data=found,
    )
    return present(report, request.json)


def _measures(data: xr.Dataset) -> list[str]:
    return [str(name) for name in data.data_vars if name not in OWN]


def _columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each point."""
    values = [*data.coords.items(), *((name, data[name]) for name in _measures(data))]
    columns = {headed(name, array.attrs.get("units")): array for name, array in values}
    columns |= {"outcome": swept.outcomes(data)[0], **swept.failure_columns(data)}
    return swept.flattened(columns | {"evaluations": data["evaluations"]}, data["outcome"])


def _report(data: xr.Dataset) -> Report:
    rows = []
    for name in _measures(data):
        values = data[name].to_numpy()
        finite = values[np.isfinite(values)]
        row = {"measure": name, "units": data[name].attrs["units"], **swept.finite_range(finite)}
        row["mean"] = float(finite.mean()) if finite.size else None
        row["deviation"] = float(finite.std(ddof=1)) if finite.size > 1 else None
        rows.append(row)
    columns = {
        "measure": "measure", "least": "least", "greatest": "greatest", "mean": "mean",
        "deviation": "standard deviation", "units": "unit",
    }  # fmt: skip
    outcome, failures = data["outcome"], swept.failures(data)
    computed = int((outcome == 0).sum())
    along = " × ".join(f"{data.sizes[dim]} {dim}" for dim in outcome.dims)
    parts: list[Part] = [Table("Measures", columns, rows)]
    return Report(
        name=data.attrs["name"],
        summary=f"{computed} of {outcome.size} points, {along}",
        parts=[*parts, Notes(swept.failure_notes(failures, "point"))],
        data={
            "mechanism": data.attrs["name"],
            "points": int(outcome.size),
            "computed": computed,
            "interrupted": bool(data.attrs["interrupted"]),
            "outcomes": swept.outcomes(data)[1],
            "measures": rows,
            "evaluations": int(data["evaluations"].sum()),
            "failures": failures,
        },
    )
