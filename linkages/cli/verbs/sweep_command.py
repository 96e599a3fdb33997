"""``sweep``: measures of the motion at many values, with tables and a store."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console

from linkages.cli import swept
from linkages.cli.options import Drawing
from linkages.cli.requests import File, Request, each_read
from linkages.cli.terminal import console, number, print_json, print_notes, table
from linkages.errors import InputError, Problem
from linkages.reading.overrides import parse_assignment

if TYPE_CHECKING:
    import xarray as xr

OWN = ("outcome", "reason", "stop_time", "evaluations")


def run(
    request: Request,
    measure: Sequence[str] | None,
    vary: Sequence[str] | None,
    sample: Sequence[str] | None,
    draws: int | None,
    seed: int,
    sequence: Drawing,
    store: Path | None,
    time_per_point: float | None,
    scheduler: str | None,
    status: bool,
    cores: int | None,
    device: str,
) -> int:
    """Compute a sweep, or say what a store holds; returns the exit code."""
    if status:
        return _status(request)
    from linkages.solution.measured import example_measure
    from linkages.sweeps.sweep import sweep

    if not measure:
        example = example_measure(request.mechanism)
        raise _refused("--measure", f"nothing is measured; expected {example!r}")
    over = _over(vary or (), sample or ())
    task = partial(
        sweep, request.mechanism, over, _named(measure), draws=draws, seed=seed,
        sequence=str(sequence), store=store, cores=cores, scheduler=scheduler,
        time_per_point=time_per_point, device=str(device), **request.given,
    )  # fmt: skip
    data = swept.result(request, "sweep", "point", task)
    content = _content(data)
    show = partial(_print, content, data)
    made = _files(data, request.figures)
    return swept.publish(request, data, "point", made, content, show, store=store)


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


def _named(measures: Sequence[str]) -> list[str]:
    twice = next((text for text in measures if measures.count(text) > 1), None)
    if twice is not None:
        raise _refused("--measure", f"{twice!r} is asked for twice")
    return list(measures)


def _status(request: Request) -> int:
    from linkages.sweeps.store import status

    found = status(request.file)
    if request.json:
        print_json(found)
        return 0
    screen = console()
    state = "finished" if found["finished"] else f"{found['left']} left"
    title = f"{found['store']}: {found['done']} of {found['points']} points, {state}"
    screen.print(title, markup=False)
    rows = [[word.replace("_", " "), count] for word, count in found["outcomes"].items()]
    if rows:
        screen.print(table("Outcomes", ["outcome", "points"], rows, numbers=1))
    print_notes(swept.failure_notes(swept.counted_texts(found["reasons"]), "point"), screen)
    return 0


def _files(data: xr.Dataset, figures: bool) -> Iterator[File]:
    yield "sweep", data
    yield "sweep", _columns(data)
    if figures:
        from linkages.plots.study_figures import sweep_figure

        names = _measures(data)
        for number_, name in enumerate(names, 1):
            yield "sweep" if len(names) == 1 else f"sweep_{number_}", sweep_figure(data, name)


def _measures(data: xr.Dataset) -> list[str]:
    return [str(name) for name in data.data_vars if name not in OWN]


def _columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each point."""
    like = data["outcome"]
    columns: dict[str, Any] = {}
    for name, array in data.coords.items():
        units = array.attrs.get("units")
        columns[f"{name} ({units})" if units else str(name)] = array
    for name in _measures(data):
        units = data[name].attrs["units"]
        columns[f"{name} ({units})" if units else name] = data[name]
    words = str(like.attrs["flag_meanings"]).split()
    outcomes = like.copy(data=np.array(words, dtype=object)[like.to_numpy()])
    columns |= {"outcome": outcomes, **swept.failure_columns(data)}
    return swept.flattened(columns | {"evaluations": data["evaluations"]}, like)


def _content(data: xr.Dataset) -> dict[str, Any]:
    outcome = data["outcome"].to_numpy()
    words = str(data["outcome"].attrs["flag_meanings"]).split()
    counts = np.bincount(outcome.ravel(), minlength=len(words))
    rows = []
    for name in _measures(data):
        values = data[name].to_numpy()
        finite = values[np.isfinite(values)]
        known = bool(finite.size)
        rows.append(
            {
                "measure": name,
                "units": data[name].attrs["units"],
                "least": float(finite.min()) if known else None,
                "greatest": float(finite.max()) if known else None,
                "mean": float(finite.mean()) if known else None,
                "deviation": float(finite.std(ddof=1)) if finite.size > 1 else None,
            }
        )
    return {
        "mechanism": data.attrs["name"],
        "points": int(outcome.size),
        "computed": int(counts[0]),
        "interrupted": bool(data.attrs["interrupted"]),
        "outcomes": {word: int(n) for word, n in zip(words, counts, strict=True) if n},
        "measures": rows,
        "evaluations": int(data["evaluations"].sum()),
        "failures": swept.failures(data),
    }


def _print(content: dict[str, Any], data: xr.Dataset, screen: Console) -> None:
    along = " × ".join(f"{data.sizes[dim]} {dim}" for dim in data["outcome"].dims)
    title = f"{content['mechanism']}: {content['computed']} of {content['points']} points, {along}"
    screen.print(title, markup=False)
    keys = ("measure", "least", "greatest", "mean", "deviation", "units")
    heads = ["measure", "least", "greatest", "mean", "standard deviation", "unit"]
    cells = [
        [number(row[key]) if isinstance(row[key], float) else row[key] for key in keys]
        for row in content["measures"]
    ]
    screen.print(table("Measures", heads, cells))
    print_notes(swept.failure_notes(content["failures"], "point"), screen)
