"""The command on wear: how clearances grow over revolutions, and how long joints last."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli import swept
from linkages.cli.requests import File, Request
from linkages.reports.report import Notes, Part, Report, Table, number

if TYPE_CHECKING:
    import xarray as xr

    from linkages.components.mechanisms.mechanism import Mechanism

LIFE = "life"
"""Of the folder below a store that has what lives are computed from."""


def run_wear(
    request: Request,
    until: str | None,
    life: bool | None,
    draws: int | None,
    seed: int | None,
    film: bool | None,
    store: Path | None,
    cores: int | None,
) -> int:
    """Wear joints; returns the exit code."""
    from linkages.options.option import OptionError
    from linkages.tribology.cycle_jumps import wear
    from linkages.tribology.life import DRAWS, wear_life

    mechanism = request.mechanism
    with request.computing("wear of", "of wear") as watch:
        if life and until is None:
            raise OptionError("life", "a life ends at a limit; expected --until as well")
        data = wear(mechanism, until=until, store=store, watch=watch, **request.given)
    lives = None
    if life and until is not None:
        how: dict[str, Any] = {"draws": draws or DRAWS, "seed": seed or 0, "cores": cores}
        how["store"] = None if store is None else store / LIFE
        task = partial(wear_life, mechanism, until, **how, **request.given)
        lives = swept.result(request, "life of", "copy", task)
    files: list[File] = [("wear", data), ("wear", _columns(data))]
    if lives is not None:
        files += [(LIFE, lives), (LIFE, _copies(lives))]
    worn = mechanism.with_values(json.loads(data.attrs["worn"]))
    files.append(("worn.yaml", partial(_write, worn)))
    if film:
        files.append(("wear.gif", partial(_film, data)))

    def figures() -> Iterator[File]:
        from linkages.plots.motion.wear_figures import life_figure, wear_figures

        yield from wear_figures(data).items()
        if lives is not None:
            yield "life", life_figure(lives)

    report = _report(data, until, lives)
    if lives is not None:
        return swept.publish(request, report, lives, "copy", files, figures, store)
    return request.publish(report, files, figures)


def _write(mechanism: Mechanism, path: Path) -> None:
    path.write_text(mechanism.to_yaml(), encoding="utf-8")


def _film(data: xr.Dataset, path: Path) -> None:
    from linkages.plots.motion.wear_figures import write_film

    write_film(data, path)


def _clearance(data: xr.Dataset, name: str) -> dict[str, Any]:
    """What JSON says of a clearance at the end."""
    end = data.sel(clearance=name).isel(jump=-1)
    return {
        "name": name,
        "volume": {side: float(end["volume"].sel(side=side)) for side in ("journal", "bearing")},
        "size": float(end["size"]),
        "error": float(end["error"]),
        "sliding_distance": float(end["sliding_distance"]),
        "work": float(end["work"]),
        "work_error": float(end["work_error"]),
        "pressure_velocity": {
            of: float(end["pressure_velocity"].sel(of=of)) for of in ("mean", "largest")
        },
        "deepest": {
            side: float(end["depth"].sel(side=side).max()) for side in ("journal", "bearing")
        },
    }


def _report(data: xr.Dataset, until: str | None, lives: xr.Dataset | None) -> Report:
    """Tables of clearances at the end, and of lives."""
    said, count = data.attrs, float(data["revolutions"][-1])
    names = [str(name) for name in data["clearance"].values]
    first = until.split(".")[1] if until is not None else names[0]
    each = [_clearance(data, name) for name in names]
    chosen = next(one for one in each if one["name"] == first)
    begun = data["size"].isel(jump=0)
    rows = [
        [
            one["name"], number(float(begun.sel(clearance=one["name"]))), number(one["size"]),
            f"{one['error']:.1e}", *(f"{v:.4g}" for v in one["volume"].values()),
            f"{one['sliding_distance']:.4g}", f"{one['pressure_velocity']['mean']:.3g}",
        ]
        for one in each
    ]  # fmt: skip
    heads = [
        "clearance", "size before (m)", "size (m)", "error (m)", "journal (m³)", "bearing (m³)",
        "slip (m)", "pressure × velocity (W/m²)",
    ]  # fmt: skip
    parts: list[Part] = [Table("Clearances at the end", heads, rows, len(heads) - 1)]
    if "difference" in said:
        changed = ", ".join(
            f"{name} by {value:.1e} m"
            for name, value in zip(names, np.atleast_1d(said["difference"]), strict=True)
        )
        parts.append(f"half the jumps change {changed}")
    jumps = data.sizes["jump"] - 1
    why = {"limit": f"the limit {until}", "revolutions": "their number"}.get(said["ended"], "")
    parts.append(
        f"{count:.6g} revolutions of {number(said['period'])} s, up to {why}: {jumps} jumps, "
        f"{said['computed']} revolutions computed"
    )
    content: dict[str, Any] = {
        "mechanism": said["name"],
        "revolutions": count,
        **{key: chosen[key] for key in ("volume", "size", "error")},
        "clearance": first,
        "clearances": each,
        "ended": said["ended"],
        "period": float(said["period"]),
        "jumps": jumps,
        "computed": int(said["computed"]),
    }
    if "difference" in said:
        pairs = zip(names, np.atleast_1d(said["difference"]).tolist(), strict=True)
        content["difference"] = dict(pairs)
    notes = json.loads(said["notes"])
    if lives is not None:
        own = _life(lives)
        parts += _life_parts(own)
        notes += swept.failure_notes(own["failures"], "copy without a life")
        content[LIFE] = own
    grown = f"{chosen['size'] * 1e3:.4g} mm ± {chosen['error'] * 1e3:.1g} mm"
    return Report(
        name=str(said["name"]),
        summary=f"{first} {grown} after {count:.6g} revolutions",
        parts=[*parts, Notes(notes)],
        data={**content, "notes": notes},
    )


def _life(lives: xr.Dataset) -> dict[str, Any]:
    """What JSON says of lives."""
    numbers = {
        f"{kind}": {
            f"P{percent}": swept.known(float(value))
            for percent, value in zip(
                lives["percent"].values.tolist(), lives[f"{kind}_quantile"].values, strict=True
            )
        }
        for kind in ("relative", "life")
    }
    return {
        "nominal": swept.known(float(lives["nominal"])),
        "error": swept.known(float(lives["error"])),
        "relative": numbers["relative"],
        "revolutions": numbers["life"],
        "uncertainty": float(lives.attrs["uncertainty"]),
        "draws": lives.sizes["draw"],
        "sensitivities": [
            {
                "path": str(path),
                "exponent": swept.known(float(lives["exponent"].sel(parameter=path))),
                "relative": [
                    swept.known(float(value))
                    for value in lives["ends"].sel(parameter=path).to_numpy()
                ],
            }
            for path in lives["parameter"].values
        ],
        "failures": swept.failures(lives),
    }


def _life_parts(own: dict[str, Any]) -> Iterator[Part]:
    """Relative life and what it depends on, then that in revolutions."""
    heads = ["", *own["relative"]]
    rows = [
        ["life over the nominal one", *(_shown(value) for value in own["relative"].values())],
        ["life in revolutions", *(_shown(value) for value in own["revolutions"].values())],
    ]
    if own["sensitivities"]:
        rows_of = [
            [one["path"], _shown(one["exponent"]), *map(_shown, one["relative"])]
            for one in own["sensitivities"]
        ]
        columns = ["number", "% of life per %", "life at −σ", "life at +σ"]
        yield Table("Relative life", columns, rows_of, 3)
    yield Table("Life", heads, rows, len(heads) - 1)
    spread = own["uncertainty"]
    yield (
        f"in revolutions with wear rates between 1/{spread:g} and {spread:g} times those of the "
        f"file; with those of the file {_shown(own['nominal'])} ± {_shown(own['error'])}"
    )


def _shown(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"


def _columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each place of each clearance."""
    names = data["clearance"].values.tolist()
    rows = [(j, name) for name in names for j in range(data.sizes["jump"])]

    def of(array: xr.DataArray) -> list[float]:
        return [float(array.sel(clearance=name).isel(jump=j)) for j, name in rows]

    volume, pressure = data["volume"], data["pressure_velocity"]
    return {
        "clearance": [name for _, name in rows],
        "revolutions": [float(data["revolutions"][j]) for j, _ in rows],
        "size (m)": of(data["size"]),
        "error (m)": of(data["error"]),
        "volume of journal (m^3)": of(volume.sel(side="journal")),
        "volume of bearing (m^3)": of(volume.sel(side="bearing")),
        "distance of slip (m)": of(data["sliding_distance"]),
        "work per revolution (J)": of(data["work"]),
        "its standard error (J)": of(data["work_error"]),
        "mean pressure by velocity (W/m^2)": of(pressure.sel(of="mean")),
        "largest pressure by velocity (W/m^2)": of(pressure.sel(of="largest")),
    }


def _copies(lives: xr.Dataset) -> dict[str, Any]:
    """A row for each copy."""
    return {
        "draw": lives["draw"].values.tolist(),
        "life over the nominal one": [
            float(v) if np.isfinite(v) else None for v in lives["relative"].values
        ],
        "reason": [str(reason) for reason in lives["reason"].values],
    }
