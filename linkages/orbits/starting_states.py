"""States to start from: written as texts, and those of labelled points of branches."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.common_period import common_period
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.scene import AssemblyHint
from linkages.errors import InputError, Problem
from linkages.kernel.system import System
from linkages.options.analysis_options import FollowOptions
from linkages.orbits.shooting import Ray, Shooting
from linkages.reading.wording import suggestion
from linkages.solution.rhs import Equations
from linkages.solution.run_options import options_of
from linkages.spec.grammar import NumberError, leading_number
from linkages.spec.units import UnitError, unit

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

SAME_PLACE = 1e-6
"""Part of the size of a mechanism by which joints in one way of assembly differ at most."""


def read_states(
    mechanism: Mechanism, given: Mapping[str, float] | Sequence[str] | None
) -> dict[str, float]:
    """Coordinate or rate → value in SI, from that or from texts such as ``rod.angle=10 deg``.

    Raises InputError with every text that is none.
    """
    if isinstance(given, Mapping):
        return dict(given)
    if not given:
        return {}
    equations = Equations(System(mechanism))
    units = dict(zip(equations.names, equations.units, strict=True))
    result: dict[str, float] = {}
    problems = []
    for text in given:
        name, equals, value = (part.strip() for part in text.partition("="))
        try:
            if not equals:
                raise ValueError(f"expected NAME=VALUE, found {text!r}")
            if name in result:
                raise ValueError(f"{name} is given twice")
            if name not in units:
                near = suggestion(name, units) or f"; expected one of: {', '.join(units)}"
                raise ValueError(f"found no coordinate {name!r}{near}")
            result[name] = _in_si(value, units[name])
        except (ValueError, UnitError) as error:
            problems.append(Problem(message=str(error)))
    if problems:
        raise InputError("--state", problems)
    return result


def _in_si(text: str, si: str) -> float:
    """A number with or without a unit."""
    try:
        value, written = leading_number(text)
    except NumberError as error:
        raise ValueError(f"expected a number, found {text!r}: {error}") from None
    if not written:
        return value
    kind = unit(written)
    if kind.exponents != unit(si).exponents:
        raise ValueError(f"expected a number in {si}, or another unit of it, found {text!r}")
    return kind.convert(value)


def section_states(mechanism: Mechanism, data: xr.Dataset) -> Floats:
    """States at the beginnings of all periods of the drives, of each point of branches.

    Returns: shape (point, period, coordinate), with nan behind the last period of an orbit, which
    may have half the periods of its branch where that ends. Orbits are integrated from their first
    state: unstable ones with large multipliers are less precise.
    """
    periods = np.array([max(one["periods"], 1) for one in json.loads(data.attrs["branches"])])
    counts = periods[data["branch"].to_numpy()]
    first = data["state"].to_numpy()
    result = np.full((len(counts), int(counts.max(initial=1)), first.shape[1]), np.nan)
    result[:, 0] = first
    if counts.max(initial=1) == 1:
        return result
    paths = [str(path) for path in data["path"].values]
    rays = [Ray((path,), (0.0,), (1.0,)) for path in paths]
    how = {name: data.attrs[name] for name in ("method", "rtol", "atol")}
    shooting = Shooting(mechanism, rays, options_of(FollowOptions, mechanism, how))
    for row, count in enumerate(counts.tolist()):
        if count > 1:
            places = data["value"][row].to_numpy()
            there = mechanism.with_values(dict(zip(paths, places.tolist(), strict=True)))
            span = float(common_period(there))
            times = span * np.arange(1.0, round(float(data["period"][row]) / span))
            if times.size:
                shot = shooting.shoot(
                    places, first[row], float(times[-1]), start=0.0, tangents=False, samples=times
                )
                states = shooting.within_turn(shooting.states(shot.motion))
                result[row, 1 : 1 + len(times)] = states
    return result


def at_label(mechanism: Mechanism, data: xr.Dataset, label: str) -> Mechanism:
    """The mechanism at a labelled point of its branches: parameters, and the state at t = 0.

    `mechanism`: of which the branches are.
    `data`: as `linkages.follow` returns them.
    `label`: such as ``PD1``.
    Raises ValueError if no point has the label; it names those that there are.
    """
    if "label" not in data or "path" not in data.coords:
        raise ValueError("has no labelled points; expected a file of branches, as follow writes it")
    labels = [str(each) for each in data["label"].values]
    if label not in labels or not label:
        known = ", ".join(each for each in labels if each) or "none"
        raise ValueError(f"found no point {label!r}; labelled points: {known}")
    row = labels.index(label)
    values = zip(data["path"].values, data["value"][row].to_numpy().tolist(), strict=True)
    there = mechanism.with_values({str(path): value for path, value in values})
    names = [str(name) for name in data["coordinate"].values]
    return with_first_state(there, names, data["state"][row].to_numpy())


def options_at(data: xr.Dataset, label: str) -> dict[str, Any]:
    """Options with which a search begins at a labelled point itself."""
    row = [str(each) for each in data["label"].values].index(label)
    branch = json.loads(data.attrs["branches"])[int(data["branch"][row])]
    result: dict[str, Any] = {"skip": 0}
    if branch["periods"]:
        result["periods"] = branch["periods"]
    return result


def with_first_state(mechanism: Mechanism, names: Sequence[str], state: Floats) -> Mechanism:
    """The mechanism with another state at t = 0: coordinates, their rates, internal states.

    `names`: of the entries of the state, such as ``rod.angle`` and ``rod.speed``.
    `state`: shape (names,), in SI.
    """
    inner = len(mechanism.internal)
    free = (len(names) - inner) // 2
    numbers = state.tolist()
    given = {
        name.rpartition(".")[0]: (numbers[k], numbers[free + k])
        for k, name in enumerate(names[:free])
    }
    result = mechanism.with_state(given)
    if inner:
        result = result.with_values(dict(zip(names[2 * free :], numbers[2 * free :], strict=True)))
    before = System(mechanism)
    if before.topology.carried or names[:free] != _coordinates(before):
        return _assembled(result, System(result, near=before.places()).places())
    joints = before.model.positions.joints
    nodes = [node for place in joints.values() for node in (place.x, place.y)]
    places = before.evaluate(nodes, 0.0, before.layout.moving(state)[:, None]).reshape(-1, 2)
    return _assembled(result, dict(zip(joints, places, strict=True)))


def _coordinates(system: System) -> list[str]:
    """Names of the free coordinates, as a state has them."""
    return list(Equations(system).names[: len(system.topology.free)])


def _assembled(mechanism: Mechanism, wanted: Mapping[str, Floats]) -> Mechanism:
    """The mechanism with hints that lead to wanted positions of its joints."""
    found = System(mechanism).places()
    size = max(float(np.abs(place).max()) for place in wanted.values())
    if all(np.abs(found[name] - wanted[name]).max() < SAME_PLACE * size for name in wanted):
        return mechanism
    moved = [
        replace(each, where=tuple(wanted[each.name].tolist()))
        if isinstance(each, AssemblyHint)
        else each
        for each in mechanism.components
    ]
    return replace(mechanism, components=tuple(moved))
