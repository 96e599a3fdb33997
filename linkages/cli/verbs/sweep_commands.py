"""Commands that compute at many points: ``sweep``, ``bifurcation`` and ``map``."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from linkages.cli import swept
from linkages.cli.requests import File, Request, each_read, initial_states, ranges
from linkages.cli.terminal import present
from linkages.errors import InputError, Interrupted, Problem
from linkages.reading.overrides import parse_assignment
from linkages.reports.report import Notes, Part, Report, Table, headed, number

if TYPE_CHECKING:
    from linkages.sweeps.axes import Axis
    from linkages.sweeps.running import Threads


OWN = ("outcome", "reason", "stop_time", "evaluations")


def run_sweep(
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
    from linkages.solution.measure_names import example_measure
    from linkages.sweeps.sweep import sweep

    if not measure:
        example = example_measure(request.mechanism)
        raise _refused("--measure", f"nothing is measured; expected {example!r}")
    twice = next((text for text in measure if measure.count(text) > 1), None)
    over = _over(vary or (), sample or ())
    if twice is not None:
        raise _refused("--measure", f"{twice!r} is given twice")
    how |= {"store": store, **request.given}
    task = partial(sweep, request.mechanism, over, list(measure), **how)
    data = swept.result(request, "sweep", "point", task)

    def figures() -> Iterator[File]:
        from linkages.plots.study_figures import sweep_figure

        for stem, name in swept.numbered("sweep", _measures(data)):
            yield stem, sweep_figure(data, name)

    files: list[File] = [("sweep", data), ("sweep", _sweep_columns(data))]
    return swept.publish(request, _sweep_report(data), data, "point", files, figures, store)


def _refused(option: str, message: str) -> InputError:
    return InputError(option, [Problem(message=message)])


def _over(vary: Sequence[str], sample: Sequence[str]) -> dict[Any, Any]:
    """What is varied, as `linkages.sweep` takes it."""
    if not vary and not sample:
        raise _refused("--vary", "nothing is varied; expected --vary or --sample")
    from linkages.sweeps.axes import parse_axis

    result: dict[Any, Any] = {}
    for axis in each_read("--vary", vary, parse_axis):
        result[axis.paths if len(axis.paths) > 1 else axis.label] = axis
    for path, text in each_read("--sample", sample, parse_assignment):
        if path in result:
            raise _refused("--sample", f"{path} is varied by --vary as well; expected one of them")
        result[path] = text
    return result


def _status(request: Request) -> int:
    from linkages.sweeps.store import status

    result = status(request.file)
    state = "finished" if result["finished"] else f"{result['left']} left"
    rows = [[word.replace("_", " "), count] for word, count in result["outcomes"].items()]
    table = [Table("Outcomes", ["outcome", "points"], rows, numbers=1)] if rows else []
    notes = swept.failure_notes(swept.counted_texts(result["reasons"]), "point")
    report = Report(
        name=result["store"],
        summary=f"{result['done']} of {result['points']} points, {state}",
        parts=[*table, Notes(notes)],
        data=result,
    )
    return present(report, request.json)


def _measures(data: xr.Dataset) -> list[str]:
    return [str(name) for name in data.data_vars if name not in OWN]


def _sweep_columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each point."""
    measured = ((name.replace("÷", "/"), data[name]) for name in _measures(data))
    values = [*data.coords.items(), *measured]
    columns = {headed(name, array.attrs.get("units")): array for name, array in values}
    columns |= {"outcome": swept.outcomes(data)[0], **swept.failure_columns(data)}
    return swept.flattened(columns | {"evaluations": data["evaluations"]}, data["outcome"])


def _of_axis(count: int, name: str) -> str:
    """How many values an axis has, or how many draws there are."""
    word = "draw" if name == "draw" else "value"
    plural = "" if count == 1 else "s"
    return f"{count} {word}{plural}" if name == "draw" else f"{count} {word}{plural} of {name}"


def _sweep_report(data: xr.Dataset) -> Report:
    rows = []
    for name in _measures(data):
        values = data[name].to_numpy()
        finite = values[np.isfinite(values)]
        text = name.replace("÷", "/")  # which names in data cannot have
        row = {"measure": text, "units": data[name].attrs["units"], **swept.finite_range(finite)}
        row["mean"] = float(finite.mean()) if finite.size else None
        row["deviation"] = float(finite.std(ddof=1)) if finite.size > 1 else None
        rows.append(row)
    outcome, failures = data["outcome"], swept.failures(data)
    computed = int((outcome == 0).sum())
    along = " × ".join(_of_axis(data.sizes[dim], str(dim)) for dim in outcome.dims)
    columns = "least", "greatest", "mean", "deviation: standard deviation", "units: unit"
    parts: list[Part] = [Table.of("Measures", rows, "measure", *columns)]
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


def run_bifurcation(
    request: Request,
    vary: Sequence[str],
    start: str,
    initial: Sequence[str],
    starts: int | None,
    within: Sequence[str] | None,
    seed: int,
    store: Path | None,
    cores: int | None,
    device: str,
) -> int:
    """Sweep over a parameter; returns the exit code."""
    from linkages.sweeps.running import Threads

    axis, states = ranges("--vary", vary), initial_states(initial or [])
    where: dict[str, Any] = {"store": store, "executor": Threads(cores), "device": device}
    if starts is not None:
        from linkages.cli.verbs.basin_commands import many_starts

        given = {"start": start, "initial": tuple(initial or ()) or None}
        return many_starts(request, axis, starts, within or (), seed, given, **where)
    if within:
        raise _refused("--within", "goes with --starts; expected both or neither")
    data = _compute(request, axis, states, start, **where)
    values = _values(data)

    def figures() -> Iterator[File]:
        from linkages.plots.chaos.diagrams import bifurcation_figure

        yield "bifurcation", bifurcation_figure(data)
        yield "bifurcation_rates", bifurcation_figure(data, rates=True)

    files: list[File] = [
        ("bifurcation", data),
        ("bifurcation", _points(data)),
        ("bifurcation_values", values),
    ]
    report = _bifurcation_report(data, values)
    return swept.publish(request, report, data, "value", files, figures, store)


def _compute(
    request: Request,
    axis: Axis,
    states: Sequence[dict[str, object]],
    start: str,
    store: Path | None,
    **where: Any,
) -> xr.Dataset:
    """One sweep, or one in either direction put together; starts have names, and their stores."""
    from linkages.chaos.bifurcation import bifurcation
    from linkages.chaos.diagram import BOTH, put_together, ways

    parts: list[xr.Dataset] = []
    for one in ways(start):
        if parts and parts[-1].attrs["interrupted"]:
            break
        kept = store / one if store is not None and start == BOTH else store
        given = {**request.given, "start": one, "initial": states, "store": kept, **where}
        task = partial(bifurcation, request.mechanism, axis, **given)
        parts.append(swept.result(request, axis.label, "value", task))
    return put_together(parts, start, states)


def _numbered(data: xr.Dataset, dim: str) -> xr.DataArray:
    return xr.DataArray(np.arange(data.sizes[dim]) + 1, dims=dim)


def _points(data: xr.Dataset) -> dict[str, Any]:
    """Columns of all points that there are."""
    free = swept.free_columns(data)
    columns = {
        "start": _numbered(data, "start"),
        **swept.varied_columns(data, "value"),
        "point": _numbered(data, "crossing"),
    }
    there = np.isfinite(next(iter(free.values())))
    result = swept.flattened(columns, _first(data)) | free
    return {head: array[there] for head, array in result.items()}


def _values(data: xr.Dataset) -> dict[str, np.ndarray]:
    """A row for each initial condition and value: points, exponent, contact, reason."""
    columns = {
        "start": _numbered(data, "start"),
        **swept.varied_columns(data, "value"),
        "points": _first(data).notnull().sum("crossing"),
    }
    if "exponent" in data:
        columns |= {"exponent (1/s)": data["exponent"], "error (1/s)": data["error"]}
    columns |= swept.contact_columns(data) | swept.failure_columns(data)
    return swept.flattened(columns, data["reason"])


def _first(data: xr.Dataset) -> xr.DataArray:
    """One of the numbers of every point."""
    return next(array for array in data.data_vars.values() if "crossing" in array.dims)[..., 0]


def _bifurcation_report(data: xr.Dataset, values: dict[str, Any]) -> Report:
    from linkages.chaos.exponents import BEYOND

    name, path = data.attrs["name"], data.attrs["varied"]
    numbers, unit = data[path].to_numpy(), data[path].attrs.get("units", "")
    ends = f"{number(float(numbers[0]))} to {number(float(numbers[-1]))} {unit}".rstrip()
    starts = [str(name) for name in data["start"].values]
    heads, rows = ["initial condition", "values computed", "points"], []
    for index, start in enumerate(starts):
        points = values["points"][values["start"] == index + 1]
        row = [start or "of the file", int((points > 0).sum()), points.sum()]
        if "exponent" in data:
            positive = data["exponent"][index] > BEYOND * data["error"][index]
            row.append(f"at {int(positive.sum())}")
        rows.append(row)
    heads += ["Lyapunov exponent positive"] if "exponent" in data else []
    # values with fewer points than asked for
    warnings = swept.counted(str(text) for text in data["warning"].to_numpy().ravel() if text)
    failures = swept.failures(data)
    notes = [n for reasons in (failures, warnings) for n in swept.failure_notes(reasons, "value")]
    return Report(
        name=name,
        summary=f"{data.sizes['value']} values of {path} from {ends}",
        parts=[
            Table("Initial conditions", heads, rows, numbers=len(heads) - 1),
            *swept.remarks(data, notes),
        ],
        data={
            "mechanism": name,
            "varied": path,
            "starts": starts,
            "interrupted": bool(data.attrs["interrupted"]),
            "values": {head: column.tolist() for head, column in values.items()},
            "failures": failures,
            "warnings": warnings,
            "contact": swept.contact_content(data),
        },
    )


def run_map(
    request: Request,
    x: Sequence[str],
    y: Sequence[str],
    loci: Sequence[Path] | None,
    page: bool,
    store: Path | None,
    cores: int | None,
    device: str,
) -> int:
    """Compute a map; returns the exit code."""
    from linkages.chaos.maps import chaos_map
    from linkages.sweeps.running import Threads

    axes = ranges("--x", x), ranges("--y", y)
    curves = _loci(loci or (), [axis.paths[0] for axis in axes], request)
    if page:
        _require_page(request, axes)
    executor = Threads(cores)
    how = {**request.given, "executor": executor, "device": device, "store": store, "states": page}
    task = partial(chaos_map, request.mechanism, *axes, **how)
    data = swept.result(request, "map", "point", task)
    pages: list[File] = []
    if page and swept.any_computed(data) and not data.attrs["interrupted"]:
        data, pages = _with_page(request, axes, data, curves, executor)

    def figures() -> Iterator[File]:
        from linkages.plots.chaos.diagrams import (
            class_figure,
            map_figure,
            period_figure,
            touch_figure,
        )

        yield "map", period_figure(data, curves) if "regime" in data else map_figure(data)
        for stem, name in swept.numbered("map_touches", _touched(data)):
            yield stem, touch_figure(data, name)
        if "rotation" not in data:
            return
        for stem, name in swept.numbered("map_rotation", _coordinates(data)):
            yield stem, class_figure(data, name)

    columns, report = (
        (_period_columns, _period_report) if "regime" in data else (_map_columns, _map_report)
    )
    files: list[File] = [("map", data), ("map", columns(data)), *pages]
    return swept.publish(request, report(data), data, "point", files, figures, store)


def _require_page(request: Request, axes: tuple[Axis, Axis]) -> None:
    """Refuse a page of what it cannot play, before anything is computed."""
    from linkages.viewer.plane import require_playable

    if request.given.get("indicator") != "period":
        message = "a page plays planes of periods; expected --indicator period as well"
        raise _refused("--page", message)
    if request.given.get("refine", 1) > 1:
        raise _refused("--page", "a page plays every point; expected no --refine")
    require_playable(request.mechanism, *axes)


def _with_page(
    request: Request,
    axes: tuple[Axis, Axis],
    data: xr.Dataset,
    loci: Sequence[xr.Dataset],
    executor: Threads,
) -> tuple[xr.Dataset, list[File]]:
    """A plane with the orbits of its points, and the page; without it after Ctrl-C."""
    from linkages.options.analysis_options import OrbitOptions
    from linkages.options.option import options_in
    from linkages.options.run import RunOptions
    from linkages.orbits.plane_orbits import plane_orbits
    from linkages.solution.run_options import options_of
    from linkages.viewer.plane import plane_page

    names = {option.name for option in options_in(RunOptions)}
    given = {name: value for name, value in request.given.items() if name in names}
    run = options_of(OrbitOptions, request.mechanism, given)
    try:
        with request.computing("orbits of", "of points") as update:
            found = plane_orbits(
                request.mechanism, *axes, data, run, executor, lambda part: update(part, "")
            )
    except (KeyboardInterrupt, Interrupted):
        return data.assign_attrs(interrupted=1), []
    text = plane_page(request.mechanism, *axes, found, loci, given)
    if text is None:
        message = "no page: a definition cannot begin in the state of any point"
        print(message, file=sys.stderr)
        return found, []
    return found, [("map.html", text)]


def _loci(files: Sequence[Path], paths: Sequence[str], request: Request) -> list[xr.Dataset]:
    """What is drawn on top of a plane."""
    from linkages.opened import open as opened
    from linkages.orbits.loci import locus_values

    if files and request.given.get("indicator") != "period":
        message = "loci are drawn over planes of periods; expected --indicator period as well"
        raise InputError("--loci", [Problem(message=message)])
    result, problems = [], []
    for file in files:
        data = opened(file).data
        try:
            locus_values(data, paths)
        except ValueError as error:
            problems.append(Problem(message=f"{file} {error}"))
        result.append(data)
    if problems:
        raise InputError("--loci", problems)
    return result


def _touched(data: xr.Dataset) -> list[str]:
    """Names of what is touched, if that was counted."""
    return [str(name) for name in data["touch"].values] if "touches" in data else []


def _coordinates(data: xr.Dataset) -> list[str]:
    return [str(name) for name in data["coordinate"].values]


def _map_columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each point."""
    columns = swept.varied_columns(data, "x", "y")
    columns[headed(data.attrs["kind"], data["indicator"].attrs["units"])] = data["indicator"]
    if "error" in data:
        columns |= {"error (1/s)": data["error"], "sign": data["sign"]}
    for name in _touched(data):
        columns[f"touches of {name} per period"] = data["touches"].sel(touch=name)
    columns |= swept.contact_columns(data)
    for name in _coordinates(data):
        columns[f"motion of {name}"] = data["rotation"].sel(coordinate=name)
    return swept.flattened(columns | swept.failure_columns(data), data["indicator"])


def _signs(data: xr.Dataset) -> dict[str, int] | None:
    """At how many points the exponent is positive, negative, or cannot be told from zero."""
    if "sign" not in data:
        return None
    signs = data["sign"].to_numpy()[np.isfinite(data["indicator"].to_numpy())]
    words = {"positive": 1, "negative": -1, "zero within its error": 0}
    return {word: int((signs == sign).sum()) for word, sign in words.items()}


def _map_report(data: xr.Dataset) -> Report:
    said, indicator = data.attrs, data["indicator"]
    values, unit, title = (
        indicator.to_numpy(),
        indicator.attrs["units"],
        indicator.attrs["long_name"],
    )
    computed, ends, signs = int(np.isfinite(values).sum()), swept.finite_range(values), _signs(data)
    failures = swept.failures(data)
    touches = {
        name: [ends["least"], ends["greatest"]]
        for name in _touched(data)
        for ends in [swept.finite_range(data["touches"].sel(touch=name).to_numpy())]
        if ends["least"] is not None
    }
    rotation = {
        name: dict(Counter(str(word) for word in words.to_numpy().ravel() if word))
        for name in _coordinates(data)
        for words in [data["rotation"].sel(coordinate=name)]
    }
    parts: list[Part] = []
    if computed:
        low, high = (number(float(end or 0.0)) for end in ends.values())
        parts.append(f"{title} from {low} to {high} {unit}".rstrip())
        if signs:
            result = [f"{word} at {count}" for word, count in signs.items() if count]
            parts.append(f"the Lyapunov exponent is {', '.join(result)}")
    for name, (least, greatest) in touches.items():
        parts.append(f"{name} is touched {least:.6g} to {greatest:.6g} times a period")
    rows = [[name, *kind] for name, kinds in rotation.items() for kind in sorted(kinds.items())]
    if rows:
        parts.append(Table("What free angles do", ["angle", "motion", "points"], rows, numbers=1))
    return Report(
        name=said["name"],
        summary=f"{computed} of {values.size} points, {said['x']} and {said['y']}",
        parts=[*parts, *swept.remarks(data, swept.failure_notes(failures, "point"))],
        data={
            "mechanism": said["name"],
            "indicator": said["kind"],
            "long_name": title,
            "units": unit,
            "x": said["x"],
            "y": said["y"],
            "points": int(values.size),
            "computed": computed,
            "interrupted": bool(said["interrupted"]),
            **ends,
            "signs": signs,
            "rotation": rotation,
            "touches": touches,
            "contact": swept.contact_content(data),
            "failures": failures,
        },
    )


def _regimes(data: xr.Dataset) -> xr.DataArray:
    """What was found at each point, in a word."""
    words = np.array(str(data["regime"].attrs["flag_meanings"]).split(), dtype=object)
    return data["regime"].copy(data=words[data["regime"].to_numpy()])


def _period_columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each point."""
    columns = swept.varied_columns(data, "x", "y")
    columns |= {"found": _regimes(data), "period": data["indicator"]}
    columns |= {name: data[name] for name in ("contraction", "lasted", "filled")}
    for name in _touched(data):
        columns[f"touches of {name} per period of the drives"] = data["touches"].sel(touch=name)
    for name in _coordinates(data) if "coordinate" in data.coords else ():
        turned = data["rotation_number"].sel(coordinate=name)
        columns[f"turns of {name} per period of the drives"] = turned
    return swept.flattened(columns | swept.failure_columns(data), data["indicator"])


def _period_report(data: xr.Dataset) -> Report:
    said, failures = data.attrs, swept.failures(data)
    found, filled = _regimes(data).to_numpy(), data["filled"].to_numpy() > 0
    period = data["indicator"].to_numpy()
    periods = Counter(period[np.isfinite(period)].astype(int).tolist())
    others = {word: int((found == word).sum()) for word in ("chaotic", "undecided")}
    rows = [[f"period {number}", count] for number, count in sorted(periods.items())]
    rows += [[word, count] for word, count in others.items() if count]
    decided = int((found != "not_computed").sum())
    computed = decided - int(filled.sum())
    parts: list[Part] = []
    if rows:
        heads = ["motion", "points"]
        parts.append(Table("Motions", heads, rows, numbers=1))
    if filled.any():
        parts.append(f"{computed} points were computed, {filled.sum()} lie between equal ones")
    notes = [*swept.failure_notes(failures, "point"), *filter(None, [said["warning"]])]
    return Report(
        name=said["name"],
        summary=f"{decided} of {found.size} points, {said['x']} and {said['y']}",
        parts=[*parts, Notes(notes)],
        data={
            "mechanism": said["name"],
            "indicator": said["kind"],
            "x": said["x"],
            "y": said["y"],
            "start": said["start"],
            "points": int(found.size),
            "computed": computed,
            "filled": int(filled.sum()),
            "interrupted": bool(said["interrupted"]),
            "periods": {str(number): count for number, count in sorted(periods.items())},
            **others,
            "failures": failures,
        },
    )
