"""Commands for designers: ``sensitivity``, ``tolerance``, ``optimise`` and ``fit``."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli import swept
from linkages.cli.requests import File, Request, overrides
from linkages.cli.swept import known
from linkages.reports.report import Notes, Part, Report, Table, headed, number
from linkages.spec.units import scale_to_si

if TYPE_CHECKING:
    import xarray as xr


MOST_ROWS = 40


def run_sensitivity(request: Request, of: Sequence[str], to: Sequence[str]) -> int:
    """Differentiate, write, print; returns the exit code."""
    from linkages.design.sensitivities import effects_of, sensitivity_asked
    from linkages.spec.measures import read_measure

    with request.computing("sensitivities of"):
        data = sensitivity_asked(request.mechanism, of, to, **request.given)
        measures = list(dict.fromkeys(read_measure(text).text for text in of))
        result = {text: effects_of(request.mechanism, data, text) for text in measures}

    def figures() -> Iterator[File]:
        from linkages.plots.study_figures import sensitivity_curves, sensitivity_figure

        yield "sensitivity", sensitivity_figure(data, result)
        yield "sensitivity_curves", sensitivity_curves(data)

    # why a measure or a series does not exist
    reasons = {str(name): str(data[name].attrs.get("reason", "")) for name in data}
    content = [
        {
            "measure": text,
            "value": float(data[text].attrs["value"]),
            "units": "" if unit == "1" else unit,
            "reason": reasons[text] or None,
            "effects": [asdict(effect) for effect in effects],
        }
        for text, effects in result.items()
        for unit in [str(data[text].attrs["units"]).partition(" / ")[0]]
    ]
    report = Report(
        parts=[
            *(part for measure in content for part in _sensitivity_parts(measure)),
            Notes([text for text in reasons.values() if text]),
        ],
        data={"mechanism": data.attrs["name"], "measures": content},
    )
    files: list[File] = [("sensitivity", data), ("sensitivity", _sensitivity_columns(content))]
    return request.publish(report, files, figures)


def _sensitivity_columns(measures: Sequence[dict[str, Any]]) -> dict[str, list[Any]]:
    """A row for each measure and number."""
    rows = [(measure, effect) for measure in measures for effect in measure["effects"]]
    relative = [effect["relative"] for _, effect in rows]
    return {
        "measure": [measure["measure"] for measure, _ in rows],
        "value": [measure["value"] for measure, _ in rows],
        "measure unit": [measure["units"] for measure, _ in rows],
        **{
            key: [effect[key] for _, effect in rows]
            for key in ("parameter", "number", "unit", "derivative")
        },
        "relative": [math.nan if value is None else value for value in relative],
        "reason": [measure["reason"] or "" for measure, _ in rows],
    }


def _sensitivity_parts(measure: dict[str, Any]) -> Iterator[Part]:
    text, unit, effects = measure["measure"], measure["units"], measure["effects"]
    title = f"{text} has no value"
    if math.isfinite(measure["value"]):
        title = f"{text} = {number(measure['value'])} {unit}".strip()
    rows = [
        [
            own["parameter"], own["number"], own["unit"], own["derivative"],
            f"{unit or '1'} / {_grouped(own['unit']) or '1'}",
            "" if own["relative"] is None else f"{own['relative']:.4f}",
        ]
        for own in effects[:MOST_ROWS]
        if math.isfinite(own["derivative"])
    ]  # fmt: skip
    heads = ["parameter", "number", "", "derivative", "", "relative"]
    yield Table(title, heads, rows) if rows else title
    if len(effects) > MOST_ROWS:
        yield f"{len(effects) - MOST_ROWS} more rows are in sensitivity.csv"


def _grouped(unit: str) -> str:
    """A unit below a fraction bar."""
    return f"({unit})" if " " in unit else unit


MANY = 12
"""Contributors that a table has; the rest is a line."""


def run_tolerance(
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

    files: list[File] = [("tolerance", data), ("tolerance", _tolerance_columns(data))]
    return swept.publish(request, _tolerance_report(data), data, "draw", files, figures, store)


def _measures(data: xr.Dataset) -> list[str]:
    return [str(name) for name in data["measure"].to_numpy()]


def _tolerance_columns(data: xr.Dataset) -> dict[str, Any]:
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


def _tolerance_report(data: xr.Dataset) -> Report:
    outcomes, yields = swept.outcomes(data)[1], _yields(data)
    draws, computed = int(data["outcome"].size), int((data["outcome"] == 0).sum())
    measures = [_measure(data, name) for name in _measures(data)]
    notes = str(data.attrs["remarks"]).splitlines()
    parts = [part for measure in measures for part in _tolerance_parts(measure)]
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


def _tolerance_parts(measure: dict[str, Any]) -> Iterator[Part]:
    """What contributes to the variance of a measure, and its distribution."""
    from linkages.plots.style import scale_of

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
    from linkages.plots.style import scale_of

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


def run_optimise(
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

        result = optimise(
            request.mechanism, [*vary], subject_to=subject_to or (), runs=runs,
            watch=watch, **how, **request.given,
        )  # fmt: skip
    data = result.data

    def figures() -> Iterator[File]:
        from linkages.plots.study_figures import convergence, fit_curves

        yield "optimise_convergence", convergence(data)
        yield "optimise_curves", fit_curves(data)

    files: list[File] = [
        ("optimised.yaml", result.text),
        ("optimise", data),
        ("optimise", _optimise_columns(data)),
    ]
    return request.publish(_optimise_report(data), files, figures)


def _varied(data: xr.Dataset, values: Mapping[str, xr.DataArray]) -> list[dict[str, Any]]:
    """A row for each number that was varied, with values in its unit."""
    return [
        {
            "path": str(path),
            **{key: known(float(own[i]) / scale_to_si(units)) for key, own in values.items()},
            "units": units,
        }
        for i, path in enumerate(data["path"].to_numpy())
        for units in [str(data["path_unit"][i].item())]
    ]


def _optimise_columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each run."""
    columns: dict[str, Any] = {"run": np.arange(1, data.sizes["run"] + 1)}
    for path, name in zip(data["path"].to_numpy(), data["path_unit"].to_numpy(), strict=True):
        values = data["history_number"].sel(path=path).to_numpy()
        columns[headed(path, name)] = values / scale_to_si(str(name))
    goal = data["history"].attrs
    columns[headed(goal["long_name"], goal["units"])] = data["history_value"].to_numpy()
    columns["violation"] = data["history_violation"].to_numpy()
    return columns


def _optimise_report(data: xr.Dataset) -> Report:
    said, value = data.attrs, data["value"]
    scaled = {
        "start": data["number"][0], "optimum": data["number"][1], "lower": data["lower"],
        "upper": data["upper"],
    }  # fmt: skip
    bounds = map(str, data["bound"].to_numpy())
    numbers = [
        {**row, "bound": bound} for row, bound in zip(_varied(data, scaled), bounds, strict=True)
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
    limits = [{**goal, "constraint": said["goal"], "active": None}, *constraints]
    parts: list[Part] = [
        Table.of(
            "Numbers", numbers, "path: number", "start", "optimum", "lower: from", "upper: to",
            "units: unit", "bound: at bound",
        ),
        Table.of(
            "Goal and constraints", limits, "constraint: measure", "start", "optimum",
            "units: unit", "active",
        ),
        *([] if optimality is None else [f"first-order optimality {optimality:.1e}"]),
    ]  # fmt: skip
    if data.sizes["variant"] > 1:
        heading = headed(said["goal"], value.attrs["units"])
        parts.append(_variants(data["variant"], data["variant_value"], heading))
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
            "variant": said["variant"],
            "notes": [*said["notes"]],
            "numbers": numbers,
            "constraints": constraints,
        },
    )


def _variants(names: xr.DataArray, values: xr.DataArray, heading: str) -> Table:
    """What came of each assembly branch and sense of the drives, the best first."""
    rows = sorted(
        (
            [str(name), known(float(value))]
            for name, value in zip(names.values, values.values, strict=True)
        ),
        key=lambda row: np.inf if row[1] is None else row[1],
    )
    return Table("Assembly branches and senses", ["branch", heading], rows, numbers=1)


PATH_SAMPLES = 721
"""Of a fitted motion, for the figure of its paths."""


def run_fit(
    request: Request,
    to: Path,
    vary: Sequence[str],
    sigma: Sequence[str] | None,
    subject_to: Sequence[str] | None,
    **how: Any,
) -> int:
    """Fit, and write what was found; returns the exit code."""
    from linkages.design.fit import fit

    spread = overrides("--sigma", sigma or ())
    with request.computing("fitting", "of the runs") as update:
        result = fit(
            request.mechanism, to, [*vary], sigma=spread, subject_to=subject_to or (), **how,
            **request.given,
            watch=lambda done, best: update(0.0, f"{done} runs, chi-square {number(best)}"),
        )  # fmt: skip
    data = result.data

    def figures() -> Iterator[File]:
        from linkages.plots.study_figures import (
            MOST_VARIANTS,
            fit_figure,
            fit_path,
            fitted_points,
        )

        yield "fit", fit_figure(data)
        end = float(data["time"][-1])
        how = {"end": end, **request.given, "outputs": ["joint_position"], "samples": PATH_SAMPLES}
        for joint in fitted_points(data):
            from linkages.solution.simulate import simulate

            best = islice(result.variants.items(), MOST_VARIANTS)
            motions = {name: simulate(one, throw=False, **how) for name, one in best}
            yield f"fit_path_{joint}", fit_path(data, joint, motions)

    files: list[File] = [("fitted.yaml", result.text), ("fit", data), ("fit", _fit_columns(data))]
    return request.publish(_fit_report(data), files, figures)


def _fit_columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each time."""
    columns: dict[str, Any] = {"time (s)": data["time"].to_numpy()}
    names = data["series"].to_numpy(), data["series_units"].to_numpy()
    for place, (name, units) in enumerate(zip(*names, strict=True)):
        for kind in ("measured", "computed"):
            columns[headed(f"{kind} {name}", units)] = data[kind].to_numpy()[place]
        columns[f"residual {name} (sigma)"] = data["residual"].to_numpy()[place]
    return columns


def _fit_report(data: xr.Dataset) -> Report:
    numbers = data["number"]
    rows = _varied(
        data, {"start": numbers[0], "fit": numbers[1], "standard_error": data["standard_error"]}
    )
    said, correlation = data.attrs, data["correlation"].to_numpy()
    name, freedom = said["name"], int(said["degrees_of_freedom"])
    chance = known(said["probability"])
    columns = "path: number", "start", "fit", "standard_error: standard error", "units: unit"
    parts: list[Part] = [Table.of("Numbers", rows, *columns)]
    if len(rows) > 1 and np.isfinite(correlation).any():
        paths = [str(row["path"]) for row in rows]
        cells: list[list[str | None]] = [
            [path, *(None if np.isnan(value) else f"{value:.3f}" for value in line)]
            for path, line in zip(paths, correlation, strict=True)
        ]
        parts.append(Table("Correlation", ["", *paths], cells, numbers=len(paths)))
    if data.sizes["variant"] > 1:
        parts.append(_variants(data["variant"], data["variant_squares"], "sum of squares"))
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
            "variant": said["variant"],
            "notes": [*said["notes"]],
        },
    )
