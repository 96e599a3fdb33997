"""The command on equilibria: where a mechanism rests, and how it vibrates about that."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli.requests import File, Request
from linkages.reports.report import Notes, Part, Report, Table, headed, number

if TYPE_CHECKING:
    import xarray as xr

    from linkages.components.mechanisms.mechanism import Mechanism


def run_equilibrium(
    request: Request,
    time: float | None,
    state: Sequence[str] | None,
    solve: Sequence[str] | None,
    inputs: Sequence[str] | None,
    observed: Sequence[str] | None,
    frequencies: str | None,
    matrices: str | None,
    film: bool | None,
) -> int:
    """Find equilibria; returns the exit code."""
    from linkages.equilibria.equilibrium import equilibrium

    with request.computing("equilibria of", "of equilibria") as watch:
        data = equilibrium(
            request.mechanism, time=time or 0.0, state=state or (), solve=solve or (),
            inputs=inputs or (), observed=observed or (), frequencies=frequencies, watch=watch,
            **request.given,
        )  # fmt: skip
    numbers = range(1, data.sizes["equilibrium"] + 1)
    files: list[File] = [("equilibrium", data), ("equilibrium", _columns(data))]
    if matrices:
        files += [(f"linear_{k}.{matrices}", _matrices(data, k, matrices)) for k in numbers]

    if film:
        moving = [(k, m) for k in numbers for m, mode in _modes(data, k) if mode["frequency"] > 0]
        files += [(f"mode_{k}_{m}.gif", _film(data, request.mechanism, k, m)) for k, m in moving]

    def figures() -> Iterator[File]:
        from linkages.plots.motion.equilibrium_figures import equilibrium_figures

        yield from equilibrium_figures(data, request.mechanism).items()

    return request.publish(_report(data), files, figures)


def _modes(data: xr.Dataset, k: int) -> list[tuple[int, dict[str, Any]]]:
    """Number and content of each mode of an equilibrium."""
    one, result = data.sel(equilibrium=k), []
    for m in range(1, data.sizes["mode"] + 1):
        mode = one.sel(mode=m)
        if np.isfinite(mode["frequency"]):
            shape = zip(data["freedom"].values, mode["mode_shape"].to_numpy().tolist(), strict=True)
            entry = {
                "frequency": float(mode["frequency"]),
                "damping_ratio": float(mode["damping_ratio"]),
                "eigenvalue": mode["eigenvalue"].to_numpy().tolist(),
                "kind": str(mode["mode_kind"].item()),
                "shape": {str(name): both for name, both in shape},
            }
            result.append((m, entry))
    return result


def _content(data: xr.Dataset, k: int) -> dict[str, Any]:
    """What JSON says of an equilibrium."""
    from linkages.equilibria.equilibrium import state_space

    one = data.sel(equilibrium=k)
    names = [str(name) for name in data["coordinate"].values]
    interval = zip(names, one["interval"].to_numpy().tolist(), strict=True)
    held = {name: ends for name, ends in interval if np.isfinite(ends).all()}
    a, b, c, d = state_space(data, k)
    states = [str(name) for name in one["state_name"].values if name]
    result = {
        "state": dict(zip(names, one["state"].to_numpy().tolist(), strict=True)),
        "stable": bool(one["stable"]),
        "reason": str(one["reason"].item()),
        "neutral": int(one["neutral"]),
        "potential_energy": float(one["potential_energy"]),
        "drive_effort": dict(
            zip(
                map(str, data["drive"].values), one["drive_effort"].to_numpy().tolist(), strict=True
            )
        ),
        "modes": [mode for _, mode in _modes(data, k)],
        "linear": {
            "states": states,
            "inputs": [str(name) for name in data["input"].values],
            "outputs": [str(name) for name in data["output"].values],
            **{name: each.tolist() for name, each in zip("ABCD", (a, b, c, d), strict=True)},
        },
    }
    return {**result, "interval": held} if held else result


def _report(data: xr.Dataset) -> Report:
    """Tables of equilibria, efforts and modes."""
    said = data.attrs
    contents = [_content(data, k) for k in data["equilibrium"].values]
    units = dict(zip(map(str, data["coordinate"].values), data["unit"].values, strict=True))
    shown = [str(name) for name in data["coordinate"].values]
    count = data.sizes["freedom"]
    if not said["moving"]:
        shown = [*shown[:count], *shown[2 * count :]]
    heads = ["number", *(headed(name, str(units[name])) for name in shown)]
    rows = []
    for k, one in enumerate(contents, 1):
        held = one.get("interval", {})
        values = [
            f"{held[name][0]:.9g} … {held[name][1]:.9g}" if name in held
            else f"{_shown(one['state'][name]):.9g}" for name in shown
        ]  # fmt: skip
        stable = "" if said["moving"] else "stable" if one["stable"] else "not stable"
        rows.append([k, *values, one["potential_energy"], stable, one["reason"]])
    efforts = [
        [k, *one["drive_effort"].values()]
        for k, one in enumerate(contents, 1)
        if one["drive_effort"]
    ]
    modes = [
        [k, m, number(mode["frequency"]), f"{100 * mode['damping_ratio']:.4g}", mode["kind"],
         _written(mode)]
        for k in range(1, len(contents) + 1) for m, mode in _modes(data, k)
    ]  # fmt: skip
    solved, notes = json.loads(said["solved"]), json.loads(said["notes"])
    parts: list[Part] = []
    if solved:
        text = ", ".join(f"{path} = {value:.12g}" for path, value in solved.items())
        parts.append(f"solved for: {text} (SI)")
    title = "Position of the motion" if said["moving"] else "Equilibria"
    parts.append(
        Table(title, [*heads, "potential energy (J)", "stability", "because"], rows, len(heads) + 1)
    )
    if efforts:
        bodies = zip(data["drive"].values, data["drive_unit"].values, strict=True)
        names = [headed(str(name), str(unit)) for name, unit in bodies]
        parts.append(Table("Drive efforts", ["number", *names], efforts))
    if modes:
        columns = [
            "equilibrium",
            "mode",
            "frequency (Hz)",
            "damping (%)",
            "kind",
            "eigenvalue (1/s)",
        ]
        parts.append(Table("Vibration modes", columns, modes, 4))
    stable = sum(one["stable"] for one in contents)
    many = f"{len(contents)} equilibri{'um' if len(contents) == 1 else 'a'}"
    summary = f"{many}, {stable} stable"
    if said["moving"]:
        summary = f"vibration at t = {number(said['time'])} s: {contents[0]['reason']}"
    return Report(
        name=str(said["name"]),
        summary=summary,
        parts=[*parts, Notes(notes)],
        data={
            "mechanism": said["name"],
            "time": said["time"],
            "moving": bool(said["moving"]),
            "equilibria": contents,
            "solved": solved,
            "notes": notes,
        },
    )


def _shown(value: float) -> float:
    """A value in a table, without round-off about zero."""
    return 0.0 if abs(value) < 1e-14 else value


def _written(mode: dict[str, Any]) -> str:
    """An eigenvalue; zero where it is known to be that but for round-off."""
    real, imaginary = (0.0, 0.0) if mode["kind"].startswith("neutral") else mode["eigenvalue"]
    first = f"{real:.6g}" if real or not imaginary else ""
    if not imaginary:
        return first
    return f"{first}{' ± ' if first else '±'}{imaginary:.6g}i"


def _columns(data: xr.Dataset) -> dict[str, Any]:
    """A row for each mode of each equilibrium; one for an equilibrium without modes."""
    none: list[tuple[int | None, dict[str, Any]]] = [(None, {})]
    rows = [
        (k, m, mode)
        for k in data["equilibrium"].values.tolist()
        for m, mode in [*_modes(data, k)] or none
    ]
    columns: dict[str, Any] = {"equilibrium": [k for k, _, _ in rows]}
    for name, unit in zip(data["coordinate"].values, data["unit"].values, strict=True):
        values = data["state"].sel(coordinate=name)
        columns[headed(str(name), str(unit))] = [
            float(values.sel(equilibrium=k)) for k, _, _ in rows
        ]
    columns["stable"] = [int(data["stable"].sel(equilibrium=k)) for k, _, _ in rows]
    columns["mode"] = [m for _, m, _ in rows]
    for key, head in (("frequency", "frequency (Hz)"), ("damping_ratio", "damping ratio")):
        columns[head] = [mode.get(key) for _, _, mode in rows]
    for part, word in enumerate(("real", "imaginary")):
        columns[f"{word} part of eigenvalue (1/s)"] = [
            mode["eigenvalue"][part] if mode else None for _, _, mode in rows
        ]
    columns["kind"] = [mode.get("kind", "") for _, _, mode in rows]
    return columns


def _film(data: xr.Dataset, mechanism: Mechanism, k: int, m: int) -> Callable[[Path], None]:
    """What writes the film of a mode."""

    def write(path: Path) -> None:
        from linkages.plots.motion.equilibrium_figures import write_film

        write_film(data, mechanism, k, m, path)

    return write


def _matrices(data: xr.Dataset, k: int, form: str) -> Callable[[Path], None]:
    """What writes the linear equations of an equilibrium."""
    from linkages.equilibria.equilibrium import state_space

    content: dict[str, Any] = dict(zip("ABCD", state_space(data, k), strict=True))
    content["states"] = [str(n) for n in data["state_name"].sel(equilibrium=k).values if n]
    content |= {f"{word}s": [str(n) for n in data[word].values] for word in ("input", "output")}

    def write(path: Path) -> None:
        with path.open("wb") as file:
            if form == "npz":
                arrays: dict[str, Any] = {n: np.asarray(each) for n, each in content.items()}
                np.savez(file, **arrays)
                return
            from scipy.io import savemat

            lists = {n: np.array(e, dtype=object) for n, e in content.items() if n[0].islower()}
            savemat(file, content | lists)

    return write
