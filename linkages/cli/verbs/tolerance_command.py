"""``tolerance``: contributions of tolerances, the worst case, and the yield of random copies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console

from linkages.cli import swept
from linkages.cli.options import Drawing
from linkages.cli.requests import File, Request
from linkages.cli.terminal import print_notes, table
from linkages.plots.style import scale_of

if TYPE_CHECKING:
    import xarray as xr

MANY = 12
"""Contributors that a table has; the rest is a line."""


def run(
    request: Request,
    of: Sequence[str],
    limits: Sequence[str] | None,
    draws: int,
    seed: int,
    sequence: Drawing,
    store: Path | None,
    time_per_point: float | None,
    scheduler: str | None,
    cores: int | None,
) -> int:
    """Compute tolerances; returns the exit code."""
    from linkages.design.tolerance import tolerance

    task = partial(
        tolerance, request.mechanism, list(of), limits=tuple(limits or ()), draws=draws, seed=seed,
        sequence=str(sequence), store=store, cores=cores, scheduler=scheduler,
        time_per_point=time_per_point, **request.given,
    )  # fmt: skip
    data = swept.result(request, "tolerances", "draw", task)
    content = _content(data)
    made = _files(data, request.figures)
    show = partial(_print, content)
    return swept.publish(request, data, "draw", made, content, show, store=store)


def _files(data: xr.Dataset, figures: bool) -> Iterator[File]:
    yield "tolerance", data
    yield "tolerance", _columns(data)
    if figures:
        from linkages.plots.study_figures import tolerance_figure

        names = [str(name) for name in data["measure"].to_numpy()]
        for number, name in enumerate(names, 1):
            stem = "tolerance" if len(names) == 1 else f"tolerance_{number}"
            yield stem, tolerance_figure(data, name)


def _columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each draw."""
    like = data["outcome"]
    columns: dict[str, Any] = {}
    for name, array in data.coords.items():
        if array.dims == ("draw",):
            units = array.attrs.get("units")
            columns[f"{name} ({units})" if units else str(name)] = array
    for name in data["measure"].to_numpy():
        own = data["sample"].sel(measure=name)
        units = str(own["units"].values)
        columns[f"{name} ({units})" if units else str(name)] = own.drop_vars(["measure", "units"])
    words = str(like.attrs["flag_meanings"]).split()
    columns["outcome"] = like.copy(data=np.array(words, dtype=object)[like.to_numpy()])
    return swept.flattened(columns | swept.failure_columns(data), like)


def _content(data: xr.Dataset) -> dict[str, Any]:
    outcome = data["outcome"].to_numpy()
    words = str(data["outcome"].attrs["flag_meanings"]).split()
    counts = np.bincount(outcome, minlength=len(words))
    return {
        "mechanism": data.attrs["name"],
        "draws": int(outcome.size),
        "computed": int(counts[0]),
        "interrupted": bool(data.attrs["interrupted"]),
        "outcomes": {word: int(n) for word, n in zip(words, counts, strict=True) if n},
        "measures": [_measure(data, str(name)) for name in data["measure"].to_numpy()],
        "yields": _yields(data),
        "remarks": str(data.attrs["remarks"]).splitlines(),
        "failures": swept.failures(data),
    }


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
    values = own["sample"].to_numpy()
    values = values[np.isfinite(values)]
    known = bool(values.size)
    return {
        "measure": name,
        "units": str(own["units"].values),
        **{key: _known(float(own[key])) for key in keys},
        "worst": [float(value) for value in own["worst"]],
        "worst_in_truth": [_known(float(value)) for value in own["corner"]],
        "least": float(values.min()) if known else None,
        "greatest": float(values.max()) if known else None,
        "contributors": sorted(contributors, key=lambda row: -float(row["share"])),
    }


def _known(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _yields(data: xr.Dataset) -> list[dict[str, Any]]:
    if "within" not in data:
        return []
    return [
        {"limits": str(name), **{str(b): float(own.sel(bound=b)) for b in own["bound"].to_numpy()}}
        for name, own in zip(data["limit"].to_numpy(), data["within"], strict=True)
    ]


def _print(content: dict[str, Any], screen: Console) -> None:
    drawn = f"{content['computed']} of {content['draws']} draws"
    screen.print(f"{content['mechanism']}: {drawn}", markup=False)
    for measure in content["measures"]:
        _print_measure(measure, screen)
    if content["yields"]:
        rows = [
            [row["limits"], f"{row['share']:.2%}", f"{row['low']:.2%} to {row['high']:.2%}"]
            for row in content["yields"]
        ]
        screen.print(table("Yield", ["limits", "yield", "95 % confidence"], rows, numbers=1))
    print_notes(content["remarks"], screen)


def _print_measure(measure: dict[str, Any], screen: Console) -> None:
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
    screen.print(table(measure["measure"], heads, rows, numbers=1))
    left = measure["contributors"][MANY:]
    if left:
        share = sum(row["share"] for row in left)
        screen.print(f"and {len(left)} others with {share:.1%} of the variance", markup=False)
    screen.print(table("", ["", "linear", "random copies"], _compared(measure), numbers=1))


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

    return [
        ["mean", shown(measure["linear_mean"]), shown(measure["mean"])],
        [
            "standard deviation",
            small.text(measure["linear_spread"]),
            small.text(measure["deviation"]),
        ],
        ["least", shown(low), shown(measure["least"])],
        ["greatest", shown(high), shown(measure["greatest"])],
        ["in truth at the linear worst case", f"{shown(real[0])} to {shown(real[1])}", ""],
    ]


def _ratio(units: str, other: str) -> str:
    if units == other:
        return ""
    return f"{units or '1'}/{other}" if other else units
