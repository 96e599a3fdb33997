"""Commands on periodic motions and equilibria: ``orbit`` and ``follow``."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli.requests import File, Request
from linkages.orbits.arclength import PREFIXES
from linkages.reports.report import Notes, Part, Report, Table, headed, number

if TYPE_CHECKING:
    import xarray as xr

    from linkages.design.ranges import Ranges


def run_orbit(request: Request, state: Sequence[str] | None) -> int:
    """Find orbits; returns the exit code."""
    from linkages.orbits.orbit import orbit

    request = _from_point(request)
    with request.computing("orbit of", "of starts") as watch:
        data = orbit(request.mechanism, state=state, watch=watch, **request.given)
    several = data.sizes.get("orbit")
    each = [data] if several is None else [_alone(data, k) for k in range(several)]
    contents = [_content(one) for one in each]
    parts: list[Part] = []
    for index, one in enumerate(each, 1):
        parts += _orbit_parts(one, f"Orbit {index}: " if len(each) > 1 else "")
    found = _summary(each[0]) if len(each) == 1 else f"{len(each)} orbits"
    more = {} if several is None else {"orbits": contents}
    report = Report(
        name=str(data.attrs["name"]),
        summary=found,
        parts=parts,
        data={"mechanism": data.attrs["name"], **contents[0], **more},
    )

    def figures() -> Iterator[File]:
        from linkages.plots.chaos.orbit_figures import orbit_figures

        for index, one in enumerate(each, 1):
            for name, figure in orbit_figures(one, request.mechanism).items():
                yield name if len(each) == 1 else f"{name}_{index}", figure

    return request.publish(report, [("orbit", data), ("orbit", _orbit_columns(each))], figures)


def _from_point(request: Request) -> Request:
    """The same with a search that begins at a labelled point, unless something else is said."""
    if request.at is None:
        return request
    from linkages.opened import open as opened
    from linkages.orbits.starting_states import options_at

    _ = request.mechanism  # says what is wrong with the file and the label
    given = options_at(opened(request.file).data, request.at)
    return replace(request, given={**given, **request.given})


def _alone(data: xr.Dataset, index: int) -> xr.Dataset:
    """One of several orbits, as a search for one returns it."""
    from linkages.orbits.orbit import OF_ORBIT

    one = data.isel(orbit=index)
    attrs = {**data.attrs, **{name: one[name].item() for name in OF_ORBIT}}
    one = one.drop_vars(OF_ORBIT).dropna("time", how="all").dropna("section", how="all")
    return one.assign_attrs(attrs)


def _content(data: xr.Dataset) -> dict[str, Any]:
    """What JSON says of an orbit."""
    said = data.attrs
    return {
        "period": said["period"],
        "periods": said["periods"],
        "state": dict(zip(_names(data), data["state"].to_numpy().tolist(), strict=True)),
        "multipliers": data["multiplier"].to_numpy().tolist(),
        "multiplier_errors": data["multiplier_error"].to_numpy().tolist(),
        "zeros": said["zeros"],
        "stable": bool(said["stable"]),
        "reason": said["reason"],
        "contacts": said["contacts"],
        "residual": said["residual"],
        "state_change": said["state_change"],
    }


def _names(data: xr.Dataset) -> list[str]:
    return [str(name) for name in data["coordinate"].values]


def _summary(data: xr.Dataset) -> str:
    """The main result in a few words."""
    said = data.attrs
    kind = "conservative" if said["conservative"] else "stable" if said["stable"] else "unstable"
    if said["reason"].endswith("bifurcation"):
        kind = "undecided"
    lasting = {0: "", 1: ", one period of the drives"}
    drives = lasting.get(said["periods"], f", {said['periods']} periods of the drives")
    touches = said["contacts"]
    closing = f", {touches} contact{'s' * (touches != 1)}" if touches else ""
    return f"{kind} orbit of {number(said['period'])} s{drives}{closing}"


def _orbit_parts(data: xr.Dataset, heading: str) -> list[Part]:
    """Tables of an orbit, and how well it is known."""
    from linkages.orbits.orbit import LOST, multiplier_texts

    said, errors = data.attrs, data["multiplier_error"].to_numpy().tolist()
    spectrum = (data["multiplier"].to_numpy() @ [1.0, 1.0j]).tolist()
    texts = multiplier_texts(data)
    rows = [
        [k, text, *([f"{abs(value):.6g}", f"{error:.1g}"] if abs(value) >= LOST else ["", ""])]
        for k, (text, value, error) in enumerate(zip(texts, spectrum, errors, strict=True), 1)
    ]
    numbers, units = data["state"].to_numpy().tolist(), data["unit"].values
    state = [
        [name, f"{value:.12g}", str(unit)]
        for name, value, unit in zip(_names(data), numbers, units, strict=True)
    ]
    zeros = int(said["zeros"])
    many = f"; {zeros} {'is' if zeros == 1 else 'are'} below 1e-12, "
    lost = f"{many}as where contacts stay closed or friction sticks" if zeros else ""
    return [
        *([f"{heading}{_summary(data)}"] if heading else []),
        f"{said['reason']}{lost}",
        Table("State at t = 0", ["coordinate", "value", "unit"], state),
        Table("Multipliers", ["number", "multiplier", "magnitude", "error"], rows, 3),
        f"residual {said['residual']:.1e} of the amplitudes; at a tenth of the tolerance the state "
        f"changes by {said['state_change']:.1e} of them",
    ]


def _orbit_columns(each: Sequence[xr.Dataset]) -> dict[str, Any]:
    """Each orbit over its period, one after the other."""
    columns: dict[str, list[Any]] = {}
    for index, data in enumerate(each, 1):
        time, states = data["time"].to_numpy(), data["orbit_state"].to_numpy()
        if len(each) > 1:
            columns.setdefault("orbit", []).extend([index] * len(time))
        columns.setdefault("time (s)", []).extend(time)
        for name, unit, values in zip(_names(data), data["unit"].values, states.T, strict=True):
            columns.setdefault(headed(name, unit), []).extend(values)
    return columns


def run_follow(
    request: Request,
    vary: Sequence[str],
    state: Sequence[str] | None,
    locus: str | None,
    other: Sequence[str] | None,
    store: Path | None,
) -> int:
    """Follow branches; returns the exit code."""
    from linkages.design.ranges import ranges_of
    from linkages.orbits.follow import follow

    request = _from_point(request)
    mechanism = request.mechanism
    both = [*vary, *(other or ())]
    ranges = ranges_of(mechanism, both, either_way=True)
    where: dict[str, Any] = {"locus": locus, "other": list(other) if other else None}
    with request.computing("branches of", counted=True) as update:
        data = follow(
            mechanism, list(vary), state=state, store=store, watch=_told(update), **where,
            **request.given,
        )  # fmt: skip

    def figures() -> Iterator[File]:
        from linkages.orbits.starting_states import section_states
        from linkages.plots.chaos.orbit_figures import branch_figures

        drawn = data
        if locus is None:
            dims = ("point", "section", "coordinate")
            drawn = data.assign(section_state=(dims, section_states(mechanism, data)))
        across = None if not other else ranges.paths[len(vary)]
        yield from branch_figures(drawn, ranges, across).items()

    report = _branch_report(data, ranges, locus)
    return request.publish(report, [("follow", data), ("follow", _rows(data, ranges))], figures)


def _told(update: Callable[..., None]) -> Callable[[str], None]:
    """Show a line on each point; those on special ones stay."""

    def line(text: str) -> None:
        update(text, text.endswith(tuple(PREFIXES)))

    return line


def _branches(data: xr.Dataset) -> list[dict[str, Any]]:
    """What is known of each branch, with the rows of its points."""
    numbers = data["branch"].to_numpy()
    return [
        {**one, "rows": np.flatnonzero(numbers == k)}
        for k, one in enumerate(json.loads(data.attrs["branches"]))
    ]


def _branch_report(data: xr.Dataset, ranges: Ranges, locus: str | None) -> Report:
    """Special points and branches."""
    said, values = data.attrs, data["value"].to_numpy()
    periods, stable = data["period"].to_numpy(), data["stable"].to_numpy() > 0
    labels, kinds, abouts = (data[name].values for name in ("label", "kind", "about"))
    paths = [str(path) for path in data["path"].values]
    found = _branches(data)
    points = [
        {
            "label": str(labels[row]),
            "kind": str(kinds[row]),
            "value": float(values[row, 0]),
            "period": float(periods[row]) if np.isfinite(periods[row]) else None,
            "branch": int(data["branch"][row]) + 1,
            "periods": found[int(data["branch"][row])]["periods"],
            "about": str(abouts[row]) or None,
            "values": dict(zip(paths, values[row].tolist(), strict=True)),
        }
        for row in range(len(values))
        if labels[row]
    ]
    branches = [
        {
            "points": values[one["rows"], 0].tolist(),
            "stable": stable[one["rows"]].tolist(),
            "what": "orbits" if np.isfinite(periods[one["rows"]]).any() else "equilibria",
            "periods": one["periods"],
            "parent": one["parent"] or None,
            "ends": one["ends"],
        }
        for one in found
    ]
    notes = json.loads(said["notes"])
    shown = [
        [p["label"], p["kind"], *_shown(p["values"], ranges), p["period"], p["branch"], p["about"]]
        for p in points
    ]
    heads = ["label", "kind", *paths, "period (s)", "branch", "contact"]
    rows = []
    for number_, one in enumerate(branches, 1):
        ends = [_shown({paths[0]: one["points"][k]}, ranges)[0] for k in (0, -1)]
        # on a locus a multiplier is on the unit circle
        many = len(one["stable"]) if locus else f"{sum(one['stable'])} of {len(one['stable'])}"
        kind = f"{one['periods']} periods" if one["periods"] > 1 else one["what"]
        why = "; ".join(dict.fromkeys(end["text"] for end in one["ends"]))
        rows.append([number_, one["parent"] or "", kind, *ends, many, why])
    said_of = "points" if locus else "stable points"
    lead = ["branch", "from", "what", "first", "last", said_of, "ended because"]
    parts: list[Part] = [Table("Special points", heads, shown)] if points else []
    count = f"{len(branches)} branch{'es' * (len(branches) != 1)}"
    summary = f"locus of {locus}" if locus else count
    return Report(
        name=str(said["name"]),
        summary=f"{summary}, {len(values)} points, {len(points)} of them special",
        parts=[*parts, Table("Branches", lead, rows), Notes(notes)],
        data={
            "mechanism": said["name"],
            "parameter": paths[0],
            "parameters": paths,
            "locus": locus,
            "points": points,
            "branches": branches,
            "notes": notes,
        },
    )


def _shown(values: dict[str, float], ranges: Ranges) -> list[str]:
    """Values in the units of the file, with ten digits."""
    units = {each.path: each for each in ranges.each}
    return [
        f"{units[path].of_si(value):.10g} {units[path].label}".rstrip()
        for path, value in values.items()
    ]


def _rows(data: xr.Dataset, ranges: Ranges) -> dict[str, Any]:
    """A row for each point of branches."""
    columns: dict[str, Any] = {"branch": data["branch"].to_numpy() + 1}
    for each, values in zip(ranges.each, data["value"].to_numpy().T, strict=True):
        columns[headed(each.path, each.si)] = values
    columns["period (s)"] = data["period"].to_numpy()
    states = data["state"].to_numpy().T
    for name, unit, values in zip(
        _names(data), data["coordinate_unit"].values, states, strict=True
    ):
        columns[headed(name, unit)] = values
    word = "multiplier" if data.attrs["what"] == "orbits" else "eigenvalue"
    for index, both in zip(
        data["index"].values, data["spectrum"].to_numpy().swapaxes(0, 1), strict=True
    ):
        for part, values in zip(("real part", "imaginary part"), both.T, strict=True):
            columns[f"{part} of {word} {index}"] = values
    columns["stable"] = data["stable"].to_numpy()
    columns["contacts"] = data["contacts"].to_numpy()
    return columns | {name: data[name].values for name in ("label", "kind", "about")}
